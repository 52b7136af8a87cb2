#!/usr/bin/env python3
"""Writes tangents.json: what the reference implementation of MikkTSpace says for small meshes, by PyPI's pymikktspace 0.3.0.

    python3.10 -m venv venv && echo 'cython<3' > old && PIP_CONSTRAINT=old venv/bin/pip install pymikktspace==0.3.0 'numpy<2' && venv/bin/python make_tangents.py

Its code compiles neither for Python 3.11 and later nor with Cython 3. Tangents are one a corner, x y z and the sign; a corner to which texture coordinates give no direction
has (1, 0, 0) and -1, or zero. The tests need nothing of this.
"""
import json
import pathlib

import numpy as np
from mikktspace import gen_default


def grid(point, normal, columns, rows, uv=lambda u, v: (u, v)):
    """point(u, v) over the unit square; a seam and poles are what points and texture coordinates make of it."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    lists = [np.stack(f(u, v), -1).reshape((columns + 1) * (rows + 1), -1) for f in (point, normal, uv)]
    a = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return (*lists, np.stack([a, b, c, a, c, d], 1).reshape(-1, 3))


def ball(u, v):
    return np.sin(np.pi * v) * np.cos(2 * np.pi * u), np.cos(np.pi * v), np.sin(np.pi * v) * np.sin(2 * np.pi * u)


def ring(u, v):
    r = 1 + 0.3 * np.cos(2 * np.pi * v)
    return r * np.cos(2 * np.pi * u), 0.3 * np.sin(2 * np.pi * v), r * np.sin(2 * np.pi * u)


def around_ring(u, v):
    c = np.cos(2 * np.pi * v)
    return c * np.cos(2 * np.pi * u), np.sin(2 * np.pi * v), c * np.sin(2 * np.pi * u)


def apex(n):
    """A cone whose tip has one pair of texture coordinates: tangents around it are opposite in pairs."""
    a = 2 * np.pi * np.arange(n + 1) / n
    rim = np.stack([np.cos(a), np.sin(a), -np.ones(n + 1)], 1)
    positions = np.concatenate([[[0, 0, 0]], rim])
    normals = np.concatenate([[[0, 0, 1]], (rim + [0, 0, 2]) / np.sqrt(2)])
    uvs = np.concatenate([[[0.5, 0]], np.stack([a / (2 * np.pi), np.ones(n + 1)], 1)])
    i = np.arange(n)
    return positions, normals, uvs, np.stack([0 * i, i + 1, i + 2], 1)


def meshes():
    rng = np.random.default_rng(5)
    yield "sphere", grid(ball, ball, 8, 5)
    yield "sphere, a point for each pole", grid(ball, ball, 8, 4, lambda u, v: (np.where((v == 0) | (v == 1), 0.5, u), v))
    yield "torus", grid(ring, around_ring, 9, 6)
    yield "torus, mirrored", grid(ring, around_ring, 8, 6, lambda u, v: (abs(u - 0.5), v))
    yield "cone", apex(8)
    p, n, uv, t = grid(ring, around_ring, 7, 5)
    uv = uv + rng.normal(size=uv.shape) * 0.05
    yield "torus, noisy", (p + rng.normal(size=p.shape) * 0.03, n, uv, rng.permutation(t))
    turned = np.where(rng.uniform(size=(len(t), 1)) < 0.3, t[:, [0, 2, 1]], t)
    yield "torus, some triangles turned", (p, n, uv, turned)
    uv = uv.copy()
    uv[rng.uniform(size=len(uv)) < 0.3] = 0.25, 0.5
    yield "torus, some of its map in a point", (p, n, uv, t)
    p = p.copy()
    p[[3, 17, 22]] = p[[4, 18, 23]]
    yield "torus, with degenerate triangles", (p, n, uv, t)
    n = rng.normal(size=(12, 3))
    yield "anything", (rng.normal(size=(12, 3)), n, rng.uniform(size=(12, 2)), rng.integers(0, 12, (40, 3)))
    yield "anything on a coarse grid", (rng.integers(-1, 2, (14, 3)), np.round(n[:1]).repeat(14, 0), rng.integers(0, 3, (14, 2)), rng.integers(0, 14, (40, 3)))


def main():
    out = {"pymikktspace": "0.3.0", "meshes": []}
    number = lambda x: round(float(x), 6) + 0.0  # zero without sign
    for name, (positions, normals, uvs, triangles) in meshes():
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        positions, normals, uvs = (np.ascontiguousarray(np.round(a, 4), np.float32) for a in (positions, normals, uvs))
        corners = np.ascontiguousarray(triangles, np.uint32).ravel()
        # It writes tangents by index, so each corner is a vertex; it welds equal ones itself.
        tangents = gen_default(np.arange(len(corners), dtype=np.uint32), *(a[corners].ravel() for a in (positions, normals, uvs)))
        values = {"positions": positions, "normals": normals, "uvs": uvs, "tangents": tangents}
        out["meshes"].append({"name": name, **{k: [number(x) for x in np.ravel(v)] for k, v in values.items()}, "corners": corners.tolist()})
    text = json.dumps(out).replace('{"name"', '\n{"name"')
    (pathlib.Path(__file__).parent / "tangents.json").write_text(text + "\n")


if __name__ == "__main__":
    main()
