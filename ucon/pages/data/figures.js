// Curves as SVG, for the pages Runs and Study.
'use strict';

const Figures = (() => {
  const SVG = 'http://www.w3.org/2000/svg', W = 420, H = 220, LEFT = 52, BOTTOM = 34, TOP = 10, RIGHT = 22;

  function shape(tag, attributes, text) {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }

  /** Round numbers across a range, some four of them. */
  function ticks(low, high) {
    const rough = (high - low) / 4 || 1, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map(k => k * power).find(k => k >= rough) || rough;
    const found = [];
    for (let at = Math.ceil(low / step) * step; at <= high + step * 1e-6; at += step) found.push(Math.abs(at) < step * 1e-6 ? 0 : at);
    return found;
  }

  const short = value => Math.abs(value) >= 1e4 || (value && Math.abs(value) < 1e-3) ? value.toExponential(0) : String(Number(value.toPrecision(3)));

  /** A curve: points are x, y, and perhaps low and high, which become a band. */
  function curve({name, x, points}) {
    const ys = points.flatMap(p => p.slice(1)), xs = points.map(p => p[0]);
    let [low, high] = [Math.min(...ys), Math.max(...ys)];
    if (low === high) { low -= Math.abs(low) * .1 || 1; high += Math.abs(high) * .1 || 1; }
    const [x0, x1] = [Math.min(...xs), Math.max(...xs)];
    const at = (px, py) => [LEFT + (x1 > x0 ? (px - x0) / (x1 - x0) : .5) * (W - LEFT - RIGHT), TOP + (high - py) / (high - low) * (H - TOP - BOTTOM)];
    const line = list => list.map(([px, py]) => at(px, py).map(v => v.toFixed(1)).join(',')).join(' ');
    const last = points.at(-1);
    const svg = shape('svg', {viewBox: `0 0 ${W} ${H}`, class: 'curve', role: 'img', 'aria-label': `${name}: ${short(last[1])} at ${x} ${last[0]}`});
    for (const tick of ticks(low, high)) {
      const [, v] = at(x0, tick);
      svg.append(shape('line', {x1: LEFT, x2: W - RIGHT, y1: v, y2: v, class: 'grid'}), shape('text', {x: LEFT - 6, y: v + 4, class: 'tick right'}, short(tick)));
    }
    for (const tick of ticks(x0, x1)) {
      if (x1 > x0) svg.append(shape('text', {x: at(tick, low)[0], y: H - BOTTOM + 16, class: 'tick middle'}, short(tick)));
    }
    svg.append(shape('text', {x: W - RIGHT, y: H - 4, class: 'tick right'}, x));
    if (last.length === 4) svg.append(shape('polygon', {points: `${line(points.map(p => [p[0], p[3]]))} ${line(points.map(p => [p[0], p[2]]).reverse())}`, class: 'band'}));
    svg.append(shape('polyline', {points: line(points), class: 'curve-line'}));
    const [u, v] = at(last[0], last[1]);
    svg.append(shape('circle', {cx: u, cy: v, r: 3.5, class: 'curve-end'}));
    return el('figure', {}, el('figcaption', {class: 'plain'}, name), svg);
  }

  /** A mean with its interval as a bar on a scale; `null` where it is not defined. */
  function bar(found, low, high) {
    const svg = shape('svg', {viewBox: '0 0 200 16', class: 'bar', role: 'img', 'aria-label': found ? `${found.mean.toFixed(3)}, ${found.low.toFixed(3)} to ${found.high.toFixed(3)}` : 'not defined'});
    const at = value => 4 + Math.max(0, Math.min(1, (value - low) / (high - low))) * 192;
    svg.append(shape('line', {x1: 4, x2: 196, y1: 8, y2: 8, class: 'grid'}));
    if (low < 0) svg.append(shape('line', {x1: at(0), x2: at(0), y1: 1, y2: 15, class: 'grid'}));
    if (found) svg.append(shape('line', {x1: at(found.low), x2: at(found.high), y1: 8, y2: 8, class: 'spread-line'}), shape('circle', {cx: at(found.mean), cy: 8, r: 4.5, class: 'curve-end'}));
    return svg;
  }

  return {curve, bar};
})();
