'use strict';
// Bode plots: magnitude, phase and coherence of every output on linked frequency axes, in any form of its family.
const Bode = (() => {
  const { format, minus } = Axes;
  const { el, withUnit, chooser, legend, seriesLegend } = Elements;

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

  const state = { form: null, log: true, groups: [], cursor: null, measured: null, name: 'measured', predictions: [], marks: [] };
  function bodeSeries(output) {
    const here = bode(state.measured.frequency, output, state.form);
    const phaseSigma = here.sigma && here.sigma.map((s, i) => Math.min(180, (s / here.magnitude[i]) * (180 / Math.PI)));
    const band = (values, sigma) => sigma && { lo: values.map((v, i) => v - sigma[i]), hi: values.map((v, i) => v + sigma[i]) };
    const cut = (values) => values && values.slice(state.first);
    const bandOf = (values, sigma) => { const b = band(values, sigma); return b && { lo: cut(b.lo), hi: cut(b.hi) }; };
    const common = { key: 'measured', colour: 'measured', width: 1.8 };
    const x = cut(state.measured.frequency);
    const group = {
      here, x,
      magnitude: [{ ...common, x, y: cut(here.magnitude), band: bandOf(here.magnitude, here.sigma) }],
      phase: [{ ...common, x, y: cut(here.phase), band: bandOf(here.phase, phaseSigma), breakAt: 180 }],
      coherence: output.coherence ? [{ ...common, width: 1, x, y: cut(output.coherence) }] : [],
      predicted: [],
    };
    for (const prediction of state.predictions) {
      const other = prediction.outputs.find((o) => o.name === output.name);
      if (!other) continue;
      const there = bode(prediction.frequency, other, state.form);
      const style = { key: prediction.key, colour: prediction.colour, dash: prediction.dash, width: 1.4, hidden: prediction.hidden, x: prediction.frequency };
      group.predicted.push({ ...there, label: prediction.short || prediction.key, magnitudeOnly: prediction.magnitudeOnly, x: prediction.frequency });
      // Before the measurement, that is above it: of two series, the first one covers the other.
      group.magnitude.unshift({ ...style, y: there.magnitude });
      if (!prediction.magnitudeOnly) group.phase.unshift({ ...style, y: there.phase, breakAt: 180 });
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
    const k = i + state.first;
    const at = (values, digits) => format(values[k], digits);
    const parts = [el('b', {}, `${format(group.data.x[i], 6)} Hz`), `  ${state.name} ${at(here.magnitude, 4)}`,
      here.sigma ? ` ± ${at(here.sigma, 2)}` : '', ` ${here.unit}, ${minus(here.phase[k].toFixed(1))}°`,
      group.output.coherence ? `, coherence ${group.output.coherence[k].toFixed(4)}` : ''];
    for (const other of group.data.predicted) {
      const j = nearestLine(other.x, group.data.x[i]);
      parts.push(`  ·  ${other.label} ${format(other.magnitude[j], 4)} ${here.unit}`, other.magnitudeOnly ? '' : `, ${minus(other.phase[j].toFixed(1))}°`);
    }
    group.readout.replaceChildren(...parts);
  }

  function moveCursor(f) {
    const x = state.groups[0].data.x;
    state.cursor = nearestLine(x, f);
    for (const group of state.groups) {
      group.plots.forEach((plot) => Plots.setCursor(plot, x[state.cursor]));
      readOut(group, x[state.cursor]);
    }
  }

  const link = {
    onView: (x) => state.groups.forEach((group) => group.plots.forEach((plot) => Plots.setView(plot, x ? { x } : { x, y: null }))),
    onCursor: moveCursor,
    onStep: (steps) => {
      const { x } = state.groups[0].data;
      const { min, max } = state.groups[0].plots[0].chart.scales.x;
      const seen = state.cursor !== null && x[state.cursor] >= min && x[state.cursor] <= max;
      const next = seen ? state.cursor + steps : nearestLine(x, steps > 0 ? min : max);
      moveCursor(x[Math.min(Math.max(next, 0), x.length - 1)]);
    },
  };

  function updateBode() {
    for (const group of state.groups) {
      const hidden = new Set(group.plots.flatMap((plot) => plot.spec.series).filter((s) => s.hidden).map((s) => s.key));
      group.data = bodeSeries(group.output);
      for (const plot of group.plots) {
        plot.spec.series = group.data[plot.spec.part];
        plot.spec.series.forEach((series) => { series.hidden = hidden.has(series.key); });
        plot.spec.x.log = state.log;
        if (plot.spec.part === 'magnitude') plot.spec.y.label = withUnit(`|${group.data.here.name}|`, group.data.here.unit);
        plot.view.y = null;
        Plots.refresh(plot);
      }
      if (state.cursor !== null) readOut(group, group.data.x[state.cursor]);
    }
  }

  function bodeGroup(output) {
    const group = { output, plots: [], data: bodeSeries(output) };
    const marks = { list: state.marks, heads: false, hidden: false };
    const range = [group.data.x[0], group.data.x[group.data.x.length - 1]];
    const width = 76;
    const parts = [
      ['magnitude', { label: withUnit(`|${group.data.here.name}|`, group.data.here.unit), log: true, width }],
      ['phase', { label: 'phase [°]', range: [-180, 180], ticks: [-180, -90, 0, 90, 180], width }],
      ['coherence', { label: 'coherence [–]', range: [0, 1.06], ticks: [0, 0.5, 1], width }],
    ].filter(([part]) => group.data[part].length);
    group.readout = el('div', { class: 'readout', 'aria-live': 'polite' }, 'Move over the plot, or use the arrow keys, to read values.');
    const hosts = parts.map(([part]) => el('div', { class: part }));
    const head = el('div', { class: 'card-head' }, el('h3', {}, output.name));
    state.host.append(el('div', { class: 'card' }, head, group.readout, hosts));
    parts.forEach(([part, y], i) => {
      group.plots.push(Plots.create(hosts[i], {
        part, label: `${part} of ${output.name} over frequency`, y, series: group.data[part], link,
        x: { label: i === parts.length - 1 ? 'frequency [Hz]' : '', log: state.log, range },
        marks: { ...marks, heads: i === 0 } }));
    });
    const keys = [{ key: 'measured', label: output.sigma ? `${state.name}, ± σ` : state.name }, ...state.predictions];
    const entries = seriesLegend(group.plots, keys);
    if (state.marks.length) entries.append(...legend([{ label: 'natural frequencies (hollow: not trusted)', colour: 'soft', line: false,
      marker: { shape: 'down' }, onToggle: (hidden) => group.plots.forEach((plot) => { plot.spec.marks.hidden = hidden; Plots.refresh(plot); }) }]).childNodes);
    head.append(entries);
    return group;
  }

  /** predictions: [{ key, label, colour, dash, hidden, magnitudeOnly, frequency, outputs }]; marks: natural frequencies [{ x, label, hollow }];
   *  name: what the first function is called. */
  function draw(host, measured, predictions, marks, name = 'measured') {
    Object.assign(state, { host, measured, predictions, marks, name, first: measured.frequency[0] > 0 ? 0 : 1 }); // a logarithmic axis has no zero
    const family = measured.outputs.length ? familyOf(measured.outputs[0].kind) : null;
    state.form = measured.outputs.length ? measured.outputs[0].kind : null;
    host.append(el('div', { class: 'controls' },
      family ? chooser('Form', family.map(([name, unit]) => [name, withUnit(name.replace('-', ' '), unit)]), state.form,
        (form) => { state.form = form; updateBode(); }) : null,
      chooser('Frequency axis', [[true, 'logarithmic'], [false, 'linear']], true, (log) => { state.log = log; updateBode(); }),
      el('button', { type: 'button', class: 'plain', onclick: () => link.onView(null) }, 'Whole band')),
    el('p', { class: 'note hint' }, 'Drag: zoom in frequency (with Shift: in both directions). Wheel: zoom, after a click on the plot or with Ctrl. ' +
      'Double click, 0 or Esc: whole band. Arrow keys: line by line, with Shift ten lines. All frequency axes are linked.'));
    measured.outputs.forEach((output) => state.groups.push(bodeGroup(output)));
  }

  return { draw };
})();
