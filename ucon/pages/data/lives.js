// Lives: the calendar of requests, the timeline of one thing, and figures by day. Reports and the served page share it.
'use strict';

const Lives = (() => {
  const SLOTS = ['morning', 'midday', 'evening'];
  const WEEKDAYS = ['Monday', 'Tuesday', 'Wednesday', 'Thursday', 'Friday', 'Saturday', 'Sunday'];
  const ROW = 26, TOP = 34;
  const named = text => String(text).replaceAll('_', ' ');
  const timeOf = row => SLOTS.length * row.day + row.slot;
  const weekdayOf = (life, day) => life.weekday === undefined ? '' : WEEKDAYS[(life.weekday + day) % 7];
  const dayName = (life, day) => `day ${day + 1}${weekdayOf(life, day) && `, ${weekdayOf(life, day)}`}`;
  const occasionOf = (life, day) => (life.occasions ?? []).find(([on]) => on === day)?.[1];

  /** What a robot knew about the thing when it was asked for it. */
  function known({seen, moved}) {
    if (seen === null) return 'the robot had never seen it';
    const ago = seen < .5 ? 'the same day' : seen < 1.5 ? 'the day before' : `${Math.round(seen)} days before`;
    return `the robot had last seen it ${ago}, ${moved ? 'and it had been moved since' : 'and it was still there'}`;
  }
  const ending = row => row.found ? `found in ${row.steps} steps, SPL ${row.spl.toFixed(2)}` : `not found (${named(row.cause)}, ${row.steps} steps)`;
  const asker = row => row.user === undefined ? '' : ` for person ${row.user + 1}`;
  const said = (life, row) => `${dayName(life, row.day)}, ${SLOTS[row.slot]}: ${named(row.target)}${asker(row)}, ${ending(row)}; ${known(row)}${row.changed ? '; the habits for it have changed' : ''}`;

  /** One request in the calendar: darker with its SPL; red, with a cross, where the thing was not found. */
  const request = (life, row) => el('button', {type: 'button', class: row.found ? 'ask' : 'ask lost', tabindex: -1, title: said(life, row), 'aria-label': said(life, row),
    'data-thing': row.target, style: row.found ? `--spl: ${Math.round(15 + 85 * row.spl)}%` : null}, row.found ? '' : '\u00d7');

  function dayHead(life, day) {
    const changes = day === life.change, occasion = occasionOf(life, day);
    const why = [changes ? 'habits change' : '', occasion ? named(occasion) : ''].filter(Boolean).join(', ');
    return el('th', {scope: 'col', class: changes ? 'changed' : '', title: why || null},
      el('span', {class: 'marks'}, changes ? '\u25b2' : '', occasion ? '\u2605' : '', why ? el('span', {class: 'hidden-label'}, ` ${why} `) : null),
      weekdayOf(life, day) ? el('abbr', {title: weekdayOf(life, day)}, weekdayOf(life, day).slice(0, 2)) : null, el('b', {}, String(day + 1)));
  }

  /** Arrows, Home and End go from request to request, so that the whole calendar is one stop of the Tab key. */
  function walkedByKeys(table) {
    const asks = [...table.querySelectorAll('.ask')].sort((a, b) => a.dataset.order - b.dataset.order);
    if (!asks.length) return;
    asks[0].tabIndex = 0;
    table.addEventListener('focusin', event => { for (const ask of asks) ask.tabIndex = ask === event.target ? 0 : -1; });
    table.addEventListener('keydown', event => {
      const at = asks.indexOf(event.target);
      const to = {ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: asks.length - 1}[event.key];
      if (at < 0 || to === undefined || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      asks[Math.max(0, Math.min(asks.length - 1, to))].focus();
    });
  }

  /**
   * The calendar of a life: days across, slots down, requests as cells. `life`: days, and where they are known weekday
   * (of day 0), change (day) and occasions. `onchoose(target)` is called when a request is chosen.
   */
  function calendar(life, rows, onchoose = null) {
    const line = el('p', {class: 'faint ask-line'}, 'Point at a request, or move between requests with the arrow keys.');
    const cell = (day, slot) => el('td', {class: day === life.change ? 'changed' : ''}, el('div', {class: 'asks'},
      rows.filter(row => row.day === day && row.slot === slot).map(row => {
        const made = request(life, row), show = () => { line.textContent = said(life, row); };
        made.dataset.order = row.request;
        for (const name of ['focus', 'mouseenter']) made.addEventListener(name, show);
        if (onchoose) made.addEventListener('click', () => onchoose(row.target));
        return made;
      })));
    const days = Array.from({length: life.days}, (_, day) => day);
    const table = el('table', {class: 'calendar', style: `min-width: ${84 + 38 * life.days}px`, 'aria-label': 'Calendar of requests'}, el('thead', {}, el('tr', {}, el('td', {class: 'slots'}), days.map(day => dayHead(life, day)))),
      el('tbody', {}, SLOTS.map((name, slot) => el('tr', {}, el('th', {scope: 'row'}, name), days.map(day => cell(day, slot))))));
    walkedByKeys(table);
    return el('div', {}, el('div', {class: 'wide'}, table), line);
  }

  /** Mark the requests of a calendar that are for a thing. */
  function mark(node, target) {
    for (const ask of node.querySelectorAll('.ask')) ask.classList.toggle('chosen', ask.dataset.thing === target);
  }

  function calendarLegend(life) {
    const key = (cls, text, mark = '', style = null) => el('span', {}, el('i', {class: `ask ${cls}`, style, 'aria-hidden': 'true'}, mark), text);
    const sign = text => el('span', {class: 'warm'}, `${text} `);
    return el('p', {class: 'keys'}, key('', 'found after a detour', '', '--spl: 25%'), key('', 'found on the shortest path (SPL 1)', '', '--spl: 100%'), key('lost', 'not found', '\u00d7'),
      life.change === null || life.change === undefined ? null : el('span', {}, sign('\u25b2'), 'the habits for some things change that morning'),
      life.occasions?.length ? el('span', {}, sign('\u2605'), 'a day with an occasion') : null);
  }

  /** SVG elements; text is set as text. */
  function node(tag, attributes, title) {
    const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (title) { const told = document.createElementNS(made.namespaceURI, 'title'); told.textContent = title; made.append(told); }
    return made;
  }

  const placeAt = (thing, time) => thing.at.filter(([from]) => from <= time).at(-1)[1];
  const heldWords = (thing, [place, p, words]) => `${(100 * p).toFixed(0)} % ${words || (place < 0 ? 'at a place without a name' : thing.places[place])}`;

  function requestWords(life, thing, row) {
    const held = row.believed ?? [];
    return `${dayName(life, row.day)}, ${SLOTS[row.slot]}: ${ending(row)}. It was ${thing.places[placeAt(thing, timeOf(row))]}; `
      + (row.believed ? held.length ? `the robot believed: ${held.map(one => heldWords(thing, one)).join('; ')}.` : 'the robot remembered no place for it.' : `${known(row)}.`);
  }

  /** Days and their slots as a grid, with the names of the days above. */
  function timeGrid(life, svg, step, height) {
    for (let time = 0; time <= SLOTS.length * life.days; time++) {
      const day = time / SLOTS.length, whole = time % SLOTS.length === 0;
      svg.append(node('line', {x1: time * step, x2: time * step, y1: whole ? TOP - 16 : TOP, y2: height, class: whole ? 'day' : 'slot'}));
      if (!whole || day === life.days) continue;
      const name = node('text', {x: time * step + 4, y: TOP - 6}, dayName(life, day));
      name.append(`${step < 18 ? '' : `${weekdayOf(life, day).slice(0, 2)} `}${day + 1}`);
      svg.append(name);
    }
  }

  function truthLine(life, thing, svg, step, y) {
    const end = SLOTS.length * life.days;
    const points = thing.at.flatMap(([time, place], k) => [[time, place], [thing.at[k + 1]?.[0] ?? end, place]]);
    svg.append(node('polyline', {points: points.map(([time, place]) => `${time * step},${y(place)}`).join(' '), class: 'truth'}, 'where it actually was'));
  }

  function requestMark(life, thing, row, svg, {x, y, step, elsewhere, onread}) {
    const text = requestWords(life, thing, row);
    const made = node('g', {class: 'request', tabindex: 0, role: 'img', 'aria-label': text}, text);
    made.append(node('rect', {x: x - step / 2, y: TOP, width: step, height: y(elsewhere) - TOP + ROW / 2, class: 'hit'}));
    if (row.found) made.append(node('circle', {cx: x, cy: y(-1), r: 6, class: 'found'}));
    else made.append(node('path', {d: `M${x - 5} ${y(-1) - 5}l10 10m0 -10l-10 10`, class: 'lost'}));
    for (const one of [...row.believed ?? []].reverse())
      made.append(node('circle', {cx: x, cy: y(one[0] < 0 ? elsewhere : one[0]), r: 6.5, class: 'held', 'fill-opacity': one[1]}, heldWords(thing, one)));
    for (const name of ['focus', 'mouseenter']) made.addEventListener(name, () => onread(text));
    svg.append(made);
  }

  /** Where one thing was over a life, every request for it, and where the robot believed it to be. */
  function timeline(life, thing, rows) {
    const mine = rows.filter(row => row.target === thing.name), believes = mine.some(row => row.believed?.length);
    const count = thing.places.length, step = life.days > 20 ? 12 : 22, elsewhere = count;
    const height = TOP + ROW * (count + 1 + believes), y = row => TOP + ROW * (row + 1.5);
    const svg = node('svg', {width: SLOTS.length * life.days * step + 2, height, class: 'timeline', role: 'group', 'aria-label': `Where the ${named(thing.name)} was, and requests for it`});
    timeGrid(life, svg, step, height);
    if (thing.change) svg.append(node('line', {x1: SLOTS.length * life.change * step, x2: SLOTS.length * life.change * step, y1: TOP - 16, y2: height, class: 'change'}, 'the habits for it change'));
    truthLine(life, thing, svg, step, y);
    const line = el('p', {class: 'ask-line'}, mine.length ? 'Point at a mark, or move between marks with the Tab key.' : 'The robot was never asked for it.');
    for (const row of mine) requestMark(life, thing, row, svg, {x: (timeOf(row) + .5) * step, y, step, elsewhere: believes ? elsewhere : count - 1, onread: text => { line.textContent = text; }});
    const labels = ['asked for', ...thing.places.map((text, k) => thing.mistakes.includes(k) ? `${text} (by mistake)` : text), ...(believes ? ['elsewhere'] : [])];
    const names = el('div', {class: 'places', style: `padding-top: ${TOP}px`}, labels.map((text, k) => el('div', {class: k && k <= count ? '' : 'faint', title: text}, plain(text))));
    return el('div', {}, el('div', {class: 'thing-line', tabindex: 0, role: 'region', 'aria-label': 'Timeline, scrolls sideways'}, names, svg), line, timelineLegend(thing, believes, rows.some(row => row.believed)));
  }

  function timelineLegend(thing, believes, remembers) {
    return el('ul', {class: 'keys'}, el('li', {}, el('i', {class: 'key-truth'}), 'where the thing actually was (the robot is not told)'),
      el('li', {}, el('i', {class: 'key-found'}), 'asked for and found; ', el('b', {class: 'bad'}, '\u00d7'), ' not found'),
      believes ? el('li', {}, el('i', {class: 'key-held'}), 'where the robot believed it to be before it set out: the more solid the dot, the more certain. A dot on the line is right; "elsewhere" is more than 0.6 m from every place of the thing')
        : el('li', {}, remembers ? 'the robot never remembered a place for it when asked for it' : 'no beliefs: this robot remembers no places, or the run predates the recording of beliefs'),
      thing.change ? el('li', {}, el('i', {class: 'key-change'}), 'from here on, the household has other habits for it') : null);
  }

  /** Figures by day, averaged over lives; `runs`: {label, color, curves: {sr, spl}}. A band is drawn for a single run. */
  function byDay(runs) {
    if (runs.every(run => run.curves.spl.length < 2)) return el('p', {class: 'faint'}, 'The curve by day appears once there are two days.');
    const chart = (name, title, format) => {
      const series = runs.filter(run => run.curves[name].length > 1).map(({label, color, curves}) => ({label, color, points: curves[name].map(([day, mean]) => [day, mean]),
        band: runs.length === 1 ? curves[name].map(([day, , low, high]) => [day, low, high]).filter(([, low]) => low !== null) : null}));
      return el('figure', {class: 'panel'}, el('figcaption', {}, `${title} by day of the life, averaged over lives${series[0].band?.length ? ', with the 95 % interval over lives' : ''}`),
        Charts.lines(series, {x: 'day', y: title, low: 0, high: 1, format, label: `${title} by day: ${series.map(({label, points}) => `${label}, ${format(points[0][1])} on the first day and ${format(points.at(-1)[1])} on the last`).join('; ')}`}));
    };
    return el('div', {class: 'cards'}, chart('spl', 'SPL', value => Charts.short(value)), chart('sr', 'SR %', value => (100 * value).toFixed(0)));
  }

  return {SLOTS, WEEKDAYS, named, calendar, calendarLegend, mark, timeline, byDay};
})();
