// What reports of runs share: the table of the runs, their differences, figures within groups.
'use strict';

const colorOf = number => `var(--run-${number % 6})`;
const swatch = number => el('span', {class: 'swatch', style: `background: ${colorOf(number)}`});
const words = name => name.replaceAll('_', ' ');
const interval = ([mean, low, high], factor, digits, sign = '') => {
  const said = v => `${sign && v >= 0 ? '+' : ''}${(factor * v).toFixed(digits)}`;
  return low === high ? said(mean) : `${said(mean)} [${said(low)}, ${said(high)}]`;
};

function table(head, rows, attributes = {}) {
  return el('table', attributes,
    el('thead', {}, el('tr', {}, head.map(name => el('th', {scope: 'col'}, name)))),
    el('tbody', {}, rows.map(row => el('tr', {}, row.map(cell => el('td', {}, cell))))));
}

function select(label, options, onchange) {
  const made = el('select', {'aria-label': label, onchange: event => onchange(event.target.value)},
    options.map(([value, text]) => el('option', {value}, text)));
  return made;
}

/** The table of runs, and their paired differences. */
function runsSection(index, unit = 'episodes') {
  const {runs} = index;
  const rows = runs.map((run, k) => [
    el('span', {}, swatch(k), plain(run.label)), String(run.figures.n), interval(run.figures.sr, 100, 1),
    interval(run.figures.spl, 1, 3), run.figures.steps.toFixed(0), percent(run.figures.seen, 1), plain(run.set), plain(run.folder),
  ]);
  const section = el('section', {id: 'runs'}, el('h2', {}, runs.length > 1 ? 'Runs' : 'Run'),
    el('div', {class: 'wide panel'}, table(['agent, habits', unit, 'SR % [95 %]', 'SPL [95 %]', 'steps', 'target seen %', 'set', 'folder'], rows)));
  if (index.differences.length) {
    const clear = ([, low, high]) => low !== high && (low > 0 || high < 0);
    const cell = (pair, factor, digits) => el('span', {class: clear(pair) ? '' : 'faint'}, interval(pair, factor, digits, '+') + (clear(pair) ? ' *' : ''));
    section.append(el('h3', {}, `Paired differences on the same ${unit}`), el('div', {class: 'wide panel'}, table(
      ['first minus second', unit, 'SR, points', 'SPL', 'steps'],
      index.differences.map(d => [
        el('span', {}, swatch(d.first), plain(runs[d.first].label), ' \u2212 ', swatch(d.second), plain(runs[d.second].label)),
        String(d.n), cell(d.sr, 100, 1), cell(d.spl, 1, 3), cell(d.steps, 1, 1)])),
      el('p', {class: 'faint'}, '*: the 95 % interval excludes zero.')));
  }
  for (const run of runs) if (run.note) section.append(el('p', {class: 'warm'}, plain(run.label), ': ', plain(run.note)));
  return section;
}

/** A table of figures within groups: one row per group, three columns per run. */
function groupsTable(title, groups, runs) {
  const head = [title, ...runs.flatMap((run, k) => [el('span', {}, swatch(k), 'n'), 'SR % [95 %]', 'SPL [95 %]'])];
  return table(head, groups.map(group => [plain(group.name), ...group.runs.flatMap(f =>
    f ? [String(f.n), interval(f.sr, 100, 0), interval(f.spl, 1, 2)] : ['', '', ''])]));
}
