// What every part of the page shares: the server's lists and state, the pose under the hand, and the messages between parts.

const query = new URLSearchParams(location.search);

export const app = {
  token: query.get('token') ?? '',
  embed: query.get('embed') === '1',
  hello: null,          // the server's greeting: lists, limits, device
  state: null,          // the last `state` message
  side: 'A',            // the side that the settings change
  dock: null,           // 'inspect', 'bench' or none
  pose: [0, 0, 0, 1],   // the stone's rotation as it is under the hand; the server may be behind
  lights: 0,            // degrees
  distance: 1,          // factor of the opening distance
  moved: 0,             // the newest message that moved both stones
  gesture: null,        // 'Turning', 'Lights' or 'Distance' while something moves
};

const bus = new EventTarget();
export const listen = (type, f) => bus.addEventListener(type, e => f(e.detail));
export const tell = (type, detail) => bus.dispatchEvent(new CustomEvent(type, { detail }));

/** The settings of a side; null before the first state. */
export const side = (name = app.side) => app.state?.sides[name] ?? null;

/** An address of the server, with the token. */
export function address(path, values = {}) {
  const url = new URL(path, location.href);
  url.search = new URLSearchParams({ ...values, token: app.token });
  return url;
}

let last = 0;
/** Numbers of messages, larger than those of any earlier window. */
export const next = () => (last = Math.max(last + 1, Date.now()));

/** The entry of a list of the greeting. */
export const entry = (list, id) => app.hello?.lists[list]?.find(e => e.id === id);
