// The page inside another one: messages { gemtrace: 1, id, type, … } from and to the window that embeds it.

import { address, app, listen, next, side } from './app.js';
import { lights, pose } from './gesture.js';
import { send, set } from './link.js';
import { upload } from './open.js';

const query = new URLSearchParams(location.search);
const named = () => { try { return new URL(query.get('origin') ?? document.referrer).origin; } catch { return null; } };
const origin = named();
const inspected = new Map();         // our number of a pixel → the message that asked

function post(type, values = {}, transfer = []) {
  if (origin && parent !== window) parent.postMessage({ gemtrace: 1, type, ...values }, origin, transfer);
}

const refuse = (id, code, message) => post('error', { id, code, message });
const numbers = (list, count) => Array.isArray(list) && list.length === count && list.every(Number.isFinite);

const commands = {
  set({ id, path, value }) {
    if (typeof path !== 'string') return refuse(id, 'value', '`path` is the name of a setting, such as "material".');
    if (path === 'rotation' && Number.isFinite(value)) return lights(value, true);
    set(path, value);
  },
  pose({ id, quaternion }) {
    const length = numbers(quaternion, 4) ? Math.hypot(...quaternion) : 0;
    if (Math.abs(length - 1) > 1e-3) return refuse(id, 'value', '`quaternion` has four numbers [x, y, z, w] of length 1.');
    pose(quaternion.map(v => v / length), true);
  },
  async load({ id, name, bytes }) {
    if (typeof name !== 'string' || !bytes) return refuse(id, 'value', '`name` is a file name and `bytes` an ArrayBuffer.');
    if (await upload(new File([bytes], name))) post('loaded', { id });
  },
  async save({ id, format = 'png' }) {
    const answer = await fetch(address('save', { format, side: 'A' })).catch(() => null);
    if (!answer?.ok) return refuse(id, 'save', `The ${format} could not be made.`);
    const bytes = await answer.arrayBuffer();
    post('saved', { id, format, bytes }, [bytes]);
  },
  inspect({ id, x, y }) {
    if (!numbers([x, y], 2)) return refuse(id, 'value', '`x` and `y` are pixels of the picture.');
    const own = next();
    inspected.set(own, { id, x: Math.floor(x), y: Math.floor(y) });
    send({ type: 'inspect', id: own, side: 'A', x: Math.floor(x), y: Math.floor(y) });
  },
};

function receive({ data, source, origin: from }) {
  if (source !== parent || from !== origin || data?.gemtrace !== 1) return;
  const command = Object.hasOwn(commands, data.type) ? commands[data.type] : null;
  if (!command) return refuse(data.id, 'type', `There is no message ${String(data.type)}: set, pose, load, save, inspect.`);
  command(data);
}

function answers() {
  let ready = false;
  listen('state', () => {
    if (!ready) post('ready', { protocol: 1, size: app.size });
    ready = true;
  });
  listen('status', s => post('state', { stage: s.stage, samples: s.samples, deltaE: s.delta_e }));
  listen('pose', () => post('pose', { quaternion: app.pose }));
  listen('state', () => post('pose', { quaternion: side('A').pose }));
  listen('error', ({ code, what, where, why }) => refuse(null, code ?? 'input', [what, where, why].filter(Boolean).join(' ')));
  listen('pixel', pixel => {
    if (!inspected.has(pixel.id)) return;
    post('pixel', {
      ...inspected.get(pixel.id), colour: pixel.colour, path: pixel.path,
      spectrum: { wavelengths: pixel.wavelengths, radiance: pixel.radiance },
    });
    inspected.delete(pixel.id);
  });
}

export function start() {
  if (!app.embed) return;
  addEventListener('message', receive);
  answers();
}
