"""One monochrome pass of LuxCore for each wavelength, joined to X, Y and Z.

Usage: luxcore_passes.py FOLDER SAMPLES SEED OUT, as mitsuba_passes.py.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
import pyluxcore

DEPTH = 65


def properties(values):
    """LuxCore's own dictionary."""
    made = pyluxcore.Properties()
    for name, value in values.items():
        made.Set(pyluxcore.Property(name, value))
    return made


def world(folder, scene, number):
    """The stone at one wavelength."""
    made = pyluxcore.Scene()
    width, height = scene["studio"]
    studio = np.fromfile(folder / "studio.f32", np.float32).reshape(height, width, 3)
    # Its image has the other direction and starts a quarter turn later.
    studio = np.ascontiguousarray(np.roll(studio[:, ::-1], width // 4, axis=1))
    made.DefineImageMap("studio", studio.reshape(-1), 1.0, 3, width, height)
    made.Parse(properties({
        "scene.camera.type": "perspective",
        "scene.camera.lookat.orig": scene["position"],
        "scene.camera.lookat.target": scene["look_at"],
        "scene.camera.up": [0.0, 0.0, 1.0],
        "scene.camera.fieldofview": scene["fov"],
        "scene.lights.studio.type": "infinite",
        "scene.lights.studio.file": "studio",
        "scene.lights.studio.gamma": 1.0,
        "scene.materials.stone.type": "glass",
        "scene.materials.stone.kr": [1.0, 1.0, 1.0],
        "scene.materials.stone.kt": [1.0, 1.0, 1.0],
        "scene.materials.stone.interiorior": scene["index"][number],
        "scene.materials.stone.exteriorior": 1.0,
        "scene.objects.stone.ply": str(folder / "stone.ply"),
        "scene.objects.stone.material": "stone",
    }))
    return made


def render(folder, scene, number, samples, seed):
    """The green channel of a pass and its CPU seconds."""
    settings = properties({
        "renderengine.type": "PATHCPU",
        "renderengine.seed": seed * len(scene["index"]) + number + 1,
        "sampler.type": "SOBOL",
        "sampler.sobol.adaptive.strength": 0.0,
        "native.threads.count": 1,
        "path.pathdepth.total": DEPTH,
        "path.pathdepth.diffuse": DEPTH,
        "path.pathdepth.glossy": DEPTH,
        "path.pathdepth.specular": DEPTH,
        "film.width": scene["size"],
        "film.height": scene["size"],
        "film.filter.type": "NONE",
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "rgb.exr",
        "batch.haltspp": [samples, 0],
    })
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(settings, world(folder, scene, number)))
    session.Start()
    start = time.process_time()
    while not session.HasDone():
        time.sleep(0.01)
        session.UpdateStats()
    cpu = time.process_time() - start
    session.Stop()
    picture = np.zeros(scene["size"] ** 2 * 3, np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, picture)
    # Its rows are in ascending order.
    return picture.reshape(scene["size"], scene["size"], 3)[::-1, :, 1], cpu


def main():
    folder, samples, seed, out = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
    scene = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    pyluxcore.Init()
    xyz, cpu = np.zeros((scene["size"], scene["size"], 3)), 0.0
    for number, response in enumerate(scene["response"]):
        light, seconds = render(folder, scene, number, samples, seed)
        xyz += scene["white"][number] * light[:, :, None] * np.array(response)
        cpu += seconds
    xyz.astype(np.float32).tofile(out)
    print(json.dumps({"cpu": cpu, "passes": len(scene["index"])}))


if __name__ == "__main__":
    main()
