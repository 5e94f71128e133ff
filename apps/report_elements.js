'use strict';
// What the page is made of: elements, tables, switches, legends, a value with its standard deviation.
const Elements = (() => {
  const { format, superscript, minus } = Axes;

  function el(tag, attributes = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name === 'onclick') element.addEventListener('click', value);
      else if (value !== undefined && value !== false) element.setAttribute(name, value);
    }
    element.append(...children.flat().filter((child) => child !== null && child !== undefined));
    return element;
  }
  const nan = (values) => (values || []).map((value) => (value === null ? NaN : value)); // JSON has no NaN
  const known = (value) => value !== null && value !== undefined && Number.isFinite(value);
  const withUnit = (label, unit) => `${label} [${unit || '?'}]`;
  const plural = (count, word) => `${count} ${word}${count === 1 ? '' : 's'}`;

  /** value ± sigma, sigma with two digits, a power of ten taken out where the value is far from 1. */
  function uncertain(value, sigma, digits = 5) {
    if (!known(value)) return '–';
    if (!(sigma > 0)) return format(value, digits);
    const size = Math.max(Math.abs(value), sigma);
    const power = size < 1e-3 || size >= 1e6 ? 3 * Math.floor(Math.log10(size) / 3) : 0;
    const decimals = Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(sigma / 10 ** power))));
    const [v, s] = [value, sigma].map((x) => minus((x / 10 ** power).toFixed(decimals)));
    return power ? `(${v} ± ${s})·10${superscript(power)}` : `${v} ± ${s}`;
  }

  /** columns: [[heading, left?, wrap?], …]; rows: cells, or { cells, className }. */
  function table(columns, rows) {
    const kinds = columns.map(([, left, wrap]) => [left && 'left', wrap && 'wrap'].filter(Boolean).join(' ') || undefined);
    const headed = columns.some(([heading]) => heading);
    const lines = (heading) => String(heading).split('\n').flatMap((line, i) => (i ? [el('br'), line] : [line]));
    return el('div', { class: 'scroll', tabindex: 0 }, el('table', {},
      headed ? el('thead', {}, el('tr', {}, columns.map(([heading], i) => el('th', { class: kinds[i], scope: 'col' }, lines(heading))))) : null,
      el('tbody', {}, rows.map((row) => el('tr', { class: row.className },
        (row.cells || row).map((cell, i) => el('td', { class: kinds[i] }, cell)))))));
  }

  /** A row of buttons of which one is pressed. choices: [[value, label], …] */
  function chooser(label, choices, chosen, onChange) {
    const buttons = choices.map(([value, text]) => el('button', {
      type: 'button', 'aria-pressed': value === chosen,
      onclick: (event) => {
        buttons.forEach((button) => button.setAttribute('aria-pressed', button === event.currentTarget));
        onChange(value);
      } }, text));
    return el('span', { class: 'switch', role: 'group', 'aria-label': label }, label, el('div', {}, buttons));
  }

  function swatch({ colour, dash, marker, width, line, band }) {
    const stroke = `var(--${colour})`;
    const shape = marker && { rect: '<path d="M11 2h8v8h-8z"', triangle: '<path d="M15 1l5 9H10z"', circle: '<circle cx="15" cy="6" r="4"',
      rectRot: '<path d="M15 0l6 6-6 6-6-6z"', down: '<path d="M10 2h10l-5 8z"', crossRot: '<path d="M11 2l8 8M19 2l-8 8"' }[marker.shape];
    const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    svg.setAttribute('aria-hidden', 'true');
    svg.innerHTML = (band ? `<rect width="30" height="12" style="fill:var(--${colour}-band)"/>` : '') +
      (line === false ? '' : `<path d="M0 6h30" style="stroke:${stroke};stroke-width:${width || 1.6};stroke-dasharray:${dash || 'none'}"/>`) +
      (shape ? `${shape} style="stroke:${stroke};fill:${marker.hollow ? 'none' : stroke}"/>` : '');
    return svg;
  }

  /** entries: [{ label, hidden, onToggle(hidden), ...swatch }]: each a button that shows or hides. */
  const legend = (entries) => el('div', { class: 'legend', role: 'group', 'aria-label': 'Show or hide' }, entries.map((entry) =>
    el('button', { type: 'button', 'aria-pressed': !entry.hidden, onclick: (event) => {
      entry.hidden = !entry.hidden;
      event.currentTarget.setAttribute('aria-pressed', !entry.hidden);
      entry.onToggle(entry.hidden);
    } }, swatch(entry), entry.label)));

  /** A legend over plots: every series that shares `key` is shown and hidden together. */
  function seriesLegend(plots, keys) {
    const series = plots.flatMap((plot) => plot.spec.series);
    return legend(keys.filter(({ key }) => series.some((s) => s.key === key)).map((entry) => ({
      ...series.find((s) => s.key === entry.key), ...entry,
      onToggle: (hidden) => {
        plots.forEach((plot) => plot.spec.series.forEach((s) => { if (s.key === entry.key) s.hidden = hidden; }));
        plots.forEach(Plots.refresh);
      } })));
  }

  return { el, nan, known, withUnit, plural, uncertain, table, chooser, legend, seriesLegend };
})();
