// What the pages of `python -m ucon serve` share: asking the server, messages, fields, text that is searched.
'use strict';

const main = document.getElementById('main');
document.querySelector('.top').append(themeButton());

/** What the server answers; its one-line error is thrown. */
async function ask(path, words = {}, signal = undefined) {
  return answered(fetch(`api/${path}?${new URLSearchParams(words)}`, {signal}));
}

async function tell(path, value) {
  return answered(fetch(`api/${path}`, {
    method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify(value)}));
}

async function answered(request) {
  let response;
  try { response = await request; } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Error('The server does not answer. Start it again: python -m ucon serve');
  }
  const value = await response.json().catch(() => ({error: response.status === 404
    ? 'The server was restarted: open the address that it printed' : `answer ${response.status}`}));
  if (!response.ok) throw new Error(value.error || `answer ${response.status}`);
  return value;
}

/** A line for errors, read out by screen readers. */
const messageLine = () => el('p', {class: 'message plain', role: 'alert', dir: 'auto'});

/** Do something; an error is shown in a line instead of being lost. */
async function shownIn(line, work) {
  line.textContent = '';
  try { return await work(); } catch (error) {
    if (error.name !== 'AbortError') line.textContent = error.message;
    return undefined;
  }
}

/** Replace the children of an element; null and undefined are left out, lists are flattened. */
const refill = (node, ...children) => node.replaceChildren(...children.flat(2).filter(child => child !== null && child !== undefined));

/** A labelled control. */
const field = (label, control) => el('label', {class: 'field'}, label, control);

const choiceOf = (values, chosen, names = {}) => el('select', {}, values.map(value =>
  el('option', {value, selected: String(value) === String(chosen)}, names[value] ?? String(value))));

/** Whether a key belongs to a field that is being filled in. */
const isTyping = event => event.ctrlKey || event.altKey || event.metaKey
  || /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName) && !/^(button|checkbox|radio)$/.test(event.target.type);

/** Text from outside, with the words that were searched for highlighted; never treated as markup. */
function marked(text, words) {
  const found = el('span', {class: 'plain', dir: 'auto'});
  if (!words.length) { found.append(text); return found; }
  const low = text.toLowerCase();
  if (low.length !== text.length) { found.append(text); return found; }  // letters that change length: nothing is highlighted
  let at = 0;
  while (at < text.length) {
    const next = words.map(word => [low.indexOf(word, at), word.length]).filter(([k]) => k >= 0).sort((a, b) => a[0] - b[0])[0];
    if (!next) break;
    found.append(text.slice(at, next[0]), el('mark', {}, text.slice(next[0], next[0] + next[1])));
    at = next[0] + next[1];
  }
  found.append(text.slice(at));
  return found;
}

const wordsOf = query => query.toLowerCase().split(/\s+/).filter(Boolean);

/** A function that runs a task once it has not been called for some time. */
function later(task, ms = 150) {
  let timer = 0;
  return (...given) => { clearTimeout(timer); timer = setTimeout(() => task(...given), ms); };
}

const interval = (mean, [low, high], factor = 100, digits = 1) =>
  `${(factor * mean).toFixed(digits)} [${(factor * low).toFixed(digits)}, ${(factor * high).toFixed(digits)}]`;

const spaced = name => String(name).replaceAll('_', ' ');

/** Control characters as visible symbols, so that nothing is hidden. */
const visible = text => text.replace(/[\u0000-\u0008\u000b-\u001f]/g, c => String.fromCharCode(0x2400 + c.charCodeAt(0))).replace(/\u007f/g, '\u2421');

/** The beginning of a text that is too long for the page. */
const clipped = (text, most = 600) => visible(text.length > most ? `${text.slice(0, most)}…` : text);

/** A text from outside in full; a very long one is expanded on demand. */
function longText(text) {
  if (text.length <= 2000) return plain(visible(text));
  return el('span', {}, plain(clipped(text)), ' ', el('button', {type: 'button', onclick: event => event.currentTarget.replaceWith(
    el('span', {class: 'plain scroll whole-text', dir: 'auto', tabindex: 0}, visible(text)))}, `show all ${text.length} characters`));
}
