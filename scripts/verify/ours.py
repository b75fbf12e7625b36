"""gemtrace as a program: scene files in, spectral EXR out."""

import json
import subprocess
import tomllib
from pathlib import Path

import mitsuba as mi
import numpy as np

# The reference last: it is not for pictures, but for the tests of the other backends.
BACKENDS = ("cpu", "wgpu", "vulkan", "reference")


class Gemtrace:
    """The program, and a folder for its scenes and pictures."""

    def __init__(self, program, folder):
        self.program, self.folder = str(program), Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)

    def ask(self, *arguments):
        """The JSON answer of a command."""
        command = [self.program, "--json", *map(str, arguments)]
        said = subprocess.run(command, check=True, capture_output=True, text=True)
        return json.loads(said.stdout)

    def devices(self):
        """Backends with a device on this machine, with the name of the device."""
        found = {}
        for backend in self.ask("devices")["backends"]:
            for device in backend["devices"]:
                found.setdefault(backend["backend"], f"{device['name']} ({device['intersection']})")
        return {name: found[name] for name in BACKENDS if name in found}

    def variant(self, path, **render):
        """A copy of a scene with other settings, next to its parts."""
        path = Path(path)
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        for part in [table["environment"], *table["stone"]]:
            for key in ("image", "mesh"):
                if key in part:
                    part[key] = str((path.parent / part[key]).resolve())
        table["film"] |= {key: render.pop(key) for key in ("width", "height") if key in render}
        table["render"] |= render
        copy = self.folder / f"{path.stem}.toml"
        copy.write_text(toml(table), encoding="utf-8")
        return copy

    def render(self, path, backend):
        """Radiance by wavelength (λ × height × width), in ascending order."""
        picture = self.folder / f"{Path(path).stem}-{backend}.exr"
        self.ask("render", path, "--backend", backend, "-o", picture)
        return planes(picture)


def planes(path):
    """The channels S0.<nm>nm of an EXR image, in ascending order."""
    bitmap = mi.Bitmap(str(path))
    pixels = np.array(bitmap)
    found = {}
    for channel, field in enumerate(bitmap.struct_()):
        name = field.name.rsplit("S0.", 1)
        if len(name) == 2 and name[1].endswith("nm"):
            found[float(name[1][:-2].replace(",", "."))] = pixels[:, :, channel].astype(float)
    return np.array([found[nm] for nm in sorted(found)])


def toml(table):
    """The part of TOML that the scenes use. Strings, numbers and lists are those of JSON."""
    lines = [f"{key} = {json.dumps(value)}" for key, value in table.items() if not holds_tables(value)]
    for key, value in table.items():
        for part in value if isinstance(value, list) else [value]:
            if isinstance(part, dict):
                lines.append(f"[[{key}]]" if isinstance(value, list) else f"[{key}]")
                lines += [f"{k} = {json.dumps(v)}" for k, v in part.items()]
    return "\n".join(lines) + "\n"


def holds_tables(value):
    """Whether a value is a table or a list of them."""
    return isinstance(value, dict) or (isinstance(value, list) and any(isinstance(v, dict) for v in value))
