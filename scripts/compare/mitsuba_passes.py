"""One monochrome pass of Mitsuba 3 for each wavelength, joined to X, Y and Z.

Mitsuba has no dispersion, so each pass has one index of refraction. Usage: mitsuba_passes.py FOLDER SAMPLES SEED OUT, where
FOLDER has the scene written by `peers describe`, with its result as scene.json.
"""

import json
import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

VARIANTS = ["llvm_ad_mono", "scalar_rgb"]


def variant():
    """Vectorised with LLVM if its library is there."""
    for name in VARIANTS:
        try:
            mi.set_variant(name)
            mi.load_dict({"type": "sphere"})
            return name
        except Exception as reason:  # After any exception the next variant is tried.
            print(f"{name}: {reason}", file=sys.stderr)
    raise SystemExit("no variant of Mitsuba runs here")


def load(folder, scene, samples):
    """The stone, the studio and the camera."""
    width, height = scene["studio"]
    studio = np.fromfile(folder / "studio.f32", np.float32).reshape(height, width, 3)
    # Its y axis is up and its image starts at -z; the stone's table faces +z.
    turn = mi.ScalarTransform4f().rotate([1, 0, 0], 90)
    view = mi.ScalarTransform4f().look_at(scene["position"], scene["look_at"], [0, 0, 1])
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 65},
        "sensor": {
            "type": "perspective",
            "fov": scene["fov"],
            "to_world": view,
            "film": {
                "type": "hdrfilm",
                "width": scene["size"],
                "height": scene["size"],
                "rfilter": {"type": "box"},
                "component_format": "float32",
            },
            "sampler": {"type": "independent", "sample_count": samples},
        },
        "light": {"type": "envmap", "bitmap": mi.Bitmap(studio), "to_world": turn},
        "stone": {
            "type": "ply",
            "filename": str(folder / "stone.ply"),
            "face_normals": True,
            "bsdf": {"type": "dielectric", "int_ior": scene["index"][0], "ext_ior": 1.0},
        },
    })


def main():
    folder, samples, seed, out = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
    scene = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    name = variant()
    mi.set_log_level(mi.LogLevel.Error)
    world = load(folder, scene, samples)
    parameters = mi.traverse(world)
    key = next(k for k in parameters.keys() if k.endswith("eta"))

    def render(number):
        parameters[key] = scene["index"][number]
        parameters.update()
        picture = mi.render(world, spp=samples, seed=seed * len(scene["index"]) + number)
        return np.array(picture)[:, :, 0]

    # The first passes compile. The measurement is rendering alone, to Mitsuba's advantage.
    for number in range(2):
        render(number)
    xyz = np.zeros((scene["size"], scene["size"], 3))
    start = time.process_time()
    for number, response in enumerate(scene["response"]):
        light = scene["white"][number] * render(number)
        xyz += light[:, :, None] * np.array(response)
    cpu = time.process_time() - start
    xyz.astype(np.float32).tofile(out)
    print(json.dumps({"cpu": cpu, "variant": name, "passes": len(scene["index"])}))


if __name__ == "__main__":
    main()
