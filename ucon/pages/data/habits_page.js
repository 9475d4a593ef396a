// Habits: the people of a home, what they say, and where each sentence is possible.
'use strict';

const RELATIONS = {ontop: 'on', inside: 'in', under: 'under', nextto: 'beside'}, FIRST = 60;
const line = messageLine(), body = el('div', {});
main.append(el('h1', {}, 'Habits'), line, body);
const home = el('select', {id: 'home'}), other = el('input', {id: 'other-home', placeholder: 'Rs_int~3, procedural:house:17', maxlength: 100});
const seed = el('input', {type: 'number', min: 0, max: 1000000, value: 0, id: 'seed'});
const form = el('form', {class: 'fields'}, field('Home', home), field('Or by name', other), field('Seed (for other people)', seed), el('button', {type: 'submit'}, 'Show'));
const search = el('input', {type: 'search', id: 'habit-search', placeholder: 'words of a sentence, a thing, a household'});
const category = el('select', {id: 'category'}), possible = el('input', {type: 'checkbox', id: 'possible'});
const count = el('p', {class: 'faint', role: 'status', id: 'count'}), list = el('ul', {class: 'list habits scroll', id: 'sentences', 'aria-label': 'Sentences'});
const planBox = el('div', {}), detail = el('div', {class: 'panel card', id: 'where', 'aria-live': 'polite'});
body.append(form, el('div', {class: 'habit-page'},
  el('section', {'aria-label': 'Sentences'}, el('div', {class: 'fields'}, field('Search', search), field('Thing', category)),
    el('label', {class: 'row check'}, possible, 'only what is possible here'), count, list),
  el('section', {'aria-label': 'Where'}, detail, planBox)));

let sentences = [], data = null, drawing = null, shown = FIRST;

form.addEventListener('submit', event => { event.preventDefault(); shownIn(line, () => load(other.value.trim() || home.value)); });
home.addEventListener('change', () => { other.value = ''; shownIn(line, () => load(home.value)); });
search.addEventListener('input', later(() => { shown = FIRST; fill(); }));
for (const control of [category, possible]) control.addEventListener('change', () => { shown = FIRST; fill(); });

async function load(name) {
  const [people, plan] = await Promise.all([ask('habits/household', {home: name, seed: seed.value}), ask('homes/plan', {home: name})]);
  data = people;
  sentences = people.entries.flatMap(entry => entry.habits.map(([text, supports]) => ({text, supports, entry,
    low: `${text} ${spaced(entry.category)} ${entry.household}`.toLowerCase(),
    here: supports.some(k => entry.places[k].here)})));
  const names = [...new Set(people.entries.map(entry => entry.category))];
  refill(category, el('option', {value: ''}, 'all'), ...names.map(one => el('option', {value: one}, spaced(one))));
  drawing = new Plan.Drawing(plan, `Plan of ${plan.name}`);
  refill(planBox, drawing.svg);
  refill(detail, el('p', {class: 'faint'}, 'Choose a sentence to see on the plan where the habit is possible.'));
  shown = FIRST;
  fill();
  location.hash = encodeURIComponent(people.home);
}

function fill() {
  const words = wordsOf(search.value);
  const found = sentences.filter(one => (!category.value || one.entry.category === category.value)
    && (!possible.checked || one.here) && words.every(word => one.low.includes(word)));
  const people = new Set(found.map(one => one.entry.household));
  count.textContent = `${found.length} of ${sentences.length} sentences, from ${people.size} households in ${data.home}`;
  refill(list, ...found.slice(0, shown).map(one => el('li', {}, el('button', {type: 'button', class: 'sentence', onclick: event => choose(one, event.currentTarget)},
    marked(clipped(one.text), words), el('span', {class: 'faint'}, spaced(one.entry.category), ' · ', plain(clipped(one.entry.household, 120)),
      one.supports.length ? el('span', {class: one.here ? 'good' : 'warm'}, one.here ? ' · possible here' : ' · not possible here') : null)))));
  if (!found.length) list.append(el('li', {class: 'faint'}, 'no sentence with these words'));
  if (found.length > shown) list.append(el('li', {}, el('button', {type: 'button', onclick: () => { shown += 200; fill(); }}, `more (${found.length - shown})`)));
}

function choose(one, button) {
  for (const pressed of list.querySelectorAll('[aria-pressed=true]')) pressed.setAttribute('aria-pressed', 'false');
  button.setAttribute('aria-pressed', 'true');
  for (const thing of drawing.things) thing?.classList.remove('chosen');
  const places = data.labelled ? one.supports.map(k => one.entry.places[k]) : one.entry.places;
  for (const place of places) {
    if (place.here) for (const k of data.things[place.anchor] || []) drawing.things[k]?.classList.add('chosen');
  }
  const said = place => {
    const number = (data.things[place.anchor] || []).length;
    if (!place.here) return `not here: ${spaced(place.why_not)}`;
    return place.brought ? 'yes, by adding it to the home' : `yes, at ${number} ${number === 1 ? 'place' : 'places'} (marked on the plan)`;
  };
  refill(detail, el('blockquote', {}, longText(one.text)),
    el('p', {}, el('b', {}, spaced(one.entry.category)), ', ', longText(one.entry.household)),
    one.entry.refusal ? el('p', {class: 'warm'}, `Never a target in this home: ${one.entry.refusal}.`) : null,
    places.length ? el('ul', {}, places.map(place => el('li', {}, `${RELATIONS[place.relation]} the ${spaced(place.anchor)}`,
      place.context ? el('span', {class: 'faint'}, ' (', plain(place.context), ')') : null, ': ', el('span', {class: place.here ? 'good' : 'warm'}, said(place)))))
      : el('p', {class: 'faint'}, 'It names no place.'),
    data.labelled ? null : el('p', {class: 'faint'}, 'This dataset does not say which sentence supports which place; these are all places of the household.'));
  if (matchMedia('(max-width: 900px)').matches) detail.scrollIntoView({block: 'nearest'});
}

shownIn(line, async () => {
  const names = await ask('homes/names');
  refill(home, ...names.map(name => el('option', {value: name}, name)));
  const asked = decodeURIComponent(location.hash.slice(1));
  if (asked && !names.includes(asked)) other.value = asked;
  home.value = names.includes(asked) ? asked : 'Rs_int';
  await load(asked || home.value);
});
