// Two stones under one drag: side by side, with a wipe, or one at a time.

import { app, entry, listen, side, tell } from './app.js';
import { difference } from './difference.js';
import { send } from './link.js';
import { pictures } from './picture.js';
import { settled } from './status.js';
import { choice } from './field.js';
import { $, el, number, phone } from './dom.js';

const stage = $('#stage'), wipe = $('#wipe');
let mode = 'sides', mean = 0;
let modes = null;

/** The line of the wipe lies under the middle of the handle, which stays inside the stage. */
function slide() {
  const width = stage.clientWidth, x = 22 + wipe.value / 100 * (width - 44);
  stage.style.setProperty('--wipe', `${x}px`);
  stage.style.setProperty('--wipe-end', `${width - x}px`);
}

/** How the two pictures lie on each other. */
function arrange() {
  const on = Boolean(app.state?.compare);
  document.body.toggleAttribute('data-compare', on);
  document.body.dataset.mode = on ? mode : '';
  document.body.dataset.side = app.side;
  $('#view-b').hidden = !on;
  $('#compare-button').setAttribute('aria-pressed', String(on));
  wipe.hidden = !on || mode !== 'wipe';
  slide();
  tell('compare');
}

/** The side that the settings change. */
export function choose(name) {
  if (!side(name) || app.side === name) return;
  app.side = name;
  arrange();
  tags();
  tell('side', name);
}

function tags() {
  for (const name of ['A', 'B']) {
    const tag = $(`#tag-${name.toLowerCase()}`), s = side(name);
    tag.setAttribute('aria-pressed', String(app.side === name));
    if (!s) continue;
    const material = entry('materials', s.material), n = s.n ?? material?.index;
    tag.replaceChildren(el('b', {}, name), el('span', {}, material?.label ?? s.material_name ?? s.material),
      el('small', {}, n ? `n ${number(n, 3)}` : ''));
    tag.dataset.tip = `Settings change ${name}: ${s.name}`;
  }
}

export function toggle() {
  if (!app.state?.compare && phone.matches) { mode = 'wipe'; modes.show(mode); }
  send({ type: 'compare', on: !app.state?.compare });
}

export const swap = () => app.state?.compare && send({ type: 'compare', on: true, swap: true });

/** While held, the other stone is in the place of this one. */
export const flip = on => document.body.toggleAttribute('data-flip', Boolean(on && app.state?.compare));

/** Whether a side's picture has settled and shows what moved it last. */
const still = name => settled(name) && (pictures[name].header?.answers ?? 0) >= app.moved;

/** The mean difference, once both pictures have settled and the page has time. */
function compare() {
  clearTimeout(mean);
  $('#difference').textContent = '–';
  if (!app.state?.compare || !still('A') || !still('B')) return;
  mean = setTimeout(() => {
    const value = difference(pictures.A.canvas, pictures.B.canvas);
    $('#difference').textContent = number(value, 1);
  }, 200);
}

function changed() {
  arrange();
  tags();
}

export function start() {
  modes = choice($('#modes'), 'mode', value => { mode = value; arrange(); });
  modes.fill([{ id: 'sides', label: 'Side by side' }, { id: 'wipe', label: 'Wipe' }, { id: 'flip', label: 'Flip' }]);
  modes.show(mode);
  listen('state', changed);
  listen('layout', slide);
  listen('shown', compare);
  listen('status', ({ stage: s }) => s === 'settled' && compare());
  $('#compare-button').addEventListener('click', toggle);
  $('#swap').addEventListener('click', swap);
  for (const name of ['A', 'B']) $(`#tag-${name.toLowerCase()}`).addEventListener('click', () => choose(name));
  wipe.addEventListener('input', slide);
}
