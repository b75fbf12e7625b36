// The loupe: the pixels under the cursor, four times as large, while L is held or a finger rests.

import { listen } from './app.js';
import { pictures } from './picture.js';
import { $ } from './dom.js';

const lens = $('#loupe');
let at = null;

function draw() {
  if (!at) return;
  const { view, x, y } = at, own = pictures[view.dataset.side];
  const box = view.getBoundingClientRect(), picture = own.canvas.getBoundingClientRect();
  const k = own.canvas.width / picture.width, size = lens.width / 4;
  const context = lens.getContext('2d');
  context.imageSmoothingEnabled = false;
  context.clearRect(0, 0, lens.width, lens.height);
  const [u, v] = [(box.x + x - picture.x) * k, (box.y + y - picture.y) * k];
  context.drawImage(own.canvas, u - size / 2, v - size / 2, size, size, 0, 0, lens.width, lens.height);
  const half = lens.offsetWidth / 2;
  lens.style.left = `${box.x + x - half}px`;
  lens.style.top = `${Math.max(0, box.y + y - half - (at.touch ? half + 24 : 0))}px`;
}

/** Shows the loupe at a point of a view, or hides it. */
export function loupe(point) {
  at = point;
  lens.hidden = !at;
  if (at) requestAnimationFrame(draw);
}

export const magnifies = () => !lens.hidden;

export function start() {
  listen('loupe', point => loupe(point && { ...point, touch: true }));
  listen('hovered', point => at && !at.touch && point && loupe(point));
  listen('shown', draw);
}
