// What the page says: one toast, the newest wins, until it is dismissed. Tooltips and the save menu float, too.

import { address, listen } from './app.js';
import { $, $$, el, icon } from './dom.js';

const toast = $('#toast');
let text = '';
let now = null, told = null;      // what is being saved and said now, and what was put away

/** Shows a toast. `error` is spoken at once; `file` offers a download. */
export function notify({ title, body, error = false, file, id = null }) {
  now = id;
  text = [title, body].filter(Boolean).join(' ');
  toast.setAttribute('role', error ? 'alert' : 'status');
  toast.classList.toggle('note', !error);
  $('.icon', toast).replaceChildren(icon(error ? 'warn' : 'ok'));
  $('.text', toast).replaceChildren(el('b', {}, title), ...(body ? [el('p', {}, body)] : []));
  $('#toast-copy').hidden = Boolean(file);
  const link = $('#toast-file');
  link.hidden = !file;
  if (file) link.href = file;
  toast.hidden = false;
}

export function dismiss() {
  if (toast.hidden) return false;
  told = now ?? told;
  const focused = toast.contains(document.activeElement);
  toast.hidden = true;
  if (focused) $('#view-a').focus();
  return true;
}

/** To the clipboard. Browsers allow it on this machine and over https; elsewhere the text is shown to be copied by hand. */
export async function copy(content, what) {
  try {
    await navigator.clipboard.writeText(content);
    notify({ title: `${what} was copied.` });
  } catch {
    notify({ title: `${what} could not be copied by the browser. Here it is:`, body: content });
  }
}

/** A sentence: with a full stop, and a capital where it does not begin with a name. */
function sentence(text, capital = true) {
  const first = capital ? text.charAt(0).toUpperCase() + text.slice(1) : text;
  return /[.!?…]$/.test(first) ? first : `${first}.`;
}

function failed({ what, where, why, unchanged }) {
  const reason = sentence([where, why].filter(Boolean).join(': '), !where);
  notify({ title: sentence(what, false), body: [reason, unchanged && sentence(unchanged)].filter(Boolean).join(' '), error: true });
}

function saved(message) {
  if (message.error) return failed(typeof message.error === 'string'
    ? { what: 'The file was not saved.', why: message.error } : message.error);
  const { files = [] } = message, [name] = files.map(path => path.split(/[\\/]/).pop());
  notify({ title: 'Saved.', body: files.join(', '), file: name && address(`saved/${encodeURIComponent(name)}`) });
}

/** A turn takes many pictures. Who puts the message away sees it again once all are done. */
function saving({ id, done, of }) {
  if (id !== told) notify({ title: `The turn: picture ${done + 1} of ${of} is rendered …`, id });
}

const tip = $('#tip');
let wait = 0;

function explain(target) {
  const { key, tip: own } = target.dataset;
  tip.replaceChildren(own ?? target.getAttribute('aria-label') ?? target.textContent.trim(), ...(key ? [el('kbd', {}, key)] : []));
  tip.hidden = false;
  const a = target.getBoundingClientRect(), b = tip.getBoundingClientRect();
  const below = a.bottom + b.height + 12 < innerHeight;
  tip.style.left = `${Math.max(8, Math.min(innerWidth - b.width - 8, a.x + a.width / 2 - b.width / 2))}px`;
  tip.style.top = `${below ? a.bottom + 8 : a.y - b.height - 8}px`;
}

export const untip = () => { clearTimeout(wait); tip.hidden = true; };

function tips() {
  const target = e => e.target.closest?.('[data-key],[data-tip]');
  addEventListener('pointerover', e => {
    untip();
    const t = target(e);
    if (t && e.pointerType !== 'touch') wait = setTimeout(explain, 500, t);
  });
  addEventListener('pointerdown', untip);
  addEventListener('focusin', e => {
    untip();
    const t = target(e);
    if (t?.matches('button,input[type=radio]') && t.matches(':focus-visible')) explain(t);
  });
  addEventListener('focusout', untip);
}

const menu = $('#menu');
let opener = null;

/** Opens the menu at a button, or closes it and gives the focus back. */
export function toggle(button) {
  if (!menu.hidden || !button) {
    const inside = menu.contains(document.activeElement);
    menu.hidden = true;
    for (const b of $$('[aria-controls=menu]')) b.setAttribute('aria-expanded', 'false');
    if (inside) opener?.focus();
    return;
  }
  opener = button;
  menu.hidden = false;
  button.setAttribute('aria-expanded', 'true');
  $$('button', menu).find(b => b.offsetParent)?.focus();
}

export function start() {
  tips();
  listen('error', failed);
  listen('saved', saved);
  listen('saving', saving);
  listen('notice', ({ text: title }) => notify({ title, error: true }));
  $('#toast-close').addEventListener('click', dismiss);
  $('#toast-copy').addEventListener('click', () => navigator.clipboard?.writeText(text).catch(() => {}));
  for (const button of $$('[aria-controls=menu]')) button.addEventListener('click', () => toggle(button));
  menu.addEventListener('click', () => toggle(null));
  menu.addEventListener('focusout', e => e.relatedTarget && !menu.contains(e.relatedTarget) && toggle(null));
  addEventListener('pointerdown', e => {
    if (!menu.hidden && !menu.contains(e.target) && !e.target.closest('[aria-controls=menu]')) toggle(null);
    if (!toast.hidden && toast.classList.contains('note') && !toast.contains(e.target)) dismiss();
  });
}
