// The panel of settings: it shows the state of the side that is edited, and sends what a person changes.

import { app, entry, listen, side, tell } from './app.js';
import { choice, refused, selection, slider } from './field.js';
import { set } from './link.js';
import { $, $$, el } from './dom.js';

const opened = { A: null, B: null };       // the values of each side when its stone was opened: a dot marks a change

const numbers = {
  size: { label: 'Width', min: 1, max: 20, step: 0.05, unit: 'mm' },
  rotation: { label: 'Rotation', min: 0, max: 360, step: 1, unit: '°' },
  strength: { label: 'Strength', min: -4, max: 4, step: 0.1, unit: 'EV' },
  exposure: { label: 'Exposure', min: -4, max: 4, step: 0.1, unit: 'EV' },
};
const sliders = {}, choices = {}, lists = {};

function build() {
  for (const [path, about] of Object.entries(numbers)) {
    sliders[path] = slider($(`[data-path=${path}]`), about, (value, done) => set(path, value, done));
  }
  for (const path of ['ground', 'quality', 'tone']) {
    choices[path] = choice($(`[data-path=${path}] fieldset`), path, value => set(path, value));
  }
  for (const path of ['cut', 'axis', 'light']) {
    lists[path] = selection($(`[data-path=${path}] select`), value => set(path, value));
  }
}

function backgrounds() {
  const inputs = app.hello.lists.backgrounds.map(({ id, label, css }) => {
    const input = el('input', { type: 'radio', name: 'background', value: id, 'aria-label': label, 'data-tip': label });
    input.addEventListener('change', () => set('background', id));
    const chip = el('span', { class: css ? '' : id });
    if (css) chip.style.background = css;
    return el('label', {}, input, chip);
  });
  $('#backgrounds').replaceChildren(...inputs);
}

function greet() {
  const all = app.hello.lists;
  choices.ground.fill(all.grounds);
  choices.quality.fill(all.qualities);
  choices.tone.fill(all.tones);
  lists.light.fill(all.lights);
  lists.axis.fill(all.axes);
  backgrounds();
}

/** The cut that is on the table says how many facets it has; one that is in no list leads it. */
function cut(s) {
  const count = label => (s.facets ? `${label} – ${s.facets} facets` : label);
  const all = app.hello.lists.cuts.map(c => (c.id === s.cut ? { ...c, label: count(c.label) } : c));
  const own = entry('cuts', s.cut) ? [] : [{ id: s.cut ?? '', label: count(s.name), group: 'Open file' }];
  lists.cut.fill([...own, ...all]);
  lists.cut.show(s.cut);
}

function axis(s) {
  const material = entry('materials', s.material);
  const reason = s.axis_reason
    ?? (material?.metal ? 'None: a metal' : material?.isotropic ? 'None: isotropic' : null);
  const { select } = lists.axis;
  select.disabled = Boolean(reason);
  $('[data-reason]', select)?.remove();
  if (!reason) return lists.axis.show(s.axis);
  select.prepend(el('option', { value: '', 'data-reason': true }, reason));
  select.selectedIndex = 0;
}

function show() {
  const s = side();
  if (!s || !app.hello) return;
  cut(s);
  axis(s);
  lists.light.show(s.light);
  for (const path in choices) choices[path].show(s[path]);
  for (const path in sliders) sliders[path].show(s[path] ?? 0, opened[app.side]?.[path] ?? s[path]);
  for (const input of $$('#backgrounds input')) input.checked = input.value === s.background;
  ground(s);
}

/** The page behind the picture has the picture's ground, for the places that it does not cover yet. */
function ground(s) {
  const css = entry('backgrounds', s.background)?.css;
  const { dataset } = document.body;
  dataset.ground = css ? 'colour' : s.background;
  $('#stage').style.background = css ?? '';
}

/** A stone that was opened anew starts anew. */
function remember() {
  for (const [name, s] of Object.entries(app.state.sides)) {
    if (!s) opened[name] = null;
    else if (opened[name]?.name !== s.name) opened[name] = { ...s };
  }
}

/** What was refused shows the old value again, with the reason beneath. */
function failed({ path, why }) {
  if (!path) return;
  show();
  const row = $(`[data-path=${CSS.escape(path)}]`);
  if (row) refused(row, why);
}

export const nudge = (path, d) => sliders[path].step(d);
export const following = path => { const id = choices[path].following(); if (id) set(path, id); };

export function background() {
  const inputs = $$('#backgrounds input');
  inputs[(inputs.findIndex(i => i.checked) + 1) % inputs.length]?.click();
}

function tabs() {
  const buttons = $$('.tabs button'), sections = $$('#panel details');
  const choose = button => {
    for (const other of buttons) other.setAttribute('aria-pressed', other === button);
    for (const section of sections) section.toggleAttribute('data-on', section.dataset.tab === button.dataset.tab);
  };
  for (const button of buttons) button.addEventListener('click', () => choose(button));
  choose(buttons[1]);
}

export function start() {
  build();
  tabs();
  listen('hello', () => { greet(); if (app.state) show(); });
  listen('state', () => { remember(); show(); });
  listen('side', show);
  listen('error', failed);
  $('#panel-button').addEventListener('click', () => tell('panel'));
}
