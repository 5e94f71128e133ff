'use strict';
// The page of `struna limits`: what was flagged of each method's wrong results, and a map for each.
(() => {
  const data = JSON.parse(document.getElementById('report-data').textContent);
  const { el, table } = Elements;

  document.getElementById('origin').textContent =
    'Wrong: off by more than five stated standard errors, or by more than three and the stated tolerance. Uncertain: off by more than the tolerance, within its standard errors. Hover over a cell for its counts.';
  const summary = document.getElementById('summary');
  summary.append(table([['map', true], ['right'], ['of them flagged'], ['uncertain'], ['wrong'], ['of them flagged'], ['refused']],
    data.summary.map((row) => [el('a', { href: `#${row.name}` }, row.title), row.right, row.alarms, row.uncertain, row.wrong, row.flagged, row.refused])));

  for (const map of data.maps) {
    const host = document.getElementById(map.name);
    const picture = el('div', { class: 'scroll' });
    picture.innerHTML = map.svg;
    host.append(el('p', {}, map.sentence), el('p', { class: 'note' }, `Error: ${map.quantity}.`), picture,
      el('details', {}, el('summary', {}, 'flags'), table([['flags', true, true], ['right results'], ['uncertain results'], ['wrong results']],
        map.flags.map(([flags, ...counts]) => [flags || '(none)', ...counts]))));
  }
  summary.append(el('h3', {}, 'How to reproduce'), el('pre', {}, data.command));
  Frame.finish();
})();
