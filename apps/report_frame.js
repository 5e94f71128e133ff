'use strict';
// What every page ends with: how it was made, its contents, and how it prints.
const Frame = (() => {
  const { el, table } = Elements;

  /** made: { settings, inputs: [[file, SHA-256]], version, date, command, inputFiles: [[name, text]] } */
  function provenance(host, made) {
    const definition = (rows) => table([['', true], ['', true, true]], rows);
    if (made.settings.length) host.append(el('h3', {}, 'Settings'), definition(made.settings));
    host.append(el('h3', {}, 'Inputs'), made.inputs.length
      ? table([['file', true], ['SHA-256', true, true]], made.inputs.map(([name, hash]) => [name, el('code', { class: 'hash' }, hash)])) : el('p', {}, 'No inputs recorded.'));
    host.append(el('p', { class: 'note' }, [made.version && `Written by struna ${made.version}`, made.date].filter(Boolean).join(', ')));
    if (made.command) host.append(el('h3', {}, 'How to reproduce'), el('pre', {}, made.command));
    for (const [name, text] of made.inputFiles) host.append(el('details', {}, el('summary', {}, name), el('pre', {}, text)));
  }

  const warnings = (texts) => (texts.length ? [el('ul', { class: 'warnings', 'aria-label': 'Warnings' }, texts.map((text) => el('li', {}, text)))] : []);

  // Paper is light whatever the screen is, and plots are drawn anew for its width instead of being shrunk with their text.
  function setPaper(on) {
    document.body.classList.toggle('paper', on);
    if (on) document.documentElement.dataset.scheme = 'light'; else delete document.documentElement.dataset.scheme;
    Plots.all.forEach((plot) => plot.chart.resize());
    Plots.recolour();
  }

  function finish() {
    const contents = document.getElementById('contents');
    for (const part of document.querySelectorAll('main > section'))
      contents.append(el('a', { href: `#${part.id}` }, part.querySelector('h2').textContent));
    addEventListener('beforeprint', () => setPaper(true));
    addEventListener('afterprint', () => setPaper(false));
    document.documentElement.dataset.ready = 'true'; // for checks of the page
  }

  return { provenance, warnings, finish };
})();
