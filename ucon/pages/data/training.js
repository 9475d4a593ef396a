// The report of a training run: curves, card and configuration.
'use strict';

/** Curves in panels; those of validation come first, the loss next. */
function curvesOf(curves) {
  const SHARES = ['val/success_rate', 'val/spl', 'val/accuracy'];
  const rank = name => (SHARES.includes(name) ? SHARES.indexOf(name) - 3 : name.startsWith('val/') ? 0 : name === 'loss' ? 1 : 2);
  const names = Object.keys(curves).filter(name => curves[name].length > 1 && name !== 'val/score').sort((a, b) => rank(a) - rank(b) || a.localeCompare(b));
  const panel = name => el('div', {class: 'panel'}, el('h3', {}, plain(name.replace('val/', '').replaceAll('_', ' ')), name.startsWith('val/') ? el('span', {class: 'faint'}, ' on validation episodes') : null),
    Charts.lines([{points: curves[name], color: name.startsWith('val/') ? 'var(--warm)' : 'var(--accent)'}],
      {x: 'step', y: '', low: SHARES.includes(name) ? 0 : undefined, label: `${name} over training steps`, format: Charts.short}));
  const main = names.filter(name => rank(name) < 2), rest = names.filter(name => rank(name) === 2);
  const more = el('details', {}, el('summary', {}, `${rest.length} more curves`));
  more.addEventListener('toggle', () => { if (more.children.length === 1) more.append(el('div', {class: 'cards'}, rest.map(panel))); });
  return [el('div', {class: 'cards'}, main.map(panel)), rest.length ? more : null];
}

function trainingPage({folder, steps, curves, card, config}) {
  return [el('section', {}, el('h2', {}, plain(folder)), el('p', {class: 'faint'}, `${steps.toLocaleString('en')} training steps.`), curvesOf(curves)),
    card ? el('section', {}, el('h2', {}, 'Model card'), plain(card, 'pre')) : null,
    el('section', {}, el('h2', {}, 'Configuration'), el('details', {}, el('summary', {}, 'config.yaml'), plain(config, 'pre')))].filter(Boolean);
}

async function showTraining(page) {
  const run = await unpack('index');
  page.replaceChildren(el('header', {class: 'spread'}, el('h1', {}, 'UcON: training run'), themeButton()), ...trainingPage(run));
  for (const block of page.querySelectorAll('pre')) block.classList.add('said');
  document.documentElement.dataset.ready = 'true';
}

document.addEventListener('DOMContentLoaded', () => {
  const page = document.getElementById('page');
  showTraining(page).catch(error => {
    page.replaceChildren(el('p', {class: 'bad'}, `This report cannot be shown: ${error.message}`));
    throw error;
  });
});
