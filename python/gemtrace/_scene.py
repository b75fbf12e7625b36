"""Scenes, from files or in code, and how they are rendered."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType

from . import _gemtrace, table
from ._array import log, remark
from ._document import Document, Maker, merged, relocate
from ._errors import DeviceError, InputError, Interrupted, OutputError
from ._film import Film

Progress = Callable[[int, int], object]
# A table whose keys replace those of another, or remove them by None.
Change = Mapping[str, object]


class Scene:
    """What is to be rendered. It never changes; :meth:`replace` gives another.

    ``camera``, ``film``, ``environment``, ``ground``, ``pose`` and ``render`` are tables with the keys of a scene file
    (:mod:`gemtrace.table`, ``docs/scene.md``): mm, degrees, nm, linear sRGB. ``stones`` is a list of such tables,
    ``materials`` has a table for each name that stones may use beside those of :data:`gemtrace.materials`. The light may be
    an array of shape (rows, columns, 3), a stone's shape a :class:`gemtrace.Cut` or a pair of arrays, (V, 3) and (T, 3).
    Without an environment there is the built-in studio; the picture has 512 × 512 pixels. Raises InputError with the key,
    its value and what would be valid, and TypeError for what no scene holds.
    """

    def __init__(
        self,
        *,
        camera: table.Camera,
        stones: Sequence[table.Stone] = (),
        environment: table.Environment | None = None,
        film: table.Film | None = None,
        materials: Mapping[str, table.Material] | None = None,
        ground: table.Ground | None = None,
        pose: table.Pose | None = None,
        render: table.Render | None = None,
    ) -> None:
        sections = {
            "camera": camera, "stones": stones, "environment": environment, "film": film, "materials": materials,
            "ground": ground, "pose": pose, "render": render,
        }
        maker = Maker()
        document = changed({"format": 1}, sections, maker)
        self._scene = _gemtrace.Scene.build(json.dumps(document), maker.made)
        self._sessions: dict[tuple[str, int | None, int | None], _gemtrace.Session] = {}
        remark(self.warnings)

    @classmethod
    def _of(cls, scene: _gemtrace.Scene, sessions: dict[tuple[str, int | None, int | None], _gemtrace.Session]) -> Scene:
        self = cls.__new__(cls)
        self._scene, self._sessions = scene, sessions
        return self

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the picture, (H, W), in pixels. No errors."""
        width, height = self._scene.size
        return height, width

    @property
    def document(self) -> Document:
        """The scene as a table with the keys of a scene file, units as there. No errors."""
        document: Document = json.loads(self._scene.document())
        return document

    @property
    def path(self) -> Path | None:
        """The file that it was read from; None for a scene in code. No units, no errors."""
        path = self._scene.path
        return None if path is None else Path(path)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Remarks about what was accepted; they are logged, too. No units, no errors."""
        return tuple(self._scene.warnings)

    @property
    def hash(self) -> str:
        """SHA-256 over the scene's text and all that it names, in hexadecimal. No units, no errors."""
        return self._scene.hash

    def replace(
        self,
        *,
        material: str | Sequence[str] | None = None,
        camera: Change | None = None,
        stones: Sequence[table.Stone] | None = None,
        environment: Change | None = None,
        film: Change | None = None,
        materials: Mapping[str, table.Material] | None = None,
        ground: Change | None = None,
        pose: Change | None = None,
        render: Change | None = None,
    ) -> Scene:
        """Another scene: tables are merged key by key, and a key with None is removed; ``stones`` takes the place of all.

        ``material`` is that of every stone, or one for each. Units are those of scene files: mm, degrees, nm; shapes of
        arrays as for :class:`Scene`. What does not change is read and prepared once for both. Raises as :class:`Scene`.
        """
        sections = {
            "camera": camera, "stones": stones, "environment": environment, "film": film, "materials": materials,
            "ground": ground, "pose": pose, "render": render,
        }
        maker = Maker()
        document = changed(self.document, sections, maker)
        if material is not None:
            set_material(document, material)
        return self._derived(document, maker)

    def _derived(self, document: Document, maker: Maker) -> Scene:
        before = set(self.warnings)
        scene = Scene._of(self._scene.derive(json.dumps(document), maker.made), self._sessions)
        remark(warning for warning in scene.warnings if warning not in before)
        return scene

    def render(
        self,
        *,
        backend: str = "auto",
        device: int | None = None,
        threads: int | None = None,
        quality: table.Quality | None = None,
        resolution: tuple[int, int] | None = None,
        coverage: table.Coverage | None = None,
        samples: int | None = None,
        tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> Film:
        """Renders the picture, a :class:`Film` of (H, W) pixels.

        ``backend``: a name of :func:`gemtrace.devices`, or ``"auto"``; ``device`` its number there; ``threads`` of a
        processor (never changes the picture). ``quality``: ``"draft"``, ``"normal"`` or ``"final"``; ``resolution``: width
        and height in pixels; ``coverage``, ``samples`` and ``tolerance`` (ΔE00) as in a scene file, in place of the scene's.

        ``progress(done, total)`` is called about twenty times a second with numbers of pixel samples; fewer than the total
        will do where parts of the picture settle. If it returns False, the film is returned as it is then. If it raises, the
        render ends with that exception. Ctrl-C raises :class:`gemtrace.Interrupted`, whose ``film`` has what is finished.

        Other threads run meanwhile. The device stays open for the next picture of this scene and of those derived from it.
        Raises InputError for settings outside their range, DeviceError where no device is left.
        """
        key = (backend, device, threads)
        session = self._sessions.get(key)
        if session is None:
            session = self._sessions.setdefault(key, opened(backend, device, threads, single=True))
        settings = (quality, resolution, coverage, samples, tolerance)
        return rendered(session, self._scene, settings, progress)

    def open(self, *, backend: str = "auto", device: int | None = None, threads: int | None = None) -> View:
        """A device for many pictures of this scene: ``with scene.open() as view: view.render(turn=10.0)``, in degrees.

        Arguments as for :meth:`render`, whose shapes and units hold. Raises UnknownNameError for an unknown backend; a device
        that fails is reported by the first picture.
        """
        return View(self, opened(backend, device, threads, single=False))

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes a scene file, which the command line renders as well, and returns its path.

        Units are those of scene files: mm, degrees, nm. Arrays become files beside it: a light an EXR of 32-bit floats, shape
        (rows, columns, 3), a solid an OBJ, whose facets are found again to rounding. Other files are named by their full
        paths. Raises InputError for a name without ``.toml`` or that of a file which the scene was read from, and OutputError
        for a file that cannot be written.
        """
        target = Path(path).absolute()
        if target.suffix != ".toml":
            raise InputError(f"{path}: scenes are written as TOML; end the name in '.toml'")
        if not target.parent.is_dir():
            raise OutputError(f"{path}: there is no folder {target.parent}")
        document = self.document
        text = json.dumps(document)
        files: dict[str, str] = {}
        for number, made in enumerate(self._scene.made, 1):
            if made.name in text:
                files[made.name] = Path(made.save(os.fspath(target.with_name(f"{target.stem}-{number}")))).name
        relocate(document, files, Path.cwd() if self.path is None else self.path.absolute().parent)
        self._scene.write(os.fspath(target), json.dumps(document))
        return Path(path)

    def __repr__(self) -> str:
        height, width = self.shape
        return f"<gemtrace.Scene {self._scene.stones}, {width} × {height} pixels>"


class View:
    """One device, and a scene that is turned, tilted, enlarged or made of other materials there.

    Only what changes is prepared anew. Closed at the end of its ``with`` block; angles are in degrees, lengths in mm.
    Threads may share it: one that finds the device at work opens another. Errors are those of :meth:`render`.
    """

    def __init__(self, scene: Scene, session: _gemtrace.Session) -> None:
        """Not for callers: use :meth:`Scene.open`. ``scene`` and ``session`` are what it made; there are no errors."""
        self.scene = scene
        self._session: _gemtrace.Session | None = session

    def render(
        self,
        scene: Scene | None = None,
        *,
        turn: float | None = None,
        tilt: float | None = None,
        size: float | None = None,
        material: str | Sequence[str] | None = None,
        quality: table.Quality | None = None,
        resolution: tuple[int, int] | None = None,
        coverage: table.Coverage | None = None,
        samples: int | None = None,
        tolerance: float | None = None,
        progress: Progress | None = None,
    ) -> Film:
        """Renders the scene as it is now held, a :class:`Film` of (H, W) pixels.

        ``turn`` about +z and ``tilt`` towards the eye in degrees, beside the scene's own pose; ``size``: width of the first
        stone in mm; ``material``: that of every stone, or one for each. Nothing is kept for the next picture. ``scene`` is
        rendered in place of the view's own. The rest, and the errors, as for :meth:`Scene.render`; InputError after the
        view was closed.
        """
        if self._session is None:
            raise InputError("this view is closed; open another with scene.open()")
        posed = held(scene or self.scene, turn, tilt, size, material)
        settings = (quality, resolution, coverage, samples, tolerance)
        return rendered(self._session, posed._scene, settings, progress)

    def close(self) -> None:
        """Gives the device back. Nothing happens the second time. No errors, no units."""
        if self._session is not None:
            self._session.close()
            self._session = None

    def __enter__(self) -> View:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def load(path: str | os.PathLike[str]) -> Scene:
    """Reads a scene file and what it names, a :class:`Scene`; units are those of ``docs/scene.md``: mm, degrees, nm.

    Raises FileError for a file that cannot be read, and InputError with file, line, value, and what would be valid.
    """
    scene = Scene._of(_gemtrace.Scene.read(os.fspath(path)), {})
    remark(scene.warnings)
    return scene


def changed(document: Document, sections: Mapping[str, object], maker: Maker) -> Document:
    """A document with other sections."""
    for name, given in sections.items():
        if given is None:
            continue
        if name == "stones":
            document["stone"] = maker.stones(given)
            continue
        section = maker.section(name, given)
        key = "material" if name == "materials" else name
        document[key] = merged(document.get(key, {}), key, section)
    return document


def set_material(document: Document, material: str | Sequence[str]) -> None:
    """Makes every stone of a material, or each of its own."""
    stones = document.get("stone", [])
    names = [material] * len(stones) if isinstance(material, str) else list(material)
    if len(names) != len(stones) or not all(isinstance(name, str) for name in names):
        raise InputError(f"material: {material!r} is not valid; expected a name, or one for each of {len(stones)} stones")
    for stone, name in zip(stones, names):
        stone["material"] = name


def held(
    scene: Scene, turn: float | None, tilt: float | None, size: float | None, material: str | Sequence[str] | None
) -> Scene:
    """A scene held in another way."""
    if turn is None and tilt is None and size is None and material is None:
        return scene
    own = scene.document.get("pose", {})
    pose: table.Pose = {}
    if turn is not None:
        pose["turn"] = own.get("turn", 0.0) + turn
    if tilt is not None:
        pose["tilt"] = own.get("tilt", 0.0) + tilt
    if size is not None:
        pose["size"] = size
    return scene.replace(pose=pose, material=material)


def opened(backend: str, device: int | None, threads: int | None, *, single: bool) -> _gemtrace.Session:
    """A backend; its device is opened by its first picture."""
    if threads is not None and not 1 <= threads <= 1024:
        raise InputError(f"threads: {threads} is not valid; expected a whole number from 1 to 1024")
    if device is not None and device < 0:
        raise InputError(f"device: {device} is not valid; expected a number of gemtrace.devices(), from 0")
    return _gemtrace.Session(backend, device, threads, single)


Settings = tuple[str | None, tuple[int, int] | None, str | None, int | None, float | None]


def rendered(session: _gemtrace.Session, scene: _gemtrace.Scene, settings: Settings, progress: Progress | None) -> Film:
    """The film, or what ended it, with the film."""
    quality, resolution, coverage, samples, tolerance = settings
    for what, number in (("samples", samples), *(("resolution", n) for n in resolution or ())):
        if number is not None and not 1 <= number < 2**32:
            raise InputError(f"{what}: {number} is not valid; expected a whole number from 1")
    if progress is not None and not callable(progress):
        raise TypeError(f"progress: {type(progress).__name__} is not valid; expected a function of two numbers")
    size = None if resolution is None else (resolution[0], resolution[1])
    raw, error = session.render(scene, size, quality, coverage, samples, tolerance, progress)
    film = Film(raw)
    log.info("%s", film.reason)
    remark(warning for warning in film.warnings if warning not in scene.warnings)
    if isinstance(error, KeyboardInterrupt) and not isinstance(error, Interrupted):
        error = Interrupted("interrupted").with_traceback(error.__traceback__)
    if isinstance(error, (DeviceError, Interrupted)):
        error.film = film
    if error is not None:
        raise error
    return film
