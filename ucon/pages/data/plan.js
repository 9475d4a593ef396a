// The floor plan of a home as SVG: rooms, openings and furniture, and layers for what happens in it.
// A plan is what ucon.pages.home_plan.plan_of returns; all coordinates are metres in the world frame.
'use strict';

const Plan = (() => {
  const SVG = 'http://www.w3.org/2000/svg';
  const LAYERS = ['rooms', 'things', 'heat', 'names', 'path', 'marks', 'agent'];
  const words = name => name.replaceAll('_', ' ');

  /** An SVG element with attributes and, as its tooltip, a title. */
  function shape(tag, attributes, title) {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (title) made.appendChild(document.createElementNS(SVG, 'title')).textContent = title;
    return made;
  }

  class Drawing {
    /** Draw a plan into a new `svg`, 100 units a metre; turned clockwise by quarter turns. */
    constructor(plan, label, turn = 0) {
      this.plan = plan;
      this.turn = turn;
      const [x0, y0, x1, y1] = this._turnedBox(plan.bounds);
      this.low = [x0, y1];
      const size = [(x1 - x0) * 100 + 20, (y1 - y0) * 100 + 20];
      this.svg = shape('svg', {viewBox: `-10 -10 ${size[0]} ${size[1]}`, class: 'plan', role: 'img', 'aria-label': label});
      this.layers = {};
      for (const name of LAYERS) this.layers[name] = this.svg.appendChild(shape('g', {}));
      this.things = [];
      this._draw();
    }

    /** Units of the picture for a point in metres. */
    at(x, y) {
      const [right, up] = this._turned(x, y);
      return [Math.round((right - this.low[0]) * 100), Math.round((this.low[1] - up) * 100)];
    }

    _turned(x, y) { return [[x, y], [y, -x], [-x, -y], [-y, x]][this.turn]; }

    _turnedBox([x0, y0, x1, y1]) {
      const [a, b] = this._turned(x0, y0), [c, d] = this._turned(x1, y1);
      return [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)];
    }

    /** A rectangle for a box x0, y0, x1, y1 in metres. */
    box(layer, [x0, y0, x1, y1], attributes, title) {
      const [a, b] = this.at(x0, y1), [c, d] = this.at(x1, y0);
      const [u, v, right, bottom] = [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)];
      const size = {x: u, y: v, width: Math.max(2, right - u), height: Math.max(2, bottom - v)};
      return this.layers[layer].appendChild(shape('rect', {...size, ...attributes}, title));
    }

    circle(layer, [x, y], radius, attributes, title) {
      const [cx, cy] = this.at(x, y);
      return this.layers[layer].appendChild(shape('circle', {cx, cy, r: radius, ...attributes}, title));
    }

    line(layer, points, attributes) {
      const path = points.map(([x, y]) => this.at(x, y).join(',')).join(' ');
      return this.layers[layer].appendChild(shape('polyline', {points: path, ...attributes}));
    }

    /** A five-pointed star, for the target. */
    star(layer, [x, y], radius, title) {
      const [cx, cy] = this.at(x, y);
      const tips = [...Array(10).keys()].map(k => {
        const reach = radius * (k % 2 ? 0.45 : 1), turn = Math.PI * k / 5;
        return `${(cx + reach * Math.sin(turn)).toFixed(1)},${(cy - reach * Math.cos(turn)).toFixed(1)}`;
      });
      return this.layers[layer].appendChild(shape('polygon', {points: tips.join(' '), class: 'target'}, title));
    }

    /** Put the agent at a point; heading in quarter turns, counter-clockwise from the x axis. */
    agent([x, y], heading) {
      if (!this._agent) {
        this._agent = this.layers.agent.appendChild(shape('path', {d: 'M24 0 L-15 16 L-7 0 L-15 -16 Z', class: 'agent'}));
      }
      const [u, v] = this.at(x, y);
      this._agent.setAttribute('transform', `translate(${u} ${v}) rotate(${-90 * (heading - this.turn)})`);
    }

    clear(...layers) { for (const layer of layers) this.layers[layer].replaceChildren(); }

    _draw() {
      const {rooms, openings, things} = this.plan;
      for (const room of rooms) this.box('rooms', room.rect, {class: `room${room.outdoor ? ' outdoor' : ''}`});
      for (const [axis, coord, lo, hi] of openings) {
        this.line('rooms', axis ? [[lo, coord], [hi, coord]] : [[coord, lo], [coord, hi]], {class: 'gap'});
      }
      for (const thing of things) {
        this.things.push(thing.box && this.box('things', thing.box, {class: 'thing'}, words(thing.category)));
      }
      for (const room of rooms) {
        const [x0, y0, x1, y1] = room.rect, name = words(room.type);
        const width = this.turn % 2 ? y1 - y0 : x1 - x0;
        if (name.length * 12 > Math.abs(width) * 100) continue;
        const [u, v] = this.at((x0 + x1) / 2, (y0 + y1) / 2);
        this.layers.names.appendChild(shape('text', {x: u, y: v, class: 'name'})).append(name);
      }
    }
  }

  return {Drawing, words};
})();
