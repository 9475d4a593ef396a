// Runs: the lives of an evaluation, also while they are played: figures by day so far, and the calendar of each life.
'use strict';

class LiveLives {
  constructor() {
    this.node = el('div', {id: 'lives'});
    this.curves = el('div', {class: 'curves'});
    this.chooser = el('select', {'aria-label': 'Life', onchange: () => this.draw()});
    this.calendar = el('div');
    this.run = null;
  }

  /** Show what a run has so far; nothing where it plays no lives. The chosen life stays chosen. */
  show(run) {
    if (!run.lives) { this.run = null; this.node.replaceChildren(); return; }
    const names = Object.keys(run.lives), another = this.run?.id !== run.id, chosen = another ? names.at(-1) : this.chooser.value;
    this.run = run;
    if (another || this.chooser.options.length !== names.length) this.chooser.replaceChildren(...names.map(name => el('option', {value: name, selected: name === chosen}, name)));
    refill(this.curves, Lives.byDay([{label: run.label, color: 'var(--accent)', curves: run.by_day}]));
    if (!this.node.children.length) this.node.append(el('h3', {}, 'Calendar of a life'), field('life', this.chooser), this.calendar, this.curves);
    this.draw();
  }

  /** The calendar of the chosen life; the keyboard focus stays on the same request. */
  draw() {
    const rows = this.run.lives[this.chooser.value], life = {days: Math.max(...rows.map(row => row.day)) + 1};
    const at = this.calendar.contains(document.activeElement) ? document.activeElement.dataset.order : undefined;
    this.calendar.replaceChildren(Lives.calendar(life, rows), Lives.calendarLegend(life));
    if (at !== undefined) this.calendar.querySelector(`[data-order="${at}"]`)?.focus({preventScroll: true});
  }
}
