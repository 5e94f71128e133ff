'use strict';
// The page of `struna tradeoff`: a chart of error over time for each quantity, its advice, its rows.
(() => {
  const data = JSON.parse(document.getElementById('report-data').textContent);
  const { format } = Axes;
  const { el, table, legend } = Elements;
  const colours = ['output-0', 'output-1', 'output-2', 'output-3', 'output-4', 'ink', 'untrusted', 'viscous'];
  const shapes = ['circle', 'rect', 'triangle', 'rectRot'];
  const time = (seconds) => (seconds >= 1 ? `${format(seconds, 3)} s` : seconds >= 1e-3 ? `${format(1e3 * seconds, 3)} ms` : `${format(1e6 * seconds, 3)} µs`);

  const drawable = (chart) => chart.rows.filter((row) => row.error !== null && row.seconds > 0);

  function methodSeries(chart) {
    const methods = [...new Set(drawable(chart).map((row) => row.method))];
    return methods.map((method, i) => {
      const rows = drawable(chart).filter((row) => row.method === method);
      return { key: method, rows, unordered: true, x: rows.map((row) => row.seconds), y: rows.map((row) => row.told),
        colour: colours[i % colours.length], marker: { shape: shapes[i % shapes.length], size: 4.5 }, width: 1.4,
        tip: (k) => `${method}, ${rows[k].label}\nerror ${format(rows[k].error, 3)}, ${time(rows[k].seconds)}` +
          `${rows[k].pareto ? '\non the front' : ''}${rows[k].isDefault ? '\nthe default' : ''}` };
    });
  }

  /** What can be had by a given time: a staircase. */
  function frontSeries(chart) {
    const rows = chart.rows.filter((row) => row.pareto).sort((a, b) => a.seconds - b.seconds);
    const x = [], y = [];
    rows.forEach((row, i) => {
      if (i) { x.push(row.seconds); y.push(rows[i - 1].told); }
      x.push(row.seconds); y.push(row.told);
    });
    if (rows.length) { x.push(Math.max(...drawable(chart).map((row) => row.seconds))); y.push(rows[rows.length - 1].told); }
    return { key: 'front', unordered: true, x, y, colour: 'soft', dash: [5, 4], width: 1.2 };
  }

  function defaultSeries(chart) {
    const rows = drawable(chart).filter((row) => row.isDefault);
    return { key: 'default', unordered: true, line: false, x: rows.map((row) => row.seconds), y: rows.map((row) => row.told),
      colour: 'ink', marker: { shape: 'circle', size: 10, hollow: true } };
  }

  /** Labels away from the middle of the cloud, in a logarithmic picture. */
  function labels(series) {
    const all = series.flatMap((s) => (s.hidden ? [] : s.rows.map((row) => ({ x: row.seconds, y: row.told, text: format(row.value, 3) }))));
    const middle = (key) => Math.exp(all.reduce((sum, point) => sum + Math.log(point[key]), 0) / all.length);
    const awayFrom = all.length ? { x: middle('x'), y: middle('y') } : null;
    return all.map((point) => ({ ...point, awayFrom }));
  }

  function chartCard(host, chart) {
    const methods = methodSeries(chart);
    const front = frontSeries(chart);
    const ring = defaultSeries(chart);
    const reference = chart.referenceError > 0
      ? [{ key: 'reference', unordered: true, ignoreInLimits: true, x: [1e-9, 1e6], y: [chart.referenceError, chart.referenceError], colour: 'viscous', dash: [2, 3], width: 1 }] : [];
    const body = el('div', { style: 'height: 420px' });
    const card = el('div', { class: 'card' }, el('div', { class: 'card-head' }, el('h3', {}, chart.title)), el('p', {}, chart.advice));
    host.append(card);
    card.append(body);
    const plot = Plots.create(body, {
      label: `${chart.title}: error over time`,
      x: { label: 'time, one thread [s]', log: true }, y: { label: `error of the ${chart.quantity} [–]`, log: true },
      series: [ring, ...methods, front, ...reference], labels: () => labels(methods) });
    const knobs = (s) => [...new Set(s.rows.map((row) => row.knob))].join(', ');
    const toggles = (s, label) => ({ ...s, label, onToggle: (hidden) => { s.hidden = hidden; Plots.refresh(plot); } });
    card.append(legend([...methods.map((s) => toggles(s, `${s.key} (label: ${knobs(s)})`)), toggles(front, 'Pareto front'), toggles(ring, 'default')]));
    card.append(el('p', { class: 'note' }, `Error: ${chart.errorLabel}. Reference: ${chart.reference}` +
      `${chart.referenceError > 0 ? `; its own error is about ${format(chart.referenceError, 2)} (dotted line: smaller ones are not told apart)` : ''}.`));
    if (chart.notes.length) card.append(el('p', { class: 'note' }, chart.notes.join(' ')));
    if (chart.better.length)
      card.append(...Frame.warnings([`Quicker and more accurate than the default, both by more than 1.5: ${chart.better.join('; ')}`]));
    card.append(el('details', {}, el('summary', {}, `${chart.rows.length} rows`), table(
      [['method', true], ['knob', true], ['value'], ['error [–]'], ['time'], ['', true]],
      chart.rows.map((row) => [row.method, row.knob, format(row.value, 4), row.error === null ? '–' : format(row.error, 3), time(row.seconds),
        [row.pareto && 'front', row.isDefault && 'default'].filter(Boolean).join(', ')]))));
  }

  document.getElementById('origin').textContent =
    'Processor time of one thread, best of several runs; files are read beforehand. A point’s label is the knob’s value; hover for more.';
  for (const stage of data.stages) {
    const host = document.getElementById(stage.name);
    stage.charts.forEach((chart) => chartCard(host, chart));
  }
  if (data.stages.length)
    document.getElementById(data.stages[data.stages.length - 1].name).append(el('h3', {}, 'How to reproduce'), el('pre', {}, data.command));
  Frame.finish();
})();
