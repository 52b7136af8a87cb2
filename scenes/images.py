"""PNG and EXR writers in plain Python, and the pictures that hang in the bundled scenes."""
import math
import struct
import zlib


def srgb_encode(linear):
    """Exact piecewise sRGB curve, [0,1] -> [0,1]."""
    return 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055


class Picture:
    """RGB floats, row 0 on top. Colours of 8-bit pictures are kept as the file will hold them (0..255)."""

    def __init__(self, width, height, pixel):
        self.width, self.height = width, height
        self.rows = [[pixel((x + 0.5) / width, (y + 0.5) / height) for x in range(width)] for y in range(height)]

    def png(self):
        """8-bit RGB PNG."""
        raw = b"".join(b"\0" + bytes(min(255, max(0, round(c))) for p in row for c in p) for row in self.rows)

        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        header = struct.pack(">IIBBBBB", self.width, self.height, 8, 2, 0, 0, 0)
        return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 9)) + chunk(b"IEND", b"")

    def exr(self):
        """float32 RGB OpenEXR, scanlines in ZIP blocks of 16 (OpenEXR file layout, version 2)."""

        def attribute(name, kind, data):
            return name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data

        window = struct.pack("<4i", 0, 0, self.width - 1, self.height - 1)
        channels = b"".join(c + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
        header = struct.pack("<II", 20000630, 2) + b"".join([
            attribute(b"channels", b"chlist", channels),
            attribute(b"compression", b"compression", b"\3"),
            attribute(b"dataWindow", b"box2i", window),
            attribute(b"displayWindow", b"box2i", window),
            attribute(b"lineOrder", b"lineOrder", b"\0"),
            attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
            attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
            attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)),
        ]) + b"\0"
        blocks = []
        for top in range(0, self.height, 16):
            raw = b"".join(struct.pack(f"<{self.width}f", *(p[c] for p in row))
                           for row in self.rows[top:top + 16] for c in (2, 1, 0))
            packed = exr_zip(raw)
            blocks.append(struct.pack("<ii", top, len(packed)) + packed)
        offset = len(header) + 8 * len(blocks)
        offsets = []
        for block in blocks:
            offsets.append(offset)
            offset += len(block)
        return header + struct.pack(f"<{len(blocks)}Q", *offsets) + b"".join(blocks)


def exr_zip(raw):
    """OpenEXR's ZIP: even bytes, then odd bytes, as differences, deflated; stored as is where that does not shrink."""
    split = raw[0::2] + raw[1::2]
    difference = bytes([split[0]]) + bytes((b - a + 128) & 255 for a, b in zip(split, split[1:]))
    packed = zlib.compress(difference, 9)
    return packed if len(packed) < len(raw) else raw


def hex_colour(text):
    return tuple(int(text[i:i + 2], 16) for i in (0, 2, 4))


def harbour(u, v):
    """A sailing boat at sunset: the painting. Crisp shapes whose recovery is easy to judge by eye."""
    sky = ["2b4f81", "4f7cac", "e8b46a", "f2d08b"]
    if min(u, v, 1 - u, 1 - v) < 1 / 32:
        return hex_colour("e9e2d0")
    if v > 0.66:  # water, with the sun's reflection as stripes
        stripe = int(v * 64) % 4 < 2
        if stripe and abs(u - 0.70) < 0.13 * (1.25 - v) / 0.5:
            return hex_colour("f0a24a")
        if 0.66 < v < 0.75 and 0.20 + 0.8 * (v - 0.66) < u < 0.50 - 0.8 * (v - 0.66):
            return hex_colour("6b2d2a")  # hull
        return hex_colour("1f4e5f" if stripe else "2f6f7e")
    if 0.22 < v < 0.63 and 0.355 < u < 0.355 + 0.30 * (v - 0.22):
        return hex_colour("f4efe3")  # main sail
    if 0.30 < v < 0.63 and 0.335 - 0.36 * (v - 0.30) < u < 0.335:
        return hex_colour("c8442f")  # jib
    if abs(u - 0.345) < 0.010 and 0.18 < v <= 0.66:
        return hex_colour("3b2a20")  # mast
    if math.hypot(u - 0.70, v - 0.50) < 0.14:
        return hex_colour("e4572e")  # sun
    if v > 0.56 and (u > 0.86 - 0.5 * (v - 0.56) or (u < 0.14 + 0.7 * (v - 0.56))):
        return hex_colour("3c4a3e")  # headlands
    return hex_colour(sky[min(3, int((v - 0.03) / 0.155))])


def inlay(u, v):
    """A wooden table top with an inlaid star and a checkered border."""
    x, y = 2 * u - 1, 2 * v - 1
    edge = max(abs(x), abs(y))
    if 0.80 < edge < 0.925:
        dark = (int(u * 16) + int(v * 16)) % 2
        return hex_colour("4a2c1a" if dark else "e3c58f")
    radius, angle = math.hypot(x, y), math.atan2(y, x)
    point = abs((angle / (math.pi / 4) + 0.5) % 1 - 0.5) * math.pi / 4  # to the nearest of eight rays
    if radius * math.cos(point) + 1.9 * radius * math.sin(point) < 0.62:
        half = (angle / (math.pi / 4)) % 1 < 0.5
        return hex_colour("2f5d62" if half else "a7c4a0")
    if radius < 0.72:
        return hex_colour("8c3b2a")
    plank = int(v * 8)
    grain = 10 * math.sin(40 * u + 9 * math.sin(7 * v + plank)) + 8 * (plank % 2)
    return tuple(c + grain for c in hex_colour("a8733f"))


def mosaic(u, v):
    """Tiles around a compass rose: the ground below the open sky."""
    x, y = 2 * u - 1, 2 * v - 1
    radius, angle = math.hypot(x, y), math.atan2(y, x)
    if radius < 0.80:
        ring = int(radius / 0.16)
        wedge = int(math.floor(angle / (math.pi / 8)))
        return hex_colour([["d9cfb8", "b5512f"], ["315b7d", "e0c078"], ["d9cfb8", "54795b"],
                           ["b5512f", "ebe3d3"], ["315b7d", "d9cfb8"]][ring][(wedge + ring) % 2])
    return hex_colour("c9bfa9" if (int(u * 8) + int(v * 8)) % 2 else "8f8a80")


def polish(u, v):
    """Roughness (green) of a metal table top, all of it metal (blue): a bright star on a satin field with a border of two finishes."""
    x, y = 2 * u - 1, 2 * v - 1
    edge, radius, angle = max(abs(x), abs(y)), math.hypot(x, y), math.atan2(y, x)
    point = abs((angle / (math.pi / 4) + 0.5) % 1 - 0.5) * math.pi / 4  # to the nearest of eight rays
    rough = 0.42
    if 0.78 < edge < 0.93:
        rough = 0.18 if (int(u * 12) + int(v * 12)) % 2 else 0.55
    elif radius * math.cos(point) + 1.9 * radius * math.sin(point) < 0.66:
        rough = 0.15 if (angle / (math.pi / 4)) % 1 < 0.5 else 0.26
    elif radius < 0.72:
        rough = 0.55
    return (0, 255 * rough, 255)


def soot(u, v):
    """Linear reflectances of about 0.02: a ring and a diagonal in black on black."""
    radius = math.hypot(2 * u - 1, 2 * v - 1)
    if 0.5 < radius < 0.75:
        return (0.032, 0.028, 0.024)
    return (0.012, 0.014, 0.016) if abs(u - v) < 0.08 else (0.020, 0.020, 0.020)
