#!/usr/bin/env python3
"""Draws docs/beams-pixel.svg and docs/beams-stone.svg: one pixel of a diamond as beams, by the equations of docs/beams.md.

Usage: beam_pictures.py [--program target/release/gemtrace] [--out docs]. The pixel is of a picture 64 wide: in one of 512 it is too
thin to be drawn.
"""

import argparse
import math
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EYE, LOOK_AT, FOV, PICTURE, WIDTH, INDEX = (0.0, -20.0, 26.2), (0.0, 0.0, -0.45), 14.0, 64, 6.5, 2.42
PIXEL = (27, 36)
LEAST = 1e-6
SEQUENCE = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#ee9944", "#7799dd", "#99bb66", "#cc88bb", "#88ccaa"]


def add(a, b, s=1.0):
    return tuple(x + s * y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return tuple(x / math.sqrt(dot(a, a)) for x in a)


class Stone:
    """Planes (normal, offset), the planes beside each, and the edges between them."""

    def __init__(self, file):
        words = [line.split() for line in Path(file).read_text(encoding="utf-8").splitlines()]
        points = [tuple(float(x) * WIDTH / 2 for x in w[1:4]) for w in words if w and w[0] == "v"]
        self.planes, edges = [], {}
        for face in ([int(c.split("/")[0]) - 1 for c in w[1:]] for w in words if w and w[0] == "f"):
            a, b, c = (points[i] for i in face[:3])
            plane = self.number(unit(cross(add(b, a, -1), add(c, a, -1))), a)
            for i, j in zip(face, face[1:] + face[:1]):
                edges.setdefault(frozenset((i, j)), []).append(plane)
        between = {edge: pair for edge, pair in edges.items() if len(set(pair)) == 2}
        self.edges = [[points[i] for i in edge] for edge in between]
        self.around = [{b for pair in between.values() if k in pair for b in pair if b != k} for k in range(len(self.planes))]

    def number(self, normal, point):
        offset = dot(normal, point)
        for k, (n, o) in enumerate(self.planes):
            if dot(n, normal) > 1 - 1e-9 and abs(o - offset) < 1e-6:
                return k
        self.planes.append((normal, offset))
        return len(self.planes) - 1

    def first(self, p, d, entering):
        """The plane that a ray meets: the last that it enters by, or the first that it leaves by."""
        sign = -1 if entering else 1
        hits = [((o - dot(n, p)) / dot(n, d), k) for k, (n, o) in enumerate(self.planes) if sign * dot(n, d) > 1e-9]
        return (max if entering else min)(hits)[1]


def at_plane(pencil, plane):
    """p, d, and their derivatives, with the origins in a plane."""
    (p, d, ps, ds), (n, o) = pencil, plane
    t = (o - dot(n, p)) / dot(n, d)
    moved = []
    for dp, dd in zip(ps, ds):
        by = add(dp, dd, t)
        moved.append(add(by, d, -dot(n, by) / dot(n, d)))
    return add(p, d, t), d, moved, ds


def reflected(pencil, n):
    p, d, ps, ds = pencil
    mirror = lambda v: add(v, n, -2 * dot(n, v))
    return p, mirror(d), ps, [mirror(v) for v in ds]


def refracted(pencil, n, eta):
    p, d, ps, ds = pencil
    c = -dot(n, d)
    c2 = math.sqrt(1 - eta**2 * (1 - c * c))
    turn = lambda v: add(tuple(eta * x for x in v), n, eta * -dot(n, v) - eta**2 * c * -dot(n, v) / c2)
    return p, unit(add(tuple(eta * x for x in d), n, eta * c - c2)), ps, [turn(v) for v in ds]


def place(vectors, by, uv):
    return add(add(vectors, by[0], uv[0]), by[1], uv[1])


def about(pencil, uv):
    p, d, ps, ds = pencil
    return place(p, ps, uv), unit(place(d, ds, uv)), ps, ds


def cut(polygon, value):
    """The parts where a value is at most 0, and where it is more."""
    parts = [], []
    for a, b in zip(polygon[-1:] + polygon[:-1], polygon):
        f, g = value(a), value(b)
        if (f <= 0) != (g <= 0):
            crossing = tuple(x + (y - x) * f / (f - g) for x, y in zip(a, b))
            parts[0].append(crossing)
            parts[1].append(crossing)
        parts[g > 0].append(b)
    return parts


def moments(polygon):
    area, centre = 0.0, [0.0, 0.0]
    for a, b in zip(polygon, polygon[1:] + polygon[:1]):
        w = a[0] * b[1] - b[0] * a[1]
        area += w
        centre = [c + w * (x + y) for c, x, y in zip(centre, a, b)]
    return abs(area) / 2, tuple(c / (3 * area) for c in centre) if area else polygon[0]


def camera():
    """The pencil of the pixel's middle."""
    forward = unit(add(LOOK_AT, EYE, -1))
    right = unit(cross(forward, (0.0, 0.0, 1.0)))
    down = cross(forward, right)
    step = 2 * math.tan(math.radians(FOV / 2)) / PICTURE
    x, y = ((k + 0.5 - PICTURE / 2) * step for k in PIXEL)
    d = add(add(forward, right, x), down, y)
    length = math.sqrt(dot(d, d))
    d = unit(d)
    across = lambda v: add(v, d, -dot(d, v))
    return EYE, d, [(0.0,) * 3] * 2, [across(tuple(step / length * c for c in v)) for v in (right, down)]


def pieces(stone, beams, entering):
    """What each beam is cut into at the next surface, all in the pixel's own (u, v)."""
    waiting, found = list(beams), []
    while waiting:
        pencil, polygon, path = waiting.pop()
        area, centre = moments(polygon)
        if area < LEAST:
            continue
        ray = about(pencil, centre)
        facet = stone.first(ray[0], ray[1], entering)
        there = at_plane(ray, stone.planes[facet])
        for side in stone.around[facet]:
            n, o = stone.planes[side]
            lie = dot(n, there[0]) - o, dot(n, there[2][0]), dot(n, there[2][1])
            inside, outside = cut(polygon, lambda v: lie[0] + lie[1] * (v[0] - centre[0]) + lie[2] * (v[1] - centre[1]))
            if len(outside) > 2 and moments(outside)[0] > LEAST and len(inside) > 2 and moments(inside)[0] > LEAST:
                waiting.append((pencil, outside, path))
                polygon = inside
        there = about(there, tuple(-c for c in centre))
        found.append((there, polygon, (*path, facet)))
    return found


def followed(stone, events):
    """The pieces at each surface, each with its pencil there, and with where it came from."""
    square = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    steps = [pieces(stone, [(camera(), square, ())], True)]
    for k in range(events - 1):
        beams = []
        for pencil, polygon, path in steps[-1]:
            n = stone.planes[path[-1]][0]
            beams.append((refracted(pencil, n, 1 / INDEX) if k == 0 else reflected(pencil, n), polygon, path))
        steps.append(pieces(stone, beams, False))
    return steps


def svg(width, height, parts):
    body = "\n".join(parts)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">\n'
            f'<rect width="100%" height="100%" fill="#fff"/>\n{body}\n</svg>\n')


def path(points, style):
    return f'<path d="M{"L".join(f"{x:.1f} {y:.1f}" for x, y in points)}Z" {style}/>'


def draw_pixel(steps, shown):
    """The square of the pixel after several surfaces; a colour for each last facet."""
    edge, gap, parts = 200, 20, []
    for k, events in enumerate(shown):
        left = gap + k * (edge + gap)
        for _, polygon, facets in steps[events - 1]:
            corners = [(left + (u + 0.5) * edge, 30 + (v + 0.5) * edge) for u, v in polygon]
            colour = SEQUENCE[sum((i + 3) * f for i, f in enumerate(facets)) % len(SEQUENCE)]
            parts.append(path(corners, f'fill="{colour}" stroke="#fff" stroke-width="0.6"'))
        what = "as it enters" if events == 1 else f"at surface {events}"
        count = len(steps[events - 1])
        words = f"{what}: {count} piece{'s' * (count > 1)}"
        parts.append(f'<text x="{left + edge / 2}" y="20" text-anchor="middle">{words}</text>')
    return svg(gap + len(shown) * (edge + gap), edge + 50, parts)


def hull(points):
    """The convex hull (Andrew's monotone chain)."""
    points = sorted(set(points))
    turn = lambda o, a, b: (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    halves = []
    for run in (points, points[::-1]):
        half = []
        for p in run:
            while len(half) > 1 and turn(half[-2], half[-1], p) <= 0:
                half.pop()
            half.append(p)
        halves.append(half[:-1])
    return halves[0] + halves[1]


def draw_stone(stone, steps, events):
    """The stone from the side, and the pieces of the beam on their ways."""
    tilt, scale = math.radians(12), 105.0
    view = lambda p: (360 + scale * p[0], 190 - scale * (p[2] * math.cos(tilt) + p[1] * math.sin(tilt)))
    parts = [f'<path d="M{x:.1f} {y:.1f}L{z:.1f} {w:.1f}" stroke="#bbb" stroke-width="0.7"/>'
             for (x, y), (z, w) in (map(view, edge) for edge in stone.edges)]
    corners = lambda pencil, polygon: [view(place(pencil[0], pencil[2], uv)) for uv in polygon]
    # From above the stone to where it enters.
    for pencil, polygon, _ in steps[0]:
        entry = corners(pencil, polygon)
        outside = [view(add(place(pencil[0], pencil[2], uv), pencil[1], -1.1)) for uv in polygon]
        parts.append(path(hull(entry + outside), 'fill="#888" fill-opacity="0.5"'))
    for k in range(1, events):
        before = {facets: pencil for pencil, _, facets in steps[k - 1]}
        for pencil, polygon, facets in steps[k]:
            start = corners(before[facets[:-1]], polygon)
            style = f'fill="{SEQUENCE[k % len(SEQUENCE)]}" fill-opacity="0.4"'
            parts.append(path(hull(start + corners(pencil, polygon)), style))
            parts.append(path(corners(pencil, polygon), 'fill="#222" fill-opacity="0.6"'))
    return svg(720, 520, parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "target/release/gemtrace")
    parser.add_argument("--out", type=Path, default=ROOT / "docs")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "stone.obj"
        command = [options.program.resolve(), "cut", ROOT / "scenes/cuts/brilliant.asc", "--mesh", mesh]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        stone = Stone(mesh)
    steps = followed(stone, 10)
    print([len(step) for step in steps], [sum(moments(p)[0] for _, p, _ in step) for step in steps])
    (options.out / "beams-pixel.svg").write_text(draw_pixel(steps, (1, 3, 6, 10)), encoding="utf-8")
    (options.out / "beams-stone.svg").write_text(draw_stone(stone, steps, 6), encoding="utf-8")


if __name__ == "__main__":
    main()
