// The status line: the stage by word and icon, figures in cells of fixed width, and the hairline of refinement.

import { app, listen } from './app.js';
import { pictures } from './picture.js';
import { $, number, say, short } from './dom.js';

const words = {
  start: ['First picture', 'tone'], moving: ['Turning', 'sun'], refining: ['Refining', 'tone'],
  settled: ['Settled', 'ok'], failed: ['Device failed', 'warn'],
};
const bar = $('#progress');
let latest = {}, first = null, speak = 0, offline = false;

function stage(word, icon) {
  $('#stage-word').textContent = word;
  $('#stage-icon').setAttribute('href', `#i-${icon}`);
  clearTimeout(speak);
  speak = setTimeout(say, 400, word);
}

/** The share of the way: ΔE on a logarithmic scale down to the tolerance, never backwards. */
function progress(s) {
  if (s.stage === 'settled') return 1;
  if (s.stage !== 'refining') { first = null; return 0; }
  let share = s.of > 1 ? 0.9 * Math.log(Math.max(1, s.samples)) / Math.log(s.of) : 0;
  if (s.delta_e > 0 && s.tolerance) {
    first = Math.max(first ?? s.delta_e, s.delta_e);
    share = first > s.tolerance ? Math.log(first / s.delta_e) / Math.log(first / s.tolerance) : share;
  }
  return Math.min(0.98, Math.max(bar.value < 1 ? bar.value : 0, share, 0.02));
}

/** 0.0023 %, or 0.12 %: two digits. */
function percent(share) {
  if (share == null) return '–';
  const value = share * 100;
  return `${value === 0 ? '0' : value < 1e-4 ? '< 0.0001' : Number(value.toPrecision(2))} %`;
}

/** Settled is what is seen: the figures may be ahead of the picture. */
function seen(name) {
  const s = latest[name], header = pictures[name].header;
  const ahead = s?.stage === 'settled' && !(header?.stage === 'settled' && (header.answers ?? 0) >= (s.answers ?? 0));
  const still = s?.stage === 'moving' && !app.gesture;       // the first coarse frames, with no hand on the stone
  return ahead || still ? { ...s, stage: pictures[name].size ? 'refining' : 'start' } : s;
}

function show() {
  if (offline) return;
  const s = seen(app.side);
  if (!s) return;
  const [word, icon] = words[s.stage] ?? words.refining;
  stage(s.stage === 'moving' ? app.gesture ?? word : word, icon);
  bar.value = progress(s);
  bar.toggleAttribute('data-done', s.stage === 'settled');
  $('#samples').textContent = s.samples ? `${number(s.samples)} / ${number(s.of)}` : '–';
  $('#delta').textContent = number(s.delta_e, 2);
  $('#rays').textContent = s.stage === 'settled' ? '–' : short(s.rays_per_second);
  $('#dropped').textContent = percent(s.dropped);
  $('#device').textContent = s.device || app.hello?.device || '–';
  for (const name of ['A', 'B']) {
    const busy = latest[name] && !settled(name);
    $(`#view-${name.toLowerCase()}`).setAttribute('aria-busy', String(Boolean(busy)));
  }
}

function lost(seconds) {
  offline = true;
  stage('Connection lost', 'warn');
  $('#retry').textContent = `again in ${seconds} s`;
  $('#retry').hidden = false;
  $('#rays').textContent = '–';
  $('#view-a').setAttribute('aria-busy', 'true');
}

export function start() {
  listen('status', message => {
    if (latest[message.side]?.answers !== message.answers) first = null;
    if (message.stage === 'moving' || message.stage === 'start') bar.value = 0;
    latest[message.side] = message;
    show();
  });
  listen('connected', () => { offline = false; latest = {}; $('#retry').hidden = true; });
  listen('hello', () => { $('#device').textContent = app.hello.device; });
  listen('shown', show);
  listen('lost', lost);
  listen('side', show);
}

export const settled = name => seen(name)?.stage === 'settled';
