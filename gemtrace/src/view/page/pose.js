// The pose plate: the table's normal on a dial, and tilt, turn and lights as numbers, so that nothing needs dragging.

import { app, listen, side } from './app.js';
import { lights, pose } from './gesture.js';
import { numeric } from './field.js';
import { $, framed, number, svg } from './dom.js';
import { angles, DEGREE, posed, wrap } from './rotation.js';

const fields = { tilt: $('#tilt'), turn: $('#turn'), lights: $('#lights') };
const digits = { tilt: 1, turn: 1, lights: 0 };

const rings = () => [10, 30, 60, 90].map(t =>
  svg('circle', { r: t / 90 * 40, fill: 'none', stroke: t === 90 ? '#7a7a7a' : '#4a4a4a' }));

function dial({ tilt, side: azimuth }) {
  const r = tilt / 90 * 40, a = azimuth * DEGREE;
  const [x, y] = [r * Math.cos(a), -r * Math.sin(a)].map(v => v.toFixed(2));
  const l = (app.lights - 90) * DEGREE;
  $('#dial').replaceChildren(...rings(),
    svg('path', { d: 'M-40 0H40M0-40V40', stroke: '#3a3a3a' }),
    svg('path', { d: `M0 0L${x} ${y}`, stroke: '#fff', 'stroke-width': 1.5 }),
    svg('path', { d: `M${x} ${y}m-5 0l5-5 5 5-5 5z`, fill: '#fff', stroke: '#181818' }),
    svg('circle', {
      r: 3.5, cx: (44 * Math.cos(l)).toFixed(2), cy: (44 * Math.sin(l)).toFixed(2),
      fill: '#181818', stroke: '#fff', 'stroke-width': 1.5,
    }));
}

const values = () => {
  const now = angles(app.pose, side());
  return { ...now, lights: app.lights };
};

const show = framed(() => {
  if (!side()?.camera) return;
  const now = values();
  for (const name in fields) {
    if (document.activeElement === fields[name] && fields[name].dataset.typing) continue;
    fields[name].value = `${number(now[name], digits[name])}°`;
  }
  dial(now);
  label(now);
});

/** Views are named by material, cut and tilt. */
function label({ tilt }) {
  for (const name of ['A', 'B']) {
    const s = side(name);
    if (!s) continue;
    const material = app.hello?.lists.materials.find(m => m.id === s.material)?.label ?? s.material_name ?? s.material;
    $(`#view-${name.toLowerCase()}`).setAttribute('aria-label', `${material}, ${s.name}, tilted ${Math.round(tilt)}°`);
  }
}

function write(name, value) {
  if (!side()?.camera) return;
  if (name === 'lights') return lights(value);
  const now = values();
  pose(posed({ ...now, [name]: name === 'tilt' ? Math.min(180, Math.max(-180, value)) : wrap(value) }, side()));
}

export function start() {
  for (const [name, input] of Object.entries(fields)) {
    numeric(input, {
      step: 1,
      read: () => ({ value: side() ? values()[name] : 0, text: side() ? `${number(values()[name], digits[name])}°` : '' }),
      write: value => write(name, value),
      done: () => (name === 'lights' ? lights(app.lights, true) : pose(app.pose, true)),
    });
  }
  for (const type of ['state', 'pose', 'side']) listen(type, show);
}
