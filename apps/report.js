'use strict';
// The page: tables and plots from the data that the program wrote into it.
(() => {
  const data = JSON.parse(document.getElementById('report-data').textContent);
  const { format, superscript } = Plots;
  const section = (id) => document.getElementById(id);

  // ---- small helpers ----
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
    const [v, s] = [value, sigma].map((x) => (x / 10 ** power).toFixed(decimals).replace('-', '−'));
    return power ? `(${v} ± ${s})·10${superscript(power)}` : `${v} ± ${s}`;
  }

  /** columns: [[heading, left?, wrap?], …]; rows: cells, or { cells, className }. */
  function table(columns, rows) {
    const kinds = columns.map(([, left, wrap]) => [left && 'left', wrap && 'wrap'].filter(Boolean).join(' ') || undefined);
    const lines = (heading) => String(heading).split('\n').flatMap((line, i) => (i ? [el('br'), line] : [line]));
    return el('div', { class: 'scroll', tabindex: 0 }, el('table', {},
      el('thead', {}, el('tr', {}, columns.map(([heading], i) => el('th', { class: kinds[i], scope: 'col' }, lines(heading))))),
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

  // ---- the data, read once ----
  const frequency = nan(data.measured.frequency);
  const complexOutput = (output) => ({ ...output, re: nan(output.re), im: nan(output.im),
    coherence: output.coherence && nan(output.coherence), sigma: output.sigma && nan(output.sigma) });
  const transferFunction = (tf) => ({ frequency: tf.frequency ? nan(tf.frequency) : frequency, outputs: tf.outputs.map(complexOutput) });
  const measured = transferFunction(data.measured);
  const predictions = [
    { key: 'structural', label: 'predicted, structural damping', colour: 'structural', ...transferFunction(data.predicted) },
    { key: 'viscous', label: 'predicted, viscous damping', colour: 'viscous', dash: [6, 3], ...transferFunction(data.viscous) },
  ];
  const modes = data.modes.list;
  const identified = data.identified;
  const fitted = identified.modulus.value.length > 0;
  const pairs = new Map(identified.pairing.pairs.map((pair) => [pair.measured, pair]));
  const trusted = (mode) => (fitted ? mode.usedForModulus || mode.usedForLossFactor : mode.flags.length === 0);
  const modulusUnit = Math.max(...nan(identified.modulus.value), 0) >= 1e9 ? ['GPa', 1e9] : ['MPa', 1e6];

  const flagMeaning = {
    coarse: 'too few lines in the half-power band for an estimate free of leakage',
    close_modes: 'a neighbour within a half-power bandwidth: the circle is not this mode’s own',
    double_mode: 'one pole stands for what looks like two modes',
    noisy: 'standard error above 5 % of the bandwidth in frequency, or above 10 % in the loss factor',
    edge: 'the half-power band reaches past the band analysed',
    poor_circle: 'scatter about the circle far above the standard deviation of the lines',
    not_converged: 'the fit did not converge',
  };
  const flagTags = (flags) => flags.map((flag) => el('span', { class: 'flag', title: flagMeaning[flag] }, flag));

  const lawFormula = { constant: 'c', power: 'c (f/f₀)ⁿ', fractional_zener: 'c₀ Re[(1 + r z)/(1 + z)], z = (i f/f_r)^α',
    monotone_spline: 'monotone cubic in ln f through knots', table: 'linear between entries' };
  const lawNames = { constant: ['c'], power: ['c', 'n', 'f₀ [Hz]'], fractional_zener: ['c₀', 'r', 'f_r [Hz]', 'α'] };
  const lawLabel = (law) => law.kind.replace('_', ' ');

  // ---- result ----
  function spread(values, scale, unit, digits = 4) {
    const sorted = nan(values).filter(Number.isFinite).sort((a, b) => a - b);
    if (sorted.length === 0) return '–';
    const [lo, hi] = [sorted[0], sorted[sorted.length - 1]].map((value) => format(value / scale, digits));
    return (lo === hi ? lo : `${lo} to ${hi}`) + (unit ? ` ${unit}` : '');
  }
  const fracs = (comparison) => comparison.outputs.map((o) => `${o.output} ${known(o.frac) ? o.frac.toFixed(4) : '–'}`).join(', ');

  function resultSentence() {
    const sound = modes.filter(trusted);
    const text = [`${plural(modes.length, 'mode')} found` +
      (modes.length ? ` between ${format(modes[0].frequency)} and ${format(modes[modes.length - 1].frequency)} Hz, ${sound.length} of them trusted.` : '.')];
    if (fitted) {
      const law = identified.modulus.laws[0];
      text.push(`The modulus of ${identified.body || 'the body'} is ${spread(identified.modulus.value, modulusUnit[1], modulusUnit[0])}` +
        `${law ? ` over frequency (${lawLabel(law)} law)` : ''}, its loss factor ${spread(identified.lossFactor.value, 1, '', 3)}.`);
    }
    const better = data.comparison.outputs.length && data.comparisonViscous.outputs.length;
    if (better) {
      const mean = (comparison) => comparison.outputs.reduce((sum, o) => sum + o.error, 0) / comparison.outputs.length;
      const [s, v] = [mean(data.comparison), mean(data.comparisonViscous)];
      text.push(`The ${s <= v ? 'structural' : 'viscous'} damping model is the closer one to the measurement ` +
        `(${format(Math.min(s, v), 3)} against ${format(Math.max(s, v), 3)} dB rms, mean over the outputs).`);
    }
    return text.join(' ');
  }

  function resultTiles() {
    const r = identified.rayleigh;
    const tiles = [[`${modes.filter(trusted).length} of ${modes.length}`, 'modes trusted']];
    if (fitted) tiles.push([spread(identified.modulus.value, modulusUnit[1], modulusUnit[0]), `modulus E(f) of ${identified.body}`]);
    if (identified.lossFactor.value.length) tiles.push([spread(identified.lossFactor.value, 1, '', 3), 'loss factor η(f)']);
    if (r.determined) {
      tiles.push([`${uncertain(r.alpha, r.alphaSigma)} 1/s`, 'Rayleigh α' + (r.alphaAtBound ? ' (held at its bound 0)' : '')],
        [`${uncertain(r.beta, r.betaSigma)} s`, 'Rayleigh β' + (r.betaAtBound ? ' (held at its bound 0)' : '')]);
    }
    if (data.comparison.outputs.length) tiles.push([fracs(data.comparison), 'FRAC, structural damping']);
    if (data.comparisonViscous.outputs.length) tiles.push([fracs(data.comparisonViscous), 'FRAC, viscous damping']);
    return el('div', { class: 'tiles' }, tiles.map(([value, label]) => el('div', { class: 'tile' }, el('b', {}, value), el('span', {}, label))));
  }

  function summary() {
    section('origin').textContent = [identified.version && `struna ${identified.version}`, identified.date,
      `${plural(frequency.length, 'line')} from ${format(frequency[0])} to ${format(frequency[frequency.length - 1])} Hz`].filter(Boolean).join(' · ');
    section('summary').append(el('p', { class: 'lead' }, resultSentence()), resultTiles());
    if (data.warnings.length)
      section('summary').append(el('ul', { class: 'warnings', 'aria-label': 'Warnings' }, data.warnings.map((text) => el('li', {}, text))));
  }

  // ---- transfer functions ----
  // Within a family, each form is the one before times (iω)^step: [name, unit, power of iω against the first].
  const families = [
    [['dynamic-stiffness', 'N/m', 0], ['impedance', 'N s/m', -1], ['apparent-mass', 'kg', -2]],
    [['receptance', 'm/N', 0], ['mobility', 'm/s/N', 1], ['accelerance', 'm/s^2/N', 2]],
  ];
  const familyOf = (kind) => families.find((family) => family.some(([name]) => name === kind));
  const formOf = (kind) => (familyOf(kind) || []).find(([name]) => name === kind);
  const wrapped = (degrees) => degrees - 360 * Math.round(degrees / 360);

  /** Magnitude and phase of an output in the wanted form (its own, where that belongs to another family). */
  function bode(lines, output, form) {
    const [own, wanted] = [formOf(output.kind), (familyOf(output.kind) || []).find(([name]) => name === form)];
    const power = own && wanted ? wanted[2] - own[2] : 0;
    const factor = lines.map((f) => (power === 0 ? 1 : f > 0 ? (2 * Math.PI * f) ** power : NaN));
    const magnitude = output.re.map((re, i) => (Math.hypot(re, output.im[i]) || NaN) * factor[i]);
    const phase = output.re.map((re, i) => wrapped((Math.atan2(output.im[i], re) * 180) / Math.PI + 90 * power));
    const sigma = output.sigma && output.sigma.map((s, i) => s * factor[i]);
    return { magnitude, phase, sigma, unit: wanted ? wanted[1] : output.unit, name: (wanted ? wanted[0] : output.kind).replace('-', ' ') };
  }

  const bodeState = { form: null, log: true, groups: [] };
  const modeMarks = modes.map((mode, i) => ({ x: mode.frequency, label: String(i + 1), hollow: !trusted(mode) }));
  const first = frequency[0] > 0 ? 0 : 1; // a logarithmic axis has no zero

  function bodeSeries(output) {
    const here = bode(measured.frequency, output, bodeState.form);
    const phaseSigma = here.sigma && here.sigma.map((s, i) => Math.min(180, (s / here.magnitude[i]) * (180 / Math.PI)));
    const band = (values, sigma) => sigma && { lo: values.map((v, i) => v - sigma[i]), hi: values.map((v, i) => v + sigma[i]) };
    const cut = (values) => values && values.slice(first);
    const bandOf = (values, sigma) => { const b = band(values, sigma); return b && { lo: cut(b.lo), hi: cut(b.hi) }; };
    const common = { key: 'measured', colour: 'measured', width: 1.1 };
    const x = cut(measured.frequency);
    const group = {
      here, x,
      magnitude: [{ ...common, x, y: cut(here.magnitude), band: bandOf(here.magnitude, here.sigma) }],
      phase: [{ ...common, x, y: cut(here.phase), band: bandOf(here.phase, phaseSigma), breakAt: 180 }],
      coherence: output.coherence ? [{ ...common, x, y: cut(output.coherence) }] : [],
      predicted: [],
    };
    for (const prediction of predictions) {
      const other = prediction.outputs.find((o) => o.name === output.name);
      if (!other) continue;
      const there = bode(prediction.frequency, other, bodeState.form);
      const style = { key: prediction.key, colour: prediction.colour, dash: prediction.dash, width: 1.8, x: prediction.frequency };
      group.predicted.push({ ...there, label: prediction.key, x: prediction.frequency });
      group.magnitude.push({ ...style, y: there.magnitude });
      group.phase.push({ ...style, y: there.phase, breakAt: 180 });
    }
    return group;
  }

  const nearestLine = (x, f) => {
    const i = Math.min(Math.max(Plots.firstAtOrAbove(x, f), 0), x.length - 1);
    return i > 0 && f - x[i - 1] < x[i] - f ? i - 1 : i;
  };

  function readOut(group, f) {
    const i = nearestLine(group.data.x, f);
    const { here } = group.data;
    const k = i + first;
    const at = (values, digits) => format(values[k], digits);
    const parts = [el('b', {}, `${format(group.data.x[i], 6)} Hz`), `  measured ${at(here.magnitude, 4)}`,
      here.sigma ? ` ± ${at(here.sigma, 2)}` : '', ` ${here.unit}, ${here.phase[k].toFixed(1).replace('-', '−')}°`,
      group.output.coherence ? `, coherence ${group.output.coherence[k].toFixed(4)}` : ''];
    for (const other of group.data.predicted) {
      const j = nearestLine(other.x, group.data.x[i]);
      parts.push(`  ·  ${other.label} ${format(other.magnitude[j], 4)} ${here.unit}, ${other.phase[j].toFixed(1).replace('-', '−')}°`);
    }
    group.readout.replaceChildren(...parts);
  }

  function moveCursor(f) {
    const x = bodeState.groups[0].data.x;
    bodeState.cursor = nearestLine(x, f);
    for (const group of bodeState.groups) {
      group.plots.forEach((plot) => Plots.setCursor(plot, x[bodeState.cursor]));
      readOut(group, x[bodeState.cursor]);
    }
  }

  const link = {
    onView: (x) => bodeState.groups.forEach((group) => group.plots.forEach((plot) => Plots.setView(plot, { x }))),
    onCursor: moveCursor,
    onStep: (steps) => {
      const { x } = bodeState.groups[0].data;
      const from = bodeState.cursor === undefined ? 0 : bodeState.cursor;
      moveCursor(x[Math.min(Math.max(from + steps, 0), x.length - 1)]);
    },
  };

  function updateBode() {
    for (const group of bodeState.groups) {
      const hidden = new Set(group.plots.flatMap((plot) => plot.spec.series).filter((s) => s.hidden).map((s) => s.key));
      group.data = bodeSeries(group.output);
      for (const plot of group.plots) {
        plot.spec.series = group.data[plot.spec.part];
        plot.spec.series.forEach((series) => { series.hidden = hidden.has(series.key); });
        plot.spec.x.log = bodeState.log;
        if (plot.spec.part === 'magnitude') plot.spec.y.label = withUnit(`|${group.data.here.name}|`, group.data.here.unit);
        plot.view.y = null;
        Plots.refresh(plot);
      }
      if (bodeState.cursor !== undefined) readOut(group, group.data.x[bodeState.cursor]);
    }
  }

  function bodeGroup(output) {
    const group = { output, plots: [], data: bodeSeries(output) };
    const marks = { list: modeMarks, heads: false, hidden: false };
    const range = [group.data.x[0], group.data.x[group.data.x.length - 1]];
    const width = 76;
    const parts = [
      ['magnitude', { label: withUnit(`|${group.data.here.name}|`, group.data.here.unit), log: true, width }],
      ['phase', { label: 'phase [°]', range: [-180, 180], ticks: [-180, -90, 0, 90, 180], width }],
      ['coherence', { label: 'coherence [–]', range: [0, 1.02], ticks: [0, 0.5, 1], width }],
    ].filter(([part]) => group.data[part].length);
    group.readout = el('div', { class: 'readout', 'aria-live': 'polite' }, 'Move over the plot, or use the arrow keys, to read values.');
    const hosts = parts.map(([part]) => el('div', { class: part }));
    const head = el('div', { class: 'card-head' }, el('h3', {}, output.name));
    section('transfer').append(el('div', { class: 'card' }, head, group.readout, hosts));
    parts.forEach(([part, y], i) => {
      group.plots.push(Plots.create(hosts[i], {
        part, label: `${part} of ${output.name} over frequency`, y, series: group.data[part], link,
        x: { label: i === parts.length - 1 ? 'frequency [Hz]' : '', log: bodeState.log, range },
        marks: { ...marks, heads: i === 0 } }));
    });
    const keys = [{ key: 'measured', label: output.sigma ? 'measured, ± σ' : 'measured' }, ...predictions];
    const entries = seriesLegend(group.plots, keys);
    if (modes.length) entries.append(...legend([{ label: 'natural frequencies (hollow: not trusted)', colour: 'soft', line: false,
      marker: { shape: 'down' }, onToggle: (hidden) => group.plots.forEach((plot) => { plot.spec.marks.hidden = hidden; Plots.refresh(plot); }) }]).childNodes);
    head.append(entries);
    return group;
  }

  function transferFunctions() {
    const family = measured.outputs.length ? familyOf(measured.outputs[0].kind) : null;
    bodeState.form = measured.outputs.length ? measured.outputs[0].kind : null;
    section('transfer').append(el('div', { class: 'controls' },
      family ? chooser('Form', family.map(([name, unit]) => [name, withUnit(name.replace('-', ' '), unit)]), bodeState.form,
        (form) => { bodeState.form = form; updateBode(); }) : null,
      chooser('Frequency axis', [[true, 'logarithmic'], [false, 'linear']], true, (log) => { bodeState.log = log; updateBode(); }),
      el('button', { type: 'button', class: 'plain', onclick: () => link.onView(null) }, 'Whole band')),
    el('p', { class: 'note hint' }, 'Drag: zoom in frequency (with Shift: in both directions). Wheel: zoom, after a click on the plot or with Ctrl. ' +
      'Double click, 0 or Esc: whole band. Arrow keys: line by line, with Shift ten lines. All frequency axes are linked.'));
    measured.outputs.forEach((output) => bodeState.groups.push(bodeGroup(output)));
  }

  // ---- comparison ----
  function comparisonTables() {
    const models = [['structural', data.comparison], ['viscous', data.comparisonViscous]].filter(([, c]) => c.outputs.length);
    if (models.length === 0) return section('comparison').remove();
    const { lo, hi } = models[0][1];
    section('comparison').append(table(
      [['output', true], ['damping model', true], ['FRAC\n[–]'], ['rms error\n[dB]'], ['mean error\n[dB]'], ['largest error\n[dB]']],
      models.flatMap(([name, c]) => c.outputs.map((o) => [o.output, name, known(o.frac) ? o.frac.toFixed(5) : '–', format(o.error, 3), format(o.mean, 3), format(o.largest, 3)]))
        .sort((a, b) => (a[0] < b[0] ? -1 : a[0] > b[0] ? 1 : 0))),
    el('p', { class: 'note' }, `Over ${format(lo)} to ${format(hi)} Hz. FRAC: frequency response assurance criterion, 1 for functions of the same shape. ` +
      'Errors: of 20 lg(|predicted|/|measured|) over the lines.'));
    for (const [name, comparison] of models)
      section('comparison').append(el('details', {}, el('summary', {}, `Peaks, ${name} damping`), table(
        [['output', true], ['measured\n[Hz]'], ['predicted\n[Hz]'], ['difference\n[%]'], ['amplitude difference\n[dB]']],
        comparison.outputs.flatMap((o) => o.peaks.map(([m, p, db]) =>
          [o.output, format(m, 6), format(p, 6), known(p) ? format((p / m - 1) * 100, 3) : '–', format(db, 3)])))));
  }

  // ---- modulus and damping ----
  /** One chart of a quantity at the modes with its laws. `quantity`: { title, label, scale, points, laws, extra } */
  function curveCard(host, quantity) {
    const scaled = (values) => nan(values).map((value) => value / quantity.scale);
    const points = (list, style) => ({ ...style, line: false, unordered: true, x: list.map((p) => p.frequency),
      y: list.map((p) => p.value / quantity.scale), error: list.map((p) => (p.sigma || 0) / quantity.scale),
      tip: (i) => `mode ${list[i].mode}: ${format(list[i].frequency, 6)} Hz\n${quantity.symbol} ${uncertain(list[i].value / quantity.scale, list[i].sigma / quantity.scale)}${quantity.unit}` +
        (list[i].flags.length ? `\n${list[i].flags.join(', ')}` : '') });
    const series = [
      ...quantity.curves.map((curve) => ({ ...curve, x: nan(identified.curveFrequency), y: scaled(curve.values) })),
      points(quantity.points.filter((p) => !p.used), { key: 'untrusted', name: 'not trusted', colour: 'untrusted', ignoreInLimits: true,
        marker: { shape: 'circle', size: 3.5, hollow: true } }),
      points(quantity.points.filter((p) => p.used), { key: 'trusted', name: 'trusted modes, ± σ', colour: 'ink', marker: { shape: 'circle', size: 3.5 } }),
    ].filter((s) => s.x.length);
    const head = el('div', { class: 'card-head' }, el('h3', {}, quantity.title));
    const plotHost = el('div');
    host.append(el('div', { class: 'card' }, head, plotHost));
    const plot = Plots.create(plotHost, { label: `${quantity.title} over frequency`, series,
      x: { label: 'frequency [Hz]', log: true }, y: { label: quantity.label } });
    plotHost.after(seriesLegend([plot], series.map((s) => ({ key: s.key, label: s.name }))));
  }

  const lawColours = ['structural', 'output-2', 'output-3', 'output-4', 'viscous'];
  const lawDashes = [undefined, [7, 3], [2, 3], [8, 3, 2, 3], [4, 4]];
  const lawCurves = (laws) => laws.map((law, i) => ({ key: `law-${i}`, name: lawLabel(law) + (i === 0 ? ' (used)' : ''), colour: lawColours[i % 5],
    dash: lawDashes[i % 5], width: i === 0 ? 3 : 1.5, values: law.curve, ignoreInLimits: i > 0,
    solidWithin: i === 0 && law.to > law.from ? [law.from, law.to] : undefined }));

  const atModes = (valueOf, used, entryOf) => modes.map((mode, i) => {
    const at = used(mode) && entryOf(mode);
    const [value, sigma] = at || valueOf(mode, i) || [NaN, NaN];
    return { mode: i + 1, frequency: mode.frequency, value, sigma, used: Boolean(at), flags: mode.flags };
  }).filter((point) => known(point.value));

  /** The identified value at a mode: its frequency is the key (the same number, rounded alike up to the last digit). */
  const identifiedAt = (curve) => (mode) => {
    const i = curve.frequency.findIndex((f) => Math.abs(f - mode.frequency) <= 1e-6 * f);
    return i < 0 ? null : [curve.value[i], curve.sigma[i]];
  };

  function lawTable(title, laws, unit) {
    return laws.length === 0 ? null : el('details', {}, el('summary', {}, title), table(
      [['law', true], ['formula', true], ['parameters', true, true], ['AICc'], ['residual / σ\n[–]'], ['data from\n[Hz]'], ['to\n[Hz]']],
      laws.map((law, i) => [lawLabel(law) + (i === 0 ? ' (used)' : ''), lawFormula[law.kind] || '',
        (lawNames[law.kind] || []).map((name, k) => `${name} = ${uncertain(law.parameters[k], law.sigma[k])}${k === 0 && unit ? ` ${unit}` : ''}`).join(',  ') ||
          law.knots.map((f, k) => `${format(law.knotValues[k])} at ${format(f)} Hz`).join(',  '),
        format(law.aicc, 5), format(law.rms, 3), format(law.from), format(law.to)])));
  }

  function parameters() {
    const host = section('parameters');
    if (!fitted && modes.length === 0) return host.remove();
    const grid = el('div', { class: 'three' });
    host.append(grid);
    const { modulus, lossFactor, rayleigh } = identified;
    if (fitted)
      curveCard(grid, { title: 'Modulus E(f)', label: `E [${modulusUnit[0]}]`, symbol: 'E', unit: ` ${modulusUnit[0]}`, scale: modulusUnit[1], curves: lawCurves(modulus.laws),
        points: atModes((_, i) => pairs.has(i) && [pairs.get(i).modulus, pairs.get(i).sigma], (m) => m.usedForModulus, identifiedAt(modulus)) });
    const lossCurves = lawCurves(lossFactor.laws);
    curveCard(grid, { title: 'Loss factor η(f)', label: 'η [–]', symbol: 'η', unit: '', scale: 1, curves: lossCurves,
      points: atModes((m) => [m.lossFactor, m.lossFactorSigma], (m) => m.usedForLossFactor, identifiedAt(lossFactor)) });
    if (identified.kramersKronig.length) addKramersKronig(grid.lastChild);
    const ratioCurves = [];
    if (rayleigh.curve) ratioCurves.push({ key: 'rayleigh', name: 'Rayleigh: α/2ω + βω/2', colour: 'viscous', dash: [6, 3], width: 2.5, values: rayleigh.curve });
    if (lossFactor.laws.length) ratioCurves.push({ key: 'half', name: 'structural: η(f)/2', colour: 'structural', width: 2, values: nan(lossFactor.laws[0].curve).map((v) => v / 2) });
    curveCard(grid, { title: 'Damping ratio ζ(f)', label: 'ζ [–]', symbol: 'ζ', unit: '', scale: 1, curves: ratioCurves,
      points: atModes((m) => [m.dampingRatio, m.lossFactorSigma / 2], (m) => m.usedForLossFactor,
        (m) => [m.dampingRatio, m.lossFactorSigma / 2]) });
    host.append(el('p', { class: 'note' }, 'Bars: ± one standard deviation. Dotted ends of a law: outside the range of its data. ' +
      'Points that are not trusted are not fitted and may lie off the scale. Laws are chosen by AICc (Akaike’s criterion, corrected for few points). ' +
      'Kramers–Kronig: (π/2) d ln E/d ln f of the modulus law; what the material alone would damp if it were purely viscoelastic; clamps, air and strands add to it.'));
    host.append(...[lawTable(`Laws of the modulus (c in Pa)`, modulus.laws, 'Pa'), lawTable('Laws of the loss factor', lossFactor.laws, '')].filter(Boolean));
    if (rayleigh.determined)
      host.append(el('p', {}, `Rayleigh coefficients: α = ${uncertain(rayleigh.alpha, rayleigh.alphaSigma)} 1/s, β = ${uncertain(rayleigh.beta, rayleigh.betaSigma)} s; ` +
        `residual ${format(rayleigh.rms, 3)} standard deviations.`));
  }

  function addKramersKronig(card) {
    const plot = lossFactorPlot(card);
    const x = nan(identified.lossFactor.frequency), y = nan(identified.kramersKronig);
    plot.spec.series.unshift({ key: 'kk', name: 'Kramers–Kronig from E(f)', colour: 'output-3', dash: [4, 4], width: 1.4, x, y,
      marker: { shape: 'rectRot', size: 3, hollow: true }, unordered: true, tip: (i) => `Kramers–Kronig\n${format(x[i], 6)} Hz\nη ${format(y[i], 3)}` });
    Plots.refresh(plot);
    card.querySelector('.legend').replaceWith(seriesLegend([plot], plot.spec.series.map((s) => ({ key: s.key, label: s.name }))));
  }
  const lossFactorPlot = (card) => [...Plots.all].find((plot) => card.contains(plot.canvas));

  // ---- modes ----
  function modeTable() {
    if (modes.length === 0) return section('modes').remove();
    const { unit, outputs } = data.modes;
    const constantUnit = data.modes.damping === 'structural' ? `${unit} rad²/s²` : `${unit} rad/s`;
    const modelFrequency = nan(data.modelFrequencies);
    const columns = [['mode'], ['natural frequency\n[Hz]'], ['half-power from\n[Hz]'], ['to\n[Hz]'], ['loss factor η\n[–]'], ['damping ratio ζ\n[–]'],
      ['flags', true]];
    if (fitted) columns.push(['model\nmode'], ['MAC\n[–]'], [`E\n[${modulusUnit[0]}]`], ['used for', true]);
    if (modelFrequency.length) columns.push(['identified model\n[Hz]'], ['off by\n[%]']);
    columns.push(['circle’s own f\n[Hz]'], ['circle’s own η\n[–]'], ...outputs.map((name) => [`${name}\n|C| [${constantUnit}]`]));
    const rows = modes.map((mode, i) => {
      const pair = pairs.get(i);
      const cells = [i + 1, uncertain(mode.frequency, mode.frequencySigma, 7), format(mode.lower, 6), format(mode.upper, 6),
        uncertain(mode.lossFactor, mode.lossFactorSigma), format(mode.dampingRatio, 4), el('span', {}, flagTags(mode.flags))];
      if (fitted) cells.push(pair ? pair.model.map((m) => m + 1).join(' + ') : '–', pair && known(pair.mac) ? pair.mac.toFixed(3) : '–',
        pair ? uncertain(pair.modulus / modulusUnit[1], pair.sigma / modulusUnit[1]) : '–',
        [mode.usedForModulus && 'E', mode.usedForLossFactor && 'η, α, β'].filter(Boolean).join(', ') || '–');
      if (modelFrequency.length) {
        const model = pair ? pair.model.reduce((sum, m) => sum + modelFrequency[m], 0) / pair.model.length : NaN;
        cells.push(format(model, 6), known(model) ? format((model / mode.frequency - 1) * 100, 2) : '–');
      }
      cells.push(format(mode.circleFrequency, 6), format(mode.circleLossFactor, 4),
        ...outputs.map((_, k) => (mode.constants[k] ? format(Math.hypot(...nan(mode.constants[k])), 4) : '–')));
      return { cells, className: trusted(mode) ? '' : 'untrusted' };
    });
    section('modes').append(table(columns, rows), el('p', { class: 'note' },
      `${data.modes.damping === 'structural' ? 'Structural' : 'Viscous'} damping; constants refer to ${data.modes.form.replace('-', ' ')}. ± is one standard deviation. ` +
      'Grey rows are not trusted. E here puts the paired model mode exactly at the measured frequency; two model modes in one row are a nearly double pair that one pole stands for.'));
    const used = [...new Set(modes.flatMap((mode) => mode.flags))];
    if (used.length) section('modes').append(el('p', { class: 'note' }, 'Flags: ', used.flatMap((flag) => [...flagTags([flag]), `${flagMeaning[flag] || ''}. `])));
  }

  // ---- Nyquist circles ----
  const outputStyle = (k) => ({ colour: `output-${k % 5}`, marker: { shape: ['circle', 'triangle', 'rect', 'rectRot', 'crossRot'][k % 5], size: 2.6 } });
  const nyquistState = { normalised: false, hidden: new Set(), shown: [] };
  const turn = Array.from({ length: 121 }, (_, i) => (2 * Math.PI * i) / 120);

  function nyquistSpec(mode, index) {
    const lines = { frequency: nan(mode.lines.frequency), outputs: mode.lines.outputs.map((o) => ({ re: nan(o.re), im: nan(o.im) })) };
    const own = mode.circles.map((c) => ({ ...c, centre: nan(c.centre), resonance: nan(c.resonance), lower: nan(c.lower), upper: nan(c.upper) }));
    const visible = (k) => !nyquistState.hidden.has(k);
    const normalised = nyquistState.normalised && own.length > 0;
    const shownLines = lines.outputs.filter((_, k) => visible(k));
    const largest = Math.max(1e-300, ...shownLines.flatMap((o) => [...o.re, ...o.im].map(Math.abs).filter(Number.isFinite)));
    const power = normalised || (largest >= 0.1 && largest < 1e3) ? 0 : 3 * Math.floor(Math.log10(largest) / 3);
    const mapped = (k) => ([re, im]) => (normalised
      ? [(re - own[k].centre[0]) / own[k].radius, (im - own[k].centre[1]) / own[k].radius] : [re / 10 ** power, im / 10 ** power]);
    const series = [];
    own.forEach((circle, k) => {
      const points = turn.map((t) => mapped(k)([circle.centre[0] + circle.radius * Math.cos(t), circle.centre[1] + circle.radius * Math.sin(t)]));
      series.push({ ...outputStyle(k), marker: undefined, key: k, hidden: !visible(k), width: 1.2, unordered: true, x: points.map((p) => p[0]), y: points.map((p) => p[1]) });
    });
    lines.outputs.forEach((output, k) => {
      const points = output.re.map((re, i) => mapped(k)([re, output.im[i]]));
      series.push({ ...outputStyle(k), key: k, hidden: !visible(k), line: false, unordered: true, x: points.map((p) => p[0]), y: points.map((p) => p[1]),
        tip: (i) => `${data.modes.outputs[k]}  ${format(lines.frequency[i], 6)} Hz\n${format(output.re[i])} ${output.im[i] < 0 ? '−' : '+'} ${format(Math.abs(output.im[i]))} i ${data.modes.unit}` });
    });
    const labelled = own.map((circle, k) => ({ ...circle, k })).filter(({ k }) => visible(k)).sort((a, b) => b.radius - a.radius)[0];
    const special = labelled ? [['resonance', 'f₀', mode.frequency], ['lower', 'f₁', mode.lower], ['upper', 'f₂', mode.upper]] : [];
    if (labelled) {
      const points = special.map(([which]) => mapped(labelled.k)(labelled[which]));
      series.push({ colour: 'ink', line: false, unordered: true, marker: { shape: 'circle', size: 4.5, hollow: true }, x: points.map((p) => p[0]), y: points.map((p) => p[1]),
        tip: (i) => `${special[i][1]} ${format(special[i][2], 6)} Hz` });
    }
    const labels = () => special.map(([which, symbol, f]) => {
      const [x, y] = mapped(labelled.k)(labelled[which]);
      const [cx, cy] = mapped(labelled.k)(labelled.centre);
      return { x, y, text: `${symbol} ${format(f, 5)}`, awayFrom: { x: cx, y: cy } };
    });
    const scale = normalised ? 'about centre / radius [–]' : `[${power ? `10${superscript(power)} ` : ''}${data.modes.unit}]`;
    return { label: `Nyquist plot of mode ${index + 1}`, series, labels, equal: true, x: { label: `Re ${scale}` }, y: { label: `Im ${scale}` } };
  }

  function nyquistCard(mode, index) {
    const host = el('div');
    const enlarge = el('button', { type: 'button', class: 'plain', 'aria-pressed': false, onclick: (event) => {
      const large = card.classList.toggle('large');
      event.currentTarget.textContent = large ? 'smaller' : 'larger';
      event.currentTarget.setAttribute('aria-pressed', large);
    } }, 'larger');
    const scatter = mode.circles.length ? `, scatter ${format(100 * Math.max(...mode.circles.map((c) => c.scatter)), 2)} % of radius` : '';
    const card = el('div', { class: 'card' }, el('div', { class: 'card-head' }, el('h3', {}, `Mode ${index + 1} `, ...flagTags(mode.flags)), enlarge),
      el('div', { class: 'facts' }, `${uncertain(mode.frequency, mode.frequencySigma, 7)} Hz, η ${uncertain(mode.lossFactor, mode.lossFactorSigma)}`, el('br'),
        mode.lines.frequency.length ? `${plural(mode.lines.frequency.length, 'line')}, ${format(mode.lines.frequency[0], 5)} to ${format(mode.lines.frequency[mode.lines.frequency.length - 1], 5)} Hz${scatter}` : 'no lines'),
      host);
    return { card, host, mode, index, plot: null };
  }

  function drawNyquist(entry) {
    if (entry.plot) entry.plot.spec = nyquistSpec(entry.mode, entry.index);
    else entry.plot = Plots.create(entry.host, nyquistSpec(entry.mode, entry.index));
    Plots.setView(entry.plot, { x: null, y: null });
  }

  function nyquist() {
    const host = section('nyquist');
    if (modes.length === 0) return host.remove();
    const entries = modes.map(nyquistCard);
    const redraw = () => entries.filter((entry) => entry.plot).forEach(drawNyquist);
    host.append(el('div', { class: 'controls' },
      legend(data.modes.outputs.map((name, k) => ({ ...outputStyle(k), label: name, onToggle: (hidden) => {
        if (hidden) nyquistState.hidden.add(k); else nyquistState.hidden.delete(k);
        redraw();
      } }))),
      chooser('Scale', [[false, 'as measured'], [true, 'each circle about its centre, over its radius']], false,
        (normalised) => { nyquistState.normalised = normalised; redraw(); })),
    el('p', { class: 'note' }, `Lines of the mode’s window in the form in which a mode is a circle (${data.modes.form.replace('-', ' ')}), with the fitted circle of each output. ` +
      'f₀: natural frequency, f₁ and f₂: half-power frequencies [Hz], marked on the largest circle shown.'),
    el('div', { class: 'circles' }, entries.map((entry) => entry.card)));
    // Drawn when they come near the screen, all of them before printing.
    const near = new IntersectionObserver((seen) => seen.filter((s) => s.isIntersecting).forEach((s) => {
      near.unobserve(s.target);
      drawNyquist(entries.find((entry) => entry.card === s.target));
    }), { rootMargin: '500px' });
    entries.forEach((entry) => near.observe(entry.card));
    addEventListener('beforeprint', () => entries.filter((entry) => !entry.plot).forEach(drawNyquist));
  }

  // ---- left out ----
  function leftOut() {
    const host = section('left-out');
    const { pairing } = identified;
    const rows = [
      ...data.modes.rejected.map((r) => [r.frequency, 'candidate that is no mode', r.reason]),
      ...identified.rejected.map((r) => [r.frequency, 'mode not used for the parameters', r.reason]),
    ];
    const told = (f) => identified.rejected.some((r) => Math.abs(r.frequency - f) <= 1e-6 * f);
    for (const { measured: i, reason } of pairing.leftOut)
      if (modes[i] && !told(modes[i].frequency)) rows.push([modes[i].frequency, 'mode without a model mode', reason]);
    rows.sort((a, b) => a[0] - b[0]);
    const missing = pairing.missing.map((m) => `${m + 1}` + (known(data.modelFrequencies[m]) ? ` (${format(data.modelFrequencies[m], 5)} Hz)` : ''));
    host.append(rows.length ? table([['at\n[Hz]'], ['what', true], ['why', true, true]], rows.map(([f, what, why]) => [format(f, 6), what, why]))
      : el('p', {}, 'Nothing was left out.'));
    if (missing.length) host.append(el('p', {}, `Model modes in the band that were not measured: ${missing.join(', ')}.`));
  }

  // ---- provenance ----
  function provenance() {
    const host = section('provenance');
    const definition = (rows) => table([['', true], ['', true, true]], rows);
    const band = identified.band[1] > identified.band[0] ? [['band analysed', `${format(identified.band[0])} to ${format(identified.band[1])} Hz`]] : [];
    const settings = [...data.settings, ...band];
    if (settings.length) host.append(el('h3', {}, 'Settings'), definition(settings));
    host.append(el('h3', {}, 'Inputs'), identified.inputs.length
      ? table([['file', true], ['SHA-256', true, true]], identified.inputs.map(([name, hash]) => [name, el('code', { class: 'hash' }, hash)])) : el('p', {}, 'No inputs recorded.'));
    host.append(el('p', { class: 'note' }, [identified.version && `Written by struna ${identified.version}`, identified.date].filter(Boolean).join(', ')));
    if (data.command) host.append(el('h3', {}, 'How to reproduce'), el('pre', {}, data.command));
    for (const [name, text] of data.inputFiles) host.append(el('details', {}, el('summary', {}, name), el('pre', {}, text)));
  }

  function contents() {
    for (const part of document.querySelectorAll('main > section'))
      section('contents').append(el('a', { href: `#${part.id}` }, part.querySelector('h2').textContent));
  }

  // Paper is light whatever the screen is.
  addEventListener('beforeprint', () => { document.documentElement.dataset.scheme = 'light'; Plots.refreshAll(); });
  addEventListener('afterprint', () => { delete document.documentElement.dataset.scheme; Plots.refreshAll(); });

  summary();
  transferFunctions();
  comparisonTables();
  parameters();
  modeTable();
  nyquist();
  leftOut();
  provenance();
  contents();
  document.documentElement.dataset.ready = 'true'; // for checks of the page
})();
