# Pictures for tests of the window: reading PNG files, finding one picture in another, how far they differ.
import math
import random
import struct
import zlib

from display import Picture


def read_png(path):
    """8-bit RGB without interlacing, as this program writes them."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", path
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            assert (depth, color, interlaced) == (8, 2, 0), path
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, stride, rows = zlib.decompress(packed), 3 * width, []
    before = bytearray(stride)
    for y in range(height):
        filter_kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            left = line[x - 3] if x >= 3 else 0
            up, corner = before[x], before[x - 3] if x >= 3 else 0
            if filter_kind == 1:
                line[x] = (line[x] + left) & 255
            elif filter_kind == 2:
                line[x] = (line[x] + up) & 255
            elif filter_kind == 3:
                line[x] = (line[x] + (left + up) // 2) & 255
            elif filter_kind == 4:
                p = left + up - corner
                distance = (abs(p - left), abs(p - up), abs(p - corner))
                line[x] = (line[x] + (left, up, corner)[distance.index(min(distance))]) & 255
        rows.append(bytes(line))
        before = line
    return Picture(width, height, rows)


def write_png(path, picture):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    raw = b"".join(b"\0" + row for row in picture.rows)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", picture.width, picture.height, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(raw, 6)) + chunk(b"IEND", b""))


def find(small, large, tolerance=2):
    """Where `small` stands in `large`: the top left corner, or None. Marks over it may hide parts."""
    generator = random.Random(1)
    # Pixels that differ from most others tell places apart best: take those far from the picture's mean.
    mean = [sum(sum(row[c::3]) for row in small.rows) / (small.width * small.height) for c in range(3)]
    probes = [(generator.randrange(small.width), generator.randrange(small.height)) for _ in range(400)]
    probes.sort(key=lambda p: -sum(abs(a - b) for a, b in zip(small.at(*p), mean)))
    probes = probes[:120]
    allowed = len(probes) // 10
    first = [(x, y, small.at(x, y)) for x, y in probes]
    for top in range(large.height - small.height + 1):
        for left in range(large.width - small.width + 1):
            missed = 0
            for i, (x, y, color) in enumerate(first):
                row, at = large.rows[top + y], 3 * (left + x)
                if abs(row[at] - color[0]) > tolerance or abs(row[at + 1] - color[1]) > tolerance or abs(row[at + 2] - color[2]) > tolerance:
                    missed += 1
                    if missed > allowed or (i < 6 and missed > 2):
                        break
            else:
                return left, top
    return None


def psnr(small, large, left, top):
    """Of the 8-bit values, in dB, over all of `small` at that place."""
    total = 0
    for y in range(small.height):
        a, b = small.rows[y], large.rows[top + y][3 * left:3 * (left + small.width)]
        total += sum((p - q) * (p - q) for p, q in zip(a, b))
    mean = total / (3 * small.width * small.height)
    return math.inf if mean == 0 else 10 * math.log10(255 * 255 / mean)
