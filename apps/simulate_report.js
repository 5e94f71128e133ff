'use strict';
// The page of a simulation: plots and tables from the data that the program wrote into it.
(() => {
  const data = JSON.parse(document.getElementById('report-data').textContent);
  const { format } = Axes;
  const { el, nan, plural, withUnit, table, chooser, seriesLegend } = Elements;
  const section = (id) => document.getElementById(id);
  const own = { key: 'simulated', label: 'simulated', colour: 'measured', width: 1.5 };
  const linear = { key: 'linear', short: 'without contact', label: 'without contact (harmonic)', colour: 'structural', width: 1.4 };
  const measured = { key: 'record', short: 'measured', label: 'measured', colour: 'viscous', dash: [5, 3], width: 1.4 };
  const largestOf = (values) => values.reduce((most, value) => (Math.abs(value) > most ? Math.abs(value) : most), 0);

  /** A unit that keeps numbers near one, and the factor to it. */
  function readableUnit(unit, largest) {
    const prefixes = { m: [['m', 1], ['mm', 1e3], ['µm', 1e6], ['nm', 1e9]], N: [['N', 1], ['mN', 1e3]], J: [['J', 1], ['mJ', 1e3], ['µJ', 1e6]] }[unit];
    if (!prefixes || !(largest > 0)) return [unit || '–', 1];
    return prefixes.find(([, factor]) => largest * factor >= 0.5) || prefixes[prefixes.length - 1];
  }

  // ---- plots that belong together ----
  /**
   * Plots over one axis: they zoom and move together. `read(x)` tells what is there, `step` is what an arrow
   * key moves by.
   */
  function linkedPlots(read, step) {
    const group = { plots: [], cursor: null, readout: el('div', { class: 'readout', 'aria-live': 'polite' }, 'Move over a plot, or use the arrow keys, to read values.') };
    const move = (x) => {
      group.cursor = x;
      group.plots.forEach((plot) => Plots.setCursor(plot, x));
      group.readout.replaceChildren(...read(x));
    };
    group.link = {
      onView: (x) => group.plots.forEach((plot) => Plots.setView(plot, x ? { x } : { x, y: null })),
      onCursor: move,
      onStep: (steps) => {
        const { min, max } = group.plots[0].chart.scales.x;
        move(Math.min(Math.max((group.cursor === null ? (min + max) / 2 : group.cursor) + steps * step, min), max));
      },
    };
    group.add = (host, className, spec) => {
      const place = el('div', { class: className });
      host.append(place);
      const plot = Plots.create(place, { ...spec, link: group.link });
      group.plots.push(plot);
      return plot;
    };
    return group;
  }
  const hint = () => el('p', { class: 'note hint' },
    'Drag: zoom in time (with Shift: in both directions). Wheel: zoom, after a click on the plot or with Ctrl. Double click, 0 or Esc: everything.');

  // ---- result ----
  function deepestContact() {
    let best = null;
    for (const map of data.contacts)
      map.penetration.forEach((row, bin) => row.forEach((g, point) => {
        if (!best || g > best.g) best = { g, map, time: (bin + 0.5) * map.interval, arcLength: map.arcLength[point] };
      }));
    return best;
  }
  function resultSentence() {
    const text = [`${format(data.duration, 4)} s simulated${data.complete ? '' : ' before the run was interrupted'}.`];
    const best = deepestContact();
    if (data.linear)
      text.push(data.nearest > 0 ? `No gap closes: the nearest point reaches ${format(100 * data.nearest, 3)} % of its gap, and the linear solution is the whole answer.` :
                                   'No contact: the linear solution is the whole answer.');
    else if (best && best.g > 0) {
      const [unit, factor] = readableUnit('m', best.g);
      text.push(`${plural(data.events, 'contact event')}. “${best.map.inside}” presses up to ${format(best.g * factor, 3)} ${unit} into “${best.map.outside}”, ` +
        `${format(best.arcLength, 3)} m along it, at ${format(best.time, 4)} s.`);
    } else text.push('The gaps stayed open.');
    if (data.comparison && data.comparison.signals.length) {
      const s = data.comparison.signals[0];
      const r = nan(s.correlation);
      text.push(`${s.name} correlates with the measured one between ${Math.min(...r).toFixed(3)} and ${Math.max(...r).toFixed(3)} over its intervals of ${format(data.comparison.interval)} s.`);
    }
    return text.join(' ');
  }
  function summary() {
    section('origin').textContent = [`struna ${data.version}`, data.date, `${format(data.duration, 4)} s at ${format(data.sampleRate, 6)} Hz`].join(' · ');
    section('summary').append(el('p', { class: 'lead' }, resultSentence()), ...Frame.warnings(data.warnings), el('h3', {}, 'What the program chose and found'),
      table([['', true], ['', true, true]], data.chosen));
  }

  // ---- against a measurement ----
  /** Levels as steps over the bands' edges. */
  const steps = (edges, levels) =>
    ({ unordered: true, x: edges.flatMap((edge, k) => (k < levels.length ? [edge, edges[k + 1]] : [])), y: levels.flatMap((level) => [level, level]) });
  const bandName = (edges, k) => `${format(edges[k], 3)} – ${format(edges[k + 1], 3)}`;

  function comparison() {
    const host = section('measured');
    if (!data.comparison) return host.remove();
    const { signals, interval, skipped, file, notCompared, motionCorrelation } = data.comparison;
    host.append(el('p', {}, `Sample by sample with ${file}, ${motionCorrelation > 0.99 ? 'whose motion drove the simulation' : `whose motion is NOT the one that drove the simulation (correlation ${format(motionCorrelation, 3)}): the two have nothing to do with each other`}.`));
    if (notCompared.length) host.append(el('p', { class: 'note' }, `At rest in one of the two, not compared: ${notCompared.join(', ')}.`));
    for (const signal of signals) {
      const card = el('div', { class: 'three' });
      host.append(el('h3', {}, signal.name), card);
      const r = nan(signal.correlation);
      const plotIn = (title, spec) => {
        const place = el('div');
        card.append(el('div', { class: 'card' }, el('div', { class: 'card-head' }, el('h3', {}, title)), place));
        Plots.create(place, spec);
      };
      plotIn(`Correlation in intervals of ${format(interval)} s`, {
        label: 'correlation over time',
        x: { label: 'time [s]' },
        y: { label: 'correlation [–]', range: [Math.min(0.8, ...r) - 0.01, 1.005] },
        series: [{
          colour: 'measured',
          marker: { shape: 'circle', size: 4 },
          unordered: true,
          x: r.map((_, i) => (i + 0.5) * interval),
          y: r,
          tip: (i) => `${format(i * interval)} to ${format((i + 1) * interval)} s\nr = ${r[i].toFixed(4)}`
        }]
      });
      const difference = nan(signal.difference);
      const largest = Math.max(0.5, 1.2 * largestOf(difference));
      plotIn('Half-octave levels: simulated less measured', {
        label: 'level difference over frequency',
        x: { label: 'frequency [Hz]', log: true },
        y: { label: 'difference [dB]', range: [-largest, largest] },
        series:
          [{ colour: 'measured', width: 2, ...steps(nan(signal.edges), difference), tip: (i) => `${bandName(signal.edges, i >> 1)} Hz\n${format(difference[i >> 1], 3)} dB` }]
      });
      host.append(el('p', {},
                    `Correlation of the whole${skipped > 0 ? ` from ${format(skipped)} s on` : ''}: ${format(signal.all, 4)}. Largest level difference: ${format(largestOf(difference), 3)} dB.`),
        el('details', {}, el('summary', {}, `Levels of ${signal.name}`),
          table([['band\n[Hz]'], [`measured\n[${signal.unit} rms]`], [`simulated\n[${signal.unit} rms]`], ['difference\n[dB]']],
            difference.map((db, k) => [bandName(signal.edges, k), format(signal.measured[k], 4), format(signal.simulated[k], 4), format(db, 3)]))));
    }
  }

  // ---- waveforms ----
  const axisWidth = 84;
  /** Times of the samples, or each bin's middle twice: for its least and its largest value. */
  function wave(channel, perBin, interval, start = 0) {
    const lo = nan(channel.lo), factor = channel.factor;
    if (perBin === 1) return { x: lo.map((_, i) => start + i * interval), y: lo.map((v) => v * factor) };
    const hi = nan(channel.hi);
    return { x: lo.flatMap((_, i) => [start + (i + 0.5) * interval, start + (i + 0.5) * interval]), y: lo.flatMap((v, i) => [v * factor, hi[i] * factor]) };
  }
  const titled = { displacement: 'base motion', acceleration: 'base acceleration' };
  const channels = data.whole.channels.map((channel) => {
    const [unit, factor] = readableUnit(channel.unit, largestOf([...nan(channel.lo), ...nan(channel.hi)]));
    return { ...channel, unit, factor, title: titled[channel.name] || channel.name };
  });
  const moving = channels.filter((channel) => !data.atRest.includes(channel.name));

  function wholeWaveforms(host) {
    const { perBin, interval } = data.whole;
    const group = linkedPlots((t) => {
      const i = Math.min(Math.max(Math.floor(t / interval), 0), channels[0].lo.length - 1);
      const parts = [el('b', {}, `${format((i + (perBin > 1 ? 0.5 : 0)) * interval, 6)} s`)];
      for (const c of moving) {
        const [lo, hi] = [c.lo[i], (c.hi || c.lo)[i]].map((v) => format(v * c.factor, 4));
        parts.push(`  ${c.title} ${perBin > 1 ? `${lo} to ${hi}` : lo} ${c.unit}`);
      }
      for (const map of data.contacts) {
        const row = map.penetration[Math.min(Math.floor(t / map.interval), map.penetration.length - 1)];
        const g = Math.max(...nan(row));
        parts.push(`  ·  ${g > 0 ? `penetration ${format(g * 1e6, 3)} µm` : `open by ${format(-g * 1e6, 3)} µm`}`);
      }
      return parts;
    }, interval);
    host.append(el('div', { class: 'controls' }, el('button', { type: 'button', class: 'plain', onclick: () => group.link.onView(null) }, 'Whole run')), hint());
    const card = el('div', { class: 'card' }, el('div', { class: 'card-head' }, el('h3', {}, 'Whole run')), group.readout);
    host.append(card);
    const range = [0, data.duration];
    moving.forEach((c, k) => group.add(card, 'wave', {
      label: `${c.title} over time`,
      x: { label: k === moving.length - 1 ? 'time [s]' : '', range },
      y: { label: `${c.title}\n[${c.unit}]`.split('\n'), width: axisWidth },
      series: [{ ...own, width: 1, ...wave(c, perBin, interval) }]
    }));
    card.append(el('p', { class: 'note' },
      (perBin > 1 ? `Each of the ${channels[0].lo.length} bins of ${format(interval * 1e3, 4)} ms holds ${perBin} samples; drawn from the least to the largest of them.` :
                    'Every sample is drawn.') +
        (data.atRest.length ? ` At rest all the time, not drawn: ${data.atRest.join(', ')}.` : '')));
    return group;
  }

  function excerptWaveforms(host) {
    const { start, interval } = data.excerpt;
    const list =
      channels.map((c, k) => ({ ...c, lo: data.excerpt.channels[k].values, measured: data.excerpt.channels[k].measured })).filter((c) => !data.atRest.includes(c.name));
    const count = list[0].lo.length;
    if (count * interval >= data.duration * 0.999) return;
    const group = linkedPlots((t) => {
      const i = Math.min(Math.max(Math.round((t - start) / interval), 0), count - 1);
      return [
        el('b', {}, `${format(start + i * interval, 7)} s`),
        ...list.map((c) => `  ${c.title} ${format(c.lo[i] * c.factor, 4)}${c.measured ? ` (measured ${format(c.measured[i] * c.factor, 4)})` : ''} ${c.unit}`)
      ];
    }, interval);
    const head = el('div', { class: 'card-head' }, el('h3', {}, `Every sample around ${data.linear ? 'the largest output' : 'the deepest penetration'}`));
    const card = el('div', { class: 'card' }, head, group.readout);
    host.append(card);
    list.forEach((c, k) => group.add(card, 'wave', {
      label: `${c.title}, excerpt`,
      x: { label: k === list.length - 1 ? 'time [s]' : '', range: [start, start + count * interval] },
      y: { label: `${c.title}\n[${c.unit}]`.split('\n'), width: axisWidth },
      series: [...(c.measured ? [{ ...measured, ...wave({ lo: c.measured, factor: c.factor }, 1, interval, start) }] : []), { ...own, width: 1.2, ...wave(c, 1, interval, start) }]
    }));
    if (list.some((c) => c.measured)) head.append(seriesLegend(group.plots, [own, measured]));
  }

  // ---- contact ----
  const ramp = [[253, 231, 150], [254, 180, 80], [240, 100, 60], [190, 40, 90], [110, 15, 110], [40, 5, 70]];
  function rampColour(share) {
    const place = Math.min(Math.max(share, 0), 1) * (ramp.length - 1);
    const k = Math.min(Math.floor(place), ramp.length - 2);
    return ramp[k].map((c, i) => Math.round(c + (ramp[k + 1][i] - c) * (place - k)));
  }
  const decades = 3;

  /** The map as a picture, one pixel per bin and point; open gaps stay clear. */
  function mapPicture(rows, points, largest) {
    const picture = document.createElement('canvas');
    [picture.width, picture.height] = [rows.length, points];
    const context = picture.getContext('2d');
    const image = context.createImageData(rows.length, points);
    rows.forEach((row, bin) => row.forEach((value, point) => {
      if (!(value > 0)) return;
      image.data.set([...rampColour(1 + Math.log10(value / largest) / decades), 255], 4 * (point * rows.length + bin));
    }));
    context.putImageData(image, 0, 0);
    return picture;
  }

  function mapScale(largest, unit) {
    const colours = Array.from({ length: 11 }, (_, k) => `rgb(${rampColour(k / 10)})`).join(',');
    const labels =
      Array.from({ length: decades + 1 }, (_, k) => el('span', {}, `${k === 0 ? '≤ ' : ''}${format(largest * 10 ** (k - decades), 2)}${k === decades ? ` ${unit}` : ''}`));
    return el('div', { class: 'map-scale' }, el('div', { style: `background: linear-gradient(to right, ${colours})` }), el('div', {}, labels));
  }

  function contactMap(host, map, time) {
    const quantities = { penetration: ['m', 'largest penetration'], force: ['N', 'largest contact force'] };
    const state = {};
    const edges = map.arcLength.map((s, i) => (i ? (s + map.arcLength[i - 1]) / 2 : s - ((map.arcLength[1] ?? s + 0.01) - s) / 2));
    edges.push(2 * map.arcLength[map.arcLength.length - 1] - edges[edges.length - 1]);
    const scalePlace = el('div');
    function choose(name) {
      const [si, label] = quantities[name];
      const rows = map[name].map(nan);
      const largest = largestOf(rows.map((row) => Math.max(0, ...row.filter(Number.isFinite))));
      const [unit, factor] = readableUnit(si, largest);
      Object.assign(state, { rows, unit, factor, label, picture: mapPicture(rows, map.arcLength.length, largest) });
      scalePlace.replaceChildren(el('span', { class: 'note' }, `${label} in a bin`), mapScale(largest * factor, unit));
    }
    choose('penetration');
    const card = el('div', { class: 'card' },
      el('div', { class: 'card-head' }, el('h3', {}, `“${map.inside}” in “${map.outside}”, gap ${format(map.gap * 1e3, 4)} mm`),
        chooser('Show', [['penetration', 'penetration'], ['force', 'force']], 'penetration',
          (name) => {
            choose(name);
            time.plots.forEach((plot) => plot.chart.draw());
          })),
      scalePlace);
    host.append(card);
    time.add(card, 'magnitude', {
      label: 'contact over time and length',
      series: [],
      x: { label: '', range: [0, data.duration] },
      y: { label: ['along', `“${map.inside}” [m]`], range: [edges[0], edges[edges.length - 1]], width: axisWidth },
      paint: (context, { x, y }) => {
        const [left, right] = [0, map.penetration.length * map.interval].map((t) => x.getPixelForValue(t));
        context.imageSmoothingEnabled = false;
        map.arcLength.forEach((_, point) => {
          const [top, bottom] = [edges[point + 1], edges[point]].map((s) => y.getPixelForValue(s));
          context.drawImage(state.picture, 0, point, state.picture.width, 1, left, top, right - left, bottom - top);
        });
      }
    });
    const deepest = map.penetration.map((row) => Math.max(...nan(row)));
    const [unit, factor] = readableUnit('m', largestOf(deepest));
    const at = deepest.map((_, bin) => (bin + 0.5) * map.interval);
    time.add(card, 'wave', {
      label: 'deepest penetration over time',
      x: { label: 'time [s]', range: [0, data.duration] },
      y: { label: ['deepest |h| − gap', `[${unit}]`], width: axisWidth },
      series: [{ colour: 'soft', width: 1, unordered: true, x: [0, data.duration], y: [0, 0] }, { ...own, width: 1, x: at, y: deepest.map((g) => g * factor) }]
    });
    card.append(el('p', { class: 'note' },
      `The largest value of each of ${map.penetration.length} bins of ${format(map.interval * 1e3, 4)} ms. Above zero the gap is closed; bins without contact stay clear. Three decades of colour.`));
    alongLength(host, map);
  }

  function alongLength(host, map) {
    const grid = el('div', { class: 'three' });
    host.append(grid);
    const most = (name) => map.arcLength.map((_, point) => map[name].reduce((m, row) => (row[point] > m ? row[point] : m), -Infinity));
    for (const [name, si, title] of [['penetration', 'm', 'Deepest penetration'], ['force', 'N', 'Largest contact force']]) {
      const values = most(name);
      const [unit, factor] = readableUnit(si, Math.max(...values));
      const place = el('div');
      grid.append(el('div', { class: 'card' }, el('div', { class: 'card-head' }, el('h3', {}, `${title} along the length`)), place));
      Plots.create(place, {
        label: title,
        x: { label: `along “${map.inside}” [m]` },
        y: { label: withUnit(name, unit) },
        series: [{
          ...own,
          marker: { shape: 'circle', size: 3 },
          unordered: true,
          x: nan(map.arcLength),
          y: values.map((v) => v * factor),
          tip: (i) => `${format(map.arcLength[i], 4)} m\n${format(values[i] * factor, 4)} ${unit}`
        }]
      });
    }
  }

  // ---- transfer functions ----
  function transfer() {
    const host = section('transfer');
    if (!data.transfer) return host.remove();
    const read = (tf) => ({
      frequency: nan(tf.frequency),
      outputs: tf.outputs.map((o) => ({ ...o, re: nan(o.re), im: nan(o.im), coherence: o.coherence && nan(o.coherence), sigma: o.sigma && nan(o.sigma) }))
    });
    const ratio = { key: 'ratio', short: 'amplitude ratio', label: 'simulated, amplitude ratio', colour: 'output-2', width: 1.1, hidden: true, magnitudeOnly: true };
    const others = [
      data.transfer.linear && { ...linear, ...read(data.transfer.linear) },
      data.transfer.measured && { ...measured, label: 'measured, H1', ...read(data.transfer.measured) },
      data.transfer.amplitudeRatio && { ...ratio, ...read(data.transfer.amplitudeRatio) },
    ].filter(Boolean);
    host.append(el('p', { class: 'note' }, 'Simulated: H1, the best linear approximation of what contact makes of the motion. Without contact: the model’s harmonic response. ' +
      (data.transfer.amplitudeRatio ? 'Coherence falls where contact answers with other frequencies. Amplitude ratio √(S_yy/S_xx) (click to show): all of the output over the motion, contact’s own noise included.'
        : 'A sweep passes each frequency once: a single segment, without coherence.')));
    Bode.draw(host, read(data.transfer.simulated), others, [], 'simulated, H1');
  }

  // ---- spectra ----
  function spectra() {
    const host = section('spectra');
    if (!data.spectra) return host.remove();
    const { edges, outputs, resolution } = data.spectra;
    const frequency = nan(data.spectra.frequency);
    const marks = { list: data.band.filter((f) => f > 0).map((f) => ({ x: f, label: '' })), heads: false };
    for (const output of outputs) {
      const curves =
        [[measured, output.densityMeasured, output.levelsMeasured], [linear, output.densityLinear, output.levelsLinear], [own, output.density, output.levels]].filter(
          ([, d]) => d);
      const grid = el('div', { class: 'three' });
      host.append(el('h3', {}, output.name), grid);
      const plots = [];
      const plotIn = (title, spec) => {
        const place = el('div');
        grid.append(el('div', { class: 'card' }, el('div', { class: 'card-head' }, el('h3', {}, title)), place));
        plots.push(Plots.create(place, { marks, x: { label: 'frequency [Hz]', log: true, range: [edges[0], frequency[frequency.length - 1]] }, ...spec }));
      };
      plotIn(`Amplitude density, lines of ${format(resolution, 3)} Hz`, {
        label: 'amplitude density over frequency',
        y: { label: `${output.name} [${output.unit}/√Hz]`, log: true },
        series: curves.map(([style, d]) => ({ ...style, x: frequency, y: nan(d) }))
      });
      plotIn('Half-octave levels', {
        label: 'half-octave levels',
        y: { label: `${output.name} [${output.unit} rms]`, log: true },
        series: curves.map(([style, , l]) => ({ ...style, width: 2, ...steps(nan(edges), nan(l)) }))
      });
      host.append(seriesLegend(plots, [own, linear, measured]),
        el('details', {}, el('summary', {}, `Levels of ${output.name}`),
          table([['band\n[Hz]'], ...curves.map(([style]) => [`${style.label}\n[${output.unit} rms]`])],
            output.levels.map((_, k) => [bandName(edges, k), ...curves.map(([, , l]) => format(l[k], 4))]))));
    }
    if (marks.list.length)
      host.append(el('p', { class: 'note' },
        `Dotted: the band of the excitation, ${format(data.band[0], 4)} to ${format(data.band[1], 4)} Hz. ` +
          (data.linear ? '' : 'What stands above the response without contact there, and beyond the band, is contact’s own. ') +
          'Without contact: the harmonic response times the motion’s density, its noise and the window’s leakage included.'));
  }

  // ---- energy ----
  function energy() {
    const host = section('energy');
    const e = data.energy;
    if (!e) return host.remove();
    const [unit, factor] = readableUnit('J', Math.abs(e.initial + e.input));
    const rows = [
      ['put in by the motion', e.input], ['at the start', e.initial], ['dissipated in the bodies', e.bodyDissipated], ['dissipated in contact', e.contactDissipated],
      ['kinetic, at the end', e.kinetic], ['strain, at the end', e.strain], ['stored in contact, at the end', e.contactStored],
      ...(e.staticJumps ? [['taken by jumps of the static modes', e.staticJumps]] : []), ['imbalance', e.imbalance]
    ];
    const given = e.initial + e.input;
    const share = (value) => (given !== 0 ? value / given : NaN);
    const bars = [
      ['dissipated in the bodies', e.bodyDissipated, 'structural'], ['dissipated in contact', e.contactDissipated, 'viscous'],
      ['left at the end', e.kinetic + e.strain + e.contactStored, 'output-2']
    ];
    host.append(el('div', { class: 'energy-bar', role: 'img', 'aria-label': 'Where the energy went' }, bars.filter(([, value]) => value > 0).map(([name, value,
      colour]) => el('span', { style: `flex: ${Math.max(share(value), 0.0005)}; background: var(--${colour})`, title: `${name}: ${format(100 * share(value), 3)} %` }))),
      el('div', { class: 'legend' }, bars.map(([name, value,
        colour]) => el('span', { class: 'energy-key' }, el('i', { style: `background: var(--${colour})` }), `${name} ${format(100 * share(value), 3)} %`))),
      table([['', true], [`energy\n[${unit}]`], ['of start + input\n[%]']], rows.map(([name, value]) => [name, format(value * factor, 4), format(100 * share(value), 3)])),
      el('p', { class: 'note' },
        'In the frame that moves with the static shape. Contact and kinetic energy, strain and input are computed on their own, and so is what viscous damping takes: the imbalance tells how well the steps follow the equations. What a loss factor takes is the rest of each mode’s own balance.'));
  }

  summary();
  comparison();
  const time = wholeWaveforms(section('waveforms'));
  excerptWaveforms(section('waveforms'));
  if (data.contacts.length) data.contacts.forEach((map) => contactMap(section('contact'), map, time));
  else section('contact').remove();
  transfer();
  spectra();
  energy();
  Frame.provenance(section('provenance'), { ...data, settings: [] });
  Frame.finish();
})();
