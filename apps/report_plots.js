'use strict';
// Plots of numbers over numbers: what Chart.js does not bring. Bands and error bars, marks, equal axes, zoom, a cursor that
// linked plots share, and drawing no more points than pixels can show.
const Plots = (() => {
  const { tint, axis } = Axes;
  Chart.defaults.animation = false;
  Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
  Chart.defaults.font.size = 12;

  const all = new Set();

  // ---- points: what of a series is drawn ----
  const firstAtOrAbove = (values, limit) => {
    let lo = 0, hi = values.length;
    while (lo < hi) {
      const middle = (lo + hi) >> 1;
      if (values[middle] < limit) lo = middle + 1; else hi = middle;
    }
    return lo;
  };

  /** Indices in view: all of them, or the lowest and highest of each of `buckets` pieces. One more on each side, so that
   *  lines leave the plot at its edge. Needs ascending x. */
  function indicesInView(series, lo, hi, buckets) {
    const first = Math.max(0, firstAtOrAbove(series.x, lo) - 1);
    const last = Math.min(series.x.length, firstAtOrAbove(series.x, hi) + 1);
    const indices = [];
    if (last - first <= 2 * buckets) {
      for (let i = first; i < last; ++i) indices.push(i);
      return indices;
    }
    for (let bucket = 0; bucket < buckets; ++bucket) {
      const from = first + Math.floor(((last - first) * bucket) / buckets);
      const to = first + Math.floor(((last - first) * (bucket + 1)) / buckets);
      let low = from, high = from;
      for (let i = from; i < to; ++i) {
        if (!(series.y[i] >= series.y[low])) low = i;
        if (!(series.y[i] <= series.y[high])) high = i;
      }
      indices.push(Math.min(low, high));
      if (low !== high) indices.push(Math.max(low, high));
    }
    return indices;
  }

  function drawnPoints(series, lo, hi, buckets) {
    const every = series.unordered || series.x.length < 3;
    const indices = every ? series.x.map((_, i) => i) : indicesInView(series, lo, hi, buckets);
    const points = [];
    indices.forEach((index, k) => {
      const jump = k > 0 && series.breakAt && Math.abs(series.y[index] - series.y[indices[k - 1]]) > series.breakAt;
      if (jump) points.push({ x: series.x[index], y: NaN });
      points.push({ x: series.x[index], y: series.y[index] });
    });
    return points;
  }

  function dataset(series, view, width) {
    const colour = tint(series.colour);
    return {
      data: drawnPoints(series, view[0], view[1], Math.max(200, Math.round(width))),
      hidden: Boolean(series.hidden),
      showLine: series.line !== false,
      borderColor: colour,
      borderWidth: series.width || 1.4,
      borderDash: series.dash || [],
      segment: series.solidWithin
        ? { borderDash: ({ p0, p1 }) =>
            (p1.parsed.x < series.solidWithin[0] || p0.parsed.x > series.solidWithin[1] ? [2, 3] : undefined) }
        : undefined,
      pointRadius: series.marker ? series.marker.size : 0,
      pointStyle: series.marker ? series.marker.shape : 'circle',
      pointBorderColor: colour,
      pointBackgroundColor: series.marker && !series.marker.hollow ? colour : tint('panel'),
      pointBorderWidth: series.marker && series.marker.size < 2.5 ? 0.5 : 1.3,
    };
  }

  // ---- limits of an axis ----
  function padded([lo, hi], log, share = 0.06) {
    if (!(hi >= lo)) return log ? [1, 10] : [0, 1];
    if (log) {
      const factor = Math.max((hi / lo) ** 0.05, 1.02);
      return [lo / factor, hi * factor];
    }
    const margin = (hi - lo || Math.abs(hi) || 1) * share;
    return [lo - margin, hi + margin];
  }

  function extent(plot, which, xView) {
    const log = plot.spec[which].log;
    const range = [Infinity, -Infinity];
    for (const series of plot.spec.series) {
      if (series.hidden || series.ignoreInLimits) continue;
      series[which].forEach((value, i) => {
        const inView = !xView || (series.x[i] >= xView[0] && series.x[i] <= xView[1]);
        const bar = which === 'y' && series.error ? series.error[i] || 0 : 0;
        if (!inView || !Number.isFinite(value) || (log && value <= 0)) return;
        range[0] = Math.min(range[0], value - bar);
        range[1] = Math.max(range[1], value + bar);
      });
    }
    return range;
  }

  function limits(plot) {
    const { spec } = plot;
    const x = plot.view.x || spec.x.range || padded(extent(plot, 'x'), spec.x.log, spec.labels ? 0.4 : 0.06);
    const y = plot.view.y || spec.y.range || padded(extent(plot, 'y', spec.equal ? null : x), spec.y.log, spec.labels ? 0.1 : 0.06);
    return { x, y };
  }

  /** One unit as long on the screen along x as along y, whatever the axes leave of the canvas. */
  function equalised({ x, y }, area) {
    const perPixel = Math.max((x[1] - x[0]) / area.width, (y[1] - y[0]) / area.height);
    const around = ([lo, hi], pixels) => [(lo + hi - perPixel * pixels) / 2, (lo + hi + perPixel * pixels) / 2];
    return { x: around(x, area.width), y: around(y, area.height) };
  }

  // ---- what is drawn besides lines and points ----
  /** The band in view as one path, in pieces where the line of the series breaks too. */
  function bandPath(context, scales, series, view) {
    const first = Math.max(0, firstAtOrAbove(series.x, view[0]) - 1);
    const last = Math.min(series.x.length, firstAtOrAbove(series.x, view[1]) + 1);
    const step = Math.max(1, Math.floor((last - first) / (2 * scales.x.width)));
    const bottom = scales.y.options.type === 'logarithmic' ? scales.y.min * 1e-3 : -Infinity;
    const trace = (values, i) =>
      context.lineTo(scales.x.getPixelForValue(series.x[i]), scales.y.getPixelForValue(Math.max(values[i], bottom)));
    let piece = [];
    const close = () => {
      piece.forEach((i, k) => (k ? trace(series.band.hi, i) : context.moveTo(scales.x.getPixelForValue(series.x[i]), scales.y.getPixelForValue(series.band.hi[i]))));
      piece.reverse().forEach((i) => trace(series.band.lo, i));
      piece = [];
    };
    context.beginPath();
    for (let i = first; i < last; i += step) {
      const previous = piece[piece.length - 1];
      const broken = !Number.isFinite(series.y[i]) || (series.breakAt && piece.length && Math.abs(series.y[i] - series.y[previous]) > series.breakAt);
      if (broken) close();
      if (Number.isFinite(series.y[i])) piece.push(i);
    }
    close();
  }

  function drawErrorBars(context, scales, series) {
    context.strokeStyle = tint(series.colour);
    context.lineWidth = 1.2;
    series.x.forEach((value, i) => {
      if (!(series.error[i] > 0)) return;
      const x = scales.x.getPixelForValue(value);
      const ends = [-1, 1].map((side) => scales.y.getPixelForValue(series.y[i] + side * series.error[i]));
      context.beginPath();
      context.moveTo(x, ends[0]);
      context.lineTo(x, ends[1]);
      for (const end of ends) { context.moveTo(x - 3, end); context.lineTo(x + 3, end); }
      context.stroke();
    });
  }

  /** Marks along the top edge with a faint line down; a label where the one before leaves room. */
  function drawMarks(context, scales, area, marks) {
    let free = -Infinity;
    context.font = `11px ${Chart.defaults.font.family}`;
    context.textAlign = 'center';
    for (const mark of marks.list) {
      if (mark.x < scales.x.min || mark.x > scales.x.max) continue;
      const x = scales.x.getPixelForValue(mark.x);
      const colour = tint(mark.hollow ? 'untrusted' : 'soft');
      context.strokeStyle = colour;
      context.fillStyle = mark.hollow ? tint('panel') : colour;
      context.lineWidth = 1;
      context.setLineDash([2, 4]);
      context.globalAlpha = 0.55;
      context.beginPath();
      context.moveTo(x, area.top + 6);
      context.lineTo(x, area.bottom);
      context.stroke();
      context.globalAlpha = 1;
      context.setLineDash([]);
      if (!marks.heads) continue;
      context.beginPath();
      context.moveTo(x - 4, area.top - 2);
      context.lineTo(x + 4, area.top - 2);
      context.lineTo(x, area.top + 5);
      context.closePath();
      context.fill();
      context.stroke();
      const half = context.measureText(mark.label).width / 2;
      if (x - half < free + 3) continue;
      context.fillStyle = colour;
      context.fillText(mark.label, x, area.top - 6);
      free = x + half;
    }
  }

  /** Labels beside points, pushed away from a centre, and the next ones past those already there. */
  function drawLabels(context, scales, area, labels) {
    context.font = `11px ${Chart.defaults.font.family}`;
    context.textBaseline = 'middle';
    const taken = [];
    for (const label of labels) {
      const at = ['x', 'y'].map((k) => scales[k].getPixelForValue(label[k]));
      const centre = ['x', 'y'].map((k) => scales[k].getPixelForValue(label.awayFrom[k]));
      const length = Math.hypot(at[0] - centre[0], at[1] - centre[1]) || 1;
      const direction = [(at[0] - centre[0]) / length, (at[1] - centre[1]) / length];
      const width = context.measureText(label.text).width;
      let box;
      for (let reach = 9; reach < 60; reach += 5) {
        const left = at[0] + direction[0] * reach + (direction[0] < 0 ? -width : 0);
        const x = Math.min(Math.max(left, area.left + 2), area.right - width - 2);
        const y = Math.min(Math.max(at[1] + direction[1] * reach, area.top + 8), area.bottom - 8);
        box = { x, y, right: x + width };
        if (!taken.some((o) => x < o.right + 3 && o.x < box.right + 3 && Math.abs(y - o.y) < 13)) break;
      }
      taken.push(box);
      context.strokeStyle = tint('panel');
      context.lineWidth = 3.5;
      context.textAlign = 'left';
      context.strokeText(label.text, box.x, box.y);
      context.fillStyle = tint('ink');
      context.fillText(label.text, box.x, box.y);
    }
    context.textBaseline = 'alphabetic';
  }

  const clipped = (context, area, draw) => {
    context.save();
    context.beginPath();
    context.rect(area.left, area.top, area.right - area.left, area.bottom - area.top);
    context.clip();
    draw();
    context.restore();
  };

  const decorations = (plot) => ({
    id: 'decorations',
    beforeDatasetsDraw({ ctx, chartArea, scales }) {
      clipped(ctx, chartArea, () => {
        if (plot.spec.paint) plot.spec.paint(ctx, scales);
        for (const series of plot.spec.series) {
          if (series.hidden || !series.band) continue;
          ctx.fillStyle = tint(`${series.colour}-band`);
          bandPath(ctx, scales, series, [scales.x.min, scales.x.max]);
          ctx.fill();
        }
      });
      ctx.save();
      if (plot.spec.marks && !plot.spec.marks.hidden) drawMarks(ctx, scales, chartArea, plot.spec.marks);
      ctx.restore();
    },
    afterDatasetsDraw({ ctx, chartArea, scales }) {
      clipped(ctx, chartArea, () => {
        for (const series of plot.spec.series)
          if (series.error && !series.hidden) drawErrorBars(ctx, scales, series);
        if (plot.spec.labels) drawLabels(ctx, scales, chartArea, plot.spec.labels());
        if (plot.cursor !== null) {
          const x = scales.x.getPixelForValue(plot.cursor);
          ctx.fillStyle = tint('accent');
          ctx.fillRect(x - 0.5, chartArea.top, 1, chartArea.bottom - chartArea.top);
        }
        if (plot.selection) {
          const { x, y, width, height } = plot.selection;
          ctx.fillStyle = tint('select');
          ctx.fillRect(x, y, width, height);
        }
      });
    },
  });

  // ---- the plot ----
  /** spec: { label, x: {label, log, range}, y: {label, log, range, ticks, width}, series: [...], marks, labels(), paint(context, scales), equal,
   *          link: {onView(x), onCursor(x), onStep(steps)} }. A series: { x, y, colour, hidden, line, width, dash, solidWithin,
   *          marker: {shape, size, hollow}, error, band: {lo, hi}, breakAt, unordered, ignoreInLimits, tip(i) }. */
  function create(host, spec) {
    const canvas = document.createElement('canvas');
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', spec.label);
    host.classList.add('plot');
    host.append(canvas);
    const plot = { host, canvas, spec, view: { x: null, y: null }, cursor: null, selection: null };
    plot.chart = new Chart(canvas, {
      type: 'line',
      data: { datasets: [] },
      plugins: [decorations(plot)],
      options: {
        responsive: true, maintainAspectRatio: false, parsing: false, normalized: true, events: [], spanGaps: false,
        layout: { padding: { top: spec.marks && spec.marks.heads ? 18 : 6, right: 14 } },
        plugins: { legend: { display: false }, tooltip: { enabled: false } },
        scales: { x: axis('x', spec.x), y: axis('y', spec.y) },
        onResize: () => requestAnimationFrame(() => refresh(plot)),
      },
    });
    refresh(plot);
    interact(plot);
    all.add(plot);
    return plot;
  }

  function apply(plot, range) {
    for (const which of ['x', 'y']) [plot.chart.options.scales[which].min, plot.chart.options.scales[which].max] = range[which];
    plot.chart.update('none');
  }

  /** Draws anew: after a change of the view, the series, an axis or the colours. */
  function refresh(plot) {
    const { chart, spec } = plot;
    for (const which of ['x', 'y']) chart.options.scales[which] = axis(which, spec[which]);
    const range = limits(plot);
    chart.data.datasets = spec.series.map((series) => dataset(series, range.x, chart.width));
    apply(plot, range);
    if (spec.equal)
      for (let pass = 0; pass < 2; ++pass) apply(plot, equalised(range, { width: chart.scales.x.width, height: chart.scales.y.height }));
  }

  function setView(plot, view) {
    Object.assign(plot.view, view);
    refresh(plot);
  }

  function setCursor(plot, x) {
    plot.cursor = x;
    plot.chart.draw();
  }

  // ---- hands on it ----
  /** At most once per frame, with the latest arguments: a hand is faster than nine plots. */
  function perFrame(act) {
    let latest = null;
    return (...parameters) => {
      if (!latest) requestAnimationFrame(() => { const now = latest; latest = null; act(...now); });
      latest = parameters;
    };
  }

  const inArea = ({ left, right, top, bottom }, x, y) => x >= left && x <= right && y >= top && y <= bottom;

  function requestView(plot, view) {
    if (!plot.spec.link) return setView(plot, view);
    plot.view.y = view.y || null;
    plot.spec.link.onView(view.x);
  }

  /** Zooms by a factor about a place on the screen (the middle when none is given). */
  function zoom(plot, factor, at) {
    const around = (scale, pixel) => {
      const [start, end] = [scale.left, scale.right];
      const horizontal = scale.isHorizontal();
      const from = horizontal ? start : scale.bottom;
      const to = horizontal ? end : scale.top;
      const middle = pixel === undefined ? (from + to) / 2 : pixel;
      return [from, to].map((edge) => scale.getValueForPixel(middle + (edge - middle) * factor));
    };
    const { x, y } = plot.chart.scales;
    requestView(plot, plot.spec.link ? { x: around(x, at && at.x) } : { x: around(x, at && at.x), y: around(y, at && at.y) });
  }

  const reset = (plot) => requestView(plot, { x: null, y: null });

  function showTip(plot, found) {
    if (!plot.tip) {
      plot.tip = document.createElement('div');
      plot.tip.className = 'tip';
      plot.tip.setAttribute('role', 'status');
      plot.host.append(plot.tip);
    }
    plot.tip.hidden = !found;
    if (!found) return;
    plot.tip.textContent = found.series.tip(found.index);
    const { width } = plot.host.getBoundingClientRect();
    plot.tip.style.left = `${Math.max(0, Math.min(found.x + 12, width - plot.tip.offsetWidth - 4))}px`;
    plot.tip.style.top = `${Math.max(0, found.y - plot.tip.offsetHeight - 10)}px`;
  }

  /** Every point that can be read out, with its place on the screen. */
  function readablePoints(plot) {
    const { x, y } = plot.chart.scales;
    return plot.spec.series.filter((series) => series.tip && !series.hidden).flatMap((series) =>
      series.x.map((value, index) => ({ series, index, x: x.getPixelForValue(value), y: y.getPixelForValue(series.y[index]) })))
      .filter((point) => inArea(plot.chart.chartArea, point.x, point.y));
  }

  function hover(plot, at) {
    if (plot.spec.link) {
      plot.spec.link.onCursor(plot.chart.scales.x.getValueForPixel(at.x));
      return;
    }
    let best = null, reach = 26;
    for (const point of readablePoints(plot)) {
      const distance = Math.hypot(point.x - at.x, point.y - at.y);
      if (distance < reach) [best, reach] = [point, distance];
    }
    showTip(plot, best);
  }

  function stepTip(plot, steps) {
    const points = readablePoints(plot);
    if (points.length === 0) return;
    plot.stepped = ((plot.stepped === undefined ? (steps > 0 ? -1 : 0) : plot.stepped) + steps + points.length) % points.length;
    showTip(plot, points[plot.stepped]);
  }

  function interact(plot) {
    const { canvas, spec } = plot;
    let start = null;
    let turned = 1;
    const hoverSoon = perFrame((at) => hover(plot, at));
    const zoomSoon = perFrame((at) => { zoom(plot, turned, at); turned = 1; });
    const place = (event) => ({ x: event.offsetX, y: event.offsetY });
    canvas.addEventListener('pointerdown', (event) => {
      if (event.button === 0 && inArea(plot.chart.chartArea, event.offsetX, event.offsetY)) {
        start = place(event);
        canvas.setPointerCapture(event.pointerId);
      }
    });
    canvas.addEventListener('pointermove', (event) => {
      const at = place(event);
      if (!start) {
        if (inArea(plot.chart.chartArea, at.x, at.y)) hoverSoon(at);
        return;
      }
      const { left, right, top, bottom } = plot.chart.chartArea;
      const [x0, x1] = [start.x, Math.min(Math.max(at.x, left), right)].sort((a, b) => a - b);
      const tall = !spec.link || event.shiftKey;
      const [y0, y1] = tall ? [start.y, Math.min(Math.max(at.y, top), bottom)].sort((a, b) => a - b) : [top, bottom];
      plot.selection = { x: x0, y: y0, width: x1 - x0, height: y1 - y0, tall };
      plot.chart.draw();
    });
    const release = () => {
      const box = plot.selection;
      start = plot.selection = null;
      if (!box) return;
      if (box.width < 6 || (box.tall && box.height < 6)) { plot.chart.draw(); return; }
      const { x, y } = plot.chart.scales;
      const view = { x: [box.x, box.x + box.width].map((p) => x.getValueForPixel(p)) };
      if (box.tall) view.y = [box.y + box.height, box.y].map((p) => y.getValueForPixel(p));
      requestView(plot, view);
    };
    canvas.addEventListener('pointerup', release);
    canvas.addEventListener('pointercancel', release);
    canvas.addEventListener('pointerleave', () => { if (!spec.link && !start) showTip(plot, null); });
    canvas.addEventListener('dblclick', () => reset(plot));
    // The wheel scrolls the page unless the plot has been clicked (has the focus) or Ctrl is held.
    canvas.addEventListener('wheel', (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      turned *= event.deltaY > 0 ? 1.25 : 0.8;
      zoomSoon(place(event));
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => {
      const steps = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (steps && spec.link) spec.link.onStep(steps * (event.shiftKey ? 10 : 1));
      else if (steps) stepTip(plot, steps);
      else if (event.key === '+' || event.key === '=') zoom(plot, 0.8);
      else if (event.key === '-') zoom(plot, 1.25);
      else if (event.key === '0' || event.key === 'Escape') reset(plot);
      else return;
      event.preventDefault();
    });
  }

  /** Draws every plot anew in the colours of the scheme at hand. */
  function recolour() {
    Axes.forgetColours();
    all.forEach(refresh);
  }
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', recolour);

  return { all, create, refresh, recolour, setView, setCursor, firstAtOrAbove };
})();
