#!/usr/bin/env python3
"""Makes the reference images and gradients in this folder with Mitsuba 3 (pip install mitsuba numpy; not needed by the tests).

    make_references.py [--only TEXT]     # all jobs, or those whose name contains TEXT

Mitsuba's llvm variants need LLVM >= 16: on Debian 12 install libllvm19 and set DRJIT_LIBLLVM_PATH=libLLVM.so.19.1.
Every result is the mean over independent seeds; <name>.error.exr holds the standard error of that mean. references.json says how
each was made. Directions are ours: "one" adds 1 to every entry of the parameter, "self" adds the parameter itself.
"""
import argparse
import json
import math
import pathlib
import sys
import time

here = pathlib.Path(__file__).resolve().parent
sys.path += [str(here), str(here.parent.parent / "scenes")]

import mitsuba as mi

mi.set_variant("llvm_ad_rgb")

import drjit as dr
import gltf_bsdf
import images
import numpy as np
from mitsuba_scene import Translation
from xml_scene import XmlScene

gltf_bsdf.register()

SIZE, SEEDS = 64, 16
# Scene: samples per pixel and seed, then the derivatives worth having there: (parameter, direction or "reverse"), and by what
# factor a noisy one needs more samples.
JOBS = {
    "box": (48, [("painting.baseColor", "one"), ("white.baseColor", "one"), ("light.emission", "self"),
                 ("painting.baseColor", "reverse"), ("left.baseColor", "reverse")]),
    "door": (192, [("painting.baseColor", "one"), ("painting.baseColor", "reverse")]),
    "bowl": (96, [("table.baseColor", "one"), ("bowl.baseColor", "self"), ("bowl.roughness", "one", 4),
                  ("table.baseColor", "reverse"), ("bowl.roughness", "reverse", 4)]),
    "environment": (64, [("painting.baseColor", "one"), ("environment.radiance", "self"), ("steel.baseColor", "one"),
                         ("ball.specular", "self"), ("painting.baseColor", "reverse"), ("environment.radiance", "reverse")]),
    # What light passes through. Mitsuba's prb has no derivatives by what single directions carry, and counts them as diffuse where a smooth coat lies
    # over a diffuse base: differences stand for them, of a larger step where sampling follows the parameter.
    "glass": (128, [("painting.baseColor", "one"), ("white.baseColor", "one"), ("ball.baseColor", "one difference"), ("pane.baseColor", "one difference"),
                    ("ball.specular", "one difference"), ("painting.baseColor", "reverse")]),
    "metals": (64, [("brass.baseColor", "one"), ("brass.roughness", "one", 4), ("plastic.baseColor", "one"), ("plastic.specular", "one", 2),
                    ("half.baseColor", "one difference"), ("brass.roughness", "reverse", 4), ("plastic.baseColor", "reverse")]),
    "coats": (64, [("brass.baseColor", "one", 2), ("brass.roughness", "one", 8), ("plastic.baseColor", "one difference 0.05", 4), ("half.baseColor", "one"),
                   ("half.specular", "one", 2), ("brass.baseColor", "reverse", 2)]),
    "materials": (32, [("varied.baseColor", "one"), ("varied.roughness", "one", 6), ("varied.metallic", "one"),
                       ("varied.specular", "one"), ("wavy.normal", "one", 4), ("plastic.specular", "self"), ("half.metallic", "one", 4),
                       ("lamp.emission", "one"), ("environment.radiance", "one"), ("varied.roughness", "reverse", 6),
                       ("wavy.normal", "reverse", 4), ("lamp.emission", "reverse"), ("half.metallic", "reverse", 4)]),
    "varnish": (32, [("brass.clearcoat", "one"), ("half.clearcoat", "one", 2), ("plastic.clearcoatRoughness", "one", 8),
                     ("plastic.baseColor", "one"), ("half.clearcoat", "reverse", 2)]),
    "brushed": (32, [("varied.anisotropy", "one", 2), ("wavy.anisotropy", "one", 2), ("varied.roughness", "one", 6), ("wavy.normal", "one", 4),
                     ("varied.anisotropy", "reverse", 2), ("wavy.normal", "reverse", 4)]),
    "velvet": (32, [("half.sheenColor", "one", 2), ("brass.sheenRoughness", "one", 4), ("half.sheenColor", "reverse", 2)]),
    # In Mitsuba's own format, beside this file.
    "mitsuba/shapes": (64, [("red.reflectance", "one")]),
    "mitsuba/textures": (32, [("sky.radiance", "self"), ("panel.reflectance", "reverse")]),
    "mitsuba/emitters": (64, [("red.reflectance", "one")]),
    "mitsuba/environment": (64, [("surroundings.data", "self")]),
    "mitsuba/older": (64, []),
    "mitsuba/tent": (16, [("tiles.reflectance", "reverse")]),
    "mitsuba/gaussian": (16, [("tiles.reflectance", "one")]),
    "mitsuba/covers": (64, [("ground.reflectance", "one"), ("veil.reflectance", "one")]),
    "mitsuba/blends": (64, [("rusty.weight", "one"), ("both.weight", "one"), ("frosted.weight", "one difference 0.2", 4), ("rusty.bsdf_1.reflectance", "one"),
                            ("rusty.weight", "reverse")]),
    "mitsuba/brushed": (64, [("steel.alpha_u", "one", 2), ("steel.alpha_v", "one", 2), ("patterned.alpha_u", "reverse", 2), ("gold.anisotropic", "one", 2),
                            ("block.alpha_u", "one", 4)]),
}

# Mitsuba splats a sample on all pixels that its filter reaches, so their errors go together, and a block's error is larger than those of its pixels tell:
# its square by (integral of the filter)^2 / integral of its square, which error.exr has in it. Such jobs have more samples than the tests then take.
SPLATTED = {"mitsuba/tent": (1.5 * 1.2) ** 2, "mitsuba/gaussian": math.pi}
OVERSAMPLED = 8

# Jobs on another scene, some materials replaced.
GOLD = {"eta": [0.143119, 0.374957, 1.44248], "k": [3.98316, 2.38572, 1.60322]}
VARIANTS = {
    "metals": ("materials", {
        "brass": {"model": "conductor", **GOLD, "colour": [0.9, 0.8, 0.7], "alpha": 0.3, "distribution": "beckmann"},
        "plastic": {"model": "plastic", "ior": 1.5, "colour": [0.15, 0.35, 0.6], "specular": [0.9, 0.9, 0.9], "alpha": 0.1, "distribution": "ggx",
                    "nonlinear": True},
        "half": {"model": "conductor", "eta": [4.36968, 2.9167, 1.6547], "k": [5.20643, 4.23136, 3.75495], "colour": [0.8, 0.8, 0.8]}}),
    "coats": ("materials", {
        "brass": {"model": "dielectric", "ior": 1.5, "colour": [0.9, 0.8, 0.7], "specular": [0.9, 0.9, 0.9], "alpha": 0.2, "distribution": "beckmann"},
        "plastic": {"model": "plastic", "ior": 1.5, "colour": [0.15, 0.35, 0.6], "specular": [0.9, 0.9, 0.9], "nonlinear": False},
        "half": {"model": "plastic", "ior": 1.7, "colour": [0.7, 0.3, 0.3], "specular": [0.9, 0.8, 0.7], "alpha": 0.3, "distribution": "beckmann",
                 "nonlinear": True}}),
    "varnish": ("materials", {
        "brass": {"model": "clearcoat", "clearcoat": 1.0, "clearcoatRoughness": 0.15},
        "plastic": {"model": "clearcoat", "clearcoat": 0.7, "clearcoatRoughness": 0.5},
        "half": {"model": "clearcoat", "clearcoat": 0.5, "clearcoatRoughness": 0.3}}),
    "brushed": ("materials", {
        "varied": {"model": "anisotropy", "anisotropy": 0.7, "rotation": 0.5},
        "wavy": {"model": "anisotropy", "anisotropy": 0.6, "rotation": -0.9}}),
    "velvet": ("materials", {
        "brass": {"model": "sheen", "sheenColor": [0.9, 0.3, 0.2], "sheenRoughness": 0.3},
        "plastic": {"model": "sheen", "sheenColor": [0.9, 0.8, 0.7], "sheenRoughness": 0.2},
        "half": {"model": "sheen", "sheenColor": [0.3, 0.5, 0.8], "sheenRoughness": 0.5},
        "varied": {"model": "sheen", "sheenColor": [0.5, 0.4, 0.2], "sheenRoughness": 0.7}}),
}


def adjoint():
    """The fixed adjoint image of all reverse gradients: smooth, coloured, of mostly one sign."""
    x, y = np.meshgrid((np.arange(SIZE) + 0.5) / SIZE, (np.arange(SIZE) + 0.5) / SIZE)
    return np.stack([1 + 0.8 * np.sin(2 * math.pi * (2 * x + y)), 1 + 0.8 * np.cos(2 * math.pi * (x - 2 * y)),
                     0.8 - 0.6 * np.sin(2 * math.pi * (x + y))], -1)


def write_exr(name, values):
    """float32 RGB; one channel is written three times."""
    values = np.broadcast_to(values, (*values.shape[:2], 3)).tolist()
    height, width = len(values), len(values[0])
    picture = images.Picture(width, height, lambda u, v: values[int(v * height)][int(u * width)])
    (here / name).write_bytes(picture.exr())


class Gradient:
    """Derivatives of one scene's image with respect to one parameter."""

    def __init__(self, translation, parameter):
        self.scene, self.integrator = translation.scene, translation.integrator()
        self.parameters, self.key = translation.parameter(parameter)
        self.base = type(self.parameters[self.key])(self.parameters[self.key])
        self.unit = 1.0
        self.environment = parameter == "environment.radiance"
        if self.environment:  # our values include the intensity, Mitsuba's do not
            self.unit = 1 / translation.extras["environment"].get("intensity", 1)

    def set(self, value):
        self.parameters[self.key] = value
        self.parameters.update()

    def forward(self, direction, spp, seed):
        t = mi.Float(0)
        dr.enable_grad(t)
        self.set(self.base + t * (self.base if direction == "self" else self.unit))
        image = mi.render(self.scene, self.parameters, integrator=self.integrator, spp=spp, seed=seed)
        dr.forward(t, dr.ADFlag.ClearEdges)  # edges from t to the parameter must be gone when rendering starts
        result = np.array(dr.grad(image))
        self.set(self.base)
        return result

    def difference(self, direction, spp, seed, step=0.05):
        """Central finite difference, to check `forward`. Sampling follows the parameter, so a small step would be all noise."""
        ends = []
        for side in (-step, step):
            self.set(self.base + side * (self.base if direction == "self" else self.unit))
            ends.append(np.array(mi.render(self.scene, integrator=self.integrator, spp=spp, seed=seed)))
        self.set(self.base)
        return (ends[1] - ends[0]) / (2 * step)

    def reverse(self, weights, spp, seed):
        value = type(self.base)(self.base)
        dr.enable_grad(value)
        self.set(value)
        image = mi.render(self.scene, self.parameters, integrator=self.integrator, spp=spp, seed=seed)
        dr.backward(dr.sum(image * mi.TensorXf(weights.astype(np.float32)), axis=None))
        result = np.array(dr.grad(value)) * self.unit
        self.set(type(self.base)(self.base))
        if result.ndim < 3:  # a constant
            result = result.reshape(1, 1, -1)
        if ".weight" in self.key or ".alpha_" in self.key:  # a number: Mitsuba's is the luminance of a picture's channels, whose weights have the sum 1
            result = result.sum(-1, keepdims=True)
        if self.environment:  # Mitsuba's array wraps: a copy of the last column before the first, of the first after the last
            result[:, 1] += result[:, -1]
            result[:, -2] += result[:, 0]
            result = result[:, 1:-1]
        return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="TEXT")
    parser.add_argument("--check", action="store_true", help="compare forward derivatives with finite differences instead")
    options = parser.parse_args()
    record = here / "references.json"
    made = json.loads(record.read_text()) if record.exists() else {"references": {}}
    made["mitsuba"], made["size"] = mi.__version__, SIZE
    weights = adjoint().astype(np.float32)
    write_exr("adjoint.exr", weights)
    for scene, (base_spp, derivatives) in JOBS.items():
        translation = None
        for parameter, kind, *factor in [(None, "image")] + derivatives:
            spp = base_spp * (factor[0] if factor else 1)
            name = f"{scene.replace('/', '_')}_{'image' if parameter is None else f'{parameter}_{kind.split()[0]}'}"
            if options.only not in name:
                continue
            if translation is None:
                folder, materials = VARIANTS.get(scene, (scene, {}))
                xml = scene.startswith("mitsuba/")
                translation = XmlScene(here / f"{scene}.xml") if xml else \
                    Translation(here.parent.parent / "scenes" / folder, SIZE, SIZE, materials=materials)
            kind, *by_difference = kind.split()
            step = float(by_difference[1]) if by_difference[1:] else 0.01
            if options.check:
                if kind in ("one", "self"):
                    gradient = Gradient(translation, parameter)
                    for way in (gradient.forward, gradient.difference):
                        means = np.array([way(kind, spp, s).mean((0, 1)) for s in range(SEEDS)])
                        print(f"{name}: {way.__name__} {means.mean(0)} +- {means.std(0) / math.sqrt(SEEDS - 1)}", flush=True)
                continue
            start = time.time()
            most = spp * (OVERSAMPLED if scene in SPLATTED else 1)
            if kind == "image":
                integrator = translation.integrator()
                sample = lambda seed: np.array(mi.render(translation.scene, integrator=integrator, spp=most, seed=seed))
            else:
                gradient = Gradient(translation, parameter)
                sample = (lambda seed: gradient.reverse(weights, most, seed)) if kind == "reverse" else \
                    (lambda seed: gradient.difference(kind, most, seed, step)) if by_difference else (lambda seed: gradient.forward(kind, most, seed))
            runs = np.array([sample(1000 + s) for s in range(SEEDS)], dtype=np.float64)
            mean, error = runs.mean(0), runs.std(0, ddof=1) * math.sqrt(SPLATTED.get(scene, 1) / SEEDS)
            write_exr(name + ".exr", mean)
            write_exr(name + ".error.exr", error)
            entry = {"scene": folder, "what": kind, "spp": spp, "seeds": SEEDS, "maxDepth": translation.max_depth,
                     "file": name + ".exr", "error": name + ".error.exr"}
            if most > spp:
                entry["oversampled"] = most // spp
            if materials:
                entry["materials"] = materials
            if parameter:
                entry["parameter"] = parameter
            if kind == "reverse":
                entry["adjoint"] = "adjoint.exr"
            made["references"][name] = entry
            record.write_text(json.dumps(made, indent=1, sort_keys=True) + "\n")
            spread = runs.mean((1, 2)).std(0, ddof=1) / math.sqrt(SEEDS)
            print(f"{name}: mean {mean.mean((0, 1))} +- {spread}, {time.time() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
