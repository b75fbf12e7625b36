// Files: chosen, or dropped onto the page, and sent to the server.

import { address, app, listen, tell } from './app.js';
import { dismiss, notify } from './toast.js';
import { $ } from './dom.js';

const picker = $('#picker'), drop = $('#drop'), zones = [$('#zone-open'), $('#zone-b')];
const known = /\.(asc|gem|gcs|obj|stl|ply|hdr|exr|png|toml)$/i;
let depth = 0;

const failed = (name, why) => tell('error', { what: `${name} was not opened.`, why, unchanged: 'The stone is unchanged.' });

/** Sends a file; the answer comes as a new state, or as an error. */
export async function upload(file, side = 'open') {
  const limit = app.hello?.limits?.upload ?? 64 << 20;
  if (!known.test(file.name)) return failed(file.name, 'Its name ends in none of .asc .gem .gcs .obj .stl .ply .hdr .exr .toml.');
  if (file.size > limit) {
    return failed(file.name, `It has ${Math.ceil(file.size / 2 ** 20)} MB; files have at most ${limit >> 20} MB.`);
  }
  const slow = setTimeout(() => notify({ title: `${file.name} is being sent …` }), 300);
  try {
    const answer = await fetch(address('drop', { name: file.name, side }), { method: 'POST', body: file });
    const body = await answer.json().catch(() => ({}));
    clearTimeout(slow);
    dismiss();
    if (!answer.ok) tell('error', body.error ?? { what: `${file.name} was not opened.`, why: answer.statusText, unchanged: 'The stone is unchanged.' });
    return answer.ok;
  } catch {
    failed(file.name, 'There is no connection to the program.');
  } finally {
    clearTimeout(slow);
  }
}

export const choose = () => picker.click();

function over(e) {
  if (!e.dataTransfer.types.includes('Files')) return;
  e.preventDefault();
  const second = zones[1].contains(e.target) && !app.embed;
  zones.forEach((zone, i) => zone.classList.toggle('on', (i === 1) === second));
}

function end() {
  depth = 0;
  drop.hidden = true;
}

export function start() {
  picker.addEventListener('change', () => {
    for (const file of picker.files) upload(file);
    picker.value = '';
  });
  $('#file').addEventListener('click', choose);
  addEventListener('dragenter', e => {
    if (!e.dataTransfer.types.includes('Files')) return;
    e.preventDefault();
    depth++;
    drop.hidden = false;
  });
  addEventListener('dragleave', () => { if (depth && !--depth) end(); });
  addEventListener('dragover', over);
  addEventListener('drop', e => {
    e.preventDefault();
    const second = zones[1].classList.contains('on');
    end();
    for (const file of e.dataTransfer.files) upload(file, second ? 'B' : 'open');
  });
  listen('hello', () => {
    const limit = app.hello.limits?.upload;
    if (limit) $('#limit').textContent = `up to ${limit >> 20} MB`;
  });
}
