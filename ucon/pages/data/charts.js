// Charts as SVG: lines with bands, and means on a scale.
'use strict';

const Charts = (() => {
  const SVG = 'http://www.w3.org/2000/svg';
  const WIDTH = 560, HEIGHT = 260, LEFT = 46, BOTTOM = 34, TOP = 12, RIGHT = 12;

  function node(tag, attributes, text) {
    const made = document.createElementNS(SVG, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }

  /** Round steps that divide a range into about four parts. */
  function ticks(low, high) {
    const raw = (high - low) / 4 || 1, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 2.5, 5, 10].map(k => k * power).find(s => s >= raw);
    const found = [];
    for (let at = Math.ceil(low / step) * step; at <= high + step / 1e6; at += step) found.push(+at.toPrecision(12));
    return found;
  }

  /**
   * A chart of lines. `lines`: {points: [[x, y], ...], color, label, band: [[x, low, high], ...] or nothing}.
   * `options`: x and y (titles), low and high (of y), label (for screen readers), format (of y).
   */
  function lines(series, {x, y, low, high, label, format = String}) {
    const all = series.flatMap(s => s.points), xs = all.map(p => p[0]), ys = all.map(p => p[1]).filter(Number.isFinite);
    const x0 = Math.min(...xs), x1 = Math.max(...xs, x0 + 1e-9);
    const y0 = low ?? Math.min(...ys), top = high ?? Math.max(...ys), y1 = top > y0 ? top : y0 + (Math.abs(y0) || 1);
    const px = v => LEFT + (v - x0) / (x1 - x0) * (WIDTH - LEFT - RIGHT);
    const py = v => HEIGHT - BOTTOM - (v - y0) / (y1 - y0) * (HEIGHT - BOTTOM - TOP);
    const svg = node('svg', {viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: 'chart', role: 'img', 'aria-label': label});
    for (const at of ticks(y0, y1)) {
      svg.append(node('line', {x1: LEFT, x2: WIDTH - RIGHT, y1: py(at), y2: py(at), class: 'grid'}),
        node('text', {x: LEFT - 6, y: py(at) + 4, 'text-anchor': 'end'}, format(at)));
    }
    for (const at of ticks(x0, x1)) {
      svg.append(node('text', {x: px(at), y: HEIGHT - BOTTOM + 16, 'text-anchor': 'middle'}, at.toLocaleString('en')));
    }
    svg.append(node('text', {x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 3, 'text-anchor': 'middle'}, x),
      node('text', {x: 0, y: 0, 'text-anchor': 'middle', transform: `translate(11 ${(HEIGHT - BOTTOM + TOP) / 2}) rotate(-90)`}, y));
    const path = points => points.filter(p => Number.isFinite(p[1])).map(p => `${px(p[0]).toFixed(1)},${py(p[1]).toFixed(1)}`).join(' ');
    for (const {points, color, band} of series) {
      if (band) {
        const around = [...band.map(p => [p[0], p[2]]), ...band.map(p => [p[0], p[1]]).reverse()];
        svg.append(node('polygon', {points: path(around), class: 'band', fill: color}));
      }
      svg.append(node('polyline', {points: path(points), class: 'line', stroke: color}));
    }
    return svg;
  }

  const short = value => (Math.abs(value) >= 1e4 || (value && Math.abs(value) < 1e-3) ? value.toExponential(0) : String(Number(value.toPrecision(3))));

  /** A curve under its name: points are x, y, and optionally low and high, which become a band. */
  function curve({name, x, points}) {
    const last = points.at(-1), band = last.length === 4 ? points.map(p => [p[0], p[2], p[3]]) : null;
    const drawn = lines([{points: points.map(p => p.slice(0, 2)), color: 'var(--accent)', band}],
      {x, y: '', label: `${name}: ${short(last[1])} at ${x} ${last[0]}`, format: short, ...(band ? {low: Math.min(...band.map(p => p[1])), high: Math.max(...band.map(p => p[2]))} : {})});
    return el('figure', {}, el('figcaption', {class: 'plain'}, name), drawn);
  }

  /** A mean with its interval as a bar on a scale; an empty scale where it is not defined. */
  function bar(found, low, high) {
    const label = found ? `${found.mean.toFixed(3)}, ${found.low.toFixed(3)} to ${found.high.toFixed(3)}` : 'not defined';
    const svg = node('svg', {viewBox: '0 0 200 16', class: 'bar', role: 'img', 'aria-label': label});
    const at = value => 4 + Math.max(0, Math.min(1, (value - low) / (high - low))) * 192;
    svg.append(node('line', {x1: 4, x2: 196, y1: 8, y2: 8, class: 'grid'}));
    if (low < 0) svg.append(node('line', {x1: at(0), x2: at(0), y1: 1, y2: 15, class: 'grid'}));
    if (found) svg.append(node('line', {x1: at(found.low), x2: at(found.high), y1: 8, y2: 8, class: 'spread-line'}), node('circle', {cx: at(found.mean), cy: 8, r: 4.5, class: 'curve-end'}));
    return svg;
  }

  return {lines, curve, bar, short};
})();
