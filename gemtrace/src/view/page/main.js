// Starts the page: its parts, the bar, docks and the panel; then the connection.

import { app, listen, side, tell } from './app.js';
import * as bench from './bench.js';
import * as comparison from './compare.js';
import * as embed from './embed.js';
import * as gesture from './gesture.js';
import * as inspector from './inspector.js';
import * as keys from './keys.js';
import { connect, send } from './link.js';
import * as loupe from './loupe.js';
import * as material from './material.js';
import * as open from './open.js';
import * as overlay from './overlay.js';
import * as picture from './picture.js';
import * as pose from './pose.js';
import * as settings from './settings.js';
import * as status from './status.js';
import * as toast from './toast.js';
import { $, $$ } from './dom.js';

/** Opens one dock, or none; `toggle` closes the one that is open. Focus goes back to its button. */
function dock(wish) {
  const [name, toggle] = (wish ?? '').split(' ');
  const before = app.dock;
  app.dock = !name || toggle && before === name ? null : name;
  const { dataset } = document.body;
  dataset.dock = app.dock ?? '';
  for (const id of ['inspect', 'bench']) {
    const own = $(`#${id}`), focused = own.contains(document.activeElement);
    own.hidden = app.dock !== id;
    $(`#${id}-button`).setAttribute('aria-pressed', String(app.dock === id));
    if (focused && own.hidden) $(`#${id}-button`).focus();
  }
  tell('docked', app.dock);
}

function panel(on = $('#panel-button').getAttribute('aria-expanded') === 'false') {
  $('#panel-button').setAttribute('aria-expanded', String(on));
  document.body.toggleAttribute('data-nopanel', !on);
}

function named() {
  const { undo, redo } = app.state, s = side('A');
  document.title = `${s.name} – gemtrace view`;
  $('h1').textContent = `${s.name} in gemtrace view`;
  $('#file span').textContent = s.name;
  $('#file').setAttribute('aria-label', `Open a file; ${s.name} is open`);
  for (const button of $$('[data-act=undo]')) { button.disabled = !undo; button.dataset.tip = undo ? `Undo: ${undo}` : 'Undo'; }
  for (const button of $$('[data-act=redo]')) { button.disabled = !redo; button.dataset.tip = redo ? `Redo: ${redo}` : 'Redo'; }
  $('#size-read').textContent = `${app.size.join(' × ')} pixels`;
  $('#output').textContent = app.hello?.output ?? './views';
}

const actions = {
  undo: () => send({ type: 'undo' }), redo: () => send({ type: 'redo' }), full: keys.full, help: keys.help,
  command: () => send({ type: 'command', side: app.side }),
  inspect: () => tell('dock', 'inspect toggle'), bench: () => tell('dock', 'bench toggle'),
  close: () => tell('dock', null),
};

function buttons() {
  for (const button of $$('[data-act]')) button.addEventListener('click', () => actions[button.dataset.act]());
  for (const button of $$('[data-save]')) button.addEventListener('click', () => keys.save(button.dataset.save));
  $('.skip').addEventListener('click', e => { e.preventDefault(); $('#view-a').focus(); });
}

/** What only appears inside another page. */
function embedded() {
  document.body.toggleAttribute('data-embed', app.embed);
  const { href } = location;
  $('#whole').href = href.replace(/&embed=1/, '').replace(/&origin=[^&]*/, '');
}

function start() {
  document.documentElement.dir = new URLSearchParams(location.search).get('dir') === 'rtl' ? 'rtl' : 'ltr';
  embedded();
  for (const part of [toast, picture, overlay, gesture, pose, settings, material, status, inspector, comparison, bench,
    loupe, open, keys, embed]) part.start();
  buttons();
  listen('dock', dock);
  listen('panel', panel);
  listen('face-up', keys.face);
  listen('hovered', keys.point);
  const size = () => (app.size = picture.measured());
  listen('layout', size);
  size();
  listen('state', named);
  listen('command', ({ text }) => toast.copy(text, 'The command'));
  connect(size);
}

start();
