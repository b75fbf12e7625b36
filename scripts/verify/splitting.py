"""Deterministic ray splitting with Mitsuba's intersections and BSDFs: no noise, so pictures can be compared per pixel.

Every ray that meets a surface goes on twice, by the BSDF's reflection alone and by its transmission alone; Mitsuba
gives points, normals, directions and weights (Mueller matrices in polarised variants). What is done here is
book-keeping: lists of rays, the stone a ray is in, Beer-Lambert's law on the length of a segment, the depth limit and
the threshold.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from world import World

AIR = -1
# Rays start at this distance (in radii of the scene) from the surface, along their direction, so the path is the same.
STEP = 1e-6
TRIES = 8
CHUNK = 1 << 20
# Exchanging s and p turns a Mueller matrix M into F M F with F = diag(1, −1, −1, 1), in any frame, since F commutes
# with rotations. Along a path these F cancel: exchanging s and p everywhere changes no intensity (like exchanging E and
# H). The fault for the tests, which can be detected, exchanges them in reflection alone.
EXCHANGE = np.array([1.0, -1.0, -1.0, 1.0])


@dataclass
class Rays:
    """Rays of one depth: origins, directions, pixels, stones and throughputs.

    `row` is the first row of the path's Mueller matrix, (n × 4), or its throughput alone, (n × 1).
    """

    pixel: np.ndarray
    origin: np.ndarray
    direction: np.ndarray
    row: np.ndarray
    inside: np.ndarray

    def __getitem__(self, chosen):
        """A selection, by mask or slice."""
        parts = (self.pixel, self.origin, self.direction, self.row, self.inside)
        return Rays(*(part[chosen] for part in parts))

    def __len__(self):
        """The number of rays."""
        return len(self.pixel)


def joined(parts):
    """Concatenates lists of rays."""
    names = ("pixel", "origin", "direction", "row", "inside")
    return Rays(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True)
class Picture:
    """Radiance by wavelength (λ × height × width), the pixels whose centre shows a stone, and the light lost by leaks."""

    radiance: np.ndarray
    stone: np.ndarray
    lost: float


def render(scene, exchanged=False):
    """The whole scene, in the current variant. `exchanged` introduces a fault: see `EXCHANGE`."""
    planes, lost = [], 0.0
    for line in range(len(scene.wavelengths)):
        walk = Walk(scene, line, exchanged)
        planes.append(walk.run())
        lost += walk.lost / (scene.width * scene.height * len(scene.wavelengths))
    shape = (scene.height, scene.width)
    return Picture(np.array(planes).reshape(-1, *shape), walk.stone.reshape(shape), lost)


class Walk:
    """All paths of a scene at one wavelength."""

    def __init__(self, scene, line, exchanged):
        self.scene, self.world, self.exchanged = scene, World(scene, line), exchanged
        self.absorption = np.array([0.0 if s.conductor else s.absorption[line] for s in scene.stones] + [0.0])
        self.index = np.array([1.0 if s.conductor else s.n[line] for s in scene.stones] + [1.0])
        pixels = scene.width * scene.height
        self.radiance, self.stone, self.lost = np.zeros(pixels), np.zeros(pixels, bool), 0.0

    def run(self):
        """Radiance, pixel by pixel."""
        rays = self.first()
        for depth in range(self.scene.max_depth + 1):
            parts = []
            for start in range(0, len(rays), CHUNK):
                parts += self.step(rays[slice(start, start + CHUNK)], depth)
            if not parts:
                break
            rays = joined(parts)
        return self.radiance

    def first(self):
        """From the pixel centres, starting at the bounding sphere of the stones, for the sake of single precision."""
        origin, direction = self.scene.rays()
        reach = np.maximum(-(origin * direction).sum(axis=1) - 1.01 * self.scene.radius(), 0.0)
        origin = origin + reach[:, None] * direction
        count = len(origin)
        row = np.zeros((count, 4 if mi.is_polarized else 1))
        row[:, 0] = 1.0
        return Rays(np.arange(count), origin, direction, row, np.full(count, AIR))

    def step(self, rays, depth):
        """Follows rays to the next surface; returns their continuations."""
        si, distance, number = self.next_surface(rays)
        met = number >= 0
        self.leave(rays[~met])
        if depth == 0:
            self.stone[rays.pixel[met]] = True
        fade = np.exp(-self.absorption[rays.inside] * distance)
        rays.row = np.where(met[:, None], rays.row * fade[:, None], 0.0)
        weak = (rays.inside == AIR) & (rays.row[:, 0] < self.scene.threshold)
        if depth == self.scene.max_depth:
            return []
        parts = [self.child(rays, si, number, met & ~weak, component) for component in (0, 1)]
        return [part for part in parts if len(part)]

    def next_surface(self, rays):
        """Intersections, distances and stones (−1: none) of rays.

        A ray in a stone can only leave it and a ray outside can only enter, so the surface that a ray comes from is
        told from the next by its side, and passed.
        """
        origin = rays.origin.copy()
        passed = np.full(len(rays), STEP * self.scene.radius())
        for _ in range(TRIES):
            si = self.world.meet(origin + passed[:, None] * rays.direction, rays.direction)
            number = self.world.number(si)
            outwards = (np.array(si.n).T * rays.direction).sum(axis=1) > 0.0
            wrong = (number >= 0) & np.where(rays.inside == AIR, outwards, ~outwards | (number != rays.inside))
            if not wrong.any():
                break
            beyond = np.array(si.t) + STEP * self.scene.radius()
            passed = np.where(wrong, passed + beyond, passed)
        number = np.where(wrong, -1, number)
        distance = ((np.array(si.p).T - origin) * rays.direction).sum(axis=1)
        return si, np.where(number >= 0, distance, 0.0), number

    def leave(self, rays):
        """Rays without an intersection see the light; rays inside a stone must not be among them."""
        self.lost += rays.row[rays.inside != AIR, 0].sum()
        if len(rays):
            np.add.at(self.radiance, rays.pixel, rays.row[:, 0] * self.world.light(rays.direction))

    def child(self, rays, si, number, active, component):
        """The rays from one component of the BSDF (0 reflects, 1 transmits)."""
        context = mi.BSDFContext(mi.TransportMode.Radiance, mi.BSDFFlags.All, component)
        half = mi.Float(0.5)
        sample, weight = si.bsdf().sample(context, si, half, mi.Point2f(0.5, 0.5), mi.Bool(active))
        weight = si.to_world_mueller(weight, -sample.wo, si.wi)
        towards = si.to_world(sample.wo)
        dr.eval(towards, weight)
        direction = np.array(towards, dtype=float).T
        row = onwards(rays.row, weight, EXCHANGE if self.exchanged and component == 0 else np.ones(4))
        inside = rays.inside
        if component == 1:
            # Radiance is n² times larger in a stone, and Mitsuba's weights include this; here rays carry energy.
            squeezed = self.index[number] ** 2
            row *= np.where(inside == AIR, squeezed, 1.0 / squeezed)[:, None]
            inside = np.where(inside == AIR, number, AIR)
        strong = (inside == AIR) | (row[:, 0] >= self.scene.threshold)
        chosen = active & strong & (row[:, 0] > 0.0)
        direction = direction[chosen]
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        point = np.array(si.p, dtype=float).T[chosen]
        return Rays(rays.pixel[chosen], point, direction, row[chosen], inside[chosen])


def onwards(row, weight, signs):
    """The first row of the path's matrix after one more event; `signs` as in `EXCHANGE`."""
    if not mi.is_polarized:
        return row * np.array(weight[0], dtype=float)[:, None]
    matrix = [[np.array(weight[i, j][0], dtype=float) for j in range(4)] for i in range(4)]
    return np.stack([sum(row[:, i] * matrix[i][j] * signs[i] * signs[j] for i in range(4)) for j in range(4)], axis=1)
