"""The frame of a live view that speaks with its notebook: needs anywidget."""

from __future__ import annotations

import anywidget
import traitlets

# The page inside the frame sends messages { gemtrace: 1, type, … }, as docs/view-protocol.md and the page's `embed.js` have them.
SCRIPT = """
function render({ model, el }) {
  const source = new URL(model.get('address'));
  source.searchParams.set('origin', location.origin);
  const frame = document.createElement('iframe');
  frame.src = source.href;
  frame.title = 'gemtrace';
  frame.style.cssText = `border: 0; width: 100%; height: ${model.get('height')}px`;
  const hear = ({ data, origin, source: from }) => {
    if (from !== frame.contentWindow || origin !== source.origin || data?.gemtrace !== 1) return;
    if (data.type === 'pose') { model.set('pose', data.quaternion); model.save_changes(); }
    if (data.type === 'state') { model.set('stage', data.stage ?? ''); model.save_changes(); }
  };
  const tell = message => frame.contentWindow?.postMessage(message, source.origin);
  addEventListener('message', hear);
  model.on('msg:custom', tell);
  el.append(frame);
  return () => { removeEventListener('message', hear); model.off('msg:custom', tell); };
}
export default { render };
"""


class Frame(anywidget.AnyWidget):
    """A frame with a page; ``pose`` and ``stage`` are what the page says last."""

    _esm = SCRIPT
    address = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int().tag(sync=True)
    pose: traitlets.List[float] = traitlets.List().tag(sync=True)
    stage = traitlets.Unicode().tag(sync=True)
