// The materials: a grid of swatches, searched in place, with a caption of the one that is chosen or pointed at.

import { address, app, entry, listen, side } from './app.js';
import { set } from './link.js';
import { $, $$, el, icon, number, phone, say } from './dom.js';

const grid = $('#swatches'), find = $('#find'), caption = $('#caption');
let filled = '', pictured = false;

function describe(material) {
  if (!material) return;
  const s = side(), own = s?.material === material.id;
  const facts = material.metal ? ['Metal'] : [];
  if (material.index) facts.push(`n ${number(material.index, 3)}`);
  if (material.dispersion) facts.push(`dispersion (B–G) ${number(material.dispersion, 3)}`);
  if (own && s.carat) facts.push(`${number(s.carat, 2)} ct`);
  caption.replaceChildren(
    el('b', {}, material.label + (material.approximate ? ' (approximate)' : '')), facts.join(' · '));
}

/** A material that the scene defines itself is not in the catalogue. */
const current = () => entry('materials', side()?.material)
  ?? { id: side()?.material, label: side()?.material_name ?? side()?.material ?? '–', index: side()?.n };

function swatch(material) {
  const input = el('input', {
    type: 'radio', name: 'material', value: material.id, 'data-tip': material.label,
    'aria-label': material.label + (material.approximate ? ', approximate' : ''),
  });
  const gem = icon('brilliant');
  gem.style.color = material.swatch;
  const label = el('label', { class: material.metal ? 'metal' : '' }, input, el('span', {}, gem));
  input.addEventListener('change', () => { set('material', material.id); describe(material); });
  label.addEventListener('pointerenter', () => describe(material));
  input.addEventListener('focus', () => describe(material));
  label.addEventListener('pointerleave', () => describe(current()));
  input.addEventListener('blur', () => describe(current()));
  return label;
}

function fill() {
  const materials = app.hello.lists.materials, key = materials.map(m => m.id).join();
  if (key === filled) return;
  filled = key;
  pictured = false;
  const sorted = [...materials.filter(m => !m.metal), ...materials.filter(m => m.metal)];
  grid.replaceChildren(el('legend', { class: 'vh' }, 'Material'), ...sorted.map(swatch));
  find.placeholder = `Search ${materials.length} materials`;
}

/** Rendered swatches in place of the drawn ones, once the first picture has settled: they must not delay it. */
function picture() {
  if (pictured || app.embed) return;
  pictured = true;
  for (const input of $$('input', grid)) {
    const image = new Image(48, 48);
    image.alt = '';
    image.src = address(`swatch/${encodeURIComponent(input.value)}.png`);
    image.onload = () => input.nextElementSibling.replaceChildren(image);
  }
}

/** What does not match dims in its place: nothing jumps. */
function search() {
  const words = find.value.trim().toLowerCase().split(/[\s-]+/);
  let hits = 0;
  for (const input of $$('input', grid)) {
    const text = `${input.value} ${input.getAttribute('aria-label')}`.toLowerCase();
    const hit = words.every(w => text.includes(w));
    hits += hit;
    input.disabled = !hit;
    input.parentNode.classList.toggle('off', !hit);
  }
  if (hits) describe(current());
  else caption.replaceChildren(el('b', {}, 'No such material'), `“${find.value.trim()}” is not in the catalogue.`);
  say(`${hits} materials`);
}

/** Up and down move by a row of the grid; on a phone it scrolls sideways. */
function keyed(e) {
  const rows = phone.matches ? 3 : 1;
  const columns = getComputedStyle(grid).gridTemplateColumns.split(' ').length;
  const step = { ArrowUp: rows > 1 ? -1 : -columns, ArrowDown: rows > 1 ? 1 : columns }[e.key];
  if (!step) return;
  e.preventDefault();
  const inputs = $$('input', grid), to = inputs[inputs.indexOf(document.activeElement) + step];
  if (to && !to.disabled) { to.focus(); to.click(); }
}

function show() {
  const s = side();
  for (const input of $$('input', grid)) input.checked = input.value === s.material;
  if (!grid.matches(':hover')) describe(current());
}

export function start() {
  listen('hello', fill);
  listen('state', show);
  listen('side', show);
  listen('status', ({ stage }) => { if (stage === 'settled') picture(); });
  find.addEventListener('input', search);
  find.addEventListener('keydown', e => {
    if (e.key === 'Enter') $('input:enabled', grid)?.click();
    if (e.key !== 'Escape' || !find.value) return;
    e.stopPropagation();
    find.value = '';
    search();
  });
  grid.addEventListener('keydown', keyed);
}
