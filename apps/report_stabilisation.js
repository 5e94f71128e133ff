'use strict';
// The stabilisation chart: poles of models of rising order over frequency, those that stay told apart from those that come
// and go, the mean level of the measured functions behind them.
const StabilisationChart = (() => {
  const { format } = Axes;
  const { el, nan, uncertain, table, chooser, legend, seriesLegend } = Elements;

  const kinds = [
    { key: 'new', name: 'new', colour: 'untrusted', marker: { shape: 'crossRot', size: 3 } },
    { key: 'f', name: 'frequency stays', colour: 'output-1', marker: { shape: 'triangle', size: 4, hollow: true } },
    { key: 'f+eta', name: 'loss factor stays too', colour: 'output-2', marker: { shape: 'rect', size: 4, hollow: true } },
    { key: 'all', name: 'shape over the outputs stays too', colour: 'output-0', marker: { shape: 'circle', size: 3.4 } },
  ];
  const levelRange = 80; // dB shown below the largest

  /** Root of the mean square over the outputs, each over its own mean square: level in dB below the largest. */
  function meanLevel(measured) {
    const power = measured.frequency.map(() => 0);
    for (const output of measured.outputs) {
      const squares = output.re.map((re, i) => re * re + output.im[i] * output.im[i]);
      const mean = squares.reduce((sum, value) => sum + (value || 0), 0) / squares.length;
      if (mean > 0) squares.forEach((value, i) => { power[i] += value / mean; });
    }
    const largest = power.reduce((most, value) => (value > most ? value : most), 0);
    return power.map((value) => 10 * Math.log10(value / largest));
  }

  /** The level between the bottom of the plot and 0.96 of its height: lowest and highest of each pixel. */
  const levelPainter = (state, frequency, level) => (context, scales) => {
    if (state.levelHidden) return;
    const { x, y } = scales;
    const height = (value) => y.bottom - 0.96 * (y.bottom - y.top) * Math.max(0, 1 + value / levelRange);
    context.beginPath();
    let pixel = -Infinity, low = 0, high = 0, started = false;
    const put = () => {
      if (pixel === -Infinity) return;
      if (started) context.lineTo(pixel, low); else context.moveTo(pixel, low);
      started = true;
      context.lineTo(pixel, high);
    };
    frequency.forEach((f, i) => {
      if (f < x.min || f > x.max || !Number.isFinite(level[i])) return;
      const at = Math.round(x.getPixelForValue(f)), place = height(level[i]);
      if (at !== pixel) { put(); pixel = at; low = high = place; }
      low = Math.min(low, place);
      high = Math.max(high, place);
    });
    put();
    context.strokeStyle = Axes.tint('soft');
    context.globalAlpha = 0.45;
    context.lineWidth = 1.3;
    context.stroke();
    context.globalAlpha = 1;
  };

  function seriesOf(found) {
    return kinds.map((kind, k) => {
      const chosen = found.stability.flatMap((value, i) => (value === k ? [i] : []));
      return { ...kind, line: false, unordered: true, x: chosen.map((i) => found.frequency[i]), y: chosen.map((i) => found.order[i]),
        tip: (i) => `order ${found.order[chosen[i]]}: ${format(found.frequency[chosen[i]], 6)} Hz\nη ${format(found.lossFactor[chosen[i]], 4)}\n${kind.name}` };
    });
  }

  function columnTable(columns, modes) {
    const modeOf = (column) => {
      const distance = (mode) => Math.abs(mode.frequency - column.frequency);
      const i = modes.reduce((best, mode, k) => (best < 0 || distance(mode) < distance(modes[best]) ? k : best), -1);
      return i >= 0 && distance(modes[i]) < 0.5 * column.frequency * column.lossFactor ? String(i + 1) : 'none';
    };
    return el('details', {}, el('summary', {}, 'Stable columns'), table(
      [['frequency\n[Hz]'], ['loss factor η\n[–]'], ['stands in'], ['mode']],
      columns.map((c) => [uncertain(c.frequency, c.frequencySpread, 7), uncertain(c.lossFactor, c.lossFactorSpread), `${c.orders} of ${c.of} orders`, modeOf(c)])),
    el('p', { class: 'note' }, '±: standard deviation over the orders, which is no error bar: the mode’s own is in the table of modes.'));
  }

  /** found: { order, frequency, lossFactor, stability, columns }, marks: natural frequencies [{ x, label, hollow }]. */
  function draw(host, found, measured, modes, marks) {
    if (found.order.length === 0) return host.remove();
    const state = { levelHidden: false };
    const from = measured.frequency[0] > 0 ? 0 : 1;
    const frequency = measured.frequency.slice(from), level = meanLevel(measured).slice(from);
    const last = frequency[frequency.length - 1];
    const highest = found.order.reduce((most, value) => Math.max(most, value), 0);
    const plotHost = el('div', { class: 'stabilisation' });
    const head = el('div', { class: 'card-head' });
    host.append(el('div', { class: 'controls' }, chooser('Frequency axis', [[true, 'logarithmic'], [false, 'linear']], true, (log) => {
      plot.spec.x.log = log;
      Plots.refresh(plot);
    })), el('div', { class: 'card' }, head, plotHost));
    const plot = Plots.create(plotHost, { label: 'Poles of models of rising order over frequency', series: seriesOf(found),
      x: { label: 'frequency [Hz]', log: true, range: [frequency[0], last] }, y: { label: 'model order [–]', range: [0, highest + 1], width: 76 },
      marks: { list: marks, heads: true }, paint: levelPainter(state, frequency, level) });
    const entries = seriesLegend([plot], kinds.map(({ key, name }) => ({ key, label: name })));
    entries.append(...legend([
      { label: `mean level of the outputs, ${levelRange} dB from bottom to top`, colour: 'soft', onToggle: (hidden) => { state.levelHidden = hidden; Plots.refresh(plot); } },
      { label: 'natural frequencies identified (hollow: not trusted)', colour: 'soft', line: false, marker: { shape: 'down' },
        onToggle: (hidden) => { plot.spec.marks.hidden = hidden; Plots.refresh(plot); } },
    ]).childNodes);
    head.append(entries);
    host.append(el('p', { class: 'note' }, 'Poles of a rational function of all outputs with one denominator, of each order: what belongs to the structure stays when the order ' +
      'rises. New: no pole of the order below within 0.2 of its half-power band. Loss factor: within 25 % of that of the order below. Shape: assurance of the constants over the outputs at least 0.95. ' +
      'Negative damping and poles within the noise are not shown. Wide windows cover the band, narrow ones the surroundings of each column; the order counts the poles of a window.'),
    columnTable(found.columns, modes));
  }

  return { draw };
})();
