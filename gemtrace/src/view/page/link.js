// The connection to the server. What moves is sent once a frame, newest only; nothing is queued while it is lost.

import { address, app, listen, next, tell } from './app.js';

const retries = [1, 2, 4, 8, 15];
let socket = null;
let failures = 0;
let pending = new Map();
let scheduled = false;
let measure = () => [512, 512];
let clock = 0;

export const connected = () => socket?.readyState === WebSocket.OPEN;

/** Sends now, after what still waits for its frame. Without a connection the message is not kept, and the answer is false. */
export function send(message) {
  if (!connected()) return false;
  drain();
  socket.send(JSON.stringify(message));
  return true;
}

/** Sends in the next frame; a later message of the same key replaces it. */
export function newest(key, message) {
  pending.set(key, message);
  schedule();
}

/** A change of a setting: `done` ends a step of undo. */
export function set(path, value, done = true, side = app.side) {
  const id = next();
  performance.mark(`gemtrace:${id}`);
  newest(`set ${path} ${side}`, { type: 'set', id, path, value, side, done });
}

function schedule() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(flush);
}

function flush() {
  scheduled = false;
  if (!connected()) return;                                    // they wait for the connection, one of each kind
  if (socket.bufferedAmount > 1 << 16) return schedule();      // a slow line: the newest may still replace them
  drain();
}

function drain() {
  for (const message of pending.values()) socket.send(JSON.stringify(message));
  pending.clear();
}

/** The first 4 bytes are the length of the JSON header; the picture follows it. */
function picture(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  tell('picture', { header, bytes: new Uint8Array(buffer, 4 + length) });
}

function receive({ data }) {
  if (typeof data !== 'string') return picture(data);
  const message = JSON.parse(data);
  if (message.type === 'hello') {
    failures = 0;
    app.hello = message;
  }
  if (message.type === 'state') {
    app.state = message;
    if (!message.sides[app.side]) app.side = 'A';              // the second stone was put away
  }
  tell(message.type, message);
}

function open() {
  const url = address('live');
  url.protocol = url.protocol.replace('http', 'ws');
  const own = socket = new WebSocket(url);
  own.binaryType = 'arraybuffer';
  own.onopen = () => {
    const [width, height] = measure();
    own.send(JSON.stringify({ type: 'hello', protocol: 1, width, height, embed: app.embed }));
    tell('connected');
    schedule();
  };
  own.onmessage = e => own === socket && receive(e);
  own.onclose = () => own === socket && lost();
}

/** Tries again after 1, 2, 4, 8, then every 15 seconds, and tells the seconds that are left. */
function lost() {
  socket = null;
  let left = retries[Math.min(failures++, retries.length - 1)];
  clearInterval(clock);
  const tick = () => {
    if (left <= 0) return retry();
    tell('lost', left--);
  };
  tick();
  clock = setInterval(tick, 1000);
  if (failures === 2) refused();
}

function retry() {
  clearInterval(clock);
  if (!socket) open();
}

/** A server that was started again has another token: no retry helps. */
async function refused() {
  const answer = await fetch(address('./')).catch(() => null);
  if (answer?.status !== 403) return;
  tell('error', {
    what: 'The connection was refused.',
    why: 'The program was started again and has a new address: open the one that it prints.',
    unchanged: 'The last picture stays.',
  });
}

/** Connects; `size` answers the device pixels of one view. */
export function connect(size) {
  measure = size;
  open();
  window.addEventListener('online', retry);
  window.addEventListener('offline', () => socket?.close());
  document.addEventListener('visibilitychange', () => document.hidden || retry());
  listen('retry', retry);
}
