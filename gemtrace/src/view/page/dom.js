// Short names for the DOM, and the number formats of the page.

export const $ = (selector, root = document) => root.querySelector(selector);
export const $$ = (selector, root = document) => [...root.querySelectorAll(selector)];

function build(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === true) node.setAttribute(name, '');
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}

/** An HTML element with attributes and children. */
export const el = (tag, attributes = {}, ...children) =>
  build(document.createElement(tag), attributes, children);

/** An SVG element with attributes and children. */
export const svg = (tag, attributes = {}, ...children) =>
  build(document.createElementNS('http://www.w3.org/2000/svg', tag), attributes, children);

/** An icon of the sprite in index.html. */
export const icon = (name, classes = '') =>
  svg('svg', { class: `i ${classes}`, 'aria-hidden': 'true' }, svg('use', { href: `#i-${name}` }));

/** Text spoken by screen readers, once. */
export function say(text) {
  const node = $('#say');
  if (node.textContent !== text) node.textContent = text;
}

/** A number with fixed digits and a real minus sign; `sign` also writes a plus. */
export function number(value, digits = 0, sign = false) {
  if (value == null || !Number.isFinite(value)) return '–';
  const text = Math.abs(value).toFixed(digits);
  const zero = Number(text) === 0;
  return (zero ? '' : value < 0 ? '−' : sign ? '+' : '') + text;
}

/** A number that a person wrote: comma or point, any minus, a unit behind it. NaN if it is none. */
export const parse = text =>
  parseFloat(text.trim().replace('−', '-').replace(',', '.'));

/** A large number with a prefix: 21.9 M. */
export function short(value) {
  if (!value || !Number.isFinite(value)) return '–';
  const step = Math.min(4, Math.max(0, Math.floor(Math.log10(value) / 3)));
  const scaled = value / 1000 ** step;
  return `${scaled.toFixed(scaled < 100 && step ? 1 : 0)} ${['', 'k', 'M', 'G', 'T'][step]}`.trim();
}

export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

/** At most once a frame, with the last arguments. */
export function framed(f) {
  let waiting = null;
  return (...args) => {
    if (!waiting) requestAnimationFrame(() => { const a = waiting; waiting = null; f(...a); });
    waiting = args;
  };
}

export const phone = matchMedia('(max-width: 40em)');
