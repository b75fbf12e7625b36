// What is drawn over the stone: its edges, the facet under the cursor, the path of a ray. White on black reads on any stone.

import { app, listen, side } from './app.js';
import { faces, placed, projector } from './camera.js';
import { connected } from './link.js';
import { frame, pictures, point } from './picture.js';
import { $, framed, svg } from './dom.js';
import { plus } from './rotation.js';

const layers = { A: $('#view-a .ov'), B: $('#view-b .ov') };

/** What to draw: an outline, and a path on the side where it was asked for. */
export const marks = { side: 'A', outline: null, path: null, pixel: null, hover: null };
let answered = 0;                          // when the last picture came
let ahead = false;                         // whether the stone was moved since

const text = points => points.map(p => `${p[0].toFixed(1)},${p[1].toFixed(1)}`).join(' ');

/** A shape twice: wide and black, then narrow and white. */
export function cased(tag, attributes, dash) {
  const line = (stroke, width) => svg(tag, {
    ...attributes, fill: 'none', stroke, 'stroke-width': width, 'stroke-linejoin': 'round', 'stroke-linecap': 'round',
  });
  const white = line('#fff', 1.5);
  if (dash) white.setAttribute('stroke-dasharray', dash);
  return [line('#000', 4), white];
}

/** A numbered event of a path; the same number is in the table. */
export function event(x, y, index) {
  return svg('g', { class: 'event', 'data-e': index },
    svg('circle', { cx: x.toFixed(1), cy: y.toFixed(1), r: 7.5 }),
    svg('text', { x: x.toFixed(1), y: (y + 3.5).toFixed(1), 'text-anchor': 'middle' }, index + 1));
}

/** The stone's edges show while there is no picture yet, or none that answers the hand. */
function edges(project, s) {
  const visible = { true: '', false: '' };
  for (const [a, b, n, m] of s.edges ?? []) {
    const front = !n || faces(a, n, s) || faces(a, m ?? n, s);
    const [p, q] = [a, b].map(e => project(placed(e, s)));
    visible[front] += `M${p[0].toFixed(1)} ${p[1].toFixed(1)}L${q[0].toFixed(1)} ${q[1].toFixed(1)}`;
  }
  const line = (d, stroke, width, opacity) =>
    svg('path', { d, fill: 'none', stroke, 'stroke-width': width, 'stroke-opacity': opacity });
  return [
    line(visible.false, '#e4e4e4', 1, 0.25),
    line(visible.true, '#000', 3, 0.35),
    line(visible.true, '#e4e4e4', 1, 0.9),
  ];
}

/** A ray from the first point towards the eye, through the events, and out. */
function path({ events, exit }, project, s, [x, y]) {
  const points = events.map(e => project(placed(e.point, s)));
  const line = [[x, y], ...points.slice(1)];
  if (exit && events.length) {
    const end = placed(plus(events.at(-1).point, exit, (s.size ?? 6.5) * 0.25), s);
    line.push(project(end));
  }
  return [
    ...cased('polyline', { points: text(line) }, '5 3'),
    ...points.slice(1).map((p, i) => event(p[0], p[1], i + 1)),
    ...cased('path', { d: `M${x - 14} ${y}h9m10 0h9M${x} ${y - 14}v9m0 10v9` }),
  ];
}

function late(name) {
  if (!pictures[name].header) return true;
  return ahead && (!connected() || performance.now() - answered > 400);
}

function drawSide(name) {
  const layer = layers[name], s = side(name);
  if (!s?.camera) return layer.replaceChildren();
  const f = frame(name);
  if (!f.width) return;
  const inside = projector(f.width, f.height, name), shapes = [];
  const project = p => { const [x, y] = inside(p); return [x + f.x, y + f.y]; };
  if (late(name)) shapes.push(...edges(project, s));
  if (marks.side === name) {
    const outline = marks.outline ?? marks.hover;
    if (outline) shapes.push(...cased('polygon', { points: text(outline.map(p => project(placed(p, s)))) }));
    if (marks.path && marks.pixel) shapes.push(...path(marks.path, project, s, point(...marks.pixel)));
  }
  layer.replaceChildren(...shapes);
}

export const redraw = framed(() => { drawSide('A'); if (app.state?.compare) drawSide('B'); });

export function start() {
  for (const type of ['state', 'pose', 'layout', 'compare']) listen(type, redraw);
  let late = 0;
  listen('pose', () => { ahead = true; clearTimeout(late); late = setTimeout(redraw, 450); });
  listen('shown', () => { answered = performance.now(); ahead = Boolean(app.gesture); redraw(); });
  listen('lost', redraw);
}
