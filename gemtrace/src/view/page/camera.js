// Where points of the stone are in the picture.

import { app, side } from './app.js';
import { DEGREE, dot, minus, plus, turned } from './rotation.js';

/** The eye, at the distance that is under the hand. */
function eye({ camera, middle, distance }) {
  const k = app.distance / (distance || 1);
  return plus(middle, minus(camera.eye, middle), k);
}

/** Projects into a picture of this size: a function from a world point to [x, y, depth]; y down, depth in mm. */
export function projector(width, height, name = app.side) {
  const s = side(name);
  const { camera } = s, from = eye(s), perspective = camera.fov != null;
  const scale = perspective ? height / 2 / Math.tan(camera.fov / 2 * DEGREE) : height / camera.height;
  return point => {
    const d = minus(point, from), depth = dot(d, camera.forward);
    const k = perspective ? scale / Math.max(depth, 1e-6) : scale;
    return [width / 2 + k * dot(d, camera.right), height / 2 - k * dot(d, camera.up), depth];
  };
}

/** A point of the stone, as it lies at identity pose, in the world under the pose that is under the hand. */
export const placed = (point, s) => plus(s.middle, turned(app.pose, minus(point, s.middle)));

/** Whether a facet of this normal (identity pose) at this point is turned to the eye. */
export function faces(point, normal, s) {
  const { camera } = s, n = turned(app.pose, normal);
  return camera.fov == null ? dot(n, camera.forward) < 0 : dot(n, minus(eye(s), placed(point, s))) > 0;
}

/** The arcball's middle and radius in a picture of this size. */
export function arcball(width, height, name) {
  const s = side(name);
  const [x, y] = s ? projector(width, height, name)(s.middle) : [width / 2, height / 2];
  return { x, y, radius: 0.45 * Math.min(width, height) };
}
