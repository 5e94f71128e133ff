'use strict';
// The page: tables and plots from the data that the program wrote into it.
(() => {
  const data = JSON.parse(document.getElementById('report-data').textContent);
  const { format, superscript } = Axes;
  const { el, nan, known, plural, uncertain, table, chooser, legend, seriesLegend } = Elements;
  const section = (id) => document.getElementById(id);

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
  const fitted = identified.modulus.laws.length > 0;
  const pairs = new Map(identified.pairing.pairs.map((pair) => [pair.measured, pair]));
  const trusted = (mode) => (fitted ? mode.usedForModulus || mode.usedForLossFactor : mode.flags.every((flag) => flag === 'may_be_two'));
  const modulusUnit = Math.max(...identified.pairing.pairs.map((pair) => pair.modulus), ...nan(identified.modulus.value), 0) >= 1e9 ? ['GPa', 1e9] : ['MPa', 1e6];

  const flagMeaning = {
    coarse: 'too few lines in the half-power band for an estimate free of leakage',
    close_modes: 'a neighbour within a half-power bandwidth: the circle is not this mode’s own',
    double_mode: 'one pole stands for what looks like two modes',
    may_be_two: 'noise would hide a second mode of equal height as far away as the column “sees a second from” says, more than 0.2 half-power bandwidths',
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
  const fracTile = (comparison, model) => [comparison.outputs.map((o) => (known(o.frac) ? o.frac.toFixed(4) : '–')).join(' / '),
    `FRAC of ${comparison.outputs.map((o) => o.output).join(' / ')}, ${model} damping`];

  function resultSentence() {
    const used = ['usedForModulus', 'usedForLossFactor'].map((key) => modes.filter((mode) => mode[key]).length);
    const verdict = fitted ? `${used[0]} trusted for the modulus, ${used[1]} for the damping` : `${modes.filter(trusted).length} without a flag`;
    const text = [`${plural(modes.length, 'mode')} found` +
      (modes.length ? ` between ${format(modes[0].frequency)} and ${format(modes[modes.length - 1].frequency)} Hz, ${verdict}.` : '.')];
    if (fitted) {
      const law = identified.modulus.laws[0];
      if (identified.modulus.value.length)
        text.push(`The modulus of body “${identified.body}” is ${spread(identified.modulus.value, modulusUnit[1], modulusUnit[0])}` +
          `${law ? ` over frequency (${lawLabel(law)} law)` : ''}, its loss factor ${spread(identified.lossFactor.value, 1, '', 3)}.`);
    }
    const [s, v] = [data.comparison, data.comparisonViscous].map((comparison) => comparison.meanError);
    if (data.modelInQuestion) text.push('Which damping model is the closer one cannot be told while the model itself is in question: see the doubts.');
    else if (known(s) && known(v)) {
      const compared = data.comparison.outputs.filter((o) => known(o.error)).length;
      text.push(`The ${s <= v ? 'structural' : 'viscous'} damping model is the closer one to the measurement ` +
        `(${format(Math.min(s, v), 3)} against ${format(Math.max(s, v), 3)} dB rms, mean over ${plural(compared, 'output')}).`);
    }
    return text.join(' ');
  }

  function resultTiles() {
    const r = identified.rayleigh;
    const count = (key) => modes.filter((mode) => mode[key]).length;
    const tiles = fitted ? [[`${count('usedForModulus')} and ${count('usedForLossFactor')} of ${modes.length}`, 'modes trusted for modulus and damping']]
      : [[String(modes.length), 'modes']];
    if (identified.modulus.value.length) tiles.push([spread(identified.modulus.value, modulusUnit[1], modulusUnit[0]), `modulus E(f) of “${identified.body}”`]);
    if (identified.lossFactor.value.length) tiles.push([spread(identified.lossFactor.value, 1, '', 3), 'loss factor η(f)']);
    if (identified.rayleighKnown) {
      tiles.push([`${uncertain(r.alpha, r.alphaSigma)} 1/s`, 'Rayleigh α' + (r.alphaAtBound ? ' (held at its bound 0)' : '')],
        [`${uncertain(r.beta, r.betaSigma)} s`, 'Rayleigh β' + (r.betaAtBound ? ' (held at its bound 0)' : '')]);
    }
    if (data.comparison.outputs.length) tiles.push(fracTile(data.comparison, 'structural'));
    if (data.comparisonViscous.outputs.length) tiles.push(fracTile(data.comparisonViscous, 'viscous'));
    return el('div', { class: 'tiles' }, tiles.map(([value, label]) => el('div', { class: value.length > 22 ? 'tile wide' : 'tile' }, el('b', {}, value), el('span', {}, label))));
  }

  function summary() {
    section('origin').textContent = [identified.version && `struna ${identified.version}`, identified.date,
      `${plural(frequency.length, 'line')} from ${format(frequency[0])} to ${format(frequency[frequency.length - 1])} Hz`].filter(Boolean).join(' · ');
    if (data.doubts.length)
      section('summary').append(el('div', { class: 'doubts', role: 'alert' }, el('h3', {}, 'This result is doubted'), ...Frame.warnings(data.doubts)));
    section('summary').append(el('p', { class: 'lead' }, resultSentence()), resultTiles());
    section('summary').append(...Frame.warnings(data.warnings));
  }

  // ---- comparison ----
  function comparisonTables() {
    const models = [['structural', data.comparison], ['viscous', data.comparisonViscous]].filter(([, c]) => c.outputs.length);
    if (models.length === 0) return section('comparison').remove();
    const { lo, hi, notCompared: missing } = models[0][1];
    section('comparison').append(table(
      [['output', true], ['damping model', true], ['FRAC\n[–]'], ['rms error\n[dB]'], ['mean error\n[dB]'], ['largest error\n[dB]']],
      models.flatMap(([name, c]) => c.outputs.map((o) => [o.output, name, known(o.frac) ? o.frac.toFixed(5) : '–', format(o.error, 3), format(o.mean, 3), format(o.largest, 3)]))
        .sort((a, b) => (a[0] < b[0] ? -1 : a[0] > b[0] ? 1 : 0))),
    el('p', { class: 'note' }, `Over ${format(lo)} to ${format(hi)} Hz.${missing.length ? ` Not predicted: ${missing.join(', ')}.` : ''} FRAC: frequency response assurance criterion, 1 for functions of the same shape. ` +
      'Errors: of 20 lg(|predicted|/|measured|) over the lines.'));
    for (const [name, comparison] of models)
      section('comparison').append(el('details', {}, el('summary', {}, `Peaks, ${name} damping`), table(
        [['output', true], ['measured\n[Hz]'], ['predicted\n[Hz]'], ['difference\n[%]'], ['amplitude difference\n[dB]']],
        comparison.outputs.flatMap((o) => o.peaks.map(([m, p, db]) =>
          [o.output, format(m, 6), known(p) ? format(p, 6) : 'no peak', known(p) ? format((p / m - 1) * 100, 3) : '–', format(db, 3)])))));
  }

  // ---- modulus and damping ----
  /** One chart of a quantity at the modes with its laws. `quantity`: { title, label, scale, points, laws, extra } */
  function curveCard(host, quantity) {
    const scaled = (values) => nan(values).map((value) => value / quantity.scale);
    const bandAround = ({ values, scene }) => scene && {
      lo: scaled(values.map((value, i) => value - scene[i])), hi: scaled(values.map((value, i) => value + scene[i])) };
    const points = (list, style) => ({ ...style, line: false, unordered: true, x: list.map((p) => p.frequency),
      y: list.map((p) => p.value / quantity.scale), error: list.map((p) => (p.sigma || 0) / quantity.scale),
      tip: (i) => `mode ${list[i].mode}: ${format(list[i].frequency, 6)} Hz\n${quantity.symbol} ${uncertain(list[i].value / quantity.scale, list[i].sigma / quantity.scale)}${quantity.unit}` +
        (list[i].flags.length ? `\n${list[i].flags.join(', ')}` : '') });
    const series = [
      points(quantity.points.filter((p) => p.used), { key: 'trusted', name: 'trusted modes, ± σ', colour: 'ink', marker: { shape: 'circle', size: 3.5 } }),
      points(quantity.points.filter((p) => !p.used), { key: 'untrusted', name: 'not trusted', colour: 'untrusted', ignoreInLimits: true,
        marker: { shape: 'circle', size: 3.5, hollow: true } }),
      ...quantity.curves.map((curve) => ({ ...curve, x: nan(identified.curveFrequency), y: scaled(curve.values), band: bandAround(curve) })),
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
    dash: lawDashes[i % 5], width: i === 0 ? 3 : 1.5, values: law.curve, scene: i === 0 ? law.sceneSigma : undefined, ignoreInLimits: i > 0,
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
    if (!fitted && !identified.lossFactor.value.length && !identified.rayleighKnown) return host.remove();
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
    if (identified.rayleighKnown) ratioCurves.push({ key: 'rayleigh', name: 'Rayleigh: α/2ω + βω/2', colour: 'viscous', dash: [6, 3], width: 2.5, values: rayleigh.curve });
    if (lossFactor.laws.length) ratioCurves.push({ key: 'half', name: 'structural: η(f)/2', colour: 'structural', width: 2, values: nan(lossFactor.laws[0].curve).map((v) => v / 2) });
    curveCard(grid, { title: 'Damping ratio ζ(f)', label: 'ζ [–]', symbol: 'ζ', unit: '', scale: 1, curves: ratioCurves,
      points: atModes((m) => [m.dampingRatio, m.lossFactorSigma / 2], (m) => m.usedForLossFactor,
        (m) => [m.dampingRatio, m.lossFactorSigma / 2]) });
    host.append(el('p', { class: 'note' }, 'Bars: ± one standard deviation. Dotted ends of a law: outside the range of its data. ' +
      'Points that are not trusted are not fitted and may lie off the scale. Laws are chosen by AICc (Akaike’s criterion, corrected for few points). ' +
      'Kramers–Kronig: (π/2) d ln E/d ln f of the modulus law; what the material alone would damp if it were purely viscoelastic; clamps, air and strands add to it.'));
    const relative = modulus.sceneSigma.length ? 100 * Math.max(...modulus.sceneSigma.map((s, i) => s / modulus.value[i])) : 0;
    if (relative > 0)
      host.append(el('p', { class: 'note' }, `Band around the modulus law: ± ${format(relative, 2)} %, what the scene's own errors put on all modes alike ` +
        `(${identified.sceneErrors.map(([name, level]) => `${name} ${format(100 * Math.abs(level), 2)} %`).join(', ')}), besides the bars, which are of noise and of the model.`));
    for (const line of identified.fittedLines) host.append(el('p', {}, line));
    host.append(...[lawTable(`Laws of the modulus (c in Pa)`, modulus.laws, 'Pa'), lawTable('Laws of the loss factor', lossFactor.laws, '')].filter(Boolean));
    if (identified.rayleighKnown)
      host.append(el('p', {}, `Rayleigh coefficients: α = ${uncertain(rayleigh.alpha, rayleigh.alphaSigma)} 1/s, β = ${uncertain(rayleigh.beta, rayleigh.betaSigma)} s; ` +
        `residual ${format(rayleigh.rms, 3)} standard deviations.` +
        (rayleigh.flag === 'contradicted' ? ` Contradicted: the modes lie ${format(100 * rayleigh.misfit, 2)} % off this curve; their damping is of another form.` : '') +
        (rayleigh.flag === 'two_modes' ? ' Two modes only: nothing has tested whether damping has this form.' : '') +
        (rayleigh.determined ? '' : ' One frequency alone cannot tell them apart: β carries all the damping.')));
  }

  function addKramersKronig(card) {
    const plot = lossFactorPlot(card);
    const x = nan(identified.lossFactor.frequency), y = nan(identified.kramersKronig);
    plot.spec.series.push({ key: 'kk', name: 'Kramers–Kronig from E(f)', colour: 'output-3', dash: [4, 4], width: 1.4, x, y,
      marker: { shape: 'rectRot', size: 3, hollow: true }, unordered: true, tip: (i) => `Kramers–Kronig\n${format(x[i], 6)} Hz\nη ${format(y[i], 3)}` });
    Plots.refresh(plot);
    card.querySelector('.legend').replaceWith(seriesLegend([plot], plot.spec.series.map((s) => ({ key: s.key, label: s.name }))));
  }
  const lossFactorPlot = (card) => [...Plots.all].find((plot) => card.contains(plot.canvas));

  // ---- modes ----
  function modeTable() {
    if (modes.length === 0) return section('modes').remove();
    const { units, outputs } = data.modes;
    const constantUnit = (k) => `${units[k] || '?'} ${data.modes.damping === 'structural' ? 'rad²/s²' : 'rad/s'}`;
    const modelFrequency = nan(data.modelFrequencies);
    const columns = [['mode'], ['natural frequency\n[Hz]'], ['half-power from\n[Hz]'], ['to\n[Hz]'], ['loss factor η\n[–]'], ['damping ratio ζ\n[–]'],
      ['stands in\norders'], ['flags', true]];
    if (fitted) columns.push(['model\nmode'], ['MAC\n[–]'], [`E\n[${modulusUnit[0]}]`], ['used for', true]);
    if (modelFrequency.length) columns.push(['identified model\n[Hz]'], ['off by\n[%]']);
    columns.push(['circle’s own f\n[Hz]'], ['circle’s own η\n[–]'], ...outputs.map((name, k) => [`${name}\n|C| [${constantUnit(k)}]`]),
      ['sees a second from\n[bandwidths]']);
    const rows = modes.map((mode, i) => {
      const pair = pairs.get(i);
      const cells = [i + 1, uncertain(mode.frequency, mode.frequencySigma, 7), format(mode.lower, 6), format(mode.upper, 6),
        uncertain(mode.lossFactor, mode.lossFactorSigma), format(mode.dampingRatio, 4),
        mode.orders ? `${mode.stableOrders} of ${mode.orders}` : '–', el('span', {}, flagTags(mode.flags))];
      const [modulus, sigma] = (mode.usedForModulus && identifiedAt(identified.modulus)(mode)) || (pair ? [pair.modulus, pair.sigma] : [NaN, NaN]);
      if (fitted) cells.push(pair ? pair.model.map((m) => m + 1).join(' + ') : '–', pair && known(pair.mac) ? pair.mac.toFixed(3) : '–',
        uncertain(modulus / modulusUnit[1], sigma / modulusUnit[1]),
        [mode.usedForModulus && 'E', mode.usedForLossFactor && 'η, α, β'].filter(Boolean).join(', ') || '–');
      if (modelFrequency.length) {
        const model = pair ? pair.model.reduce((sum, m) => sum + modelFrequency[m], 0) / pair.model.length : NaN;
        cells.push(format(model, 6), known(model) ? format((model / mode.frequency - 1) * 100, 2) : '–');
      }
      cells.push(format(mode.circleFrequency, 6), format(mode.circleLossFactor, 4),
        ...outputs.map((_, k) => (mode.constants[k] ? format(Math.hypot(...nan(mode.constants[k])), 4) : '–')), format(mode.resolvesFrom, 2));
      return { cells, className: trusted(mode) ? '' : 'untrusted' };
    });
    section('modes').append(table(columns, rows), el('p', { class: 'note' },
      `${data.modes.damping === 'structural' ? 'Structural' : 'Viscous'} damping; constants refer to ${data.modes.form.replace('-', ' ')}. ± is one standard deviation. ` +
      'Grey rows are not trusted. E here puts the paired model mode exactly at the measured frequency; its ± has the error of the model in it (0.1 % and more) where the row is trusted, and is that of the noise alone where not; two model modes in one row are a nearly double pair that one pole stands for.'));
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
      const style = outputStyle(k);
      if (points.length > 40) style.marker.size = 1.5; // many lines: small marks
      series.unshift({ ...style, key: k, hidden: !visible(k), line: false, unordered: true, x: points.map((p) => p[0]), y: points.map((p) => p[1]),
        tip: (i) => `${data.modes.outputs[k]}  ${format(lines.frequency[i], 6)} Hz\n${format(output.re[i])} ${output.im[i] < 0 ? '−' : '+'} ${format(Math.abs(output.im[i]))} i ${data.modes.units[k] || ''}` });
    });
    const labelled = own.map((circle, k) => ({ ...circle, k })).filter(({ k }) => visible(k)).sort((a, b) => b.radius - a.radius)[0];
    const special = labelled ? [['resonance', 'f₀', mode.frequency], ['lower', 'f₁', mode.lower], ['upper', 'f₂', mode.upper]] : [];
    if (labelled) {
      const points = special.map(([which]) => mapped(labelled.k)(labelled[which]));
      series.unshift({ colour: 'ink', line: false, unordered: true, marker: { shape: 'circle', size: 4, hollow: true }, x: points.map((p) => p[0]), y: points.map((p) => p[1]),
        tip: (i) => `${special[i][1]} ${format(special[i][2], 6)} Hz` });
    }
    const labels = () => special.map(([which, symbol, f]) => {
      const [x, y] = mapped(labelled.k)(labelled[which]);
      const [cx, cy] = mapped(labelled.k)(labelled.centre);
      return { x, y, text: `${symbol} ${format(f, 5)}`, awayFrom: { x: cx, y: cy } };
    });
    const scale = normalised ? 'about centre / radius [–]' : `[${power ? `10${superscript(power)} ` : ''}${[...new Set(data.modes.units)].join(', ') || '?'}]`;
    return { label: `Nyquist plot of mode ${index + 1}`, series, labels, equal: true, x: { label: `Re ${scale}` }, y: { label: `Im ${scale}` } };
  }

  function nyquistCard(mode, index) {
    const host = el('div');
    const enlarge = el('button', { type: 'button', class: 'plain', 'aria-pressed': false, onclick: (event) => {
      const large = card.classList.toggle('large');
      event.currentTarget.textContent = large ? 'smaller' : 'larger';
      event.currentTarget.setAttribute('aria-pressed', large);
    } }, 'larger');
    const worst = mode.circles.map((c, k) => [c.scatter, data.modes.outputs[k]]).filter(([value]) => known(value)).sort((p, q) => q[0] - p[0])[0];
    const scatter = worst ? `, scatter up to ${format(100 * worst[0], 2)} % (${worst[1]})` : '';
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
      'f₀: natural frequency, f₁ and f₂: half-power frequencies [Hz], marked on the largest circle shown. Scatter: rms distance of the lines from the circle over its radius, of the output in which it is worst (named); the mode rests on all outputs together.'),
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
  const notUsedFor = { both: 'mode not used for E, η, α, β', modulus: 'mode not used for E', loss_factor: 'mode not used for η, α, β' };

  function leftOut() {
    const host = section('left-out');
    const { pairing } = identified;
    const rows = [
      ...data.modes.rejected.map((r) => [r.frequency, 'candidate that is no mode', r.reason]),
      ...identified.rejected.map((r) => [r.frequency, notUsedFor[r.what], r.reason]),
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

  summary();
  const marks = modes.map((mode, i) => ({ x: mode.frequency, label: String(i + 1), hollow: !trusted(mode) }));
  Bode.draw(section('transfer'), measured, predictions, marks);
  comparisonTables();
  parameters();
  modeTable();
  StabilisationChart.draw(section('stabilisation'), data.modes.stabilisation, measured, modes, marks);
  nyquist();
  leftOut();
  const band = identified.band[1] > identified.band[0] ? [['band analysed', `${format(identified.band[0])} to ${format(identified.band[1])} Hz`]] : [];
  Frame.provenance(section('provenance'), { ...data, settings: [...data.settings, ...band],
    inputs: identified.inputs, version: identified.version, date: identified.date });
  Frame.finish();
})();
