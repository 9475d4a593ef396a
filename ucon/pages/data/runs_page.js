// Runs: what eval.py and train.py have written, also while they write.
'use strict';

const EVERY_MS = 2000;
// Polls have their own message line, or they would clear the answer to a click.
const line = messageLine(), polls = messageLine(), body = el('div', {});
main.append(el('h1', {}, 'Runs'), line, polls, body);
const search = el('input', {type: 'search', placeholder: 'search', 'aria-label': 'Search the runs', id: 'run-search'});
const kind = choiceOf(['all', 'eval', 'train'], 'all', {all: 'all', eval: 'evaluations', train: 'training runs'});
kind.setAttribute('aria-label', 'Kind');
const count = el('span', {class: 'faint', role: 'status'}), table = el('div', {class: 'wide'}), figures = el('div'), lives = new LiveLives(), detail = el('section', {class: 'run-detail', id: 'detail', 'aria-label': 'The chosen run'}, figures, lives.node);
body.append(el('div', {class: 'row'}, search, kind, count), el('div', {class: 'runs'}, table, detail));
search.addEventListener('input', () => fill());
kind.addEventListener('change', () => fill());

let runs = [], total = 0, lastList = '', lastOne = '', chosen = decodeURIComponent(location.hash.slice(1));

const ago = seconds => seconds < 90 ? `${seconds} s` : seconds < 5400 ? `${Math.round(seconds / 60)} min` : seconds < 129600 ? `${Math.round(seconds / 3600)} h` : `${Math.round(seconds / 86400)} d`;
const state = run => run.finished ? 'finished' : run.age_s < 180 ? 'running' : 'not finished';
const done = run => run.done === undefined ? '' : run.total && run.total !== run.done ? `${run.done} of ${run.total}` : String(run.done);

function fill() {
  const words = wordsOf(search.value);
  const found = runs.filter(run => (kind.value === 'all' || run.kind === kind.value)
    && words.every(word => `${run.name} ${run.label} ${run.level} ${state(run)}`.toLowerCase().includes(word)));
  count.textContent = found.length === total ? `${total} runs` : `${found.length} of ${total} runs`;
  if (!runs.length) {
    refill(table, el('p', {class: 'faint'}, 'No runs yet. A run appears as soon as eval.py or train.py has written its first line.'));
    return;
  }
  const kept = document.activeElement?.dataset?.run;
  refill(table, el('table', {}, el('thead', {}, el('tr', {},
    ['run', 'agent', 'habits', 'state', 'done', 'SR % [95 %]', 'SPL', 'age'].map((text, k) => el('th', {class: k < 4 ? 'left' : ''}, text)))),
  el('tbody', {}, found.map(run => el('tr', {class: run.id === chosen ? 'chosen' : ''},
    el('td', {class: 'run-name'}, el('button', {type: 'button', class: 'link', 'data-run': run.id, 'aria-pressed': run.id === chosen, onclick: () => choose(run.id)}, plain(run.name))),
    el('td', {class: 'left what', title: run.problem || ''}, plain(run.label || '')), el('td', {class: 'left'}, plain(run.level || '')),
    el('td', {class: `left ${run.finished ? '' : state(run) === 'running' ? 'good' : 'warm'}`}, state(run)),
    el('td', {}, done(run)),
    el('td', {}, run.success_rate_ci95 ? interval(run.success_rate, run.success_rate_ci95) : run.score != null ? `best score ${Number(run.score.toPrecision(2))}` : ''),
    el('td', {}, run.spl === undefined ? '' : run.spl.toFixed(3)), el('td', {}, ago(run.age_s)))))));
  if (kept) table.querySelector(`[data-run="${kept}"]`)?.focus();
}

async function choose(id) {
  chosen = id;
  history.replaceState(null, '', `#${encodeURIComponent(id)}`);
  fill();
  line.textContent = '';
  await shownIn(polls, one);
  if (detail.getBoundingClientRect().top > innerHeight) detail.scrollIntoView();  // below the list, where the window is narrow
}

async function one() {
  if (!chosen) {
    refill(figures, el('p', {class: 'faint'}, 'Choose a run to see its curves and figures.'));
    return;
  }
  const asked = chosen, run = await ask('runs/one', {run: asked});
  const text = sameBut(run, ({age_s, ...rest}) => [rest, state(run)]);
  if (asked !== chosen || text === lastOne) return;
  lastOne = text;
  const share = run.total ? run.done / run.total : null;
  lives.show(run);
  refill(figures, el('h2', {}, plain(run.name)),
    el('p', {}, plain(run.label || ''), run.level ? [', habits: ', plain(run.level)] : null, `, ${state(run)}`),
    el('p', {class: 'row'}, el('span', {class: 'figure', id: 'progress'}, `${done(run)} ${run.kind === 'train' ? 'steps' : run.lives ? 'requests' : 'episodes'}`),
      share === null ? null : el('progress', {max: 1, value: share, 'aria-label': 'Progress'})),
    run.success_rate_ci95 ? el('dl', {class: 'facts'}, ...[['SR %', interval(run.success_rate, run.success_rate_ci95)], ['SPL', interval(run.spl, run.spl_ci95, 1, 3)],
      ['steps', run.steps.toFixed(0)], ['failures', Object.entries(run.failure_causes).map(([why, n]) => `${spaced(why)} ${n}`).join(', ') || 'none']]
      .flatMap(([name, value]) => [el('dt', {}, name), el('dd', {class: 'figure'}, value)])) : null,
    reportLine(run),
    el('div', {class: 'curves'}, run.curves.map(Charts.curve)),
    run.episodes?.length ? el('details', {}, el('summary', {}, run.lives ? 'The last requests' : 'The last episodes'), el('div', {class: 'wide'}, el('table', {}, el('tbody', {}, run.episodes.map(episode =>
      el('tr', {}, el('td', {}, plain(episode.episode)), el('td', {class: 'left'}, plain(spaced(episode.target))), el('td', {class: `left ${episode.success ? 'good' : 'bad'}`}, episode.success ? 'found' : plain(episode.why)), el('td', {}, episode.steps))))))) : null);
}

/** The link to a run's report, and the button that makes it. */
function reportLine(run) {
  const link = run.report ? el('a', {href: `report/${run.id}`, target: '_blank', rel: 'noopener noreferrer', id: 'report'}, 'Open the report') : null;
  const make = el('button', {type: 'button', id: 'make-report', disabled: run.making, onclick: () => shownIn(line, async () => { await tell('runs/report', {run: run.id}); await one(); })},
    run.making ? 'The report is being made' : run.report ? 'Make it again' : 'Make a report');
  return run.can_report || link ? el('p', {class: 'row'}, link, link ? el('span', {class: 'faint'}, 'opens in a new tab') : null, run.can_report ? make : null, run.fault ? el('span', {class: 'bad plain'}, run.fault) : null) : null;
}

async function list() {
  const found = await ask('runs/list'), text = sameBut(found, ({age_s, ...run}) => run);
  runs = found.runs;
  total = found.n;
  if (text !== lastList || !document.activeElement?.closest('table')) fill();  // does not disturb somebody who reads the table
  lastList = text;
}

const sameBut = (found, rest) => JSON.stringify(found.runs ? found.runs.map(rest) : rest(found));

/** Poll while the page is visible, every second time for the list, too; an open list of episodes stays open. */
async function again(round) {
  if (!document.hidden) {
    const open = detail.querySelector('details')?.open;
    await shownIn(polls, async () => { if (round % 2) await list(); await one(); });
    if (open) detail.querySelector('details')?.setAttribute('open', '');
  }
  setTimeout(again, EVERY_MS, round + 1);
}

shownIn(polls, list).then(() => again(0));
