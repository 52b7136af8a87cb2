"""Scenes of bench-differing that are not bundled: light that comes in from outside, a ball seen from all sides, a screen, many lamps, a pane or a slab of glass
before a picture, a poster of many texels to a pixel, a ball of glass over a floor, a tabletop with maps of all that it is, reliefs of stone and metal, polished balls
under a sun, tiles in the shade."""
import math
import random

from beside_mitsuba import root  # also makes scenes/ importable

import images
from generate import facing
from gltf import REPEAT, Gltf, Mesh


def clouds(u, v):
    """Smooth waves of many lengths, nothing like the drawings of the bundled scenes."""
    waves = ((1, 2, 0.3), (3, 1, 1.1), (5, 4, 2.0), (9, 7, 0.7), (16, 13, 1.9), (23, 29, 0.1))
    a = 0.5 + 0.18 * sum(math.sin(2 * math.pi * (x * u + y * v) + phase) / (i + 1) for i, (x, y, phase) in enumerate(waves))
    b = 0.5 + 0.2 * math.sin(2 * math.pi * (2 * u - 3 * v)) * math.cos(9 * u)
    return tuple(255 * min(1, max(0, c)) for c in (a, 0.6 * a + 0.3 * b, 0.8 * b))


def letters(u, v):
    """Dark strokes on a pale ground, some narrower than a pixel of a small image."""
    column, row, x, y = int(u * 10), int(v * 12), u * 10 % 1, v * 12 % 1
    kind = (column * 7919 + row * 104729 + column * row * 31) % 5
    ink = 0.15 < y < 0.8 and (x < 0.3, abs(x - 0.5) < 0.15, y < 0.4, abs(x - y) < 0.2, False)[kind]
    return (25, 25, 40) if ink else (238, 232, 215)


def printed(u, v):
    """Large letters over waves: a poster has edges and shades."""
    ink = letters(0.4 * u, 0.5 * v)
    return ink if ink[0] < 100 else clouds(u, v)


def texture(g, picture, width=64, height=64, **more):
    return g.texture("picture.png", images.Picture(width, height, picture).png(), **more)


def window():
    """A room that is dim beside what its window shows: a sky, and a sun that reaches a patch of the floor and a metal ball."""
    g = Gltf(max_depth=8)

    def sky(u, v):
        elevation = math.pi * (0.5 - v)
        glow = math.exp(-4 * elevation)
        return (2 + 3 * glow, 3 + 2 * glow, 5) if elevation >= 0 else (0.3, 0.28, 0.22)

    outside = images.Picture(128, 64, sky)
    for row in (16, 17):
        for column in (30, 31):
            outside.rows[row][column] = (4000.0, 3600.0, 3000.0)
    g.environment("sky.exr", outside.exr())
    g.material("picture", texture=texture(g, clouds))
    g.material("wall", (0.75, 0.72, 0.68))
    g.material("floor", (0.40, 0.28, 0.18))
    g.material("ball", (0.8, 0.8, 0.82), metallic=1, roughness=0.15)
    g.mesh("floor", Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), "floor")
    walls = Mesh().quad((-2, 2.5, -2), (2, 2.5, -2), (2, 2.5, 2), (-2, 2.5, 2)).quad((-2, 0, -2), (2, 0, -2), (2, 2.5, -2), (-2, 2.5, -2))
    walls.quad((2, 0, 2), (-2, 0, 2), (-2, 2.5, 2), (2, 2.5, 2)).quad((-2, 0, 2), (-2, 0, -2), (-2, 2.5, -2), (-2, 2.5, 2))
    walls.box((2, 0, -2), (2.15, 0.9, 2), without="y-").box((2, 2, -2), (2.15, 2.5, 2), without="y+")
    walls.box((2, 0.9, -2), (2.15, 2, -1)).box((2, 0.9, 0.4), (2.15, 2, 2))
    g.mesh("walls", walls, "wall")
    g.mesh("picture", Mesh().quad((-1.2, 0.6, -1.98), (0.4, 0.6, -1.98), (0.4, 2, -1.98), (-1.2, 2, -1.98)), "picture")
    g.mesh("ball", Mesh().sphere((0.9, 0.4, -1.0), 0.4), "ball")
    g.camera("room", (-1.6, 1.4, 1.8), (0.5, 1.15, -1.6), 62)
    return g


def globe():
    """A glossy ball under an open sky, seen from eight sides."""
    g = Gltf(max_depth=6)
    sky = images.Picture(128, 64, lambda u, v: (0.6, 0.8, 1.2) if v < 0.5 else (0.3, 0.25, 0.2))
    for column in (40, 41):
        sky.rows[14][column] = (800.0, 700.0, 600.0)
    g.environment("sky.exr", sky.exr())
    g.material("globe", texture=texture(g, clouds, 128, wrap=REPEAT), roughness=0.4, specular=1)
    g.material("ground", (0.35, 0.4, 0.3))
    g.mesh("ground", Mesh().quad((-20, -1, 20), (20, -1, 20), (20, -1, -20), (-20, -1, -20)), "ground")
    g.mesh("globe", Mesh().sphere((0, 0, 0), 1, 64, 32), "globe")
    for i in range(8):
        a = math.pi * i / 4
        g.camera(f"side{i}", (3.6 * math.cos(a), 0.9 * math.sin(3 * a) + 0.7, 3.6 * math.sin(a)), (0, 0, 0), 38)
    return g


def showcase():
    """Letters behind a pane: no light sample gets through it."""
    g = Gltf(max_depth=8)
    g.material("picture", texture=texture(g, letters))
    g.material("white", (0.7, 0.7, 0.7))
    g.material("dark", (0.1, 0.1, 0.12))
    g.material("light", (0.2, 0.2, 0.2), emission=(30, 28, 25))
    g.material("pane", (0.97, 0.99, 1), roughness=0, specular=1, glass="pane", ior=1.5)
    g.mesh("floor", Mesh().quad((-3, 0, 3), (3, 0, 3), (3, 0, -1), (-3, 0, -1)), "dark")
    g.mesh("room", Mesh().quad((-3, 0, -1), (3, 0, -1), (3, 3, -1), (-3, 3, -1)).quad((-3, 3, -1), (3, 3, -1), (3, 3, 3), (-3, 3, 3)), "white")
    g.mesh("picture", Mesh().quad((-0.8, 0.6, -0.9), (0.8, 0.6, -0.9), (0.8, 2.2, -0.9), (-0.8, 2.2, -0.9)), "picture")
    g.mesh("pane", Mesh().quad((-0.85, 0.55, -0.7), (0.85, 0.55, -0.7), (0.85, 2.25, -0.7), (-0.85, 2.25, -0.7)), "pane")
    g.mesh("light", Mesh().quad((-1.5, 2.98, 0.4), (-0.9, 2.98, 0.4), (-0.9, 2.98, 1), (-1.5, 2.98, 1)), "light")
    g.camera("front", (0.4, 1.3, 2.6), (0, 1.35, -0.9), 46)
    return g


def slab():
    """A picture behind a closed slab of glass in a room with a small lamp, which only chance finds from there."""
    g = Gltf(max_depth=8)
    g.material("picture", texture=texture(g, clouds))
    g.material("white", (0.75, 0.75, 0.75))
    g.material("red", (0.7, 0.3, 0.2))
    g.material("green", (0.2, 0.6, 0.3))
    g.material("light", (0, 0, 0), emission=(25, 25, 25))
    g.material("slab", (1, 1, 1), roughness=0, specular=1, glass="solid", ior=1.5)
    g.mesh("room", Mesh().quad((-2, -1, 2), (2, -1, 2), (2, -1, -2), (-2, -1, -2)).quad((-2, 1.5, -2), (2, 1.5, -2), (2, 1.5, 2), (-2, 1.5, 2))
           .quad((-2, -1, -2), (2, -1, -2), (2, 1.5, -2), (-2, 1.5, -2)), "white")
    g.mesh("left", Mesh().quad((-2, -1, 2), (-2, -1, -2), (-2, 1.5, -2), (-2, 1.5, 2)), "red")
    g.mesh("right", Mesh().quad((2, -1, -2), (2, -1, 2), (2, 1.5, 2), (2, 1.5, -2)), "green")
    g.mesh("picture", Mesh().quad((-0.8, -0.8, -1), (0.8, -0.8, -1), (0.8, 0.8, -1), (-0.8, 0.8, -1)), "picture")
    g.mesh("slab", Mesh().box((-1, -0.95, -0.65), (1, 0.95, -0.55)), "slab")
    g.mesh("light", Mesh().quad((-0.4, 1.45, -0.4), (0.4, 1.45, -0.4), (0.4, 1.45, 0.4), (-0.4, 1.45, 0.4)), "light")
    g.camera("front", (0, 0.1, 2.5), (0, 0.1, 0), 45)
    return g


def poster(edge=512):
    """A poster on the far wall of a room: its texture is ten times as fine as the picture of it."""
    g = Gltf(max_depth=6)
    g.material("poster", texture=texture(g, printed, edge, edge))
    g.material("wall", (0.7, 0.68, 0.62))
    g.material("floor", (0.35, 0.25, 0.18))
    g.material("box", (0.3, 0.45, 0.6))
    g.material("light", (0, 0, 0), emission=(14, 13, 11))
    g.mesh("walls", Mesh().quad((-2, 0, -2), (2, 0, -2), (2, 2.6, -2), (-2, 2.6, -2)).quad((-2, 0, 2), (-2, 0, -2), (-2, 2.6, -2), (-2, 2.6, 2))
           .quad((-2, 2.6, -2), (2, 2.6, -2), (2, 2.6, 2), (-2, 2.6, 2)), "wall")
    g.mesh("floor", Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), "floor")
    g.mesh("poster", Mesh().quad((-0.9, 0.7, -1.98), (0.7, 0.7, -1.98), (0.7, 2.3, -1.98), (-0.9, 2.3, -1.98)), "poster")
    g.mesh("box", Mesh().box((0.6, 0, -1.5), (1.4, 0.9, -0.7)), "box")
    g.mesh("light", Mesh().quad((-0.5, 2.58, -0.6), (0.5, 2.58, -0.6), (0.5, 2.58, 0.2), (-0.5, 2.58, 0.2)), "light")
    g.camera("front", (0.5, 1.4, 2.4), (-0.1, 1.35, -2), 48)
    return g


def mural():
    """The same with a texture of the size that cameras and painters deliver."""
    return poster(2048)


def caustic():
    """A floor whose texture repeats, below a ball of glass: the bright dots of the caustic are the noise of a few texels."""
    g = Gltf(max_depth=8)
    g.material("floor", texture=texture(g, clouds, 32, 32, wrap=REPEAT))
    g.material("light", (0, 0, 0), emission=(20, 20, 20))
    g.material("ball", (1, 1, 1), roughness=0, specular=1, glass="solid", ior=1.5)
    floor = Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2))
    floor.uvs = [(3 * u, 3 * v) for u, v in floor.uvs]
    g.mesh("floor", floor, "floor")
    g.mesh("ball", Mesh().sphere((-0.5, 0.5, -0.5), 0.5, 96, 48), "ball")
    g.mesh("light", Mesh().quad((-0.5, 2.5, -0.5), (0.5, 2.5, -0.5), (0.5, 2.5, 0.5), (-0.5, 2.5, 0.5)), "light")
    g.camera("front", (0, 2, 3.2), (0, 0, 0), 45)
    return g


def screen():
    """A screen is the only light of a room: what it shows is what is unknown."""
    g = Gltf(max_depth=6)
    g.material("screen", (0.05, 0.05, 0.05), emission=(4, 4, 4), emission_texture=texture(g, clouds))
    g.material("white", (0.7, 0.7, 0.7))
    g.material("box", (0.6, 0.3, 0.2))
    g.mesh("room", Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)).quad((-2, 0, -2), (2, 0, -2), (2, 2.5, -2), (-2, 2.5, -2))
           .quad((-2, 0, 2), (-2, 0, -2), (-2, 2.5, -2), (-2, 2.5, 2)), "white")
    g.mesh("screen", Mesh().quad((-1, 0.5, -1.9), (1, 0.5, -1.9), (1, 1.9, -1.9), (-1, 1.9, -1.9)), "screen")
    g.mesh("box", Mesh().box((0.3, 0, -1), (0.9, 0.6, -0.4)), "box")
    g.camera("front", (0.8, 1.3, 2.8), (0, 0.9, -1.5), 50)
    return g


def lamps():
    """24 lamps of very different strength over a floor with columns."""
    g, random_ = Gltf(max_depth=6), random.Random(3)  # equal on every run
    uniform = random_.uniform
    g.material("floor", texture=texture(g, clouds))
    g.material("column", (0.6, 0.6, 0.58))
    g.material("wall", (0.5, 0.5, 0.55))
    g.mesh("floor", Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), "floor")
    g.mesh("wall", Mesh().quad((-2, 0, -2), (2, 0, -2), (2, 2.5, -2), (-2, 2.5, -2)), "wall")
    for i in range(24):
        strength = 10 ** uniform(-0.5, 1.8)
        g.material(f"lamp{i}", (0.1, 0.1, 0.1), emission=tuple(strength * uniform(0.4, 1) for _ in range(3)))
        place, target = (uniform(-2, 2), uniform(0.8, 2.3), uniform(-2, 1.5)), (uniform(-1, 1), 0, uniform(-1, 1))
        g.mesh(f"lamp{i}", facing(place, target, uniform(0.02, 0.1)), f"lamp{i}")
    for i in range(6):
        x, z = uniform(-1.6, 1.6), uniform(-1.6, 1.2)
        g.mesh(f"column{i}", Mesh().box((x - 0.1, 0, z - 0.1), (x + 0.1, 1.2, z + 0.1)), "column")
    g.camera("front", (0.2, 2.4, 3.6), (0, 0.1, 0), 42)
    return g


def tiles():
    """A tabletop whose colour, roughness and metalness are maps that have nothing in common, under a sky and a lamp, from three sides."""
    g = Gltf(max_depth=5)

    def worn(u, v):
        polish = 0.5 + 0.5 * math.sin(2 * math.pi * (2 * u + 3 * v)) * math.cos(11 * u)
        metal = 0.5 + 0.5 * math.sin(2 * math.pi * (3 * u - 2 * v) + 1) * math.cos(7 * v)
        return 0, 255 * (0.2 + 0.6 * polish), 255 * metal

    sky = images.Picture(64, 32, lambda u, v: (0.7, 0.9, 1.3) if v < 0.5 else (0.2, 0.18, 0.15))
    g.environment("sky.exr", sky.exr())
    g.material("tiles", texture=texture(g, clouds), metallic=1, rough_texture=g.texture("worn.png", images.Picture(64, 64, worn).png()), specular=1)
    g.material("lamp", (0.2, 0.2, 0.2), emission=(14, 13, 11))
    g.mesh("tiles", Mesh().quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)), "tiles")
    g.mesh("lamp", Mesh().quad((-0.8, 1.2, -2), (0.8, 1.2, -2), (0.8, 2, -1.6), (-0.8, 2, -1.6)), "lamp")
    for name, place in (("front", (0, 1.6, 1.9)), ("left", (-1.9, 1.5, 0.8)), ("right", (1.9, 1.2, 0.6))):
        g.camera(name, place, (0, 0, 0), 50)
    return g


def relief(name="stones", colour=(0.55, 0.5, 0.42), **more):
    """A tabletop of stones, whose normals are a map, under a sky and between a red, a green and a blue lamp, from three sides."""
    g = Gltf(max_depth=5)

    def height(u, v):
        """Round stones in rows, each moved by half of one, with a fine grain."""
        x, y = 4 * u + 0.5 * (math.floor(5 * v) % 2), 5 * v
        dome = max(0, 1 - (2 * (x % 1) - 1) ** 4) * max(0, 1 - (2 * (y % 1) - 1) ** 4)
        return 0.035 * math.sqrt(dome) + 0.002 * math.sin(60 * u + 20 * math.sin(9 * v))

    def normal(u, v):
        """The map's v runs down the image, tangent space has y up."""
        step = 1 / 128
        x = (height(u + step, v) - height(u - step, v)) / (4 * step)
        y = (height(u, v - step) - height(u, v + step)) / (4 * step)
        length = math.sqrt(x * x + y * y + 1)
        return tuple(127.5 + 127.5 * c / length for c in (-x, -y, 1))

    sky = images.Picture(64, 32, lambda u, v: (0.25, 0.3, 0.4) if v < 0.5 else (0.1, 0.09, 0.08))
    g.environment("sky.exr", sky.exr())
    g.material(name, colour, normal_texture=g.texture("relief.png", images.Picture(64, 64, normal).png()), specular=1, **{"roughness": 0.6, **more})
    g.mesh(name, Mesh().quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)), name)
    for i, tint in enumerate(((30, 8, 4), (6, 24, 6), (4, 8, 30))):
        x, z = 1.6 * math.sin(2 * math.pi * i / 3), -1.6 * math.cos(2 * math.pi * i / 3)
        g.material(f"lamp{i}", (0.2, 0.2, 0.2), emission=tint)
        g.mesh(f"lamp{i}", facing((x, 2.2, z), (0, 0, 0), 0.5), f"lamp{i}")
    for camera, place in (("front", (0, 1.6, 1.9)), ("left", (-1.9, 1.5, 0.8)), ("right", (1.9, 1.2, 0.6))):
        g.camera(camera, place, (0, 0, 0), 50)
    return g


def plate():
    """The same relief of a metal that shines, whose images are far from linear in its normals."""
    return relief("plate", (0.9, 0.75, 0.5), metallic=1, roughness=0.35)


def sunny(sun):
    """A blue sky over dark ground, with a sun of four texels."""
    sky = images.Picture(128, 64, lambda u, v: (0.35 + 0.3 * (0.5 - abs(v - 0.5)), 0.5, 0.9) if v < 0.5 else (0.12, 0.1, 0.08))
    for row in (15, 16):
        for column in (30, 31):
            sky.rows[row][column] = (sun, 0.9 * sun, 0.77 * sun)
    return sky


def terrace():
    """A polished metal ball and one of glass on tiles in the sun, from three sides."""
    g = Gltf(max_depth=8)

    def tile(u, v):
        tint = random.Random(int(6 * u) * 17 + int(6 * v) * 101)
        shade = 0.9 + 0.1 * math.sin(40 * u + 31 * v)
        colour = [shade * (low + spread * tint.random()) for low, spread in ((0.5, 0.3), (0.35, 0.25), (0.25, 0.2))]
        return tuple(255 * images.srgb_encode(c) for c in ((0.15, 0.15, 0.14) if min(6 * u % 1, 6 * v % 1) < 0.06 else colour))

    g.environment("sky.exr", sunny(700.0).exr())
    g.material("ground", texture=texture(g, tile, 128, 128), roughness=0.7, specular=0.5)
    g.material("ball", (0.9, 0.7, 0.4), metallic=1, roughness=0.3, specular=1)
    g.material("glass", roughness=0, specular=1, glass="solid", ior=1.5)
    g.material("post", (0.7, 0.2, 0.15))
    g.mesh("ground", Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), "ground")
    g.mesh("ball", Mesh().sphere((-0.6, 0.5, -0.3), 0.5), "ball")
    g.mesh("glass", Mesh().sphere((0.7, 0.4, 0.3), 0.4), "glass")
    g.mesh("post", Mesh().box((0.2, 0, -1.4), (0.45, 1.6, -1.15)), "post")
    for name, place in (("front", (0.3, 2.2, 3.4)), ("left", (-3.2, 1.8, 1.6)), ("back", (2.6, 2.6, -2.2))):
        g.camera(name, place, (0, 0.2, 0), 48)
    return g


def shade():
    """Tiles of which a wall leaves most in the shade, a thousandth as bright as those beside the lamp."""
    g = Gltf(max_depth=6)

    def tile(u, v):
        fire = 0.5 + 0.4 * random.Random(int(7 * u + 0.5 * (int(9 * v) % 2)) * 31 + int(9 * v) * 57).random()
        return (255 * fire, 180 * fire, 130 * fire) if min(7 * u % 1, 9 * v % 1) > 0.1 else (200, 200, 195)

    g.environment("sky.exr", images.Picture(64, 32, lambda u, v: (0.004, 0.005, 0.008)).exr())
    g.material("floor", texture=texture(g, tile))
    g.material("wall", (0.5, 0.5, 0.5))
    g.material("light", (0, 0, 0), emission=(60, 50, 40))
    g.mesh("floor", Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), "floor")
    g.mesh("wall", Mesh().box((-0.1, 0, -2), (0.1, 1.6, 1.0)).quad((-2, 0, -2), (2, 0, -2), (2, 2, -2), (-2, 2, -2)), "wall")
    g.mesh("light", Mesh().box((1.2, 0.4, -0.2), (1.3, 0.5, -0.1)), "light")
    g.camera("front", (-1.2, 2.2, 3.0), (-0.3, 0, 0), 50)
    return g


def polished():
    """A metal ball of 8 x 8 fields, each polished in its own way, in the sun, from two sides."""
    g = Gltf(max_depth=6)

    def field(u, v):
        return 0, 255 * (0.12 + 0.25 * random.Random(int(8 * u) * 17 + int(8 * v) * 101).random()), 255

    sky = sunny(300.0)
    for row in range(20, 26):
        sky.rows[row][80:90] = [(6.0, 5.0, 4.0)] * 10
    g.environment("sky.exr", sky.exr())
    g.material("ball", (0.9, 0.7, 0.4), metallic=1, rough_texture=g.texture("polish.png", images.Picture(64, 64, field).png()), specular=1)
    g.material("ground", (0.4, 0.35, 0.3))
    g.mesh("ground", Mesh().quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)), "ground")
    g.mesh("ball", Mesh().sphere((0, 0.8, 0), 0.8, 64, 32), "ball")
    for name, place in (("front", (0.3, 1.6, 3.2)), ("left", (-2.9, 1.5, 1.4))):
        g.camera(name, place, (0, 0.7, 0), 42)
    return g


GENERATED = {f.__name__: f for f in (window, globe, showcase, slab, poster, mural, caustic, screen, lamps, tiles, relief, plate, terrace, shade, polished)}
