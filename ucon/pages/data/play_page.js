// Play: a person searches with what an agent is given: the picture, the names of the things in view, the habits.
'use strict';

const ACTIONS = [
  {action: 2, keys: ['ArrowLeft'], key: '←', name: 'Turn left'},
  {action: 0, keys: ['ArrowUp'], key: '↑', name: 'Move ahead'},
  {action: 1, keys: ['ArrowRight'], key: '→', name: 'Turn right'},
  {action: 3, keys: ['w'], key: 'W', name: 'Look up'},
  {action: 5, keys: ['o'], key: 'O', name: 'Open'},
  {action: 4, keys: ['s'], key: 'S', name: 'Look down'},
  {action: 6, keys: ['f'], key: 'F', name: 'Found it: end the search', wide: true},
];
const LEVEL_NAMES = {none: 'none', retrieval: 'retrieval: the 20 nearest', gt: 'gt: all about the target', full: 'full: all of the household'};
const PICTURE_NAMES = {128: '128 × 128, as agents get it', 384: '384 × 384, sharper'};

const line = messageLine();
const body = el('div', {});
main.append(el('h1', {}, 'Play'), line, body);
let game = '', busy = false, view = null, act = () => {};

document.addEventListener('keydown', event => {
  const found = !isTyping(event) && view && ACTIONS.find(one => one.keys.includes(event.key.length === 1 ? event.key.toLowerCase() : event.key));
  if (!found) return;
  event.preventDefault();
  act(found.action);
});

/** The first view: choose a run, or continue one. */
async function start() {
  view = null;
  const {levels, sets, pictures, left, rules} = await ask('play/choices');
  const name = el('input', {required: true, maxlength: 40, pattern: '[A-Za-z0-9][A-Za-z0-9_\\-]*', autocomplete: 'nickname', id: 'player', title: 'Letters a to z, digits, _ and -'});
  const level = choiceOf(levels, 'retrieval', LEVEL_NAMES);
  const set = choiceOf(sets, sets[0]);
  const n = el('input', {type: 'number', min: 1, max: 2000, value: 5, required: true});
  const picture = choiceOf(pictures, 128, PICTURE_NAMES);
  try { name.value = localStorage.getItem('ucon-name') || ''; } catch { /* no storage */ }
  const form = el('form', {class: 'panel'},
    el('div', {class: 'fields'}, field('Your name or initials (letters a to z, digits, _ and -)', name), field('Habits', level), field('Episodes', set),
      field('How many', n), field('Picture', picture), el('button', {class: 'main', type: 'submit'}, 'Begin')));
  form.addEventListener('submit', event => {
    event.preventDefault();
    try { localStorage.setItem('ucon-name', name.value); } catch { /* no storage */ }
    begin({player: name.value, level: level.value, episodes: set.value, n: Number(n.value), picture_px: Number(picture.value)});
  });
  refill(body, 
    el('p', {}, 'You stand in a home that you do not know, and look for one thing. You get what an agent gets: the '
      + 'picture from where you stand, the names of what is in view, sentences about the household’s habits, and 300 steps. '
      + 'You are done when the thing is in view, within 1 m, and you say so.'),
    form, left.length ? [el('h2', {}, 'Earlier runs'), leftList(left)] : null, el('h2', {}, 'Keys'), keyTable(rules));
  name.focus();
}

function keyTable(rules) {
  return el('div', {class: 'wide'}, el('table', {class: 'keys'}, el('tbody', {}, ACTIONS.map(one => el('tr', {},
    el('td', {}, el('kbd', {}, one.key)), el('td', {class: 'left'}, one.name), el('td', {class: 'left faint'}, rules[one.action].effect))))));
}

function leftList(left) {
  return el('div', {class: 'wide'}, el('table', {}, el('thead', {}, el('tr', {},
    ['who', 'habits', 'episodes', 'done', ''].map((text, k) => el('th', {class: k < 3 ? 'left' : ''}, text)))),
  el('tbody', {}, left.map(one => el('tr', {},
    el('td', {}, plain(one.player)), el('td', {class: 'left'}, one.level), el('td', {class: 'left'}, `${one.episodes}`),
    el('td', {}, `${one.done} of ${one.n}`),
    el('td', {}, one.finished ? el('span', {class: 'faint', title: one.run}, 'finished')
      : el('button', {type: 'button', 'aria-label': `Continue: ${one.player}, ${one.level}, ${one.episodes}`, onclick: () => begin(one)}, 'Continue')))))));
}

async function begin(options) {
  const {player, level, episodes, n, picture_px} = options;
  body.append(el('p', {role: 'status', id: 'wait'}, 'Opening the home …'));
  await shownIn(line, async () => {
    const opened = await tell('play/begin', {player, level, episodes, n, picture_px});
    game = opened.game;
    await show(opened.state, opened.rules);
  });
  document.getElementById('wait')?.remove();
}

/** The search itself; its elements are made once and filled in with every step. */
async function show(state, rules) {
  if (!state.view) return finished(state);
  const parts = searching(rules);
  refill(body, parts.whole);
  let given = null;
  const update = async next => {
    if (!next.view || given !== null && next.view.episode !== given) {
      view = null;
      await result(next, rules);
      return;
    }
    view = next.view;
    parts.fill(next);
    if (given === null) {
      given = view.episode;
      parts.habits(await ask('play/habits', {game}));
    }
  };
  act = async action => {
    if (busy || !view) return;
    busy = true;
    const sent = {game, episode: view.episode, step: view.step, action};
    await shownIn(line, async () => {
      const next = await tell('play/act', sent);
      await update(next);
      if (next.dropped) line.textContent = 'That key did nothing: somebody else is playing under this name, or you are in another tab.';
    });
    busy = false;
  };
  await update(state);
}

function searching(rules) {
  const target = el('b', {}), steps = el('b', {class: 'figure'}), where = el('span', {class: 'faint'});
  const context = el('p', {class: 'faint plain', dir: 'auto'});
  const eye = el('img', {class: 'eye', alt: 'What you see'}), seen = el('img', {class: 'seen', alt: 'Map of what you have seen'});
  const effect = el('p', {class: 'effect', role: 'status'}), things = el('ul', {class: 'things', 'aria-label': 'Things in view'});
  const bar = el('progress', {'aria-label': 'Steps used'});
  const search = el('input', {type: 'search', placeholder: 'search', 'aria-label': 'Search the habits', id: 'habit-search'});
  const list = el('ul', {class: 'list habits scroll', tabindex: 0, 'aria-label': 'Habits'}), count = el('span', {class: 'faint'});
  let sentences = [];
  const listed = () => {
    const words = wordsOf(search.value);
    const found = sentences.filter(text => words.every(word => text.toLowerCase().includes(word)));
    count.textContent = words.length ? `${found.length} of ${sentences.length}` : `${sentences.length}`;
    refill(list, ...found.map(text => el('li', {}, marked(clipped(text, 2000), words))));
    if (!found.length) list.append(el('li', {class: 'faint'}, sentences.length ? 'none with these words' : 'none are given at this level'));
  };
  search.addEventListener('input', listed);
  const pad = el('div', {class: 'pad'}, ACTIONS.map(one => el('button', {
    type: 'button', class: one.action === 6 ? 'main wide-key' : '', title: rules[one.action].effect, 'data-action': one.action,
    onclick: () => act(one.action)}, el('span', {}, one.name), el('kbd', {}, one.key))));
  const whole = el('div', {},
    el('div', {class: 'status'}, el('span', {}, 'Find the ', target), el('span', {}, steps, ' steps left ', bar), where,
      el('button', {type: 'button', onclick: () => shownIn(line, start)}, 'Leave (continue later)')),
    context,
    el('div', {class: 'play'},
      el('section', {'aria-label': 'View and actions'}, eye, effect, pad),
      el('section', {}, el('h2', {}, 'In view'), things, el('h2', {}, 'Seen so far'), seen,
        el('p', {class: 'faint'}, 'Drawn only from what you have seen; your first view faced right.')),
      el('section', {class: 'third'}, el('div', {class: 'spread'}, el('h2', {}, 'Habits ', count), search), list)));
  return {
    whole,
    fill: ({view: now, n, figures}) => {
      target.textContent = now.target;
      steps.textContent = now.max_steps - now.step;
      Object.assign(bar, {max: now.max_steps, value: now.step});
      where.textContent = `search ${now.number} of ${n}${figures ? `, found ${Math.round(figures.success_rate * figures.n)} of ${figures.n}` : ''}`;
      context.textContent = now.context || '';
      eye.src = now.picture;
      seen.src = now.map;
      effect.textContent = now.effect || (now.step ? '' : 'The search begins.');
      effect.className = `effect${/^(Blocked|Nothing|Cannot)/.test(now.effect) ? ' warm' : ''}`;
      refill(things, ...now.things.map(thing => el('li', {
        class: `${thing.metres <= 1 ? 'reach' : ''}${thing.target ? ' goal' : ''}`},
      `${thing.name} ${thing.metres.toFixed(1)} m${thing.opened ? ', opened' : ''}`)));
      if (!now.things.length) things.append(el('li', {}, 'no named thing'));
    },
    habits: texts => { sentences = texts; listed(); },
  };
}

/** The end of one search. */
async function result(state, rules, episode = state.last) {
  const end = await ask('play/result', {game, episode});
  const drawing = new Plan.Drawing(end.plan, `Plan of ${end.home} with your path and the shortest one`, end.turn);
  drawEnd(drawing, end);
  const next = el('button', {type: 'button', class: 'main big', onclick: () => shownIn(line, () => show(state, rules))}, state.view ? 'Next search' : 'Show the figures');
  const row = (name, own, best) => el('tr', {}, el('td', {}, name), el('td', {}, own), el('td', {}, best));
  refill(body, el('div', {class: 'result'},
    el('section', {'aria-label': 'The home'}, drawing.svg),
    el('section', {},
      el('h2', {class: end.success ? 'good' : 'bad', id: 'ending'}, end.success ? `Found the ${end.target}` : `Not found: the ${end.target}`),
      end.why ? el('p', {}, end.why) : null, el('p', {}, `It was ${end.place}.`),
      el('table', {}, el('thead', {}, el('tr', {}, ['', 'you', 'shortest'].map(text => el('th', {}, text)))),
        el('tbody', {}, row('path, m', end.path_m.toFixed(2), end.shortest_m.toFixed(2)), row('steps', end.steps, ''),
          row('blocked moves', end.collisions, ''), row('times opened', end.opens, ''), row('SPL', end.spl.toFixed(3), '1'))),
      el('p', {class: 'faint'}, el('span', {class: 'key-line'}), 'your path ', el('span', {class: 'key-line shortest'}), 'the shortest path; ★ the target; oriented like the map of what you had seen'),
      next)));
  next.focus();
}

function drawEnd(drawing, end) {
  for (const k of end.placed.removed) drawing.things[k]?.remove();
  for (const box of end.opened) drawing.box('things', box, {class: 'thing opened'}, 'opened');
  drawing.line('path', end.path, {class: 'path'});
  drawing.line('path', end.shortest, {class: 'path shortest'});
  drawing.circle('marks', end.path[0], 12, {class: 'start'}, 'start');
  const [x0, y0, x1, y1] = end.target_box;
  drawing.star('marks', [(x0 + x1) / 2, (y0 + y1) / 2], 26, end.target);
  drawing.agent(end.path.at(-1), end.heading);
}

/** After the last search. */
function finished(state) {
  const f = state.figures;
  refill(body, el('h2', {id: 'finished'}, state.n === 1 ? 'The search is done' : `All ${state.n} searches are done`),
    f ? el('table', {}, el('thead', {}, el('tr', {}, ['agent', 'habits', 'n', 'SR % [95 %]', 'SPL [95 %]', 'steps'].map((t, k) => el('th', {class: k < 2 ? 'left' : ''}, t)))),
      el('tbody', {}, el('tr', {}, el('td', {}, 'human'), el('td', {class: 'left'}, state.level), el('td', {}, f.n),
        el('td', {}, interval(f.success_rate, f.success_rate_ci95)), el('td', {}, interval(f.spl, f.spl_ci95, 1, 3)), el('td', {}, f.steps.toFixed(0))))) : null,
    el('h2', {}, 'The searches'),
    el('div', {class: 'wide'}, el('table', {}, el('tbody', {}, state.ended.map(one => el('tr', {},
      el('td', {}, one.target), el('td', {class: `left ${one.success ? 'good' : 'bad'}`}, one.success ? 'found' : one.why), el('td', {}, `${one.steps} steps`),
      el('td', {}, `SPL ${one.spl.toFixed(3)}`), el('td', {}, el('button', {type: 'button', 'aria-label': `Map of the search for the ${one.target}`,
        onclick: () => shownIn(line, () => result(state, [], one.episode))}, 'Map'))))))),
    el('p', {}, 'Compare your run with those of agents: ', el('code', {class: 'plain'}, `python -m ucon compare ${state.run} RUN`)),
    el('button', {type: 'button', class: 'main', onclick: () => shownIn(line, start)}, 'Play more'));
}

shownIn(line, start);
