"""Mitsuba's path tracer on a scene, in independent passes; absorption by its homogeneous medium."""

import tempfile

import mitsuba as mi
import numpy as np

import world


def describe(scene, line, folder):
    """The scene with Mitsuba's own camera, a box filter and paths without Russian roulette."""
    parts = world.shapes(scene, line, folder)
    absorbing = False
    for part, stone in zip(parts.values(), scene.stones, strict=True):
        if not stone.conductor and stone.absorption[line] > 0.0:
            absorbing = True
            part["interior"] = {"type": "homogeneous", "albedo": 0.0, "sigma_t": stone.absorption[line]}
    view = mi.ScalarTransform4f().look_at(list(scene.position), list(scene.look_at), list(scene.up))
    return {
        "type": "scene",
        "integrator": {
            "type": "volpath" if absorbing else "path",
            # One more, since its depth counts segments and ours surfaces.
            "max_depth": scene.max_depth + 1,
            "rr_depth": 10_000,
        },
        "sensor": {
            "type": "perspective",
            "fov": scene.fov,
            "fov_axis": "y",
            "to_world": view,
            "film": {
                "type": "hdrfilm",
                "width": scene.width,
                "height": scene.height,
                "pixel_format": "luminance",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent"},
        },
        "light": world.light(scene.light),
        **parts,
    }


def passes(scene, line, count, samples, seed):
    """`count` independent pictures (count × height × width) of `samples` samples a pixel."""
    with tempfile.TemporaryDirectory() as folder:
        loaded = mi.load_dict(describe(scene, line, folder))
    pictures = [mi.render(loaded, spp=samples, seed=seed + k) for k in range(count)]
    return np.array([np.array(picture)[:, :, 0] for picture in pictures], dtype=float)
