// Homes: the plan, a walk in first person, and cards of the things.
'use strict';

const SPEED_M_S = 1.7, TURN_S = 1.25, PITCH_S = 60, WIDTH = 560, HEIGHT = 400, EYE_M = 1.4;
const RELATIONS = {ontop: 'on top', inside: 'inside', under: 'under', nextto: 'next to it'};
const line = messageLine(), body = el('div', {});
main.append(el('h1', {}, 'Homes'), line, body);

const home = el('select', {id: 'home'}), other = el('input', {id: 'other-home', placeholder: 'Rs_int~3, procedural:house:17', maxlength: 100});
const form = el('form', {class: 'fields'}, field('Home', home), field('Or by name', other), el('button', {type: 'submit'}, 'Show'));
const facts = el('p', {class: 'faint', role: 'status', id: 'facts'});
const canvas = el('canvas', {width: WIDTH, height: HEIGHT, class: 'walk', tabindex: 0, id: 'walk', role: 'img',
  'aria-label': 'The view in first person; arrow keys walk and turn, Page Up and Page Down look up and down, Enter names the thing ahead'});
const speed = el('span', {class: 'faint figure', id: 'speed'});
const pad = el('div', {class: 'walk-pad'}), planBox = el('div', {}), card = el('div', {class: 'panel card', id: 'card', 'aria-live': 'polite'});
const filter = el('input', {type: 'search', placeholder: 'search', 'aria-label': 'Search the things', id: 'thing-search'});
const list = el('ul', {class: 'list things-list scroll', 'aria-label': 'Things'});
body.append(form, facts, el('div', {class: 'home'},
  el('section', {'aria-label': 'Walk'}, canvas, el('div', {class: 'spread'},
    el('span', {class: 'faint'}, el('kbd', {}, '↑'), el('kbd', {}, '↓'), ' walk ', el('kbd', {}, '←'), el('kbd', {}, '→'), ' turn ',
      el('kbd', {}, 'Page ↑'), el('kbd', {}, 'Page ↓'), ' look; click a thing'), speed), pad, card),
  el('section', {'aria-label': 'Plan and things'}, planBox, el('div', {class: 'spread'}, el('h2', {}, 'Things'), filter), list)));

const KEYS = {ArrowUp: [1, 0, 0], ArrowDown: [-1, 0, 0], ArrowLeft: [0, 1, 0], ArrowRight: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1]};
const NAMES = {ArrowUp: 'Ahead', ArrowDown: 'Back', ArrowLeft: 'Left', ArrowRight: 'Right', PageUp: 'Up', PageDown: 'Down'};
const held = new Set(), context = canvas.getContext('2d');
let plan = null, drawing = null, pose = null, opened = new Set(), chosen = -1, dirty = false, asking = false, times = [], before = 0;

for (const key of ['ArrowLeft', 'ArrowUp', 'ArrowDown', 'ArrowRight', 'PageUp', 'PageDown']) {
  const button = el('button', {type: 'button'}, NAMES[key]);
  button.addEventListener('pointerdown', event => { button.setPointerCapture(event.pointerId); held.add(key); });
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) button.addEventListener(end, () => held.delete(key));
  button.addEventListener('click', event => { if (!event.detail) step(KEYS[key], .15); });  // pressed with the keyboard
  pad.append(button);
}
canvas.addEventListener('keydown', event => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key in KEYS) { held.add(event.key); event.preventDefault(); }
  if (event.key === 'Enter') { event.preventDefault(); pick(.5, .5); }
});
canvas.addEventListener('keyup', event => held.delete(event.key));
canvas.addEventListener('blur', () => held.clear());
canvas.addEventListener('click', event => {
  const box = canvas.getBoundingClientRect();
  pick((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
});
form.addEventListener('submit', event => { event.preventDefault(); shownIn(line, () => load(other.value.trim() || home.value)); });
home.addEventListener('change', () => { other.value = ''; shownIn(line, () => load(home.value)); });
filter.addEventListener('input', () => listThings());

/** Show a home, and stand where there is most space. */
async function load(name) {
  const found = await ask('homes/plan', {home: name});
  plan = found;
  opened = new Set();
  chosen = -1;
  drawing = new Plan.Drawing(plan, `Plan of ${plan.name}`);
  drawing.things.forEach((shape, k) => shape?.addEventListener('click', () => choose(k)));
  refill(planBox, drawing.svg);
  facts.textContent = `${plan.name}: ${spaced(plan.kind)}, ${plan.rooms.length} rooms, ${plan.area_m2} m², ${plan.things.length} things`;
  refill(card, el('p', {class: 'faint'}, 'Click a thing in the picture or on the plan, or choose one from the list, to see its card.'));
  pose = {...standing(), yaw: 0, pitch: 0};
  dirty = true;
  listThings();
  location.hash = encodeURIComponent(plan.name);
}

/** Roughly the free node furthest from any obstacle: the one with most free nodes around it. */
function standing() {
  let best = [-1, 0, 0];
  plan.free.forEach((row, i) => [...row].forEach((cell, j) => {
    if (cell !== '1') return;
    let room = 0;
    for (let a = -4; a <= 4; a++) for (let b = -4; b <= 4; b++) room += plan.free[i + a]?.[j + b] === '1';
    if (room > best[0]) best = [room, i, j];
  }));
  return {x: plan.origin[0] + (best[1] + .5) * .25, y: plan.origin[1] + (best[2] + .5) * .25};
}

const isFree = (x, y) => plan.free[Math.floor((x - plan.origin[0]) / .25)]?.[Math.floor((y - plan.origin[1]) / .25)] === '1';

/** Move for some seconds: ahead, turn, look, each -1 to 1. Walls block the way, but one slides along them. */
function step([ahead, turn, look], seconds) {
  pose.yaw = (pose.yaw + turn * TURN_S * seconds + 4) % 4;
  pose.pitch = Math.max(-60, Math.min(60, pose.pitch + look * PITCH_S * seconds));
  const way = ahead * SPEED_M_S * seconds, angle = pose.yaw * Math.PI / 2;
  const [dx, dy] = [way * Math.cos(angle), way * Math.sin(angle)];
  if (isFree(pose.x + dx, pose.y + dy)) { pose.x += dx; pose.y += dy; }
  else if (isFree(pose.x + dx, pose.y)) pose.x += dx;
  else if (isFree(pose.x, pose.y + dy)) pose.y += dy;
  dirty = true;
}

const words = () => ({home: plan.name, x: pose.x.toFixed(3), y: pose.y.toFixed(3), yaw: pose.yaw.toFixed(4), pitch: pose.pitch.toFixed(1), open: [...opened].join(',')});

function tick(now) {
  const seconds = Math.min(.1, (now - before) / 1000);
  before = now;
  if (pose && held.size) {
    const sum = [...held].reduce((all, key) => all.map((v, k) => v + KEYS[key][k]), [0, 0, 0]);
    step(sum, seconds);
  }
  if (pose && dirty && !asking) draw();
  requestAnimationFrame(tick);
}

async function draw() {
  asking = true;
  dirty = false;
  await shownIn(line, async () => {
    const response = await fetch(`api/homes/frame?${new URLSearchParams(words())}`).catch(() => { throw new Error('The server does not answer. Start it again: python -m ucon serve'); });
    if (!response.ok) throw new Error((await response.json()).error);
    context.drawImage(await createImageBitmap(await response.blob()), 0, 0);
  });
  drawing.agent([pose.x, pose.y], pose.yaw);
  const now = performance.now();
  times = [...times.filter(time => now - time < 1000), now];
  canvas.dataset.frames = Number(canvas.dataset.frames || 0) + 1;
  speed.textContent = held.size ? `${times.length} frames a second` : '';
  asking = false;
}

async function pick(u, v) {
  if (!plan) return;
  await shownIn(line, async () => {
    const {thing} = await ask('homes/pick', {...words(), u: u.toFixed(4), v: v.toFixed(4)});
    if (thing !== null) await choose(thing);
  });
}

async function choose(k) {
  await shownIn(line, async () => {
    const found = await ask('homes/card', {home: plan.name, thing: k});
    drawing.things[chosen]?.classList.remove('chosen');
    chosen = k;
    drawing.things[k]?.classList.add('chosen');
    for (const button of list.querySelectorAll('button')) button.setAttribute('aria-pressed', button.dataset.thing === String(k));
    showCard(found);
  });
}

function showCard(found) {
  const [w, d, h] = found.size_m;
  const open = el('button', {type: 'button', onclick: () => {
    if (!opened.delete(found.thing)) opened.add(found.thing);
    drawing.things[found.thing]?.classList.toggle('opened', opened.has(found.thing));
    dirty = true;
    showCard(found);
  }}, opened.has(found.thing) ? 'Close it' : 'Open it');
  const kept = Object.entries(found.kept);
  refill(card, el('h2', {}, spaced(found.category)),
    el('dl', {class: 'facts'}, ...[['room', spaced(found.room)], ['size', `${w} × ${d} × ${h} m, ${found.bottom_m} m above the floor`],
      ['opens', found.openable ? 'yes' : 'no']].flatMap(([name, value]) => [el('dt', {}, name), el('dd', {}, value)])),
    el('div', {class: 'row'}, el('button', {type: 'button', onclick: () => goTo(found.thing)}, 'Go there'), found.openable ? open : null),
    el('h3', {}, 'What households keep there'),
    ...(kept.length ? kept.map(([relation, names]) => el('p', {}, el('b', {}, `${RELATIONS[relation]}: `), keptNames(names)))
      : [el('p', {class: 'faint'}, 'No habit names this kind of thing as a place.')]));
}

function keptNames(names) {
  const shown = names.slice(0, 24).map(spaced).join(', ');
  return el('span', {}, plain(shown), names.length > 24 ? el('details', {}, el('summary', {}, `and ${names.length - 24} more`), plain(names.slice(24).map(spaced).join(', '))) : null);
}

/** Stand about a metre from a thing, in its room where that is possible, and look at it. */
function goTo(k) {
  const [cx, cy, cz] = plan.middles[k], [x0, y0, x1, y1] = plan.rooms[plan.room_of[k]].rect;
  let best = [Infinity, pose.x, pose.y];
  plan.free.forEach((row, i) => [...row].forEach((cell, j) => {
    const x = plan.origin[0] + (i + .5) * .25, y = plan.origin[1] + (j + .5) * .25;
    const within = x > x0 && x < x1 && y > y0 && y < y1;
    const cost = Math.abs(Math.hypot(x - cx, y - cy) - 1.2) + (within ? 0 : 20);
    if (cell === '1' && cost < best[0]) best = [cost, x, y];
  }));
  const [dx, dy] = [cx - best[1], cy - best[2]];
  const pitch = Math.atan2(cz - EYE_M, Math.max(.3, Math.hypot(dx, dy))) * 180 / Math.PI;
  pose = {x: best[1], y: best[2], yaw: (Math.atan2(dy, dx) / (Math.PI / 2) + 4) % 4, pitch: Math.max(-60, Math.min(60, pitch))};
  dirty = true;
  canvas.focus();
}

function listThings() {
  const wanted = wordsOf(filter.value);
  const rows = plan.things.map((thing, k) => [spaced(thing.category), spaced(plan.rooms[plan.room_of[k]].name), k])
    .filter(([name, room]) => wanted.every(word => `${name} ${room}`.toLowerCase().includes(word)))
    .sort((a, b) => a[1].localeCompare(b[1]) || a[0].localeCompare(b[0]));
  refill(list, ...rows.map(([name, room, k]) => el('li', {}, el('button', {type: 'button', 'data-thing': k, 'aria-pressed': k === chosen,
    onclick: () => choose(k)}, el('span', {}, name), el('span', {class: 'faint'}, room)))));
  if (!rows.length) list.append(el('li', {class: 'faint'}, 'nothing with these words'));
}

shownIn(line, async () => {
  const names = await ask('homes/names');
  refill(home, ...names.map(name => el('option', {value: name}, name)));
  const asked = decodeURIComponent(location.hash.slice(1));
  if (asked && !names.includes(asked)) other.value = asked;
  home.value = names.includes(asked) ? asked : 'Rs_int';
  await load(asked || home.value);
  canvas.focus({preventScroll: true});
});
requestAnimationFrame(tick);
