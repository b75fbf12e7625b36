// Plots in SVG: a spectrum in steps as computed, a section through the stone, a curve over tilt.

import { cased, event } from './overlay.js';
import { number, svg } from './dom.js';

const text = (x, y, content, anchor, extra = {}) => svg('text', { x, y, 'text-anchor': anchor, ...extra }, content);
const rule = (x, y, to) => svg('path', { d: `M${x} ${y}H${to}`, stroke: '#333' });

/** About the colour of a wavelength (nm), dark enough for a white line over it. */
function hue(nm) {
  const bell = (middle, width) => Math.exp(-(((nm - middle) / width) ** 2));
  const channels = [bell(600, 70) + 0.3 * bell(415, 28), bell(545, 48), bell(455, 34)];
  return `rgb(${channels.map(c => Math.round(60 + 170 * c)).join()})`;
}

/** A round number at or above the value: 1, 2 or 5 times a power of ten. */
function above(value) {
  const power = 10 ** Math.floor(Math.log10(value || 1));
  return [1, 2, 5, 10].map(k => k * power).find(v => v >= value * 0.9999);
}

/** Limits of the cells of wavelengths: halfway between neighbours. */
function cells(nm) {
  const middle = nm.slice(1).map((w, i) => (w + nm[i]) / 2);
  const first = nm[0] - (nm.length > 1 ? middle[0] - nm[0] : 5);
  const last = nm.at(-1) + (nm.length > 1 ? nm.at(-1) - middle.at(-1) : 5);
  return [first, ...middle, last];
}

export function spectrum(plot, nm, radiance) {
  if (!nm?.length) return plot.replaceChildren();
  const top = above(Math.max(...radiance, 1e-6)), edge = cells(nm);
  const X = w => 36 + (w - edge[0]) / (edge.at(-1) - edge[0]) * 284;
  const Y = v => 104 - v / top * 92;
  const bars = radiance.map((v, i) => svg('rect', {
    x: X(edge[i]), width: X(edge[i + 1]) - X(edge[i]), y: Y(v), height: Math.max(0, 104 - Y(v)),
    fill: hue(nm[i]), 'fill-opacity': 0.55,
  }));
  const line = radiance.map((v, i) => `${i ? 'L' : 'M'}${X(edge[i])} ${Y(v)}H${X(edge[i + 1])}`).join('');
  const ticks = [400, 500, 600, 700].filter(w => w >= edge[0] && w <= edge.at(-1));
  plot.replaceChildren(
    ...[0, top / 2, top].flatMap(v => [rule(36, Y(v), 320), text(30, Y(v) + 4, `${Number(v.toPrecision(2))}`, 'end')]),
    ...bars, svg('path', { d: line, fill: 'none', stroke: '#fff', 'stroke-width': 1.5 }),
    ...ticks.map(w => text(X(w), 122, w, 'middle')), text(320, 122, 'nm', 'end'));
  const peak = nm[radiance.indexOf(Math.max(...radiance))];
  plot.setAttribute('aria-label', `Spectrum of the pixel, ${nm.length} wavelengths, highest at ${Math.round(peak)} nm`);
}

/** The stone cut through the plane of the path's first events, and the path in it. */
export function section(plot, { outline, points, from, to } = { outline: [], points: [] }) {
  if (!outline.length) return plot.replaceChildren();
  const us = outline.map(p => p[0]), vs = outline.map(p => p[1]);
  const [u0, u1, v0, v1] = [Math.min(...us), Math.max(...us), Math.min(...vs), Math.max(...vs)];
  const scale = Math.min(232 / (u1 - u0), 112 / (v1 - v0));
  const X = u => 164 + (u - (u0 + u1) / 2) * scale, Y = v => 98 - (v - (v0 + v1) / 2) * scale;
  const line = list => list.map(p => `${X(p[0]).toFixed(1)},${Y(p[1]).toFixed(1)}`).join(' ');
  plot.replaceChildren(
    svg('polygon', { points: line(outline), fill: '#2a2a2a', stroke: '#a8a8a8' }),
    ...cased('polyline', { points: line([from, ...points, to].filter(Boolean)) }),
    ...points.map((p, i) => event(X(p[0]), Y(p[1]), i)));
}

/** Curves over tilt, 0 to 100 %, always on the same axes: `lines` are [{ tilts, values, label, dashed }]. */
export function curves(plot, lines) {
  const all = lines.flatMap(l => l.values), low = Math.min(60, Math.floor(Math.min(...all, 100) / 20) * 20);
  const span = Math.max(...lines.flatMap(l => l.tilts.map(Math.abs)), 30);
  const X = t => 36 + (t + span) / (2 * span) * 280, Y = v => 148 - (v - low) / (100 - low) * 132;
  const path = ({ tilts, values }) => tilts.map((t, i) => `${i ? 'L' : 'M'}${X(t).toFixed(1)} ${Y(values[i]).toFixed(1)}`).join('');
  const levels = Array.from({ length: 5 }, (_, i) => low + i * (100 - low) / 4);
  const ends = lines.map(l => Y(l.values.at(-1)) + 4);
  if (ends.length === 2 && Math.abs(ends[0] - ends[1]) < 14) {
    const down = ends[0] > ends[1] ? 0 : 1, middle = (ends[0] + ends[1]) / 2;
    ends[down] = middle + 7;
    ends[1 - down] = middle - 7;
  }
  plot.replaceChildren(
    ...levels.flatMap(v => [rule(36, Y(v), 316), text(30, Y(v) + 4, v, 'end')]),
    ...[-1, -0.5, 0, 0.5, 1].map(k => text(X(k * span), 168, `${number(k * span)}°`, 'middle')),
    ...lines.flatMap((l, i) => [
      svg('path', {
        d: path(l), fill: 'none', stroke: l.dashed ? '#a8a8a8' : '#fff', 'stroke-width': l.dashed ? 1.5 : 2,
        'stroke-dasharray': l.dashed ? '4 4' : null,
      }),
      text(322, ends[i], l.label, 'start', { class: l.dashed ? '' : 'high' }),
    ]));
}
