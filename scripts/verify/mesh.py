"""Triangle meshes in OBJ and binary PLY, for the scenes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stage import write_ply

__all__ = ["Mesh", "read", "write_ply"]


@dataclass(frozen=True)
class Mesh:
    """A closed surface: vertices (n × 3, mm, double precision) and triangles (m × 3)."""

    vertices: np.ndarray
    triangles: np.ndarray

    def placed(self, width, rotation, position):
        """Scaled about the file's origin to `width`, turned about x, y and z (degrees), moved."""
        scale = 1.0
        if width is not None:
            scale = width / np.ptp(self.vertices[:, :2], axis=0).min()
        turn = np.eye(3)
        for axis, angle in enumerate(np.radians(rotation)):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            step = np.eye(3)
            step[i, i] = step[j, j] = np.cos(angle)
            step[j, i], step[i, j] = np.sin(angle), -np.sin(angle)
            turn = step @ turn
        return Mesh(scale * self.vertices @ turn.T + np.asarray(position), self.triangles)


def read(path):
    """The mesh in a file."""
    return read_obj(path) if Path(path).suffix == ".obj" else read_ply(path)


def read_obj(path):
    """Triangles only."""
    vertices, triangles = [], []
    for line in Path(path).read_text(encoding="ascii").splitlines():
        kind, *rest = line.split()
        if kind == "v":
            vertices.append([float(x) for x in rest])
        elif kind == "f":
            triangles.append([int(i) - 1 for i in rest])
    return Mesh(np.array(vertices), np.array(triangles))


def read_ply(path):
    """What `stage.write_ply` wrote."""
    head, body = Path(path).read_bytes().split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in head.decode("ascii").splitlines() if line.startswith("element")]
    vertices = np.frombuffer(body, "<f4", 3 * counts[0]).reshape(-1, 3).astype(float)
    faces = np.frombuffer(body, np.dtype([("n", "u1"), ("v", "<i4", 3)]), counts[1], 12 * counts[0])
    return Mesh(vertices, faces["v"].astype(int))
