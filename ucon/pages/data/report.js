// The report: tables of the runs, and the list of episodes. One episode is shown by episode.js.
'use strict';

const MOST_ROWS = 200;

/** SR over steps, and why searches failed. */
function endingsSection(index) {
  const curves = index.runs.map((run, k) => {
    const ends = run.rows.filter(r => r.found).map(r => r.steps).sort((a, b) => a - b);
    const points = [[0, 0], ...ends.map((s, n) => [s, (n + 1) / run.rows.length]), [300, ends.length / run.rows.length]];
    return {points, color: colorOf(k), label: run.label};
  });
  const causes = [...new Set(index.runs.flatMap(run => run.rows.filter(r => !r.found).map(r => r.cause)))].sort();
  const rows = [['found', 'var(--good)'], ...causes.map((cause, k) => [cause, `color-mix(in srgb, var(--bad) ${95 - 17 * (k % 5)}%, var(--panel))`])];
  const count = (run, name) => run.rows.filter(r => (r.found ? 'found' : r.cause) === name).length;
  return el('section', {id: 'endings'}, el('h2', {}, 'How searches end'), el('div', {class: 'cards'},
    el('div', {class: 'panel'}, el('h3', {}, 'Success rate within N steps'),
      Charts.lines(curves, {x: 'steps', y: 'SR %', low: 0, high: 1, format: v => (100 * v).toFixed(0), label: 'Success rate over steps, one line per run'}),
      index.runs.map((run, k) => el('div', {}, swatch(k), plain(run.label)))),
    el('div', {class: 'panel'}, el('h3', {}, 'Endings'),
      index.runs.map((run, k) => el('div', {}, el('div', {}, swatch(k), plain(run.label)), el('div', {class: 'bar', 'aria-hidden': 'true'},
        rows.map(([name, color]) => el('span', {style: `width: ${100 * count(run, name) / run.rows.length}%; background: ${color}`}))))),
      el('div', {class: 'wide'}, table(['', ...index.runs.map((run, k) => el('span', {}, swatch(k)))],
        rows.map(([name, color]) => [el('span', {}, el('span', {class: 'swatch', style: `background: ${color}`}), words(name)), ...index.runs.map(run => String(count(run, name)))]))))));
}

/** Figures within groups of episodes. */
function groupsSection(index) {
  const titles = Object.keys(index.groups);
  if (!titles.length) return null;
  const place = el('div', {class: 'scroll'});
  const show = title => place.replaceChildren(groupsTable(title, index.groups[title], index.runs));
  show(titles.includes('relation') ? 'relation' : titles[0]);
  const chooser = select('Group episodes by', titles.map(title => [title, title]), show);
  if (titles.includes('relation')) chooser.value = 'relation';
  return el('section', {id: 'groups'}, el('div', {class: 'spread'}, el('h2', {}, 'By kind of episode'), el('label', {}, 'by ', chooser)),
    el('div', {class: 'panel'}, place));
}

/** One entry per episode: what is common to all runs, and the row of each run that played it. */
function episodesOf(index) {
  const found = new Map();
  index.runs.forEach((run, number) => run.rows.forEach((row, k) => {
    if (!found.has(row.id)) found.set(row.id, {id: row.id, order: found.size, common: row, runs: []});
    found.get(row.id).runs.push({run: number, at: k, row});
  }));
  return [...found.values()];
}

const SORTS = {
  order: ['as played', (a, b) => a.order - b.order],
  target: ['target', (a, b) => a.common.target.localeCompare(b.common.target)],
  home: ['home', (a, b) => a.common.scene.localeCompare(b.common.scene)],
  steps: ['most steps first', (a, b) => Math.max(...b.runs.map(r => r.row.steps)) - Math.max(...a.runs.map(r => r.row.steps))],
  spl: ['lowest SPL first', (a, b) => Math.min(...a.runs.map(r => r.row.spl)) - Math.min(...b.runs.map(r => r.row.spl))],
  gap: ['largest difference in SPL first', (a, b) => gap(b) - gap(a)],
};
const gap = episode => Math.max(...episode.runs.map(r => r.row.spl)) - Math.min(...episode.runs.map(r => r.row.spl));

/** The list of episodes with its filters; `onopen(episode)` shows one. */
function listSection(index, episodes, onopen) {
  const wanted = {text: '', ending: '', relation: '', sort: 'order', most: MOST_ROWS};
  const endings = [['', 'all endings'], ['found', 'found'], ['lost', 'not found'],
    ...(index.runs.length > 1 ? [['differ', 'runs differ']] : []),
    ...[...new Set(episodes.flatMap(e => e.runs.map(r => r.row.cause)))].filter(c => c !== 'none').sort().map(c => [c, words(c)])];
  const relations = [['', 'all relations'], ...[...new Set(episodes.map(e => e.common.relation))].sort().map(r => [r, r])];
  const fits = e => {
    const text = `${e.id} ${words(e.common.target)} ${e.common.scene} ${e.common.split}`.toLowerCase();
    const rows = e.runs.map(r => r.row);
    const ending = {'': () => true, found: () => rows.some(r => r.found), lost: () => rows.some(r => !r.found),
      differ: () => new Set(rows.map(r => r.found)).size > 1}[wanted.ending] ?? (() => rows.some(r => r.cause === wanted.ending));
    return wanted.text.toLowerCase().split(/\s+/).every(word => text.includes(word)) && (!wanted.relation || e.common.relation === wanted.relation) && ending();
  };
  const body = el('tbody'), count = el('p', {class: 'faint', 'aria-live': 'polite'}), more = el('button', {type: 'button'}, 'Show more');
  let shown = [];
  const show = () => {
    shown = episodes.filter(fits).sort(SORTS[wanted.sort][1]);
    body.replaceChildren(...shown.slice(0, wanted.most).map(e => el('tr', {onclick: () => onopen(e)},
      el('td', {}, el('button', {type: 'button', class: 'open', onclick: event => { event.stopPropagation(); onopen(e); }}, plain(words(e.common.target)))),
      index.runs.map((run, k) => {
        const row = e.runs.find(r => r.run === k)?.row;
        return row ? [el('td', {class: `left ${row.found ? 'good' : 'bad'}`}, row.found ? 'found' : words(row.cause)), el('td', {}, String(row.steps)), el('td', {}, row.spl.toFixed(2))]
          : [el('td'), el('td'), el('td')];
      }).flat(),
      el('td', {class: 'left'}, e.common.relation + (e.common.contained ? ' *' : '')), el('td', {class: 'left'}, plain(e.common.scene)))));
    count.textContent = `${shown.length} of ${episodes.length} episodes${wanted.most < shown.length ? `, the first ${wanted.most} shown` : ''}. * behind a door.`;
    more.hidden = wanted.most >= shown.length;
  };
  const set = name => value => { wanted[name] = value; wanted.most = MOST_ROWS; show(); };
  more.addEventListener('click', () => { wanted.most += MOST_ROWS; show(); });
  const search = el('input', {type: 'search', placeholder: 'target, home, ...', 'aria-label': 'Search episodes', oninput: event => set('text')(event.target.value)});
  show();
  return {
    /** The episode after (1) or before (-1) another in the list as shown. */
    beside: (episode, way) => shown[shown.indexOf(episode) + way],
    section: el('section', {id: 'list'}, el('h2', {}, 'Episodes'), el('div', {class: 'row'}, search, select('Ending', endings, set('ending')),
      select('Relation', relations, set('relation')), el('label', {}, 'sort: ', select('Sort', Object.entries(SORTS).filter(([name]) => name !== 'gap' || index.runs.length > 1).map(([name, [text]]) => [name, text]), set('sort')))),
    count, el('div', {class: 'panel scroll'}, el('table', {}, el('thead', {}, el('tr', {}, el('th', {scope: 'col'}, 'target'),
      index.runs.map((run, k) => [el('th', {scope: 'col', class: 'left'}, swatch(k), 'ending'), el('th', {scope: 'col'}, 'steps'), el('th', {scope: 'col'}, 'SPL')]).flat(),
      ['relation', 'home'].map(text => el('th', {scope: 'col', class: 'left'}, text)))), body)), more),
  };
}

async function start() {
  const page = document.getElementById('page'), index = await unpack('index'), episodes = episodesOf(index);
  const list = listSection(index, episodes, episode => show(episode));
  const view = el('section', {id: 'episode', tabindex: '-1'});
  async function show(episode, step = 0) {
    await showEpisode(view, index, episode, step, way => { const next = list.beside(episode, way); if (next) show(next); });
    history.replaceState(null, '', `#${encodeURIComponent(episode.id)}`);
    view.scrollIntoView({block: 'start'});
    view.focus({preventScroll: true});
  }
  page.replaceChildren(
    el('header', {class: 'spread'}, el('div', {}, el('h1', {}, 'UcON: finding things where this person keeps them'),
      el('p', {class: 'faint'}, `Report of ${index.runs.length === 1 ? 'one run' : `${index.runs.length} runs`}, made by UcON ${index.version}. Open an episode in the list to see what the agent did, and why.`)), themeButton()),
    runsSection(index), endingsSection(index), groupsSection(index) ?? '', list.section, view);
  const asked = episodes.find(e => e.id === decodeURIComponent(location.hash.slice(1)));
  if (asked) await show(asked);
  document.documentElement.dataset.ready = 'true';
}

document.addEventListener('DOMContentLoaded', () => start().catch(error => {
  document.getElementById('page').replaceChildren(el('p', {class: 'bad'}, `This report cannot be shown: ${error.message}`));
  throw error;
}));
