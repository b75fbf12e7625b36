// Controls of settings: a slider with a number, a row of choices, a list. Each shows a value and tells what a person chose.

import { $, clamp, el, number, parse } from './dom.js';

let count = 0;

/** What a field of a number does on keys: arrows step, Shift ten times, Esc restores. */
export function numeric(input, { step, read, write, done }) {
  const typed = () => { delete input.dataset.typing; };
  input.addEventListener('focus', () => input.select());
  input.addEventListener('input', () => { input.dataset.typing = ''; });
  input.addEventListener('blur', typed);
  input.addEventListener('change', () => {
    typed();
    const value = parse(input.value);
    if (Number.isFinite(value)) { write(value); done(); } else input.value = read().text;
  });
  input.addEventListener('keydown', e => {
    const d = { ArrowUp: 1, ArrowDown: -1 }[e.key];
    if (e.key === 'Escape') input.value = read().text;
    if (!d) return;
    e.preventDefault();
    e.stopPropagation();
    typed();
    write(read().value + d * step * (e.shiftKey ? 10 : 1) * (e.altKey ? 0.1 : 1));
    done();
  });
}

/** A row with a label, a slider and a number. `change(value, done)` is told of every change. */
export function slider(row, { label, min, max, step, unit }, change) {
  const id = `f${count++}`, digits = (String(step).split('.')[1] ?? '').length;
  const range = el('input', { type: 'range', id, min, max, step });
  const field = el('input', { class: 'num', inputmode: 'decimal', autocomplete: 'off', 'aria-label': `${label}, ${unit}` });
  const name = el('label', { for: id }, label);
  let opened = null, now = 0;
  const format = value => number(value, digits, min < 0) + (unit === '°' ? '°' : ` ${unit}`);
  const show = value => {
    now = value;
    range.max = value > max ? value * 2 : max;
    range.value = value;
    const share = v => (v - min) / (range.max - min) * 100, zero = min < 0 ? share(0) : 0;
    range.style.setProperty('--a', `${Math.min(zero, share(value))}%`);
    range.style.setProperty('--b', `${Math.max(zero, share(value))}%`);
    const text = format(value);
    if (document.activeElement !== field || !field.dataset.typing) field.value = text;
    range.setAttribute('aria-valuetext', text);
    row.classList.toggle('changed', opened != null && Math.abs(value - opened) > step / 2);
  };
  const to = (value, done) => { show(value); change(value, done); };     // whether it can be is for the server to say
  range.addEventListener('input', () => to(Number(range.value), false));
  range.addEventListener('change', () => to(Number(range.value), true));
  numeric(field, {
    step, read: () => ({ value: now, text: format(now) }),
    write: value => to(value, false), done: () => to(now, true),
  });
  name.addEventListener('dblclick', () => opened != null && to(opened, true));
  row.classList.add('row');
  row.append(name, range, field);
  return {
    range, field, step: d => to(clamp(now + d * step, min, max), true),
    show(value, first) { opened = first; if (document.activeElement !== range || !range.matches(':active')) show(value); },
  };
}

/** Radio buttons in a row; where they would not fit, a list. */
export function choice(fieldset, name, change) {
  let chosen = null, list = [];
  const fill = entries => {
    if (JSON.stringify(entries) === JSON.stringify(list)) return;
    list = entries;
    fieldset.replaceChildren(...entries.map(({ id, label }) => {
      const input = el('input', { type: 'radio', name, value: id });
      input.addEventListener('change', () => change(id));
      return el('label', {}, input, el('span', {}, label));
    }));
    show(chosen);
  };
  const show = value => {
    chosen = value;
    for (const input of fieldset.querySelectorAll('input')) input.checked = input.value === value;
  };
  const following = () => list[(list.findIndex(e => e.id === chosen) + 1) % list.length]?.id;
  return { fill, show, following };
}

/** Files by their names alone, where no other has the same. */
function short(entries) {
  const name = ({ label }) => label.split('/').pop();
  const count = new Map();
  for (const e of entries) count.set(name(e), (count.get(name(e)) ?? 0) + 1);
  return entries.map(e => (count.get(name(e)) === 1 ? { ...e, label: name(e) } : e));
}

/** A native list with groups. A value that is not in it gets an entry of its own. */
export function selection(select, change) {
  let key = '';
  select.addEventListener('change', () => change(select.value));
  const fill = entries => {
    const now = JSON.stringify(entries);
    if (now === key) return;
    key = now;
    const groups = new Map();
    for (const entry of short(entries)) {
      const group = groups.get(entry.group) ?? groups.set(entry.group, []).get(entry.group);
      group.push(el('option', { value: entry.id }, entry.label));
    }
    select.replaceChildren(...[...groups].flatMap(([label, options]) =>
      label ? [el('optgroup', { label }, ...options)] : options));
  };
  const show = value => {
    let option = [...select.options].find(o => o.value === (value ?? ''));
    if (!option) select.prepend(option = el('option', { value: value ?? '', disabled: true }, value ?? 'As in the scene'));
    option.selected = true;
  };
  return { fill, show, select };
}

/** The reason why a value was refused, beneath its row, until the next change. */
export function refused(row, reason) {
  $('.why', row)?.remove();
  if (!reason) return;
  const id = `f${count++}`;
  row.append(el('p', { class: 'why', id }, reason.charAt(0).toUpperCase() + reason.slice(1)));
  const field = $('input,select', row);
  field?.setAttribute('aria-describedby', id);
  field?.setAttribute('aria-invalid', 'true');
  row.addEventListener('input', () => {
    $('.why', row)?.remove();
    field?.removeAttribute('aria-invalid');
    field?.removeAttribute('aria-describedby');
  }, { once: true });
}
