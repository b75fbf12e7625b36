// The bench: light return over tilt and figures of the stone on the table, beside those it had when it was opened.

import { app, entry, listen, next, side } from './app.js';
import { send, set } from './link.js';
import { choice } from './field.js';
import { curves } from './plot.js';
import { $, el, number } from './dom.js';

const first = new Map();           // the first curve of each opened stone
let asked = null, key = '', strip = null;

/** What the curve depends on; pose, light and exposure are not among it. */
const stone = s => [app.side, s.name, s.cut, s.material, s.size, s.axis].join('|');

function ask() {
  const s = side();
  if (app.dock !== 'bench' || !s || key === stone(s)) return;
  key = stone(s);
  asked = next();
  $('#bench .plot').setAttribute('aria-busy', 'true');
  $('#curve-note').textContent = 'computing …';
  send({ type: 'curve', id: asked, side: app.side });
}

function figure({ label, value, unit }, before) {
  const d = before == null ? 0 : value - before;
  const change = Math.abs(d) < 0.05 ? '±0' : number(d, 1, true);
  return el('div', {}, el('dt', {}, label), el('dd', {}, `${number(value, 1)} ${unit ?? ''}`, el('small', {}, change)));
}

function show(message) {
  if (message.id !== asked) return;
  const name = `${app.side}|${side().name}`;
  if (!first.has(name)) first.set(name, message);
  const before = first.get(name);
  const scale = Math.max(...message.values) <= 1.5 ? 100 : 1;
  const line = (m, label, dashed) => ({ tilts: m.tilts, values: m.values.map(v => v * scale), label, dashed });
  const now = line(message, 'now', false);
  curves($('#curve'), before === message ? [now] : [line(before, 'opened', true), now]);
  $('#bench .plot').setAttribute('aria-busy', 'false');
  $('#curve-note').textContent = message.label ?? '%';
  const middle = now.values[now.tilts.findIndex(t => Math.abs(t) < 1e-6)] ?? now.values[now.values.length >> 1];
  $('#curve').setAttribute('aria-label',
    `Light return from ${number(now.tilts[0])}° to ${number(now.tilts.at(-1))}° of tilt; ${number(middle, 1)} % face up`);
  const own = message.figures ?? [{ label: 'Return', value: middle, unit: '%' }];
  $('#figures').replaceChildren(...own.map(f => figure(f, before.figures?.find(b => b.label === f.label)?.value)));
}

function tiers() {
  const s = side(), rows = s?.tiers ?? [];
  $('#tiers').hidden = !rows.length;
  $('#tier-rows').replaceChildren(...rows.map(t => el('tr', {},
    el('th', { scope: 'row' }, t.name), el('td', {}, t.part ?? ''),
    el('td', { class: 'n' }, `×${t.count}`), el('td', { class: 'n' }, `${number(t.angle, 2)}°`))));
  $('#bench-read').textContent = [s?.gear && `gear ${s.gear}`, entry('materials', s?.material)?.index
    && `n ${number(entry('materials', s.material).index, 3)}`].filter(Boolean).join(' · ');
}

/** Lights that cutters judge by, at hand while the bench is open. */
function lights() {
  const all = app.hello.lists.lights, photograph = all.find(l => !/model/i.test(l.group ?? '')) ?? all[0];
  const wanted = ['iso', 'cos', 'aset', 'ideal-scope'];
  const models = wanted.map(id => all.find(l => l.id === id || l.id.endsWith(`:${id}`))).filter(Boolean);
  strip.fill([{ id: photograph.id, label: photograph.label }, ...models]);
}

function changed() {
  if (app.dock !== 'bench') return;
  strip.show(side()?.light);
  tiers();
  ask();
}

export function start() {
  strip = choice($('#bench-lights'), 'bench-light', value => set('light', value));
  listen('connected', () => { key = ''; });
  listen('hello', lights);
  listen('state', changed);
  listen('side', changed);
  listen('docked', changed);
  listen('curve', show);
  curves($('#curve'), []);
}
