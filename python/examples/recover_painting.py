"""Recovers the painting of the box scene from one picture of the room, starting from grey.

    python python/examples/recover_painting.py [STEPS [FOLDER]]

Writes the recovered texture, how the loss changed with it, what the camera sees and a glTF scene to FOLDER (out/recovered).
"""

import pathlib
import sys

import numpy as np

import cmpg

steps = int(sys.argv[1]) if len(sys.argv) > 1 else 20
folder = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else "out/recovered")
box = pathlib.Path(__file__).resolve().parents[2] / "scenes/box"
name = "painting.baseColor"

scene = cmpg.Scene(box / "scene.gltf")
truth = scene[name].values
scene[name] = 0.5  # what is known of it before: nothing

recovery = cmpg.Recovery(scene, box / "target.exr", param=name, steps=steps, spp=4, spp_gradient=4)
for step in recovery:
    error = np.sqrt(np.mean((recovery[name] - truth) ** 2))
    print(f"step {step.step}: loss {step.loss:.3g} +- {step.loss_error:.2g}, error of a texel {error:.3f}, {step.seconds:.1f} s")

folder.mkdir(parents=True, exist_ok=True)
recovery[name].save(folder / "painting.png")
recovery.gradient(name).save(folder / "gradient.exr")
recovery.image(spp=64).save(folder / "room.png")
recovery.apply(scene)
scene.export(folder)
print(f"wrote {folder}")
