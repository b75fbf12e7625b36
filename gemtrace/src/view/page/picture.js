// Pictures onto the canvas of a side: only whole ones, the old one stays until the new one is there.

import { app, listen, tell } from './app.js';
import { connected, send } from './link.js';
import { $ } from './dom.js';

/** Of each side: the canvas, the last header, and whether a picture has been drawn. */
export const pictures = {
  A: { canvas: $('#view-a canvas'), header: null },
  B: { canvas: $('#view-b canvas'), header: null },
};

let full = [512, 512];                       // device pixels of one view

const ratio = () => Math.min(devicePixelRatio || 1, 2);

/** The device pixels of one view as it lies on the screen. */
export function measured() {
  const box = $('#view-a').getBoundingClientRect();
  full = [box.width, box.height].map(v => Math.max(16, Math.round(v * ratio())));
  return full;
}

/** A point in CSS pixels of a view in pixels of the full picture. */
export const pixel = (x, y) => [x * ratio(), y * ratio()].map(Math.floor);

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

/** The time from a message to its picture, as `gemtrace` measures in the browser's performance entries. */
function timed({ answers }) {
  const mark = `gemtrace:${answers}`;
  if (!answers || !performance.getEntriesByName(mark, 'mark').length) return;
  performance.measure('gemtrace', { start: mark, detail: answers });
  performance.clearMarks();
  if (performance.getEntriesByName('gemtrace').length > 500) performance.clearMeasures('gemtrace');
}

async function show({ header, bytes }) {
  const name = header.side ?? 'A', own = pictures[name];
  try {
    const image = await decode(header, bytes);
    draw(own.canvas, image);
    own.header = header;
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

/** The colour of a pixel of the canvas, 0 to 255 each, with alpha. */
export function sample(name, x, y) {
  const { canvas } = pictures[name];
  const k = canvas.width / full[0], l = canvas.height / full[1];
  return canvas.getContext('2d').getImageData(Math.floor(x * k), Math.floor(y * l), 1, 1).data;
}
