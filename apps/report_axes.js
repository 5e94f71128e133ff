'use strict';
// Numbers as text, and axes with the ticks that engineers expect, linear and logarithmic, far out and zoomed in.
// Colours are names of CSS variables, looked up when first needed and again after a change of the colour scheme.
const Axes = (() => {
  const colours = new Map();
  const forgetColours = () => colours.clear();
  function tint(name) {
    if (!colours.has(name)) colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
    return colours.get(name);
  }

  // ---- numbers as text ----
  const superscript = (n) => String(n).replace(/./g, (c) => '⁰¹²³⁴⁵⁶⁷⁸⁹⁻'['0123456789-'.indexOf(c)]);
  const minus = (text) => text.replace('-', '−');

  /** Plain where that is short, else mantissa × power of ten. */
  function format(value, digits = 4) {
    if (!Number.isFinite(value)) return '–';
    if (value === 0) return '0';
    const size = Math.abs(value);
    if (size >= 1e-3 && size < 10 ** Math.max(digits, 5))
      return minus(String(Number(value.toPrecision(Math.max(digits, Math.ceil(Math.log10(size)))))));
    const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
    return minus(`${Number(mantissa)}·10`) + superscript(Number(exponent));
  }

  // ---- ticks: those with `major` get their text ----
  function linearTicks(lo, hi, count) {
    const raw = (hi - lo) / count;
    const power = 10 ** Math.floor(Math.log10(raw));
    const steps = [10, 5, 2, 1, 0.5].map((m) => m * power).filter((s, k) => k === 0 || s >= raw / 2.6);
    const fits = steps.filter((s) => s >= raw * (1 - 1e-9)).pop();
    // One tick tells no scale: then a finer step than there would be room for.
    const inside = (s) => Math.floor(hi / s + 1e-6) - Math.ceil(lo / s - 1e-6) + 1;
    const step = inside(fits) > 1 ? fits : steps.find((s) => s < fits && inside(s) > 1) || fits;
    const decimals = Math.max(0, -Math.floor(Math.log10(step * (1 + 1e-9))));
    const largest = Math.max(Math.abs(lo), Math.abs(hi));
    const text = (value) => (decimals > 5 || largest >= 1e6 ? format(value, 5) : minus(value.toFixed(decimals)));
    const ticks = [];
    for (let i = Math.ceil(lo / step - 1e-6); i * step <= hi + 1e-6 * step; ++i) {
      const value = Number((i * step).toPrecision(12));
      ticks.push({ value, major: true, text: text(value) });
    }
    return ticks;
  }

  function logTicks(lo, hi, count) {
    const decades = Math.log10(hi / lo);
    if (decades < 0.9) return linearTicks(lo, hi, count);
    const labelled = decades * 3 <= 1.3 * count ? [1, 2, 5] : [1];
    const every = Math.max(1, Math.ceil(decades / count));
    const ticks = [];
    for (let decade = Math.floor(Math.log10(lo)); decade <= Math.log10(hi); ++decade)
      for (let m = 1; m < 10; ++m) {
        const value = Number(`${m}e${decade}`);
        if (value >= lo * (1 - 1e-9) && value <= hi * (1 + 1e-9))
          ticks.push({ value, major: labelled.includes(m) && decade % every === 0,
            text: m === 1 && Math.abs(decade) > 3 ? '10' + superscript(decade) : format(value, 6) });
      }
    return ticks;
  }

  function axis(which, options) {
    return {
      type: options.log ? 'logarithmic' : 'linear',
      bounds: 'data',
      title: { display: Boolean(options.label), text: options.label, color: () => tint('ink') },
      afterFit: which === 'y' && options.width ? (scale) => { scale.width = options.width; } : undefined,
      afterBuildTicks: (scale) => {
        if (options.ticks) { scale.ticks = options.ticks.map((value) => ({ value, major: true, text: minus(String(value)) })); return; }
        const length = which === 'x' ? scale.width || scale.chart.width : scale.height || scale.chart.height;
        const count = Math.max(2, Math.min(11, length / (which === 'y' ? 34 : options.log ? 60 : 70)));
        scale.ticks = (options.log ? logTicks : linearTicks)(scale.min, scale.max, count);
      },
      ticks: {
        autoSkip: false, maxRotation: 0, color: () => tint('soft'),
        callback: (value, index, ticks) => (ticks[index].major ? ticks[index].text : ''),
      },
      grid: {
        drawTicks: true, tickLength: 4, borderColor: () => tint('soft'),
        color: (context) => tint(context.tick && context.tick.major ? 'rule' : 'rule-faint'),
      },
    };
  }

  return { tint, forgetColours, axis, format, superscript, minus };
})();
