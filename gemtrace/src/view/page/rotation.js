// Rotations as unit quaternions [x, y, z, w], the arcball, and the angles that people read.

export const DEGREE = Math.PI / 180;

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const minus = (a, b) => a.map((v, i) => v - b[i]);
export const plus = (a, b, k = 1) => a.map((v, i) => v + k * b[i]);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const unit = a => { const n = Math.hypot(...a) || 1; return a.map(v => v / n); };

/** The rotation by `angle` (radians) about a unit axis. */
export function about(axis, angle) {
  const s = Math.sin(angle / 2);
  return [axis[0] * s, axis[1] * s, axis[2] * s, Math.cos(angle / 2)];
}

/** First b, then a. */
export function times(a, b) {
  const [x, y, z, w] = a, [X, Y, Z, W] = b;
  return unit([
    w * X + x * W + y * Z - z * Y,
    w * Y - x * Z + y * W + z * X,
    w * Z + x * Y - y * X + z * W,
    w * W - x * X - y * Y - z * Z,
  ]);
}

export const inverse = q => [-q[0], -q[1], -q[2], q[3]];

/** A vector turned by q. */
export function turned(q, v) {
  const t = cross(q, v).map(c => 2 * c);
  return plus(plus(v, t, q[3]), cross(q, t));
}

/** Holroyd's arcball: a sphere inside, a hyperbola outside, so that nothing snaps at the rim. x, y in radii, y up. */
export function ball(x, y) {
  const d = x * x + y * y;
  return unit([x, y, d < 0.5 ? Math.sqrt(1 - d) : 0.5 / Math.sqrt(d)]);
}

/** The rotation from one direction to another, its angle times `factor`. */
export function between(a, b, factor = 1) {
  const axis = cross(a, b), s = Math.hypot(...axis);
  return s < 1e-12 ? [0, 0, 0, 1] : about(axis.map(v => v / s), Math.atan2(s, dot(a, b)) * factor);
}

/** The rotation that turns x, y, z into three perpendicular unit vectors. */
export function basis([a, b, c]) {
  const [m00, m11, m22] = [a[0], b[1], c[2]];
  if (m00 + m11 + m22 > 0) return unit([b[2] - c[1], c[0] - a[2], a[1] - b[0], 1 + m00 + m11 + m22]);
  if (m00 > m11 && m00 > m22) return unit([1 + m00 - m11 - m22, b[0] + a[1], c[0] + a[2], b[2] - c[1]]);
  if (m11 > m22) return unit([b[0] + a[1], 1 + m11 - m00 - m22, c[1] + b[2], c[0] - a[2]]);
  return unit([c[0] + a[2], c[1] + b[2], 1 + m22 - m00 - m11, a[1] - b[0]]);
}

/** The picture's axes right, up and towards the eye, in the world. */
const towards = ({ right, up, forward }) => basis([right, up, forward.map(v => -v)]);

/** A pose as a person says it: how far the table is tilted from the line of sight and to which side, and its turn about its normal. */
export function angles(pose, { camera, normal = [0, 0, 1] }) {
  const level = between([0, 0, 1], unit(normal));
  const seen = times(inverse(towards(camera)), times(pose, level));
  const n = turned(seen, [0, 0, 1]);
  const swing = between([0, 0, 1], n);
  const spin = times(inverse(swing), seen);
  const tilt = Math.acos(Math.min(1, Math.max(-1, n[2]))) / DEGREE;
  const turn = 2 * Math.atan2(spin[2], spin[3]) / DEGREE;
  const flat = Math.hypot(n[0], n[1]) < 1e-6;
  return { tilt, side: flat ? 90 : Math.atan2(n[1], n[0]) / DEGREE, turn: wrap(turn), n };
}

/** The pose of these angles. */
export function posed({ tilt, side, turn }, { camera, normal = [0, 0, 1] }) {
  const axis = [-Math.sin(side * DEGREE), Math.cos(side * DEGREE), 0];
  const seen = times(about(axis, tilt * DEGREE), about([0, 0, 1], turn * DEGREE));
  const level = between([0, 0, 1], unit(normal));
  return times(times(towards(camera), seen), inverse(level));
}

/** Degrees from −180 to 180. */
export const wrap = degrees => degrees - 360 * Math.round(degrees / 360);
