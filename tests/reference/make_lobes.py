#!/usr/bin/env python3
"""Writes lobes.json: what Mitsuba's BSDF plugins say for single pairs of directions (f cos, density), in the frame where the normal is +z.

Directions: wo is where the path came from, wi where it goes. Smooth boundaries: what is sampled for two numbers. Needs Mitsuba 3; the tests do not.
"""
import json
import pathlib

import mitsuba as mi

mi.set_variant("llvm_ad_rgb")

import drjit as dr
import numpy as np

GOLD = {"eta": [0.143119, 0.374957, 1.44248], "k": [3.98316, 2.38572, 1.60322]}
STEEL = {"eta": [4.36968, 2.9167, 1.6547], "k": [5.20643, 4.23136, 3.75495]}


def rgb(*value):
    return {"type": "rgb", "value": list(value)}


def rough(distribution, alpha):
    return {"distribution": distribution, "alpha": alpha}


def conductor(metal, reflectance, **more):
    return {"model": "conductor", **metal, "colour": reflectance, **more}


def plastic(base, reflectance, ior, nonlinear, **more):
    return {"model": "plastic", "colour": base, "specular": reflectance, "ior": ior, "nonlinear": nonlinear, **more}


MATERIALS = [
    conductor(GOLD, [1, 0.9, 0.8], **rough("beckmann", 0.1)),
    conductor(GOLD, [1, 0.9, 0.8], **rough("ggx", 0.3)),
    conductor(STEEL, [0.5, 0.7, 1], **rough("ggx", 0.05)),
    conductor(STEEL, [0.5, 0.7, 1], **rough("beckmann", 0.6)),
    plastic([0.2, 0.5, 0.9], [1, 0.8, 0.6], 1.5, True, **rough("beckmann", 0.2)),
    plastic([0.2, 0.5, 0.9], [1, 1, 1], 1.5, False, **rough("ggx", 0.1)),
    plastic([0.9, 0.5, 0.1], [1, 1, 1], 1.9, True, **rough("ggx", 0.5)),
    plastic([0.2, 0.5, 0.9], [1, 0.8, 0.6], 1.5, True),
    plastic([0.9, 0.5, 0.1], [1, 1, 1], 1.3, False),
    {"model": "dielectric", "colour": [1, 0.9, 0.8], "specular": [0.7, 0.9, 1], "ior": 1.5, **rough("ggx", 0.2)},
    {"model": "dielectric", "colour": [1, 1, 1], "specular": [1, 1, 1], "ior": 1.33, **rough("beckmann", 0.35)},
    {"model": "dielectric", "colour": [1, 1, 1], "specular": [1, 1, 1], "ior": 0.7, **rough("ggx", 0.4)},
]
# With two alphas, along x and y.
ANISOTROPIC = [
    conductor(GOLD, [1, 0.9, 0.8], distribution="ggx", alpha_u=0.3, alpha_v=0.05),
    conductor(STEEL, [0.5, 0.7, 1], distribution="beckmann", alpha_u=0.1, alpha_v=0.5),
    {"model": "dielectric", "colour": [1, 0.9, 0.8], "specular": [0.7, 0.9, 1], "ior": 1.5, "distribution": "ggx", "alpha_u": 0.15, "alpha_v": 0.45},
    {"model": "dielectric", "colour": [1, 1, 1], "specular": [1, 1, 1], "ior": 1.33, "distribution": "beckmann", "alpha_u": 0.4, "alpha_v": 0.15},
]
SINGLE = [
    {"model": "dielectric", "colour": [1, 0.9, 0.8], "specular": [0.7, 0.9, 1], "ior": 1.5},
    {"model": "dielectric", "colour": [1, 1, 1], "specular": [1, 1, 1], "ior": 0.8},
    {"model": "thindielectric", "colour": [1, 0.9, 0.8], "specular": [0.7, 0.9, 1], "ior": 1.5},
    conductor(GOLD, [1, 0.9, 0.8]),
]


def load(m):
    plugin = m["model"]
    if "distribution" in m:
        plugin = "rough" + plugin
    d = {"type": plugin}
    for key in ("alpha", "alpha_u", "alpha_v", "distribution"):
        if key in m:
            d[key] = m[key]
    if m["model"] == "conductor":
        d.update(eta=rgb(*m["eta"]), k=rgb(*m["k"]), specular_reflectance=rgb(*m["colour"]))
    else:
        d.update(int_ior=m["ior"], ext_ior=1.0, specular_reflectance=rgb(*m["specular"]))
        if m["model"] == "plastic":
            d.update(diffuse_reflectance=rgb(*m["colour"]), nonlinear=m["nonlinear"])
        else:
            d["specular_transmittance"] = rgb(*m["colour"])
    return mi.load_dict(d)


def interaction(wo, n):
    si = dr.zeros(mi.SurfaceInteraction3f, n)
    si.wi = wo  # Mitsuba's wi is where the path came from
    si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
    si.n = mi.Normal3f(0, 0, 1)
    return si


def directions(rng, n, both):
    z = rng.uniform(0.03, 1, n) * (rng.choice([-1, 1], n) if both else 1)
    phi = rng.uniform(0, 2 * np.pi, n)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z])


def pairs(materials, rng, n):
    """Pairs of directions and what the materials say for them."""
    found, context = [], mi.BSDFContext()
    for m in materials:
        bsdf, both = load(m), m["model"] == "dielectric"
        wo = directions(rng, n, both)
        # Half around what is sampled, half anywhere.
        si = interaction(mi.Vector3f(*wo.astype(np.float32)), n)
        bs, _ = bsdf.sample(context, si, mi.Float(rng.uniform(0, 1, n).astype(np.float32)), mi.Point2f(*rng.uniform(0, 1, (2, n)).astype(np.float32)))
        drawn = np.array(bs.wo).reshape(3, n)
        wi = directions(rng, n, both)
        use = (np.arange(n) % 2 == 0) & (np.abs(np.linalg.norm(drawn, axis=0) - 1) < 1e-3) & (np.abs(drawn[2]) > 0.03)
        wi[:, use] = drawn[:, use]
        value, pdf = bsdf.eval_pdf(context, si, mi.Vector3f(*wi.astype(np.float32)))
        value = np.array(value).reshape(3, n)
        found.append({"material": m, "wo": wo.T.round(7).tolist(), "wi": wi.T.round(7).tolist(), "value": value.T.tolist()})
    return found


def main():
    rng = np.random.default_rng(11)
    context, n = mi.BSDFContext(), 60
    out = {"mitsuba": mi.__version__, "pairs": pairs(MATERIALS, rng, n), "single": []}
    for m in SINGLE:
        bsdf, both = load(m), m["model"] != "conductor"
        wo = directions(rng, n, both)
        si = interaction(mi.Vector3f(*wo.astype(np.float32)), n)
        bs, weight = bsdf.sample(context, si, mi.Float(rng.uniform(0, 1, n).astype(np.float32)), mi.Point2f(*rng.uniform(0, 1, (2, n)).astype(np.float32)))
        carried = np.array(weight).reshape(3, n) * np.array(bs.pdf)
        out["single"].append({"material": m, "wo": wo.T.round(7).tolist(), "wi": np.array(bs.wo).reshape(3, n).T.tolist(), "carried": carried.T.tolist()})
    out["pairs"] += pairs(ANISOTROPIC, np.random.default_rng(12), n)
    (pathlib.Path(__file__).parent / "lobes.json").write_text(json.dumps(out) + "\n")


if __name__ == "__main__":
    main()
