// Keys. Letters go by what they write, not by where they are; they can be switched off for voice control.

import { app, next, tell } from './app.js';
import { choose, flip, swap, toggle as compare } from './compare.js';
import { loupe, magnifies } from './loupe.js';
import { send, set } from './link.js';
import { background, following, nudge } from './settings.js';
import { choose as openFile } from './open.js';
import { dismiss, toggle as menu, untip } from './toast.js';
import { $, el } from './dom.js';

const list = [
  ['Turn', 'drag · arrows'], ['Lights', 'Shift drag · Shift arrows'], ['Spin', 'Ctrl drag · Page Up, Down'],
  ['Ten times finer', 'Alt with any of these'], ['Distance', 'wheel · + −'], ['Face up', 'double click · F'],
  ['Inspect a pixel', 'click · Enter'], ['Loupe, while held', 'L'], ['Compare', 'C'], ['Side A, side B', '1 2'],
  ['Swap A and B; flip, while held', 'X; Space'], ['Inspector', 'I'], ['Bench', 'B'], ['Settings panel', 'P'],
  ['Search materials', '/'], ['Exposure down, up, auto', ', . E'], ['Next background', 'G'], ['Next quality', 'Q'],
  ['Open', 'O'], ['Save the picture; the menu', 'Ctrl S; S'], ['Copy the command', 'K'],
  ['Undo, redo', 'Ctrl Z, Ctrl Shift Z'], ['Full screen', 'F11'], ['Close', 'Esc'], ['This list', '?'],
];

const dialog = $('#keys'), single = $('#single');
const view = () => (document.activeElement?.matches('.view') ? document.activeElement : $('#view-a'));
let pointer = null;                  // where the pointer is, for the loupe

export const save = format => send({ type: 'save', id: next(), format, side: app.side });
export const help = () => dialog.showModal();
export const face = () => send({ type: 'face-up', done: true });
export const full = () => (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen?.());

function search() {
  tell('panel', true);
  $('.tabs [data-tab=material]').click();
  $('#find').focus();
}

const letters = {
  f: face, c: compare, 1: () => choose('A'), 2: () => choose('B'), x: swap,
  i: () => tell('dock', 'inspect toggle'), b: () => tell('dock', 'bench toggle'), p: () => tell('panel'), '/': search,
  ',': () => nudge('exposure', -1), '.': () => nudge('exposure', 1), e: () => set('exposure', 'auto'),
  g: background, q: () => following('quality'), o: openFile, s: () => menu($('#save-button')),
  k: () => send({ type: 'command', side: app.side }), '?': help,
};

/** Closes the topmost: tooltip, menu, toast, dock. */
function escape() {
  if (!$('#tip').hidden) untip();
  if (!$('#menu').hidden) return menu(null);
  if (dismiss()) return;
  if (app.dock) return tell('dock', null);
  if (app.state?.compare && !app.embed) compare();
}

function commanded(e) {
  const key = e.key.toLowerCase();
  const act = { z: () => send({ type: e.shiftKey ? 'redo' : 'undo' }), y: () => send({ type: 'redo' }), s: () => save('png') }[key];
  if (!act) return;
  e.preventDefault();
  act();
}

/** A field where letters are text. */
const writes = target => target.matches?.('input:not([type=radio],[type=range],[type=checkbox]),select,textarea');

function held(e) {
  if (e.key === ' ' && (e.target === document.body || e.target.matches('.view')) && app.state?.compare) {
    e.preventDefault();
    if (!e.repeat) flip(true);
  } else if (e.key.toLowerCase() === 'l' && !e.repeat) {
    const own = view(), box = own.getBoundingClientRect();
    loupe(pointer ?? { view: own, x: box.width / 2, y: box.height / 2 });
  } else return false;
  return true;
}

function down(e) {
  if (app.embed || dialog.open || e.defaultPrevented) return;
  if (e.key === 'Escape') return escape();
  if (writes(e.target)) return;
  if (e.ctrlKey || e.metaKey) return commanded(e);
  if (e.altKey) return;
  if (e.key === 'Enter' && e.target.matches('.view')) { e.preventDefault(); return tell('enter', e.target); }
  if (e.key === 'F11') { e.preventDefault(); return full(); }
  if (!single.checked || held(e)) return;
  const act = letters[e.key.toLowerCase()];
  if (!act || e.repeat && !',.'.includes(e.key)) return;
  e.preventDefault();
  act();
}

function up(e) {
  if (e.key === ' ') flip(false);
  if (e.key.toLowerCase() === 'l' && magnifies()) loupe(null);
}

function remember() {
  single.checked = localStorage.getItem('gemtrace-keys') !== 'off';
  single.addEventListener('change', () => localStorage.setItem('gemtrace-keys', single.checked ? 'on' : 'off'));
}

export function start() {
  try { remember(); } catch { /* a browser without storage: the choice lasts as long as the page */ }
  $('#key-list').replaceChildren(...list.map(([what, keys]) => el('div', {}, el('dt', {}, what), el('dd', { class: 'read' }, keys))));
  $('#keys-close').addEventListener('click', () => dialog.close());
  dialog.addEventListener('click', e => e.target === dialog && dialog.close());
  addEventListener('keydown', down);
  addEventListener('keyup', up);
  addEventListener('blur', () => { flip(false); loupe(null); });
}

export const point = at => { pointer = at; };
