// The first page: what there is.
'use strict';

main.append(
  el('h1', {}, 'Finding things where this person keeps them'),
  el('p', {class: 'faint'}, 'These pages are on this machine alone. What you play and answer is written at once.'),
  el('div', {class: 'cards'}, [
    ['runs', 'Runs', 'Evaluations and trainings, also while they run, and their reports.'],
    ['homes', 'Homes', 'Plans of the homes, a walk through them, and what can be kept where.'],
    ['habits', 'Habits', 'Who lives in a home, what they say, and where it can come true.'],
    ['play', 'Play', 'Search yourself, with what an agent is given.'],
    ['study', 'Study', 'Judge habits and places, as people did for the paper.'],
  ].map(([page, title, text]) => el('a', {href: page, class: 'panel'}, el('h2', {}, title), text))),
);
