"""The furnished room: at least 250 000 triangles of furniture, cloth and crockery, for traversal and memory."""
import math
import random

import images
from gltf import Gltf, Mesh, rotation


def lathe(profile, columns, rows, centre):
    """A pot: profile(t) -> (radius, height) for t in [0,1], from the bottom up, turned about y."""
    def point(u, v):
        radius, height = profile(v)
        phi = -2 * math.pi * (u % 1)
        return (centre[0] + radius * math.cos(phi), centre[1] + height, centre[2] + radius * math.sin(phi))
    return Mesh().surface(point, columns, rows)


def vase(t):
    return (0.11 + 0.06 * math.sin(1.2 + 5.2 * t) + 0.01 * t, 0.42 * t)


def cup(t):
    return (0.02 + 0.05 * math.sqrt(t), 0.09 * t)


def plate(t):
    return (0.01 + 0.12 * t, 0.015 * t * t + 0.002)


def chair(offset, degrees):
    legs = Mesh()
    for x in (-0.2, 0.2):
        for z in (-0.2, 0.2):
            legs.merge(lathe(lambda t: (0.018 + 0.006 * math.sin(25 * t) * math.sin(math.pi * t), 0.45 * t), 24, 48, (x, 0, z)))
    for i in range(5):
        x = -0.18 + 0.09 * i
        legs.merge(lathe(lambda t: (0.012 + 0.003 * math.sin(30 * t), 0.45 + 0.5 * t), 16, 40, (x, 0, -0.2)))
    return legs.transform(rotation("y", degrees), offset)


def cushion(width, height, depth, centre, columns=64):
    """A superellipsoid."""
    def power(c, e):
        return math.copysign(abs(c) ** e, c)

    def point(u, v):
        a, b = -2 * math.pi * (u % 1), math.pi * (v - 0.5)
        c = power(math.cos(b), 0.4) if 0 < v < 1 else 0.0
        return (centre[0] + width / 2 * c * power(math.cos(a), 0.4), centre[1] + height / 2 * power(math.sin(b), 0.4),
                centre[2] + depth / 2 * c * power(math.sin(a), 0.4))
    return Mesh().surface(point, columns, columns // 2)


def curtain(x, width, phase):
    def point(u, v):
        fold = 0.05 * math.sin(40 * u + phase) + 0.015 * math.sin(97 * u + 5 * v)
        return (x + width * u, 0.1 + 2.4 * v, -2.38 + fold * (1 - 0.5 * v))
    return Mesh().surface(point, 160, 40)


def rug(u, v):
    x, z = 3.2 * (u - 0.5), -2.2 * (v - 0.5)
    return (x, 0.012 + 0.006 * math.sin(60 * x) * math.sin(55 * z) + 0.004 * math.sin(7 * x + 3 * z), z + 0.2)


def leaf(rng):
    """One blade of a plant, rooted at the origin and bending under its own weight."""
    turn, bend, length, width = rng.uniform(0, 2 * math.pi), rng.uniform(0.6, 1.6), rng.uniform(0.35, 0.7), rng.uniform(0.02, 0.04)

    def point(u, v):
        reach, rise = length * math.sin(bend * v) / bend, length * (v - 0.35 * bend * v * v)
        side = width * (2 * u - 1) * math.sin(math.pi * (0.1 + 0.9 * v))
        c, s = math.cos(turn), math.sin(turn)
        return (c * reach - s * side, rise, s * reach + c * side)
    return Mesh().surface(point, 2, 10)


def room():
    rng = random.Random(7)  # equal on every run
    g = Gltf(max_depth=8)
    g.material("painting", texture=g.texture("painting.png", images.Picture(64, 64, images.harbour).png()))
    g.material("wall", (0.74, 0.72, 0.68))
    g.material("floor", (0.40, 0.29, 0.19))
    g.material("frame", (0.20, 0.12, 0.07))
    g.material("wood", (0.42, 0.27, 0.15), roughness=0.45, specular=1)
    g.material("rug", (0.45, 0.16, 0.14))
    g.material("curtain", (0.30, 0.38, 0.45))
    g.material("cushion", (0.55, 0.48, 0.30))
    g.material("sofa", (0.22, 0.32, 0.30))
    g.material("glaze", (0.20, 0.40, 0.55), roughness=0.2, specular=1)
    g.material("china", (0.80, 0.79, 0.76), roughness=0.3, specular=1)
    g.material("brass", (0.90, 0.72, 0.38), metallic=1, roughness=0.3)
    g.material("leaf", (0.16, 0.34, 0.12))
    for i, colour in enumerate([(0.45, 0.15, 0.12), (0.15, 0.25, 0.40), (0.50, 0.42, 0.22), (0.18, 0.34, 0.22), (0.60, 0.56, 0.50)]):
        g.material(f"book {i}", colour)
    g.material("window", (0.3, 0.3, 0.3), emission=(7, 8, 10))
    g.material("bulb", (0.5, 0.5, 0.5), emission=(40, 30, 18))

    g.mesh("floor", Mesh().quad((-3, 0, 2.5), (3, 0, 2.5), (3, 0, -2.5), (-3, 0, -2.5)), "floor")
    shell = Mesh().quad((-3, 2.8, -2.5), (3, 2.8, -2.5), (3, 2.8, 2.5), (-3, 2.8, 2.5))
    shell.quad((-3, 0, -2.5), (3, 0, -2.5), (3, 2.8, -2.5), (-3, 2.8, -2.5)).quad((3, 0, 2.5), (-3, 0, 2.5), (-3, 2.8, 2.5), (3, 2.8, 2.5))
    shell.quad((-3, 0, 2.5), (-3, 0, -2.5), (-3, 2.8, -2.5), (-3, 2.8, 2.5)).quad((3, 0, -2.5), (3, 0, 2.5), (3, 2.8, 2.5), (3, 2.8, -2.5))
    g.mesh("walls", shell, "wall")
    g.mesh("window", Mesh().quad((0.9, 0.8, -2.48), (2.3, 0.8, -2.48), (2.3, 2.2, -2.48), (0.9, 2.2, -2.48)), "window")
    g.mesh("curtains", curtain(0.25, 0.75, 0).merge(curtain(2.2, 0.75, 1)), "curtain")
    g.mesh("frame", Mesh().box((-1.56, 0.99, -2.5), (-0.34, 2.21, -2.46), without="z-"), "frame")
    g.mesh("painting", Mesh().quad((-1.5, 1.05, -2.455), (-0.4, 1.05, -2.455), (-0.4, 2.15, -2.455), (-1.5, 2.15, -2.455)), "painting")
    g.mesh("rug", Mesh().surface(rug, 160, 110), "rug")

    g.mesh("table top", Mesh().box((-0.75, 0.70, -0.45), (0.75, 0.74, 0.85)), "wood")
    legs = Mesh()
    for x in (-0.65, 0.65):
        for z in (-0.35, 0.75):
            legs.merge(lathe(lambda t: (0.035 + 0.015 * math.sin(18 * t) * math.sin(math.pi * t), 0.7 * t), 48, 64, (x, 0, z)))
    for x, z, turn in ((-0.4, -0.75, 0), (0.4, -0.72, 8), (-0.4, 1.15, 175), (0.45, 1.2, 190)):
        legs.merge(chair((x, 0, z), turn))
    g.mesh("legs", legs, "wood")
    seats = Mesh()
    for x, z in ((-0.4, -0.75), (0.4, -0.72), (-0.4, 1.15), (0.45, 1.2)):
        seats.merge(cushion(0.46, 0.07, 0.46, (x, 0.48, z)))
    g.mesh("seats", seats, "cushion")
    china = Mesh()
    for x, z in ((-0.45, -0.2), (0.4, -0.2), (-0.4, 0.6), (0.4, 0.6)):
        china.merge(lathe(plate, 64, 12, (x, 0.741, z))).merge(lathe(cup, 64, 24, (x + 0.2, 0.741, z)))
    g.mesh("china", china, "china")
    g.mesh("vase", lathe(vase, 96, 64, (0, 0.741, 0.2)), "glaze")

    sofa = cushion(0.75, 0.40, 2.0, (-2.5, 0.25, 0.4), 72).merge(cushion(0.25, 0.8, 2.0, (-2.8, 0.55, 0.4), 72))
    sofa.merge(cushion(0.8, 0.6, 0.25, (-2.5, 0.35, -0.65), 72)).merge(cushion(0.8, 0.6, 0.25, (-2.5, 0.35, 1.45), 72))
    g.mesh("sofa", sofa, "sofa")
    pillows = Mesh()
    for z in (-0.2, 0.4, 1.0):
        pillows.merge(cushion(0.18, 0.42, 0.42, (0, 0, 0), 72).transform(rotation("z", 18), (-2.45, 0.63, z)))
    g.mesh("pillows", pillows, "cushion")

    shelf = Mesh()
    for y in (0.05, 0.45, 0.85, 1.25, 1.65, 2.05):
        shelf.box((2.65, y, -1.2), (3, y + 0.03, 1.2))
    for z in (-1.2, -0.4, 0.4, 1.17):
        shelf.box((2.65, 0, z), (3, 2.08, z + 0.03))
    g.mesh("shelf", shelf, "wood")
    books = [Mesh() for _ in range(5)]
    for y in (0.08, 0.48, 0.88, 1.28, 1.68):
        z = -1.15
        while z < 1.12:
            thick, tall, deep = rng.uniform(0.018, 0.05), rng.uniform(0.22, 0.34), rng.uniform(0.18, 0.26)
            if rng.random() < 0.9 and not any(s - thick < z < s + 0.035 for s in (-0.4, 0.4)):
                rng.choice(books).box((2.97 - deep, y, z), (2.97, y + tall, z + thick * 0.95))
            z += thick
    for i, mesh in enumerate(books):
        g.mesh(f"books {i}", mesh, f"book {i}")
    pots = Mesh()
    for z in (-0.8, 0.0, 0.8):
        pots.merge(lathe(vase, 96, 64, (2.82, 2.08, z)))
    pots.merge(lathe(vase, 96, 64, (-2.5, 0.0, -1.9)))
    g.mesh("pots", pots, "glaze")
    plant = Mesh()
    for centre, size in (((-2.5, 0.40, -1.9), 1.2), ((0, 1.14, 0.2), 0.55), ((2.82, 2.46, 0.0), 0.4)):
        for _ in range(160):
            plant.merge(leaf(rng).transform(((size, 0, 0), (0, size, 0), (0, 0, size)), centre))
    g.mesh("plants", plant, "leaf")

    lamp, bulbs = lathe(lambda t: (0.012, 0.5 * t), 24, 24, (0, 2.3, 0.2)), Mesh()
    for i in range(8):
        a = i * math.pi / 4
        x, z = 0.35 * math.cos(a), 0.2 + 0.35 * math.sin(a)
        lamp.merge(lathe(lambda t: (0.02 + 0.03 * t, 0.06 * t), 32, 16, (x, 2.27, z))).merge(Mesh().sphere((x, 2.25, z), 0.03))
        arm = lathe(lambda t: (0.006, 0.35 * t), 12, 8, (0, 0, 0)).transform(rotation("z", -90))
        lamp.merge(arm.transform(rotation("y", -45 * i), (0, 2.27, 0.2)))
        bulbs.merge(Mesh().sphere((x, 2.36, z), 0.03, 8, 4))
    g.mesh("lamp", lamp, "brass")
    g.mesh("bulbs", bulbs, "bulb")
    g.camera("front", (1.2, 1.6, 2.35), (-0.45, 0.95, -0.6), 58)
    g.camera("sofa", (-2.0, 1.2, 1.9), (1.2, 0.9, -0.8), 62)
    return g
