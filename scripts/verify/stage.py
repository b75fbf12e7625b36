"""The parts of the scenes that are not cut files: a light, a drilled bead, plates.

Usage: stage.py FOLDER. Everything is computed, nothing drawn at random; the light is stored in half precision, so both
renderers read the very same texels.
"""

import struct
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

LIGHT_SIZE = (256, 128)
# Soft lamps of a grey room: direction, sharpness and peak radiance (the mean is about 0.6).
LAMPS = [((0.5, 0.3, 0.8), 60.0, 6.0), ((-0.8, -0.2, 0.5), 25.0, 3.0), ((0.1, -0.9, 0.35), 120.0, 8.0),
         ((0.0, 0.6, -0.8), 30.0, 2.0), ((-0.3, 0.2, 0.93), 200.0, 5.0)]

# The bead: a ball with a cylindrical hole along z, mm.
BEAD_RADIUS, HOLE_RADIUS = 3.0, 0.8
BEAD_AROUND, BEAD_ALONG_BALL, BEAD_ALONG_HOLE = 144, 58, 14


def directions(width, height):
    """Unit vectors of the texel centres, z up, the image's left edge at +y."""
    azimuth = 2.0 * np.pi * (np.arange(width) + 0.5) / width
    polar = np.pi * (np.arange(height) + 0.5) / height
    azimuth, polar = np.meshgrid(azimuth, polar)
    return np.stack([np.sin(polar) * np.sin(azimuth), np.sin(polar) * np.cos(azimuth), np.cos(polar)], axis=-1)


def light():
    """Grey radiance: a room brighter above than below, soft lamps, and window bars all round."""
    towards = directions(*LIGHT_SIZE)
    azimuth = np.arctan2(towards[..., 0], towards[..., 1])
    level = 0.35 + 0.2 * towards[..., 2]
    level += 0.12 * (1.0 - towards[..., 2] ** 2) * np.sin(9.0 * azimuth + 2.0 * towards[..., 2])
    for axis, sharpness, peak in LAMPS:
        axis = np.array(axis) / np.linalg.norm(axis)
        level += peak * np.exp(sharpness * (towards @ axis - 1.0))
    return level.astype(np.float16)


def bead():
    """A surface of revolution, closed and not convex: vertices, triangles."""
    rim = np.sqrt(BEAD_RADIUS**2 - HOLE_RADIUS**2)
    latitude = np.linspace(-np.arctan2(rim, HOLE_RADIUS), np.arctan2(rim, HOLE_RADIUS), BEAD_ALONG_BALL + 1)
    ball = [(BEAD_RADIUS * np.cos(a), BEAD_RADIUS * np.sin(a)) for a in latitude]
    hole = [(HOLE_RADIUS, z) for z in np.linspace(rim, -rim, BEAD_ALONG_HOLE + 1)[1:-1]]
    profile = ball + hole
    turns = 2.0 * np.pi * np.arange(BEAD_AROUND) / BEAD_AROUND
    vertices = [(r * np.cos(t), r * np.sin(t), z) for t in turns for r, z in profile]
    count = len(profile)
    triangles = []
    for i in range(BEAD_AROUND):
        here, there = i * count, (i + 1) % BEAD_AROUND * count
        for j in range(count):
            k = (j + 1) % count
            triangles += [(here + j, there + j, there + k), (here + j, there + k, here + k)]
    return np.array(vertices), np.array(triangles)


def box(width, depth, height):
    """A plate with its upper face in the plane z = 0."""
    x, y = width / 2.0, depth / 2.0
    corners = [(s * x, t * y, z) for z in (-height, 0.0) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    triangles = [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]
    return np.array(corners), np.array(triangles)


def write_ply(path, vertices, triangles):
    """Little-endian PLY in single precision, so that readers do not round."""
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment written by scripts/verify/stage.py\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    with open(path, "wb") as file:
        file.write(header.encode("ascii"))
        file.write(np.asarray(vertices, "<f4").tobytes())
        for triangle in triangles:
            file.write(struct.pack("<B3i", 3, *triangle))


def main():
    """Writes all parts."""
    mi.set_variant("scalar_rgb")
    folder = Path(sys.argv[1])
    mi.Bitmap(np.repeat(light()[:, :, None], 3, axis=2)).write(str(folder / "room.exr"))
    write_ply(folder / "bead.ply", *bead())
    write_ply(folder / "slab.ply", *box(8.0, 8.0, 2.0))
    write_ply(folder / "plate.ply", *box(12.0, 12.0, 0.6))


if __name__ == "__main__":
    main()
