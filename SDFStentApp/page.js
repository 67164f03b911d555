// What the page does in the browser by itself. The markup calls the functions of `window`; `begin` runs once the page is there.
(() => {
'use strict';

const trigger = (name, args) => window.trame.trigger(name, args);

// Sets the background of the view by the browser's light or dark theme, now and when that changes.
const followTheme = () => {
  const isDark = window.matchMedia('(prefers-color-scheme: dark)');
  const tell = () => trigger('theme', [isDark.matches ? 'dark' : 'light']);
  isDark.addEventListener('change', tell);
  tell();
};

// Calls the page after all earlier edits were sent: while a call is under way trame's client sends further calls, but no edits.
window.inOrder = async (name, args) => {
  const {state} = window.trame;
  for (let turn = 0; state.dirtyKeys.size && turn < 1000; turn += 1) {
    await state.flush();
    if (state.dirtyKeys.size) await new Promise(done => setTimeout(done, 5));
  }
  return trigger(name, args);
};

// Lets the browser keep the files that were made for it.
window.keep = async () => {
  for (const file of await trigger('fetch')) window.trame.utils.download(file.name, file.content, file.type);
};

// Adds what trame leaves out for users who cannot see a page, or need it larger.
const nameImages = () => {
  const screen = document.querySelector('.screen');
  const name = () => screen.querySelectorAll('img:not([alt])').forEach(one => { one.alt = 'Vessel and stents'; });
  new MutationObserver(name).observe(screen, {childList: true, subtree: true});
  name();
  document.querySelector('meta[name=viewport]').content = 'width=device-width, initial-scale=1';
};

// Finds the values of a plot that are nearest to the pointer, and lets the view mark their place, one call after another.
let pointed = -1, told = -1, isTelling = false;
const point = async station => {
  pointed = station;
  if (isTelling) return;
  isTelling = true;
  try { while (told !== pointed) await trigger('point', [told = pointed]); } finally { isTelling = false; }
};
window.nearest = (event, values) => {
  const seen = event.currentTarget.getScreenCTM().inverse();
  const {x} = new DOMPoint(event.clientX, event.clientY).matrixTransform(seen);
  const away = values.map(one => Math.abs(one.at - x)), station = away.indexOf(Math.min(...away));
  point(station);
  return values[station];
};
window.nowhere = () => { point(-1); return null; };

// Sends files of the browser's own machine, chosen or dropped. Of a file that is too large only the name is sent.
window.send = (variable, files) => Array.from(files).forEach(async file => {
  const {state} = window.trame, isLarge = file.size > state.get('largestUpload');
  state.set('message', `Sending ${file.name}...`);
  trigger('upload', [variable, file.name, isLarge ? null : await file.arrayBuffer().catch(() => null)]);
});
const withFiles = take => event => {
  if (!event.dataTransfer.types.includes('Files')) return;
  event.preventDefault();
  take(event);
};
const takeDroppedFiles = () => {
  window.addEventListener('dragover', withFiles(() => {}));
  window.addEventListener('drop', withFiles(event => {
    const field = event.target.closest('[type=file]');
    const other = window.trame.state.get('chooser').button ? 'chosenPath' : '';
    if (!other) document.querySelector('[data-name=opening]').open = true;
    window.send(field ? field.dataset.name.split('-')[0] : other, event.dataTransfer.files);
  }));
};

// Sets the width of the panel, or changes it by a step, such that both sides stay usable. A page that is loaded again keeps it.
window.split = to => {
  const [page, panel, split] = ['.page', '.panel', '.split'].map(one => document.querySelector(one));
  const steps = {'-': -20, '+': 20}, wanted = to in steps ? panel.offsetWidth + steps[to] : to;
  const most = Math.max(300, Math.min(900, window.innerWidth - 400));
  const width = Math.round(Math.min(Math.max(wanted, 300), most));
  page.style.setProperty('--panel', `${width}px`);
  split.setAttribute('aria-valuenow', width);
  localStorage.setItem('panel', width);
};

// Unfolds a part of the panel and scrolls to it.
window.unfold = name => {
  const part = document.querySelector(`[data-name=${name}]`);
  for (let one = part; one; one = one.parentElement.closest('details')) one.open = true;
  part.scrollIntoView({block: 'nearest'});
};

// Passes keys to the panel's table of stents, also when no widget or the view has the focus; keys typed into a field stay there.
const keyNames = {Escape: 'Esc', ArrowLeft: 'Left', ArrowRight: 'Right', Delete: 'Del'};
const keyButtons = {z: 'undoButton', y: 'redoButton'};
const takeKey = event => {
  const {target} = event, isTyped = target.matches('input:not([type=checkbox]), select');
  const button = (event.ctrlKey || event.metaKey) && keyButtons[event.key];
  const key = keyNames[event.key], widget = target.closest('[data-name]');
  const keys = document.querySelector('.keys');
  if (keys.open) return;
  if (event.key === '?' && !isTyped) { keys.showModal(); return; }
  if (isTyped && key !== 'Esc' || !key && !button) return;
  if (button || key.length > 3) event.preventDefault();
  if (button) { window.inOrder('click', [button]); return; }
  const name = widget ? widget.dataset.name : key === 'Del' ? '' : 'stentTable';
  window.inOrder('key', [name, (event.shiftKey ? 'Shift+' : '') + key]);
};

// Loads a page whose connection is lost again as soon as the server answers: only in the window with the focus, since the page may be
// open in another one. A page that fails at once is not loaded again and again.
const goOn = async () => {
  if (!document.querySelector('.gone') || !document.hasFocus() || performance.now() < 10000) return;
  const answer = await fetch(window.location.href).catch(() => null);
  if (answer && answer.ok) window.location.reload();
};

window.begin = () => {
  followTheme();
  nameImages();
  takeDroppedFiles();
  window.addEventListener('keydown', takeKey);
  window.setInterval(goOn, 2000);
  if (localStorage.getItem('panel')) window.split(localStorage.getItem('panel'));
};
})();
