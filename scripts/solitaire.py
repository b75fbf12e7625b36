#!/usr/bin/env python3
"""Writes scenes/meshes/solitaire.glb: the torus of scenes/meshes/ring.obj with a brilliant on top, as exporters write rings: y-up,
a node for each part, materials with extensions. Usage: solitaire.py BRILLIANT.obj, which 'gemtrace cut … --mesh' writes."""

import json
import struct
import sys
from pathlib import Path

MESHES = Path(__file__).parent.parent / "scenes/meshes"


def obj(path):
    """Points and triangles of an OBJ file."""
    points, triangles = [], []
    for line in Path(path).read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind == "v":
            points.append(tuple(map(float, words)))
        elif kind == "f":
            corners = [int(word.split("/")[0]) - 1 for word in words]
            triangles += [(corners[0], b, c) for b, c in zip(corners[1:], corners[2:])]
    return points, triangles


def main():
    binary, views, accessors, meshes = b"", [], [], []

    def accessor(data, kind, component, count, extra):
        nonlocal binary
        binary += bytes(-len(binary) % 4)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind, **extra})
        return len(accessors) - 1

    def mesh(name, points, triangles, material):
        up = [(x, z, -y) for x, y, z in points]
        box = {"min": [min(axis) for axis in zip(*up)], "max": [max(axis) for axis in zip(*up)]}
        position = accessor(b"".join(struct.pack("<3f", *p) for p in up), "VEC3", 5126, len(up), box)
        corners = b"".join(struct.pack("<3H", *t) for t in triangles)
        indices = accessor(corners, "SCALAR", 5123, 3 * len(triangles), {})
        primitive = {"attributes": {"POSITION": position}, "indices": indices, "material": material}
        meshes.append({"name": name, "primitives": [primitive]})

    # The ring stands: its axis, z in its file, is y here.
    band, faces = obj(MESHES / "ring.obj")
    mesh("band", [(9 / 2.75 * x, -9 / 2.75 * z, 9 / 2.75 * y) for x, y, z in band], faces, 0)
    stone, facets = obj(sys.argv[1])
    width = max(p[0] for p in stone) - min(p[0] for p in stone)
    mesh("brilliant", [tuple(6.5 / width * c for c in p) for p in stone], facets, 1)
    document = {
        "asset": {"version": "2.0", "generator": "scripts/solitaire.py"},
        "extensionsUsed": ["KHR_materials_dispersion", "KHR_materials_ior", "KHR_materials_transmission"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "solitaire", "children": [1, 2, 3]},
            {"name": "shank", "mesh": 0},
            {"name": "stone", "mesh": 1, "translation": [0, 12.1, 0]},
            {"name": "camera", "camera": 0, "translation": [0, 60, 46], "rotation": [-0.4107, 0, 0, 0.9118]},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.36, "znear": 0.1}}],
        "meshes": meshes,
        "materials": [
            {
                "name": "yellow metal",
                "pbrMetallicRoughness": {"baseColorFactor": [0.944, 0.776, 0.373, 1], "roughnessFactor": 0},
            },
            {
                "name": "clear stone",
                "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
                "extensions": {
                    "KHR_materials_transmission": {"transmissionFactor": 1},
                    "KHR_materials_ior": {"ior": 2.417},
                    "KHR_materials_dispersion": {"dispersion": 0.36},
                },
            },
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary)
    head = struct.pack("<4s2I", b"glTF", 2, length) + struct.pack("<I4s", len(text), b"JSON")
    (MESHES / "solitaire.glb").write_bytes(head + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


if __name__ == "__main__":
    main()
