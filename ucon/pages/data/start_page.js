// The first page: an overview of what there is.
'use strict';

main.append(
  el('h1', {}, 'Finding things where this person keeps them'),
  el('p', {class: 'faint'}, 'These pages are served on this machine only. Every action and answer is saved at once.'),
  el('div', {class: 'cards'}, [
    ['runs', 'Runs', 'Evaluations and training runs, finished or in progress, and their reports.'],
    ['homes', 'Homes', 'Floor plans, a walk through each home, and what can be kept where.'],
    ['habits', 'Habits', 'Who lives in a home, what they say, and where each habit is possible.'],
    ['play', 'Play', 'Search for things yourself, with the same information as an agent.'],
    ['study', 'Study', 'Judge habits and places, as people did for the paper.'],
  ].map(([page, title, text]) => el('a', {href: page, class: 'panel'}, el('h2', {}, title), text))),
);
