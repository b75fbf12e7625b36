"""The live view inside a notebook."""

from __future__ import annotations

import os
import tempfile
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _gemtrace
from ._errors import InputError
from ._scene import Scene

if TYPE_CHECKING:
    from ._widget import Frame


class LiveView:
    """A live view of a scene, served by this process to this machine, until :meth:`close` or the end of its ``with`` block.

    A notebook shows it as a frame of some pixels' height. With anywidget the two speak with each other: :attr:`pose` follows
    the hand, and :meth:`set` changes what is seen. Without it there is the frame alone. Errors are those of :func:`view`.
    """

    def __init__(self, scene: Scene, backend: str, height: int, output: str | os.PathLike[str]) -> None:
        """Not for callers: use :func:`view`, whose arguments these are, in pixels, with its errors."""
        stem = "scene" if scene.path is None else scene.path.stem
        self._folder: tempfile.TemporaryDirectory[str] | None = tempfile.TemporaryDirectory(prefix="gemtrace-")
        try:
            path = scene.save(Path(self._folder.name) / f"{stem}.toml")
            self._live = _gemtrace.Live(os.fspath(path), backend, os.path.abspath(os.fspath(output)))
        except BaseException:
            self._folder.cleanup()
            raise
        self._height = height
        self._frame: Frame | None = None

    @property
    def address(self) -> str:
        """The address of the page, with the token that it asks for. No units, no errors."""
        return self._live.address

    def _widget(self) -> Frame | None:
        """The frame that speaks with this process, where anywidget is installed."""
        if self._frame is None:
            try:
                from ._widget import Frame
            except ImportError:
                return None
            self._frame = Frame(address=f"{self.address}&embed=1", height=self._height)
        return self._frame

    @property
    def pose(self) -> tuple[float, float, float, float] | None:
        """How the stones are turned in the frame: a unit quaternion (x, y, z, w), without unit; None before the notebook has
        shown it, and without anywidget. No errors."""
        frame = self._widget()
        pose = frame.pose if frame is not None else []
        return (pose[0], pose[1], pose[2], pose[3]) if len(pose) == 4 else None

    def set(self, path: str, value: str | float) -> None:
        """Changes a setting of what is shown, by the names and units of ``docs/view-protocol.md``: ``"material"``, ``"light"``,
        ``"size"`` in mm, ``"rotation"`` in degrees, ``"exposure"`` in stops. Raises InputError without anywidget; what the page
        refuses it says in the frame."""
        frame = self._widget()
        if frame is None:
            raise InputError("a setting: the notebook needs anywidget to be told; pip install 'gemtrace[notebook]'")
        frame.send({"gemtrace": 1, "type": "set", "path": path, "value": value})

    def close(self) -> None:
        """Stops the server; nothing happens the second time. No units, no errors."""
        self._live.close()
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def __enter__(self) -> LiveView:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_mimebundle_(self, **kinds: Any) -> Any:
        """What a notebook shows."""
        frame = self._widget()
        if frame is not None:
            return frame._repr_mimebundle_(**kinds)
        source = escape(f"{self.address}&embed=1", quote=True)
        return {"text/html": f'<iframe src="{source}" width="100%" height="{self._height}" style="border:0"></iframe>'}

    def __repr__(self) -> str:
        return f"<gemtrace.LiveView at {self.address}>"


def view(
    scene: Scene, *, backend: str = "auto", height: int = 600, output: str | os.PathLike[str] = "views"
) -> LiveView:
    """The live view of a scene, to turn it, change its material and click on its pixels, inside a notebook.

    ``height`` of the frame in pixels, ``output``: the folder that files are saved to. The frame is served at an address of this
    machine alone, so the notebook's kernel must run here, or its port be forwarded. Raises InputError for an unknown backend,
    a height outside 100 to 4096, or a scene that cannot be shown, OutputError where no port is free.
    """
    if not 100 <= height <= 4096:
        raise InputError(f"height: {height} is not valid; expected pixels from 100 to 4096")
    return LiveView(scene, backend, height, output)
