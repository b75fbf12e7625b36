"""A scene inside Mitsuba: its shapes, interfaces and light, at one wavelength."""

import tempfile
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

from mesh import write_ply

SCALAR, POLARIZED = "llvm_ad_mono", "llvm_ad_mono_polarized"


def use(polarized):
    """Chooses the variant: monochromatic, with or without Stokes vectors. Both compute in single precision."""
    mi.set_variant(POLARIZED if polarized else SCALAR)
    mi.set_log_level(mi.LogLevel.Error)


def read_image(path):
    """The texels of a picture, height × width × 3."""
    bitmap = mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.array(bitmap)


def light(texels):
    """Mitsuba's own `envmap` or `constant` emitter for grey texels."""
    if texels.size == 1:
        return {"type": "constant", "radiance": {"type": "uniform", "value": float(texels[0, 0])}}
    # Mitsuba's first and last row are at the poles; ours are in the middle of their bands. With additional rows between
    # ours, both are the same piecewise linear function.
    height, width = texels.shape
    rows = np.empty((2 * height + 1, width), np.float32)
    rows[1::2] = texels
    rows[2:-1:2] = (texels[1:] + texels[:-1]) / 2.0
    rows[0], rows[-1] = texels[0], texels[-1]
    # Its y axis is up, and its image starts at −z.
    turn = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    bitmap = mi.Bitmap(np.repeat(rows[:, :, None], 3, axis=2))
    return {"type": "envmap", "bitmap": bitmap, "to_world": turn}


def interface(stone, line):
    """The BSDF of a stone's surface at a wavelength."""
    if stone.conductor:
        eta = {"type": "uniform", "value": stone.n[line]}
        return {"type": "conductor", "eta": eta, "k": {"type": "uniform", "value": stone.k[line]}}
    return {"type": "dielectric", "int_ior": stone.n[line], "ext_ior": 1.0}


def shapes(scene, line, folder):
    """Mitsuba's descriptions of all stones, with flat triangles; their files are written to `folder`."""
    found = {}
    for number, stone in enumerate(scene.stones):
        path = Path(folder) / f"{number}.ply"
        write_ply(path, stone.mesh.vertices, stone.mesh.triangles)
        bsdf = interface(stone, line)
        found[f"stone{number}"] = {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": bsdf}
    return found


class World:
    """The stones at one wavelength, for rays traced here."""

    def __init__(self, scene, line):
        with tempfile.TemporaryDirectory() as folder:
            parts = {name: mi.load_dict(shape) for name, shape in shapes(scene, line, folder).items()}
        self.scene = mi.load_dict({"type": "scene", **parts})
        self.shapes = list(parts.values())
        self.emitter = mi.load_dict(light(scene.light))

    def light(self, directions):
        """Radiance from directions (n × 3), by Mitsuba's emitter."""
        si = dr.zeros(mi.SurfaceInteraction3f, len(directions))
        si.wi = -vector(directions)
        value = self.emitter.eval(si)
        value = value[0, 0] if mi.is_polarized else value
        return np.broadcast_to(np.array(value[0], dtype=float), len(directions))

    def meet(self, origins, directions):
        """Mitsuba's next intersection of each ray."""
        si = self.scene.ray_intersect(mi.Ray3f(vector(origins), vector(directions)))
        dr.eval(si)
        return si

    def number(self, si):
        """The stone of each intersection; −1 for none."""
        number = np.full(dr.width(si), -1)
        for k, shape in enumerate(self.shapes):
            number[np.array(si.shape == mi.ShapePtr(shape))] = k
        return number


def vector(points):
    """Points (n × 3) as Mitsuba's vectors."""
    return mi.Vector3f(np.ascontiguousarray(np.asarray(points, np.float32).T))
