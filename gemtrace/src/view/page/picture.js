// Pictures onto the canvas of a side: only whole ones, the old one stays until the new one is there.

import { app, listen, tell } from './app.js';
import { connected, send } from './link.js';
import { $ } from './dom.js';

/** Of each side: the canvas, the last picture's header, and the size of the last whole picture. */
export const pictures = {
  A: { canvas: $('#view-a canvas'), header: null, size: null },
  B: { canvas: $('#view-b canvas'), header: null, size: null },
};

let full = [512, 512];                       // device pixels of one view

const ratio = () => Math.min(devicePixelRatio || 1, 2);

/** The device pixels of one view as it lies on the screen. */
export function measured() {
  const box = $('#view-a').getBoundingClientRect();
  full = [box.width, box.height].map(v => Math.max(16, Math.round(v * ratio())));
  return full;
}

/** Where the picture of a side lies in its view, CSS pixels. Another window may have asked for another size. */
export function frame(name) {
  const { canvas, header } = pictures[name], view = canvas.parentNode;
  const [width, height] = header ? [canvas.offsetWidth, canvas.offsetHeight] : [view.clientWidth, view.clientHeight];
  return { x: (view.clientWidth - width) / 2, y: (view.clientHeight - height) / 2, width, height };
}

/** A point of a view in CSS pixels, in device pixels; and the middle of a device pixel in CSS pixels. */
export const pixel = (x, y) => [x * ratio(), y * ratio()].map(Math.floor);
export const point = (x, y) => [x, y].map(v => (v + 0.5) / ratio());

/** The size of a view, for questions about its pixels: the server may not know it yet. */
export const viewed = () => ({ width: full[0], height: full[1] });

/** The picture's scale is that of its smaller side, so a picture of an older size lies where it belongs. */
function place({ canvas }) {
  const { width, height } = canvas;
  const scale = Math.min(...full) / Math.min(width, height) / ratio();
  const fills = Math.abs(width / height / (full[0] / full[1]) - 1) < 0.02;
  canvas.style.width = `${fills ? full[0] / ratio() : width * scale}px`;
  canvas.style.height = `${fills ? full[1] / ratio() : height * scale}px`;
}

async function decode({ format, width, height }, bytes) {
  if (format === 'rgba') {
    const pixels = new Uint8ClampedArray(bytes.buffer, bytes.byteOffset, 4 * width * height);
    return new ImageData(pixels, width, height);
  }
  return createImageBitmap(new Blob([bytes], { type: 'image/png' }), { colorSpaceConversion: 'none' });
}

function draw(canvas, image) {
  canvas.width = image.width;                // clears, but nothing is shown before this function ends
  canvas.height = image.height;
  const context = canvas.getContext('2d');
  if (image instanceof ImageData) return context.putImageData(image, 0, 0);
  context.drawImage(image, 0, 0);
  image.close();
}

/** The time from an event to its picture, kept in the browser's performance entries for whoever measures. */
function timed({ answers }) {
  for (const { name } of performance.getEntriesByType('mark')) {
    const id = Number(name.split(':')[1]);
    if (!(id <= answers)) continue;
    if (id === answers) performance.measure('gemtrace', { start: name, detail: id });
    performance.clearMarks(name);
  }
  if (performance.getEntriesByName('gemtrace').length > 500) performance.clearMeasures('gemtrace');
}

async function show({ header, bytes }) {
  const name = header.side ?? 'A', own = pictures[name];
  try {
    const image = await decode(header, bytes);
    draw(own.canvas, image);
    own.header = header;
    if (['refining', 'settled'].includes(header.stage)) own.size = [header.width, header.height];
    place(own);
    timed(header);
    tell('shown', header);
  } catch (error) {
    console.error(error);                    // a picture that cannot be read is left out; the next one is asked for
  }
  send({ type: 'shown', answers: header.answers, side: name });
}

/** Layout has changed: the old pictures are placed anew, and the server is told. */
function resized() {
  const before = full.join();
  if (measured().join() === before) return;
  for (const own of Object.values(pictures)) if (own.header) place(own);
  if (connected()) send({ type: 'size', width: full[0], height: full[1] });
  tell('layout');
}

export function start() {
  measured();
  listen('picture', show);
  listen('hello', () => { const before = full.join(); if (measured().join() !== before) resized(); });
  new ResizeObserver(resized).observe($('#view-a'));
  listen('state', () => { if (!app.state.compare) pictures.B.header = null; });
}
