#!/usr/bin/env python3
"""Writes the bundled scenes: generate.py [SCENE...] [-o DIR]; without names, all small ones beside this file.

Everything here is made from formulas, so the scenes carry no licence but ours, and equal runs write equal files.
"""
import argparse
import math
import pathlib
import sys

import images
from gltf import REPEAT, Gltf, Mesh, cross, normalise, rotation, sub


def box():
    """A diffuse box of a few dozen triangles with a ceiling light and a painting."""
    g = Gltf(max_depth=8)
    g.material("painting", texture=g.texture("painting.png", images.Picture(64, 64, images.harbour).png()))
    g.material("white", (0.73, 0.71, 0.68))
    g.material("left", (0.61, 0.08, 0.06))
    g.material("right", (0.13, 0.42, 0.13))
    g.material("frame", (0.22, 0.13, 0.07))
    g.material("light", (0.5, 0.5, 0.5), emission=(14, 11.5, 8.5))
    g.mesh("room", Mesh().quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))
           .quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)).quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)), "white")
    g.mesh("left wall", Mesh().quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), "left")
    g.mesh("right wall", Mesh().quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), "right")
    g.mesh("frame", Mesh().box((-0.62, 0.62, -1), (0.62, 1.86, -0.95), without="z-"), "frame")
    g.mesh("painting", Mesh().quad((-0.56, 0.68, -0.945), (0.56, 0.68, -0.945), (0.56, 1.80, -0.945), (-0.56, 1.80, -0.945)), "painting")
    g.mesh("tall block", Mesh().box((-0.24, 0, -0.24), (0.24, 0.72, 0.24), without="y-")
           .transform(rotation("y", 20), (-0.48, 0, -0.30)), "white")
    g.mesh("short block", Mesh().box((-0.26, 0, -0.26), (0.26, 0.42, 0.26), without="y-")
           .transform(rotation("y", -17), (0.42, 0, 0.25)), "white")
    g.mesh("light", Mesh().quad((-0.3, 1.99, -0.3), (0.3, 1.99, -0.3), (0.3, 1.99, 0.3), (-0.3, 1.99, 0.3)), "light")
    g.camera("front", (0, 1, 3.9), (0, 1, 0), 39)
    g.camera("corner", (0.75, 1.55, 0.9), (-0.25, 0.95, -0.9), 55)
    return g


# The door scene in plan (x to the right, z towards the viewer): the room is -2..2 by -2..2, its right wall is 0.1 thick, the
# corridor lies beyond. The lamp hangs on the corridor's side of that wall and shines away from the room, so every point with
# x <= 2.1 is behind it. The door leaf, hinged on its near side and ajar into the room, hides the opening from the camera;
# so whatever the camera sees lies in front of x = 2.1 and sees no emitter.
def lit_through_door(furnish):
    g = Gltf(max_depth=8)
    g.material("painting", texture=g.texture("painting.png", images.Picture(64, 64, images.harbour).png()))
    g.material("wall", (0.72, 0.70, 0.66))
    g.material("floor", (0.42, 0.30, 0.20))
    g.material("corridor", (0.82, 0.80, 0.76))
    g.material("door", (0.55, 0.44, 0.33))
    g.material("frame", (0.16, 0.10, 0.06))
    g.material("plinth", (0.60, 0.60, 0.62))
    g.material("ball", (0.25, 0.38, 0.52))
    g.material("lamp", (0.5, 0.5, 0.5), emission=(6000, 5000, 3850))
    near, far, height, hinge, top = 2.0, -2.0, 2.6, 0.0, 2.05
    opening = hinge - 0.9
    g.mesh("floor", Mesh().quad((-2, 0, near), (2, 0, near), (2, 0, far), (-2, 0, far)), "floor")
    walls = Mesh()
    walls.quad((-2, height, far), (2, height, far), (2, height, near), (-2, height, near))
    walls.quad((-2, 0, far), (2, 0, far), (2, height, far), (-2, height, far))
    walls.quad((2, 0, near), (-2, 0, near), (-2, height, near), (2, height, near))
    walls.quad((-2, 0, near), (-2, 0, far), (-2, height, far), (-2, height, near))
    walls.box((2, 0, hinge), (2.1, height, near), without="y- y+ z+")
    walls.box((2, 0, far), (2.1, height, opening), without="y- y+ z-")
    walls.box((2, top, opening), (2.1, height, hinge), without="y+ z- z+")
    g.mesh("walls", walls, "wall")
    hall = Mesh()
    hall.quad((2, 0, near), (3.4, 0, near), (3.4, 0, far), (2, 0, far))
    hall.quad((2.1, height, far), (3.4, height, far), (3.4, height, near), (2.1, height, near))
    hall.quad((3.4, 0, far), (3.4, 0, near), (3.4, height, near), (3.4, height, far))
    hall.quad((2.1, 0, far), (3.4, 0, far), (3.4, height, far), (2.1, height, far))
    hall.quad((3.4, 0, near), (2.1, 0, near), (2.1, height, near), (3.4, height, near))
    g.mesh("corridor", hall, "corridor")
    leaf = Mesh().box((-0.045, 0, -0.9), (0, top, 0)).transform(rotation("y", 17), (2, 0, hinge))
    g.mesh("door", leaf, "door")
    g.mesh("frame", Mesh().box((-0.75, 0.80, far), (0.75, 2.30, far + 0.05), without="z-"), "frame")
    g.mesh("painting", Mesh().quad((-0.68, 0.87, far + 0.055), (0.68, 0.87, far + 0.055), (0.68, 2.23, far + 0.055),
                                   (-0.68, 2.23, far + 0.055)), "painting")
    furnish(g)
    g.mesh("lamp", Mesh().quad((2.13, 1.9, 1.7), (2.13, 1.9, 1.5), (2.13, 2.1, 1.5), (2.13, 2.1, 1.7)), "lamp")
    return g


def door():
    """A room that gets all its light through a door ajar from the corridor next to it."""
    def furnish(g):
        g.mesh("plinth", Mesh().box((-1.55, 0, -1.35), (-1.05, 0.55, -0.85), without="y-"), "plinth")
        g.mesh("ball", Mesh().sphere((-1.3, 0.80, -1.1), 0.25, 32, 16), "ball")
    g = lit_through_door(furnish)
    g.camera("room", (-0.9, 1.45, 1.9), (0.32, 1.25, -2), 58)
    return g


def door_roughness():
    """The same room with a metal table under the painting: how polished it is where is what is unknown."""
    def furnish(g):
        polish = images.Picture(16, 16, images.polish).png()
        g.material("table", (0.93, 0.90, 0.86), roughness=1, metallic=1, rough_texture=g.texture("polish.png", polish))
        g.material("leg", (0.10, 0.10, 0.11))
        (x, z), (X, Z), top = (-0.75, -1.75), (1.15, -0.05), 0.62
        g.mesh("table", Mesh().quad((x, top, Z), (X, top, Z), (X, top, z), (x, top, z)), "table")
        g.mesh("apron", Mesh().box((x, top - 0.08, z), (X, top - 0.001, Z), without="y+"), "leg")
        g.mesh("stem", Mesh().box((0.1, 0, -1.0), (0.3, top - 0.08, -0.8), without="y- y+"), "leg")
        g.mesh("ball", Mesh().sphere((-0.42, top + 0.2, -1.42), 0.2, 32, 16), "ball")
    g = lit_through_door(furnish)
    g.camera("room", (-0.75, 1.75, 1.75), (0.28, 0.74, -1.2), 44)
    # The table from two more sides; both see the door's leaf from where it hides the opening.
    g.camera("left", (-1.8, 1.5, 0.3), (0.25, 0.66, -0.85), 50)
    g.camera("right", (1.5, 1.75, 1.3), (0.15, 0.66, -0.95), 50)
    return g


# The occluded scene in plan: the right wall, x = 2, is lit by a lamp that hangs high before it, behind a lintel at x = 1.4, and shines
# away from the room. Whatever the camera sees lies behind the lamp's plane, so no point of it sees an emitter: all its light comes back
# from the right wall and what lies before it. The camera looks the other way and sees neither the wall nor the patches on it.
def occluded():
    """A nearly black patch on a bright wall, both lit by a lamp and seen only by way of other surfaces."""
    g = Gltf(max_depth=8)
    g.material("patch", texture=g.texture("patch.exr", images.Picture(64, 64, images.soot).exr()))
    g.material("wall", (0.62, 0.58, 0.52))
    g.material("floor", (0.40, 0.33, 0.27))
    g.material("bright", (0.88, 0.87, 0.84))
    g.material("black", (0.02, 0.02, 0.02))
    g.material("crate", (0.55, 0.38, 0.20))
    g.material("ball", (0.22, 0.36, 0.52))
    g.material("lamp", (0.1, 0.1, 0.1), emission=(420, 380, 320))
    near, far, left, right, height, lintel = 2.0, -2.0, -2.0, 2.0, 2.4, 1.4
    g.mesh("floor", Mesh().quad((left, 0, near), (right, 0, near), (right, 0, far), (left, 0, far)), "floor")
    walls = Mesh()
    walls.quad((left, height, far), (right, height, far), (right, height, near), (left, height, near))
    walls.quad((left, 0, far), (right, 0, far), (right, height, far), (left, height, far))
    walls.quad((right, 0, near), (left, 0, near), (left, height, near), (right, height, near))
    walls.quad((left, 0, near), (left, 0, far), (left, height, far), (left, height, near))
    walls.box((lintel - 0.05, 1.75, far), (lintel, height, near), without="y+ z- z+")
    g.mesh("walls", walls, "wall")
    g.mesh("bright wall", Mesh().quad((right, 0, far), (right, 0, near), (right, height, near), (right, height, far)), "bright")

    def panel(low, high, y, Y):  # on the right wall, facing the room
        x = right - 0.01
        return Mesh().quad((x, y, low), (x, y, high), (x, Y, high), (x, Y, low))
    g.mesh("patch", panel(-0.4, 0.4, 0.8, 1.6), "patch")
    g.mesh("black panel", panel(0.8, 1.6, 0.8, 1.6), "black")
    g.mesh("crate", Mesh().box((-0.35, 0, -0.35), (0.35, 0.6, 0.35), without="y-").transform(rotation("y", 25), (-1.2, 0, -1.2)), "crate")
    g.mesh("ball", Mesh().sphere((-1.2, 0.88, -1.2), 0.28, 32, 16), "ball")
    x = lintel + 0.03
    g.mesh("lamp", Mesh().quad((x, 2.0, 0.15), (x, 2.0, -0.15), (x, 2.3, -0.15), (x, 2.3, 0.15)), "lamp")
    g.camera("room", (1.15, 1.35, 1.6), (-1.25, 0.75, -1.15), 55)
    return g


def facing(centre, target, half):
    """A square of edge 2 half whose front looks at target."""
    z = normalise(sub(target, centre))
    x = normalise(cross((0, 1, 0), z))
    y = cross(z, x)
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return Mesh().quad(*(tuple(c + half * (i * a + j * b) for c, a, b in zip(centre, x, y)) for i, j in corners))


def bowl():
    """A shallow metal bowl on its side under a small lamp; it focuses a caustic on an inlaid table."""
    g = Gltf(max_depth=8)
    g.material("table", texture=g.texture("table.png", images.Picture(64, 64, images.inlay).png(), nearest=True))
    g.material("bowl", (0.95, 0.66, 0.42), metallic=1, roughness=0.2)
    g.material("wall", (0.42, 0.45, 0.48))
    g.material("floor", (0.25, 0.22, 0.20))
    g.material("lamp", (0.2, 0.2, 0.2), emission=(1500, 1350, 1140))
    g.material("panel", (0.2, 0.2, 0.2), emission=(0.6, 0.7, 0.85))
    g.mesh("table", Mesh().quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)), "table")
    g.mesh("floor", Mesh().quad((-4, -0.8, 4), (4, -0.8, 4), (4, -0.8, -2.2), (-4, -0.8, -2.2)), "floor")
    g.mesh("wall", Mesh().quad((-4, -0.8, -2.2), (4, -0.8, -2.2), (4, 4, -2.2), (-4, 4, -2.2)), "wall")

    def shell(u, v):
        # Profile of a bowl around +y: inner wall from the bottom to the rim, round lip, outer wall back to the bottom.
        phi = 2 * math.pi * (u % 1)
        inner, thick, open_angle = 0.90, 0.02, math.radians(31)
        if v < 0.46:
            theta, radius = open_angle * v / 0.46, inner
        elif v < 0.54:
            turn = math.pi * (v - 0.46) / 0.08
            theta = open_angle + 0.5 * thick / inner * math.sin(turn)
            radius = inner + 0.5 * thick * (1 - math.cos(turn))
        else:
            theta, radius = open_angle * (1 - v) / 0.46, inner + thick
        if v in (0, 1):
            theta = 0
        r = radius * math.sin(theta)
        return (r * math.cos(phi), -radius * math.cos(theta), r * math.sin(phi) if theta else 0)

    # On its side, turned so that the lamp's light is thrown down in front of it.
    side = Mesh().surface(shell, 64, 50).transform(rotation("x", 89)).transform(rotation("y", -4))
    side.shift((-0.12, -min(p[1] for p in side.positions), 0.15))
    g.mesh("bowl", side, "bowl")
    g.mesh("lamp", facing((-0.95, 1.5, 1.05), (-0.1, 0.4, -0.75), 0.05), "lamp")
    g.mesh("panel", Mesh().quad((-2, 3.5, -2), (2, 3.5, -2), (2, 3.5, 2), (-2, 3.5, 2)), "panel")
    g.camera("front", (0.75, 1.5, 2.1), (-0.02, 0.22, -0.1), 40)
    return g


def sky(u, v):
    """Radiance of a clear evening sky above a dim ground, over longitude and latitude; the sun is set apart."""
    elevation = math.pi * (0.5 - v)
    azimuth = math.cos(2 * math.pi * (u - SUN_COLUMN / 128))
    if elevation < 0:
        return (0.10, 0.09, 0.075)
    up = math.sin(elevation) ** 0.6
    glow = 0.14 * math.exp(-6 * elevation) * (0.6 + 0.4 * azimuth)
    return (0.05 - 0.025 * up + glow, 0.065 - 0.02 * up + 0.6 * glow, 0.10 + 0.01 * up + 0.25 * glow)


SUN_COLUMN, SUN_ROW = 44, 19


def environment():
    """A ring and a ball on a mosaic under a sky whose sun fills two texels."""
    g = Gltf(max_depth=8)
    map_ = images.Picture(128, 64, sky)
    for column in (SUN_COLUMN, SUN_COLUMN + 1):
        map_.rows[SUN_ROW][column] = (1000.0, 880.0, 700.0)
    g.environment("sky.exr", map_.exr())
    g.material("painting", texture=g.texture("painting.png", images.Picture(64, 64, images.mosaic).png()))
    g.material("ring", (0.80, 0.72, 0.60))
    g.material("ball", (0.60, 0.12, 0.08), roughness=0.35, specular=1)
    g.material("steel", (0.70, 0.72, 0.75), metallic=1, roughness=0.4)
    g.material("sand", (0.45, 0.40, 0.32))
    g.mesh("ground", Mesh().quad((-1.6, 0, 1.6), (1.6, 0, 1.6), (1.6, 0, -1.6), (-1.6, 0, -1.6)), "painting")
    g.mesh("sand", Mesh().quad((-30, -0.02, 30), (30, -0.02, 30), (30, -0.02, -30), (-30, -0.02, -30)), "sand")

    def ring(u, v):
        a, b = 2 * math.pi * (u % 1), 2 * math.pi * (v % 1)
        r = 0.55 + 0.17 * math.cos(b)
        return (r * math.cos(a), r * math.sin(a), 0.17 * math.sin(b))

    g.mesh("ring", Mesh().surface(ring, 64, 24).transform(rotation("y", 25), (-0.15, 0.72, -0.45)), "ring")
    g.mesh("ball", Mesh().sphere((0.62, 0.30, 0.25), 0.30), "ball")
    g.mesh("steel ball", Mesh().sphere((-0.75, 0.22, 0.50), 0.22), "steel")
    g.camera("front", (0.5, 1.45, 3.7), (0, 0.52, 0), 38)
    return g


def furnace():
    """Closed, every face emits Le = 0.5 and reflects rho = 0.6: L = Le (1 - rho^D) / (1 - rho) in every direction."""
    g = Gltf(max_depth=8)
    g.material("wall", (0.6, 0.6, 0.6), emission=(0.5, 0.5, 0.5))
    inside = Mesh().box((-1, -1, -1), (1, 1, 1))
    inside.indices = inside.indices[::-1]  # faces point inwards
    g.mesh("box", inside, "wall")
    g.mesh("block", Mesh().box((-0.3, -0.4, -0.5), (0.2, 0.1, 0.0)), "wall")
    g.camera("inside", (0.3, 0.2, 0.9), (0, 0, -0.3), 60)
    return g


def materials():
    """Small test scene in which every differentiable slot appears, constant and textured."""
    g = Gltf(max_depth=5)
    bump = lambda u, v: (127.5 + 50 * math.sin(8 * math.pi * u), 127.5 + 50 * math.cos(6 * math.pi * v), 240)
    rough = lambda u, v: (0, 60 + 170 * ((int(u * 8) + int(v * 8)) % 2), 40 + 200 * (u > 0.5))
    glow = lambda u, v: (255, 200, 120) if math.hypot(u - 0.5, v - 0.5) < 0.33 else (60, 110, 200)
    texture = lambda name, picture, size, **more: g.texture(name, images.Picture(size, size, picture).png(), **more)
    g.environment("sky.exr", images.Picture(32, 16, lambda u, v: (
        0.35 + 0.2 * math.cos(2 * math.pi * u), 0.4, 0.6 - 0.3 * v)).exr(), intensity=0.5, rotation_radians=0.7)
    g.material("painting", texture=texture("painting.png", images.mosaic, 32))
    g.material("varied", (0.8, 0.6, 0.4), roughness=1, metallic=1, specular=1,
               rough_texture=texture("rough.png", rough, 16, wrap=REPEAT))
    g.material("wavy", (0.5, 0.6, 0.7), roughness=0.4, metallic=0.4, specular=0.8,
               normal_texture=texture("normal.png", bump, 16, wrap=REPEAT), normal_scale=0.8)
    g.material("plastic", (0.15, 0.35, 0.6), roughness=0.3, specular=1)
    g.material("brass", (0.9, 0.7, 0.35), roughness=0.35, metallic=1)
    g.material("half", (0.7, 0.3, 0.3), roughness=0.5, metallic=0.5, specular=0.5)
    g.material("lamp", (0.5, 0.5, 0.5), emission=(7, 6, 5), emission_texture=texture("lamp.png", glow, 8))
    g.mesh("ground", Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), "painting")
    g.mesh("varied panel", Mesh().quad((-1.8, 0.0, -1.0), (-0.1, 0.0, -1.5), (-0.1, 1.6, -1.5), (-1.8, 1.6, -1.0)), "varied")
    g.mesh("wavy panel", Mesh().quad((0.1, 0.0, -1.5), (1.8, 0.0, -1.0), (1.8, 1.6, -1.0), (0.1, 1.6, -1.5)), "wavy")
    for i, name in enumerate(("plastic", "brass", "half")):
        g.mesh(name, Mesh().sphere((-1.1 + 1.1 * i, 0.4, 0.2), 0.4, 32, 16), name)
    g.mesh("lamp", Mesh().quad((-0.6, 2.4, -0.4), (0.6, 2.4, -0.4), (0.6, 2.4, 0.8), (-0.6, 2.4, 0.8)), "lamp")
    g.camera("front", (0, 1.5, 4.2), (0, 0.65, -0.4), 42)
    return g


def glass():
    """A room whose lamp shines through a closed pane, a glass ball before its painting, and a glass block: no light sample finds the lamp."""
    g = Gltf(max_depth=8)
    g.material("painting", texture=g.texture("painting.png", images.Picture(64, 64, images.harbour).png()))
    g.material("white", (0.73, 0.71, 0.68))
    g.material("left", (0.61, 0.08, 0.06))
    g.material("right", (0.13, 0.42, 0.13))
    g.material("light", (0.5, 0.5, 0.5), emission=(9, 7.5, 5.5))
    g.material("pane", (0.95, 0.97, 1), roughness=0, specular=1, glass="pane", ior=1.5)
    g.material("ball", (1, 1, 1), roughness=0, specular=1, glass="solid", ior=1.5)
    g.material("block", (0.75, 0.9, 0.85), roughness=0, specular=1, glass="solid", ior=1.33)
    g.mesh("room", Mesh().quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))
           .quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)).quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)), "white")
    g.mesh("left wall", Mesh().quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), "left")
    g.mesh("right wall", Mesh().quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), "right")
    g.mesh("painting", Mesh().quad((-0.56, 0.68, -0.945), (0.56, 0.68, -0.945), (0.56, 1.80, -0.945), (-0.56, 1.80, -0.945)), "painting")
    g.mesh("light", Mesh().quad((-0.5, 1.99, -0.5), (0.5, 1.99, -0.5), (0.5, 1.99, 0.5), (-0.5, 1.99, 0.5)), "light")
    g.mesh("pane", Mesh().quad((-1, 1.9, -1), (1, 1.9, -1), (1, 1.9, 1), (-1, 1.9, 1)), "pane")
    g.mesh("ball", Mesh().sphere((-0.35, 0.62, 0.05), 0.36, 96, 48), "ball")
    g.mesh("block", Mesh().box((-0.2, 0.02, -0.2), (0.2, 0.5, 0.2)).transform(rotation("y", 30), (0.5, 0, 0.25)), "block")
    g.camera("front", (0, 1, 3.9), (0, 1, 0), 39)
    return g


SMALL = {f.__name__: f for f in (box, door, door_roughness, occluded, bowl, environment, furnace, materials, glass)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"of: {' '.join(SMALL)} room (default: all but room)")
    parser.add_argument("-o", metavar="DIR", help="folder for one scene (default: scenes/<name>)")
    options = parser.parse_args()
    names = options.scenes or list(SMALL)
    if options.o and len(names) != 1:
        parser.error("-o takes exactly one scene")
    for name in names:
        if name == "room":
            from room import room as make
        elif name in SMALL:
            make = SMALL[name]
        else:
            parser.error(f"no scene '{name}'; known: {' '.join(SMALL)} room")
        scene = make()
        folder = pathlib.Path(options.o) if options.o else pathlib.Path(__file__).parent / name
        scene.write(folder)
        print(f"{folder}: {scene.triangles()} triangles", file=sys.stderr)


if __name__ == "__main__":
    main()
