// Study: habits and places, two questions each; every answer is saved immediately.
'use strict';

const line = messageLine(), body = el('div', {});
main.append(el('h1', {}, 'Study'), line, body);
const note = el('span', {class: 'faint', id: 'saved'});
let study = '', rater = '', data = null, at = 0, saving = Promise.resolve(), pending = 0, keys = () => {};

document.addEventListener('keydown', event => { if (!isTyping(event)) keys(event); });

const link = (path, words, text, name) => el('a', {href: `api/study/${path}?${new URLSearchParams(words)}`, download: name}, text);

/** The first view: the studies, and a new one. */
async function start() {
  keys = () => {};
  const studies = await ask('study/list');
  const who = el('input', {id: 'rater', required: true, maxlength: 40, pattern: '[A-Za-z0-9][A-Za-z0-9_\\-]*', autocomplete: 'nickname', value: rater || stored()});
  const open = name => {
    if (!who.reportValidity()) return;
    rater = who.value;
    try { localStorage.setItem('ucon-name', rater); } catch { /* no storage */ }
    shownIn(line, () => answer(name));
  };
  const name = el('input', {id: 'study-name', required: true, maxlength: 40, pattern: '[A-Za-z0-9][A-Za-z0-9_\\-]*', value: studies.length ? '' : 'habits'});
  const n = el('input', {type: 'number', min: 2, max: 5000, value: 20, required: true, id: 'study-n'});
  const seed = el('input', {type: 'number', min: 0, max: 1000000, value: 0, required: true});
  const form = el('form', {class: 'fields'}, field('Name (letters a to z, digits, _ and -)', name), field('Items', n), field('Seed', seed), el('button', {type: 'submit', class: studies.length ? '' : 'main'}, 'Create the study'));
  form.addEventListener('submit', event => {
    event.preventDefault();
    shownIn(line, async () => { await tell('study/make', {study: name.value, n: Number(n.value), seed: Number(seed.value)}); await start(); });
  });
  refill(body,
    el('p', {}, 'Each item is a sentence about somebody’s habits, an OBJECT and a PLACE. Two questions: could a real person have this habit, and would you look for the object there after reading it? Skip what you cannot answer; this is not a test.'),
    studies.length ? [el('div', {class: 'fields'}, field('Your name or initials (letters a to z, digits, _ and -)', who)), el('div', {class: 'cards'}, studies.map(one => el('div', {class: 'panel'},
      el('h2', {}, plain(one.name)), el('p', {class: 'faint'}, one.items === null ? 'the key is damaged' : `${one.items} items; raters: `, one.items === null ? null : plain(one.raters.join(', ') || 'none yet')),
      el('div', {class: 'row'}, el('button', {type: 'button', class: 'main', 'aria-label': `Answer ${one.name}`, onclick: () => open(one.name)}, 'Answer'),
        el('button', {type: 'button', 'aria-label': `Figures of ${one.name}`, onclick: () => shownIn(line, () => figures(one.name))}, 'Figures')))))] : null,
    el('h2', {}, 'A new study'), form);
  (studies.length ? who : name).focus();
}

function stored() {
  try { return localStorage.getItem('ucon-name') || ''; } catch { return ''; }
}

/** The items, one at a time, from the first one without an answer. */
async function answer(name) {
  study = name;
  data = await ask('study/items', {study, rater});
  at = data.items.findIndex(one => !isWhole(one));
  if (at < 0) at = data.items.length;
  show();
}

const said = one => data.answers[one.item] || [null, null];
const isWhole = one => said(one).every(value => value !== null);

function show() {
  const total = data.items.length, done = data.items.filter(isWhole).length;
  const progress = el('p', {class: 'row', role: 'status'}, el('span', {id: 'done'}, `${done} of ${total} answered, as ${rater}`), el('progress', {max: total, value: done, 'aria-label': 'Answered'}), note);
  if (at >= total) {
    keys = () => {};
    const written = el('p', {}), any = data.items.some(one => said(one).some(value => value !== null));
    if (any) saving.then(() => refill(written, link('sheet', {study, rater}, 'Your sheet (CSV)', `${rater}.csv`)));
    refill(body, progress, el('h2', {id: 'thanks'}, done === total ? 'All items are answered. Thank you!' : 'That was the last item'),
      written,
      el('div', {class: 'row'}, done < total ? el('button', {type: 'button', class: 'main', onclick: () => { at = data.items.findIndex(one => !isWhole(one)); show(); }}, 'To the skipped items') : null,
        el('button', {type: 'button', onclick: () => { at = total - 1; show(); }}, 'Back'), el('button', {type: 'button', class: done === total ? 'main' : '', onclick: () => shownIn(line, start)}, 'Back to the studies')));
    return;
  }
  const one = data.items[at], [real, look] = said(one);
  const choice = (which, values, chosen, names) => el('div', {class: 'choices'}, values.map(value => el('label', {class: 'choice'},
    el('input', {type: 'radio', name: which, value, checked: value === chosen, onchange: () => save(one, which, value)}), el('span', {}, names[value] ?? String(value)))));
  refill(body, progress, el('article', {class: 'panel item'},
    el('p', {class: 'faint'}, `item ${at + 1} of ${total}`),
    el('blockquote', {id: 'habit'}, longText(one.habit)),
    el('p', {class: 'about'}, 'OBJECT ', el('b', {}, plain(one.object)), el('br'), 'PLACE ', el('b', {}, plain(one.place))),
    el('fieldset', {}, el('legend', {}, 'Is this a habit a real person could have?'), choice('real', [1, 2, 3, 4, 5], real, {1: '1 surely not', 5: '5 surely'})),
    el('fieldset', {}, el('legend', {}, `Would you look for the ${one.object} there after reading it?`), choice('look', ['yes', 'unsure', 'no'], look, {})),
    el('div', {class: 'row'}, el('button', {type: 'button', disabled: at === 0, onclick: () => go(-1)}, 'Back'),
      el('button', {type: 'button', class: isWhole(one) ? 'main' : '', id: 'next', onclick: () => go(1)}, isWhole(one) ? 'Next' : 'Skip'),
      real !== null || look !== null ? el('button', {type: 'button', onclick: () => save(one, 'none', null)}, 'Clear both') : null,
      el('span', {class: 'faint'}, 'keys: ', el('kbd', {}, '1'), '–', el('kbd', {}, '5'), ' ', el('kbd', {}, 'Y'), ' ', el('kbd', {}, 'U'), ' ', el('kbd', {}, 'N'), ', then ', el('kbd', {}, 'Enter')))),
  el('p', {}, el('button', {type: 'button', onclick: () => shownIn(line, start)}, 'Leave (continue later)')));
  keys = event => {
    const key = event.key.toLowerCase();
    if ('12345'.includes(key) && key.length === 1) save(one, 'real', Number(key));
    else if ('yun'.includes(key) && key.length === 1) save(one, 'look', {y: 'yes', u: 'unsure', n: 'no'}[key]);
    else if (key === 'enter' && !/^(BUTTON|A)$/.test(event.target.tagName)) go(1);
  };
}

function go(by) {
  at = Math.max(0, at + by);
  show();
  document.querySelector('.item input, #thanks')?.focus?.();
}

/** Save an answer; the next one waits for it, so that none overtakes another. */
function save(one, which, value) {
  const [real, look] = which === 'none' ? [null, null] : said(one);
  const next = {real: which === 'real' ? value : real, look: which === 'look' ? value : look};
  data.answers[one.item] = [next.real, next.look];
  const focused = document.activeElement?.name ? `input[name=${document.activeElement.name}]:checked` : null;
  show();
  const whole = isWhole(one);
  (whole ? document.getElementById('next') : focused && document.querySelector(focused))?.focus();
  const owner = data, sent = {study, rater, item: one.item, ...next};  // the page may show other answers by then
  pending += 1;
  note.textContent = 'saving …';
  saving = saving.then(() => shownIn(line, () => tell('study/answer', sent))).then(done => {
    pending -= 1;
    if (!done) note.textContent = 'not saved';
    else if (!pending) note.textContent = 'saved';
    if (!done && owner === data) data.answers[one.item] = [real, look];
    if (!done && owner === data) show();
  });
}

/** Means, agreement and intervals of all raters. */
async function figures(name) {
  keys = () => {};
  const {figures: f} = await ask('study/figures', {study: name});
  const row = (text, found, low, high) => el('tr', {}, el('td', {}, text), el('td', {}, found ? found.mean.toFixed(3) : '–'),
    el('td', {}, found ? `${found.low.toFixed(3)} to ${found.high.toFixed(3)}` : 'not defined'), el('td', {}, found ? found.n : '–'), el('td', {}, Charts.bar(found, low, high)));
  const back = el('button', {type: 'button', onclick: () => shownIn(line, start)}, 'Back to the studies');
  if (!f) { refill(body, el('h2', {}, plain(name)), el('p', {class: 'faint'}, 'Nobody has answered yet.'), back); return; }
  const share = value => value === null ? '–' : value.toFixed(2);
  refill(body, el('h2', {id: 'figures'}, plain(name), `: ${f.raters} ${f.raters === 1 ? 'rater' : 'raters'}, ${f.items} items`),
    el('div', {class: 'wide'}, el('table', {}, el('thead', {}, el('tr', {}, ['', 'mean', '95 %', 'answers', ''].map(text => el('th', {}, text)))), el('tbody', {},
      row('a real person’s habit, 1 to 5', f.real, 1, 5), row('would look there: true places', f.look.yes_true, 0, 1), row('would look there: swapped places', f.look.yes_swapped, 0, 1),
      row('true minus swapped', f.look.difference, -1, 1), row('Krippendorff’s alpha, real (ordinal)', f.alpha_real, -1, 1), row('Krippendorff’s alpha, look (nominal)', f.alpha_look, -1, 1)))),
    el('h3', {}, 'Raters'),
    el('div', {class: 'wide'}, el('table', {}, el('thead', {}, el('tr', {}, ['rater', 'real', 'yes, true', 'yes, swapped', 'sheet'].map(text => el('th', {}, text)))), el('tbody', {},
      Object.entries(f.by_rater).map(([who, one]) => el('tr', {}, el('td', {}, plain(who)), el('td', {}, share(one.real)), el('td', {}, share(one.yes_true)), el('td', {}, share(one.yes_swapped)),
        el('td', {}, link('sheet', {study: name, rater: who}, 'CSV', `${who}.csv`))))))),
    el('details', {}, el('summary', {}, 'For the person who runs the study'), el('p', {}, link('key', {study: name}, 'The key (CSV)', `${name}.key.csv`), ' says which places are true. Raters must not see it. The same figures come from ', el('code', {}, 'python -m ucon habits survey score KEY.csv SHEET.csv ...'))),
    el('p', {}, back));
}

shownIn(line, start);
