// The report of runs of lives: tables, the learning curve, and one life with its calendar and its things.
'use strict';

function curveSection({runs}) {
  return el('section', {id: 'curve'}, el('h2', {}, 'Does the robot get better as it lives in the home?'),
    Lives.byDay(runs.map((run, k) => ({label: run.label, color: colorOf(k), curves: run.curves}))),
    el('p', {}, runs.map((run, k) => el('span', {class: 'key'}, swatch(k), plain(run.label), ' '))));
}

function groupsSection({groups, runs}) {
  return el('section', {id: 'groups'}, el('h2', {}, 'By kind of request'),
    el('div', {class: 'panel wide'}, groupsTable('requests', groups, runs)),
    el('p', {class: 'faint'}, 'Intervals resample whole lives (requests, if a kind occurs in one life only). Days count from 1; "seen" means seen by the robot in an earlier request.'));
}

/** A life in one line. */
function lifeName(life, number) {
  const occasions = life.occasions.map(([day, name]) => `${words(name)} on day ${day + 1}`);
  return [`${number + 1}: ${life.scene}`, life.users === 1 ? '1 person' : `${life.users} people`, `day 1 is a ${Lives.WEEKDAYS[life.weekday]}`, words(life.season), ...occasions,
    life.change === null ? 'no change' : `change on day ${life.change + 1}`].join(', ');
}

/** The things of a life with how often each is asked for, those asked for most first. */
function thingsOf(things, rows) {
  const count = new Map(things.map(thing => [thing.name, rows.filter(row => row.target === thing.name).length]));
  return [...things].sort((a, b) => count.get(b.name) - count.get(a.name) || a.name.localeCompare(b.name))
    .map(thing => [thing.name, `${words(thing.name)} (${count.get(thing.name)})`]);
}

/** One life, redrawn for every choice of life, run and thing. */
class LifeView {
  constructor(index) {
    this.index = index;
    this.number = Math.max(0, index.lives.findIndex(life => life.id === decodeURIComponent(location.hash.slice(1))));
    this.run = 0;
    this.thing = null;
    this.body = el('div');
    const chooser = select('Life', index.lives.map((life, k) => [k, lifeName(life, k)]), value => this.open(Number(value)));
    chooser.value = String(this.number);
    this.section = el('section', {id: 'life'}, el('h2', {}, 'One life'), el('div', {class: 'row'}, el('label', {class: 'row'}, 'life ', chooser)), this.body);
  }

  async open(number) {
    this.number = number;
    this.thing = null;
    history.replaceState(null, '', `#${encodeURIComponent(this.index.lives[number].id)}`);
    await this.show();
  }

  async show() {
    const life = this.index.lives[this.number], told = await unpack(`life-${this.number}`);
    const played = told.runs.flatMap((rows, k) => rows ? [k] : []);
    if (!played.includes(this.run)) this.run = played[0];
    const rows = told.runs[this.run], names = thingsOf(told.things, rows);
    const timeline = el('div'), things = select('Thing', names, name => choose(name));
    const calendar = Lives.calendar(life, rows, name => choose(name));
    const choose = name => {
      this.thing = things.value = name;
      Lives.mark(calendar, name);
      timeline.replaceChildren(Lives.timeline(life, told.things.find(thing => thing.name === name), rows));
    };
    this.body.replaceChildren(el('p', {class: 'faint narrow'}, plain(lifeName(life, this.number))), this.runChooser(played) ?? '',
      el('h3', {}, 'Calendar'), el('div', {class: 'panel'}, calendar, Lives.calendarLegend(life)),
      el('div', {class: 'row'}, el('h3', {}, 'One thing over the life'), el('label', {class: 'row'}, 'thing (requests) ', things)),
      el('div', {class: 'panel', id: 'thing'}, timeline));
    choose(this.thing ?? names[0][0]);
  }

  /** The choice of the run whose requests and beliefs are shown, where there are several. */
  runChooser(played) {
    if (played.length < 2) return null;
    const chooser = select('Run', played.map(k => [k, this.index.runs[k].label]), async value => {
      this.run = Number(value);
      await this.show();
      this.body.querySelector('[aria-label=Run]').focus();  // the choice is redrawn, too
    });
    chooser.value = String(this.run);
    return el('p', {}, el('label', {class: 'row'}, 'run ', chooser));
  }
}

async function start() {
  const page = document.getElementById('page'), index = await unpack('index'), view = new LifeView(index);
  const count = (n, one, many) => `${n} ${n === 1 ? one : many}`;
  page.replaceChildren(
    el('header', {class: 'spread'}, el('div', {}, el('h1', {}, 'UcON: a robot that lives in the home'),
      el('p', {class: 'faint'}, `Report of ${count(index.runs.length, 'run', 'runs')} in ${count(index.lives.length, 'life', 'lives')}, made by UcON ${index.version}. `
        + 'In a life, a robot stays in a home for days and is asked for things that the household uses and moves.')), themeButton()),
    runsSection(index, 'requests'), curveSection(index), groupsSection(index), view.section);
  await view.show();
  document.documentElement.dataset.ready = 'true';
}

document.addEventListener('DOMContentLoaded', () => start().catch(error => {
  document.getElementById('page').replaceChildren(el('p', {class: 'bad'}, `This report cannot be shown: ${error.message}`));
  throw error;
}));
