// The inspector: facet, colour, spectrum and the path of the main ray of one pixel.

import { app, listen, next, side, tell } from './app.js';
import { send } from './link.js';
import { marks, redraw } from './overlay.js';
import { pixel, viewed } from './picture.js';
import { section, spectrum } from './plot.js';
import { copy } from './toast.js';
import { $, $$, el, framed, number, parse, phone } from './dom.js';

const dock = $('#inspect');
let asked = null;                 // the pixel that was asked for: { side, x, y, id }
let shown = null;                 // the last answer
let over = null;                  // the place under the cursor that was asked for

const words = {
  in: 'refracted in', out: 'refracted out', part: 'reflected in part', total: 'total reflection', end: 'ends here',
};

/** The middle of a view, where no pixel has been chosen. */
const middle = () => { const { width, height } = viewed(); return [width >> 1, height >> 1]; };

/** Asks about a pixel (device pixels of the picture). */
function ask(name, x, y) {
  asked = { side: name, x, y, id: next() };
  send({ type: 'inspect', ...asked, ...viewed() });
  $('#pixel-x').value = x;
  $('#pixel-y').value = y;
}

/** A click opens the inspector first: the layout moves the picture's middle, and the pixel with it. */
function clicked({ view, x, y }) {
  const box = view.getBoundingClientRect();
  const [dx, dy] = [x - box.width / 2, y - box.height / 2];
  tell('dock', 'inspect');
  requestAnimationFrame(() => requestAnimationFrame(() => {
    const now = view.getBoundingClientRect(), name = view.dataset.side;
    ask(name, ...pixel(now.width / 2 + dx, now.height / 2 + dy));
  }));
}

const list = rows => $('#facts').replaceChildren(
  ...rows.flatMap(([name, ...parts]) => [el('dt', {}, name), el('dd', {}, ...parts)]));

function named(facet) {
  if (!facet) return ['Facet', 'no stone here'];
  const angle = Number.isFinite(facet.angle) ? `${number(facet.angle, 2)}°` : '';
  const place = facet.index != null ? `index ${number(facet.index, facet.index % 1 ? 1 : 0)}` : '';
  return ['Facet', el('b', {}, facet.name), [facet.part, angle, place].filter(Boolean).join(', ')];
}

/** Enter asks about the same pixel again, or about the middle. */
function entered(view) {
  if (asked && app.dock === 'inspect') return ask(asked.side, asked.x, asked.y);
  const box = view.getBoundingClientRect();
  clicked({ view, x: box.width / 2, y: box.height / 2 });
}

function facts({ facet, colour, chromaticity, source }) {
  const chip = el('span', { class: 'chip' });
  chip.style.background = colour;
  const xy = `${colour} · x ${number(chromaticity?.[0], 3)} y ${number(chromaticity?.[1], 3)}`;
  list([named(facet), ['Colour', chip, xy], ['Light', source || '–']]);
}

function row(event, i) {
  const button = el('button', { class: 'number', 'data-e': i, 'aria-label': `Event ${i + 1}: show in the pictures` }, i + 1);
  const share = event.left * 100;
  return el('tr', { 'data-e': i }, el('td', {}, button), el('td', {}, event.facet),
    el('td', {}, words[event.event] ?? event.event),
    el('td', { class: 'n' }, `${number(event.angle, 1)}°`),
    el('td', { class: 'n' }, `${number(share, share < 9.95 ? 2 : 1)} %`));
}

function show(message) {
  if (message.id !== asked?.id) return;
  shown = message;
  const events = message.path?.events ?? [];
  facts(message);
  spectrum($('#spectrum'), message.wavelengths, message.radiance);
  section($('#section'), message.section ?? undefined);
  $('#length').textContent = events.length
    ? `${number(message.path.length, 1)} mm inside, ${events.length} event${events.length > 1 ? 's' : ''}` : 'it meets no stone';
  $('#events').replaceChildren(...events.map(row));
  Object.assign(marks, {
    side: asked.side, outline: message.outline ?? null, path: message.path, pixel: [asked.x, asked.y],
  });
  redraw();
}

/** Turning keeps the pixel's facet and drops the path. */
function moved(type) {
  if (!shown || !marks.path) return;
  if (type === 'pose' || type === 'distance') stale('the stone was turned; click a point for its path');
  else if (type === 'lights') stale('the lights were turned; click a point for its path');
}

/** No path and no spectrum, with the reason. */
function stale(reason) {
  list([...(shown ? [named(shown.facet)] : []), ['Pixel', reason]]);
  marks.path = marks.pixel = shown = null;
  spectrum($('#spectrum'), []);
  section($('#section'));
  $('#events').replaceChildren();
  $('#length').textContent = '';
  redraw();
}

/** After a change of a setting the same pixel is asked again, once its picture has settled. */
function settled({ stage, side: name }) {
  if (stage === 'settled' && app.dock === 'inspect' && shown && name === asked.side) ask(asked.side, asked.x, asked.y);
}

function closed() {
  marks.path = marks.outline = marks.pixel = null;
  shown = asked = null;
  redraw();
}

function opened() {
  if (app.dock !== 'inspect') return closed();
  if (!asked) stale(phone.matches ? 'tap a point of the stone' : 'click a point of the stone, or give its place');
}

/** Hover or focus on one number marks all three: table, section and stone. */
function mark(e) {
  const index = e.type === 'pointerleave' ? null : e.target.closest('[data-e]')?.dataset.e;
  for (const node of $$('[data-e]')) node.classList.toggle('on', node.dataset.e === index);
}

const hover = framed(at => {
  const readout = $('#hover');
  if (!at || app.gesture || !side()?.camera) {
    readout.textContent = '–';
    over = null;
    if (marks.hover) { marks.hover = null; redraw(); }
    return;
  }
  const name = at.view.dataset.side, [x, y] = pixel(at.x, at.y);
  over = { id: next(), side: name, x, y };
  send({ type: 'hover', ...over, ...viewed() });
});

function facet({ id, facet, outline }) {
  if (id !== over?.id) return;
  const what = facet && [facet.name, facet.part, Number.isFinite(facet.angle) && `${number(facet.angle, 2)}°`];
  $('#hover').textContent = [`${over.x}, ${over.y}`, what && what.filter(Boolean).join(' ')].filter(Boolean).join(' · ');
  if (app.dock !== 'inspect' || marks.path) return;
  Object.assign(marks, { side: over.side, hover: facet ? outline : null });
  redraw();
}

function table() {
  if (!shown) return '';
  const rows = shown.path.events.map((e, i) => [i + 1, e.facet, e.event, e.angle, e.left, ...(e.point ?? [])].join('\t'));
  return ['event\tfacet\tkind\tangle\tleft\tx\ty\tz', ...rows].join('\n');
}

export function start() {
  listen('inspect', clicked);
  listen('pixel', show);
  listen('facet', facet);
  listen('pose', moved);
  listen('status', settled);
  listen('docked', opened);
  listen('hovered', hover);
  listen('enter', entered);
  for (const type of ['pointerover', 'focusin', 'pointerleave']) dock.addEventListener(type, mark);
  for (const input of [$('#pixel-x'), $('#pixel-y')]) {
    input.addEventListener('change', () => {
      const [x, y] = [$('#pixel-x'), $('#pixel-y')].map((n, i) => parse(n.value) || middle()[i]);
      ask(app.side, Math.round(x), Math.round(y));
    });
  }
  $('#copy-spectrum').addEventListener('click', () => shown && copy(
    ['nm\tradiance', ...shown.wavelengths.map((w, i) => `${w}\t${shown.radiance[i]}`)].join('\n'), 'The spectrum'));
  $('#copy-path').addEventListener('click', () => copy(table(), 'The path'));
}
