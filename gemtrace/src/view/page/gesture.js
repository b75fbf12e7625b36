// Turning, lights and distance by pointer, wheel and keys. One drag is one step of undo.

import { app, listen, next, side, tell } from './app.js';
import { arcball } from './camera.js';
import { newest } from './link.js';
import { $, clamp } from './dom.js';
import { about, ball, between, times, DEGREE } from './rotation.js';

const CLICK = 4;                 // CSS pixels: less is a click
const HOLD = 500;                // milliseconds to a loupe
const pointers = new Map();
let press = null;                // where the first pointer went down, and what it has done
let pinch = null;
let rest = 0;                    // the timer that ends a gesture of keys or wheel
let since = 0;                   // when the event came that is being answered, for the page's own timings

function post(type, values, done) {
  const id = app.moved = next();
  performance.mark(`gemtrace:${id}`, { startTime: since || performance.now() });
  since = 0;
  newest(type, { type, id, ...values, done });
  app.gesture = done ? null : { pose: 'Turning', lights: 'Lights', distance: 'Distance' }[type];
  tell('pose', type);
}

export const pose = (rotation, done = false) => { app.pose = rotation; post('pose', { rotation }, done); };
export const lights = (rotation, done = false) => {
  app.lights = ((rotation % 360) + 360) % 360;
  post('lights', { rotation: app.lights }, done);
};
export const distance = (factor, done = false) => {
  app.distance = clamp(factor, 0.1, 10);
  post('distance', { factor: app.distance }, done);
};

/** Ends what keys or the wheel have moved, once they have rested. */
function settle(type) {
  clearTimeout(rest);
  rest = setTimeout(() => {
    if (type === 'pose') pose(app.pose, true);
    else if (type === 'lights') lights(app.lights, true);
    else distance(app.distance, true);
  }, 400);
}

/** A rotation about axes of the picture (right, up, towards the eye), in the world. */
function turn([x, y, z, w], done) {
  const { camera } = side();
  const axis = [0, 1, 2].map(i => x * camera.right[i] + y * camera.up[i] - z * camera.forward[i]);
  pose(times([...axis, w], app.pose), done);
}

function drag(e, view) {
  const box = view.getBoundingClientRect(), factor = e.altKey ? 0.1 : 1;
  const centre = arcball(box.width, box.height, view.dataset.side);
  const [x, y] = [e.clientX - box.x, e.clientY - box.y];
  const at = (u, v) => [(u - centre.x) / centre.radius, (centre.y - v) / centre.radius];
  if (e.shiftKey) {
    press.type = 'lights';
    lights(app.lights + (x - press.x) * 0.5 * factor);
  } else if (e.ctrlKey || e.metaKey) {
    const angle = ([u, v]) => Math.atan2(v, u);
    turn(about([0, 0, 1], (angle(at(x, y)) - angle(at(press.x, press.y))) * factor));
  } else turn(between(ball(...at(press.x, press.y)), ball(...at(x, y)), factor));
  press.x = x;
  press.y = y;
}

/** Two fingers: their distance is the distance, their twist turns the lights. */
function pinched() {
  const [a, b] = [...pointers.values()];
  const now = { length: Math.hypot(a.x - b.x, a.y - b.y), angle: Math.atan2(b.y - a.y, b.x - a.x) };
  if (pinch) {
    distance(app.distance * pinch.length / now.length);
    const twist = Math.atan2(Math.sin(now.angle - pinch.angle), Math.cos(now.angle - pinch.angle));
    if (Math.abs(twist) > 1e-4) { press.twisted = true; lights(app.lights - twist / DEGREE); }
    press.type = 'pinch';
  }
  pinch = now;
}

function down(e) {
  if (e.button || !side()?.camera) return;
  const view = e.currentTarget, box = view.getBoundingClientRect();
  view.setPointerCapture(e.pointerId);
  pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
  if (pointers.size > 1) { clearTimeout(press?.hold); return; }
  const [x, y] = [e.clientX - box.x, e.clientY - box.y];
  press = { x, y, from: [x, y], moved: false, type: 'pose', touch: e.pointerType === 'touch' };
  if (press.touch) press.hold = setTimeout(() => { press.loupe = true; tell('loupe', { view, x, y }); }, HOLD);
}

function move(e) {
  const view = e.currentTarget, box = view.getBoundingClientRect();
  const [x, y] = [e.clientX - box.x, e.clientY - box.y];
  tell('hovered', { view, x, y });
  if (!press || !pointers.has(e.pointerId)) return;
  pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
  if (pointers.size === 2) return pinched();
  if (press.loupe) return tell('loupe', { view, x, y });
  if (press.type === 'pinch') return;
  press.moved ||= Math.hypot(x - press.from[0], y - press.from[1]) >= CLICK;
  if (!press.moved) return;
  clearTimeout(press.hold);
  since = e.timeStamp;
  drag(e, view);
}

function up(e) {
  if (!pointers.delete(e.pointerId) || !press) return;
  clearTimeout(press.hold);
  pinch = null;
  if (pointers.size) return;
  const own = press, view = e.currentTarget;
  press = null;
  if (own.loupe) return tell('loupe', null);
  if (own.type === 'pinch') {
    if (own.twisted) lights(app.lights, true);
    return distance(app.distance, true);
  }
  if (own.moved) return own.type === 'lights' ? lights(app.lights, true) : pose(app.pose, true);
  adopt();
  if (e.type === 'pointerup') clicked(view, own.from);
}

/** One click inspects, two turn the table to the eye. The first waits for the second only where it would move the layout. */
let click = null;
function clicked(view, [x, y]) {
  const now = performance.now();
  if (click && now - click.time < 350) {
    clearTimeout(click.timer);
    click = null;
    return tell('face-up');
  }
  const go = () => tell('inspect', { view, x, y });
  click = { time: now, timer: app.dock === 'inspect' ? void go() : setTimeout(go, 300) };
}

function wheel(e) {
  if (app.embed && document.activeElement !== e.currentTarget || !side()?.camera) return;
  e.preventDefault();
  const lines = e.deltaMode === 1 ? 16 : 1;
  distance(app.distance * Math.exp(e.deltaY * lines * 0.001 * (e.altKey ? 0.1 : 1)));
  settle('distance');
}

const arrows = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] };

function keyed(e) {
  if (e.ctrlKey || e.metaKey || !side()?.camera) return;
  const angle = e.altKey ? 0.5 : 5, arrow = arrows[e.key];
  if (arrow && e.shiftKey) { lights(app.lights + (arrow[1] - arrow[0]) * angle); settle('lights'); }
  else if (arrow) { turn(about([arrow[0], arrow[1], 0], angle * DEGREE)); settle('pose'); }
  else if (e.key === 'PageUp' || e.key === 'PageDown') {
    turn(about([0, 0, 1], (e.key === 'PageUp' ? angle : -angle) * DEGREE));
    settle('pose');
  } else if ('+=-−'.includes(e.key)) {
    distance(app.distance * ('+='.includes(e.key) ? 1 / 1.1 : 1.1) ** (e.altKey ? 0.1 : 1));
    settle('distance');
  } else return;
  e.preventDefault();
}

/** The server's pose counts while no hand is on the stone. */
function adopt() {
  if (press || app.gesture) return;
  const s = side('A');
  app.pose = s.pose;
  app.lights = s.rotation;
  app.distance = s.distance;
}

export function start() {
  for (const view of [$('#view-a'), $('#view-b')]) {
    const events = { pointerdown: down, pointermove: move, pointerup: up, pointercancel: up, keydown: keyed };
    for (const [type, f] of Object.entries(events)) view.addEventListener(type, f);
    view.addEventListener('wheel', wheel, { passive: false });
    view.addEventListener('pointerleave', () => tell('hovered', null));
    view.addEventListener('contextmenu', e => press && e.preventDefault());
  }
  listen('state', adopt);
}

