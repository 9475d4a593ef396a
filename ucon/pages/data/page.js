// Small helpers that all pages share: elements, the button for light and dark, messages.
'use strict';

/** An element: `el('p', {class: 'faint'}, 'text', otherElement)`. Strings become text, never markup. */
function el(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else if (name === 'style') made.style.cssText = value ?? '';  // as an attribute it is blocked on served pages
    else if (value === true) made.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children.flat().filter(child => child !== null && child !== undefined));
  return made;
}

/** Text from outside (habits, names, answers): shown as it is, with its own direction of writing. */
const plain = (text, tag = 'span') => el(tag, {class: 'plain', dir: 'auto'}, String(text));

const percent = (share, digits = 1) => (100 * share).toFixed(digits);

/** The button that switches between light, dark, and the system's setting. */
function themeButton() {
  const names = {auto: 'system', light: 'light', dark: 'dark'};
  let theme = 'auto';
  try { theme = localStorage.getItem('ucon-theme') || 'auto'; } catch { /* a file opened without storage */ }
  const button = el('button', {type: 'button', id: 'theme'});
  const show = () => {
    if (theme === 'auto') delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = theme;
    button.textContent = `Colours: ${names[theme]}`;
  };
  button.addEventListener('click', () => {
    theme = {auto: 'light', light: 'dark', dark: 'auto'}[theme];
    try { localStorage.setItem('ucon-theme', theme); } catch { /* as above */ }
    show();
  });
  show();
  return button;
}
