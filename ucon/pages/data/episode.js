// One episode: map, path, camera, belief, decisions and habits, of one run, or of several side by side in lockstep.
'use strict';

const ACTIONS = ['moves ahead', 'turns right', 'turns left', 'looks up', 'looks down', 'opens', 'says Done'];
let stopPlaying = () => {};

/** What one run did in the episode. */
class Side {
  constructor(index, home, texts, facts, {run, at, row}) {
    Object.assign(this, {index, facts, row, run});
    this.pictures = facts.ends ? this._cut(bytesOf(`pictures-${run}-${at}`), facts.ends) : [];
    this.drawing = this._drawn(home);
    this.image = el('img', {alt: 'What the camera shows', width: 128, height: 128});
    this.said = el('p', {'aria-live': 'off'});
    this.decisions = el('ol', {class: 'decisions', tabindex: '0', 'aria-label': 'Decisions'});
    this.marks = facts.decisions.map(decision => this._decisionLine(decision));
    this.decisions.append(...this.marks);
    this.element = this._laidOut(texts);
  }

  _cut(bytes, ends) {
    return ends.map((end, k) => URL.createObjectURL(new Blob([bytes.subarray(k ? ends[k - 1] : 0, end)], {type: 'image/webp'})));
  }

  _drawn(home) {
    const {placed, target, instances} = this.facts;
    const drawing = new Plan.Drawing(home, `Map of ${home.name} with the path of the search`);
    for (const k of placed.removed) drawing.things[k]?.remove();
    this.objects = placed.objects.map((object, k) => object.box && drawing.box('things', object.box, {class: 'thing'}, words(object.category)));
    this.thingOf = instance => (instance < instances ? drawing.things[instance] : this.objects[instance - instances]);
    this.nameOf = instance => words((instance < instances ? home.things[instance] : placed.objects[instance - instances]).category);
    const box = placed.objects[target].box;
    if (box) drawing.star('marks', [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2], 24, `the target: ${words(this.row.target)}, ${this.facts.place}`);
    const [x, y] = this.facts.poses[0];
    drawing.circle('path', [x, y], 18, {class: 'start'}, 'start');
    this.ahead = drawing.line('path', this.facts.poses.map(pose => pose.slice(0, 2)), {class: 'path ahead'});
    this.path = drawing.line('path', [], {class: 'path'});
    return drawing;
  }

  _laidOut(texts) {
    const {row, facts} = this, run = this.index.runs[this.run];
    const ending = row.found ? el('strong', {class: 'good'}, `found after ${row.steps} steps`) : el('strong', {class: 'bad'}, `not found: ${facts.lost || words(row.cause)}`);
    const legend = el('p', {class: 'legend'}, el('i', {style: 'background: var(--target)'}), 'target', el('i', {style: 'background: var(--opened)'}), 'opened',
      facts.beliefs.length ? [el('i', {style: 'background: var(--heat)'}), 'belief (the darker, the likelier)', el('i', {style: 'border: 2px solid var(--accent)'}), 'goal'] : null);
    const decisions = facts.decisions.length ? this.decisions : el('p', {class: 'faint'}, 'None: this agent chooses single actions.');
    return el('div', {class: 'panel side'}, el('h3', {}, swatch(this.run), plain(run.label)),
      el('p', {}, ending, ` \u00b7 ${row.metres.toFixed(2)} m, shortest ${row.shortest.toFixed(2)} m, SPL ${row.spl.toFixed(2)} \u00b7 `,
        row.seen < 0 ? 'target never seen' : `target first seen at step ${row.seen}`),
      el('p', {}, `It is kept ${facts.place} (${words(facts.room)}). `, this._belief()),
      el('div', {class: 'scene'}, el('div', {}, this.drawing.svg, legend),
        el('div', {}, this.pictures.length ? this.image : null, this.said, el('h3', {}, 'Decisions'), decisions)),
      el('h3', {}, 'Habits'), this._habits(texts));
  }

  /** How much the agent believed in the place that holds the target, in words. */
  _belief() {
    const {believed, beliefs} = this.facts;
    if (!beliefs.length) return '';
    if (!believed) return 'The agent\u2019s belief never included that place.';
    const [first, at, share] = believed;
    return `The agent\u2019s belief included that place from step ${first} on, most at step ${at}: ${(100 * share).toFixed(1)} % of its belief.`;
  }

  _decisionLine(decision) {
    const line = el('li', {}, el('button', {type: 'button', class: 'to', onclick: () => this.onjump(decision.step)}, `step ${decision.step}`),
      ' ', plain(decision.words, 'b'), decision.fallback ? el('span', {class: 'tag warm'}, `no usable answer: ${decision.failure || 'its rule chose'}`) : null,
      decision.text && !decision.asked ? el('span', {class: 'faint'}, ' ', plain(decision.text)) : null);
    const others = decision.options ? decision.options.map(([name, score], k) => el('li', {}, k === decision.chosen ? '\u2192 ' : '', plain(name), score === null ? '' : ` ${score.toFixed(3)}`))
      : (decision.others ?? []).map(([name, why]) => el('li', {}, 'or ', plain(name), ' ', plain(why)));
    if (others.length) line.append(el('details', {}, el('summary', {class: 'faint'}, `${others.length} ${decision.options ? 'options' : 'other views'}`), el('ul', {class: 'others'}, others)));
    if (decision.asked) {
      const said = decision.said ?? [];
      line.append(el('details', {}, el('summary', {class: 'faint'}, `asked a language model${decision.text ? '' : ', which named an option'}`),
        said.map(([system, situation, answer]) => [plain(system, 'pre'), plain(situation, 'pre'), plain(answer, 'pre')].map(block => { block.classList.add('said'); return block; })).flat(),
        said.length ? null : plain(decision.text || 'Its answers are not kept.', 'pre')));
    }
    return line;
  }

  _habits(texts) {
    const {habits, relevance} = this.facts;
    if (!habits) return el('p', {class: 'faint'}, 'This agent does not read habits.');
    if (!habits.given.length) return el('p', {class: 'faint'}, `None are given at level ${this.index.runs[this.run].level}; ${habits.household.length} describe this household.`);
    const about = new Set(habits.about), given = habits.given.map((text, rank) => ({text, rank, weight: relevance[rank]}));
    const read = given.some(one => one.weight > 0);
    const first = read ? [...given].sort((a, b) => b.weight - a.weight) : given;
    const line = one => el('li', {class: about.has(one.text) ? 'about' : '', value: one.rank + 1}, one.weight === undefined ? null : el('span', {class: 'weight', title: 'how much this sentence alone says about the place, 0 to 100 %'}, `${(100 * one.weight).toFixed(0)} %`),
      plain(texts[one.text]));
    const list = (items, make) => {
      const made = el('details', {}, el('summary', {}, items.title));
      made.addEventListener('toggle', () => { if (made.children.length === 1) made.append(el('ol', {class: 'habits'}, items.all.map(make))); });
      return made;
    };
    const known = new Set(habits.given), rest = habits.household.filter(text => !known.has(text));
    return el('div', {}, el('p', {class: 'faint'}, `${given.length} given${read ? '; those that the agent uses most come first, with how much each alone says about the place' : ''}. Marked: those about the ${words(this.row.target)}. The number is the position in the agent\u2019s list.`),
      el('ol', {class: 'habits'}, first.slice(0, 5).map(line)),
      first.length > 5 ? list({title: `${first.length - 5} more that were given`, all: first.slice(5)}, line) : null,
      rest.length ? list({title: `${rest.length} that were not given`, all: rest}, text => el('li', {class: about.has(text) ? 'about' : '', value: 0, style: 'list-style: none'}, plain(texts[text]))) : null);
  }

  /** Show the state after `step` actions; beyond the end, the last one. */
  show(step) {
    const {facts, drawing, row} = this, at = Math.min(step, facts.poses.length - 1), pose = facts.poses[at];
    drawing.agent(pose.slice(0, 2), pose[2]);
    this.path.setAttribute('points', facts.poses.slice(0, at + 1).map(p => drawing.at(p[0], p[1]).join(',')).join(' '));
    const opened = facts.opened.filter(([when]) => when <= at).map(([, what]) => what);
    for (const [, what] of facts.opened) this.thingOf(what)?.classList.toggle('opened', opened.includes(what));
    this._showBelief(at);
    if (this.pictures.length) {
      let frame = at;
      while (frame > 0 && facts.frames[frame] < 0) frame--;
      this.image.src = this.pictures[facts.frames[frame]];
      this.image.style.opacity = frame === at ? 1 : 0.55;
      this.image.alt = frame === at ? `What the camera shows at step ${at}` : `What the camera showed at step ${frame}`;
    }
    this.said.replaceChildren(...this._now(at, row));
    const now = facts.decisions.reduce((last, decision, k) => (decision.step < Math.max(at, 1) ? k : last), 0);
    this.marks.forEach((mark, k) => mark.classList.toggle('now', k === now));
    const mark = this.marks[now];
    if (mark) this.decisions.scrollTop = mark.offsetTop - this.decisions.offsetTop - 40;
  }

  _now(at, row) {
    if (!at) return [`Looks for the ${words(row.target)}, which is kept ${this.facts.place}.`];
    const opened = this.facts.opened.filter(([when]) => when === at).map(([, what]) => this.nameOf(what));
    const effect = this.facts.blocked.includes(at) ? ', and is blocked' : opened.length ? ` the ${opened.join(' and the ')}` : '';
    return [`Step ${at}: ${ACTIONS[this.actions[at - 1]]}${effect}`, at >= row.steps ? (row.found ? ': found.' : ': the search ends.') : '.'];
  }

  _showBelief(at) {
    const {drawing, facts} = this;
    drawing.clear('heat');
    const belief = facts.beliefs.findLast(([when]) => when < Math.max(at, 1));
    if (!belief) return;
    const [, things, goal] = belief, most = Math.max(...things.map(thing => thing[2]), 1e-9);
    for (const [category, box, share] of things) {
      drawing.box('heat', box, {class: 'heat', 'fill-opacity': (0.12 + 0.78 * share / most).toFixed(2), 'stroke-opacity': 0.8},
        `${words(category)}: ${(100 * share).toFixed(1)} % of its belief`);
    }
    if (goal && at < this.row.steps) drawing.circle('heat', goal, 20, {class: 'goal'}, 'its goal');
  }
}

/** Show an episode in `view`. `beside(way)` opens the next (1) or the previous one (-1). */
async function showEpisode(view, index, episode, step, beside) {
  stopPlaying();
  for (const url of view.urls ?? []) URL.revokeObjectURL(url);
  const {common} = episode, home = await unpack(`home-${index.scenes.indexOf(common.scene)}`), texts = await unpack('texts');
  const sides = [];
  for (const played of episode.runs) {
    const facts = await unpack(`episode-${played.run}-${played.at}`);
    const side = new Side(index, home, texts, facts, played);
    side.actions = [...facts.actions].map(Number);
    side.onjump = to => go(to);
    sides.push(side);
  }
  view.urls = sides.flatMap(side => side.pictures);
  const last = Math.max(...sides.map(side => side.row.steps));
  let at = 0, timer = null;
  const slider = el('input', {type: 'range', min: 0, max: last, value: 0, 'aria-label': 'Step', oninput: event => go(+event.target.value)});
  const said = el('output', {style: 'min-width: 6.5em'});
  const play = el('button', {type: 'button', class: 'main', onclick: () => (timer ? stopPlaying() : begin())}, 'Play');
  const speed = select('Speed', [[8, '8 steps a second'], [3, '3 steps a second'], [20, '20 steps a second']], () => { if (timer) begin(); });
  stopPlaying = () => { clearInterval(timer); timer = null; play.textContent = 'Play'; };
  function begin() {
    clearInterval(timer);
    if (at >= last) go(0);
    play.textContent = 'Pause';
    timer = setInterval(() => (at < last ? go(at + 1) : stopPlaying()), 1000 / +speed.value);
  }
  function go(to) {
    at = Math.max(0, Math.min(last, to));
    slider.value = at;
    slider.setAttribute('aria-valuetext', `step ${at} of ${last}`);
    said.textContent = `step ${at} / ${last}`;
    for (const side of sides) side.show(at);
  }
  const button = (text, label, action) => el('button', {type: 'button', 'aria-label': label, title: label, onclick: action}, text);
  const [kind, area] = index.kinds[index.scenes.indexOf(common.scene)];
  view.replaceChildren(
    el('div', {class: 'spread'}, el('h2', {}, 'Find the ', plain(words(common.target)), ' in ', plain(common.scene)), el('span', {class: 'faint'}, `${{scenes: 'a scene', 'own homes': 'a user\u2019s own home'}[kind] ?? `one of the ${kind}`}, ${area.toFixed(0)} m\u00b2 \u00b7 ${common.split ? `${common.split} \u00b7 ` : ''}`, plain(episode.id))),
    el('div', {class: 'controls row'}, button('\u00ab', 'Previous episode ( [ )', () => beside(-1)), button('\u2039', 'One step back (left arrow)', () => go(at - 1)), play,
      button('\u203a', 'One step forward (right arrow)', () => go(at + 1)), button('\u00bb', 'Next episode ( ] )', () => beside(1)), slider, said, speed),
    el('p', {class: 'faint'}, 'Keys: ', el('kbd', {}, '\u2190'), ' ', el('kbd', {}, '\u2192'), ' step, ', el('kbd', {}, 'space'), ' play, ', el('kbd', {}, '['), ' ', el('kbd', {}, ']'), ' other episodes.'),
    el('div', {class: 'sides'}, sides.map(side => side.element)));
  view.onkeydown = event => {
    if (event.target.matches('select, input:not([type=range]), textarea') || event.ctrlKey || event.metaKey || event.altKey) return;
    const typed = event.target.matches('button, summary');
    const action = {ArrowLeft: () => go(at - 1), ArrowRight: () => go(at + 1), Home: () => go(0), End: () => go(last), '[': () => beside(-1), ']': () => beside(1),
      ' ': typed ? null : () => (timer ? stopPlaying() : begin())}[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  };
  go(step);
}
