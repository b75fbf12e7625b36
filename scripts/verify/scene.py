"""A scene file, converted for the other renderer.

Geometry, camera and light are read from the scene file here, by the rules of docs/scene.md and independently of
gemtrace. What no other renderer can know, n and α at each wavelength, comes from `gemtrace check --json`.
"""

import json
import subprocess
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import mesh

KNOWN = {"mesh", "width", "rotation", "position", "material"}


@dataclass(frozen=True)
class Stone:
    """A placed mesh with n, k and α (1/mm, Napierian), one value a wavelength."""

    mesh: mesh.Mesh
    conductor: bool
    n: list
    k: list
    absorption: list


@dataclass(frozen=True)
class Scene:
    """All lengths in mm, with the origin in the middle of the stones; `light` is grey texels or one level."""

    name: str
    path: Path
    position: np.ndarray
    look_at: np.ndarray
    up: np.ndarray
    fov: float
    width: int
    height: int
    light: np.ndarray
    stones: list
    wavelengths: list
    max_depth: int
    threshold: float

    def radius(self):
        """The radius of the sphere about the origin that contains all stones."""
        return max(np.linalg.norm(stone.mesh.vertices, axis=1).max() for stone in self.stones)

    def rays(self):
        """Origins and directions (pixels × 3, double precision) through the pixel centres, row by row."""
        forward = unit(self.look_at - self.position)
        right = unit(np.cross(forward, self.up))
        half = np.tan(np.radians(self.fov) / 2.0)
        x = (2.0 * (np.arange(self.width) + 0.5) / self.width - 1.0) * half * self.width / self.height
        y = (1.0 - 2.0 * (np.arange(self.height) + 0.5) / self.height) * half
        x, y = np.meshgrid(x, y)
        towards = forward + x[..., None] * right + y[..., None] * np.cross(right, forward)
        towards = unit(towards.reshape(-1, 3))
        return np.broadcast_to(self.position, towards.shape), towards


def unit(v):
    """Vectors of length 1."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def load(path, gemtrace, read_image):
    """Reads a scene. `gemtrace` is the program, `read_image` gives the texels of a picture, height × width × 3."""
    path = Path(path)
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    said = subprocess.run([gemtrace, "check", "--json", path], check=True, capture_output=True, text=True)
    facts = json.loads(said.stdout)
    settings = facts["settings"]
    if settings["leftover"] != "drop" or settings["samples"] != 1:
        raise SystemExit(f"{path}: a scene to verify has samples = 1 and leftover = \"drop\"")
    meshes = [placed(path, stone) for stone in table["stone"]]
    corners = np.concatenate([m.vertices for m in meshes])
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2.0
    meshes = [mesh.Mesh(m.vertices - middle, m.triangles) for m in meshes]
    stones = [
        Stone(m, f["conductor"], f["n"], f["k"], f["absorption_per_mm"])
        for m, f in zip(meshes, facts["stones"], strict=True)
    ]
    camera = table["camera"]
    return Scene(
        name=path.stem,
        path=path,
        position=np.array(camera["position"]) - middle,
        look_at=np.array(camera["look_at"]) - middle,
        up=np.array(camera.get("up", [0.0, 0.0, 1.0])),
        fov=camera["fov"],
        width=settings["width"],
        height=settings["height"],
        light=light(path, table["environment"], read_image),
        stones=stones,
        wavelengths=settings["wavelengths"],
        max_depth=settings["max_depth"],
        threshold=settings["threshold"],
    )


def placed(path, stone):
    """The placed mesh of a `[[stone]]` table."""
    if unknown := set(stone) - KNOWN:
        raise SystemExit(f"{path}: a scene to verify cannot have {sorted(unknown)} in a stone")
    shape = mesh.read(path.parent / stone["mesh"])
    zero = [0.0, 0.0, 0.0]
    return shape.placed(stone.get("width"), stone.get("rotation", zero), stone.get("position", zero))


def light(path, environment, read_image):
    """Grey texels under illuminant E: radiance is the texel, at every wavelength."""
    if environment.get("illuminant") != "E" or set(environment) - {"image", "uniform", "illuminant"}:
        raise SystemExit(f"{path}: a scene to verify is lit by grey texels under illuminant E")
    texels = np.array([[environment["uniform"]]]) if "uniform" in environment else read_image(
        path.parent / environment["image"]
    )
    if np.ptp(texels, axis=2).max() > 0.0:
        raise SystemExit(f"{path}: its light is not grey")
    return texels[:, :, 0]
