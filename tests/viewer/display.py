# A display without a screen, for tests of the window: Xvfb, synthetic input by xdotool, pictures of what is shown.
import mmap
import os
import shutil
import struct
import subprocess
import tempfile
import time

SKIPPED = 77  # exit code that CTest takes for "skipped"


def require_tools():
    """Exits with SKIPPED where the display cannot be had."""
    missing = [tool for tool in ("Xvfb", "xdotool") if not shutil.which(tool)]
    if missing:
        print("skipped: not installed: " + ", ".join(missing))
        raise SystemExit(SKIPPED)


def wait_until(condition, seconds, what):
    """The first true value of condition()."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.1)
    raise AssertionError(f"no {what} within {seconds} s")


class Picture:
    """8-bit RGB, row 0 on top; rows are bytes of 3 * width."""

    def __init__(self, width, height, rows):
        self.width, self.height, self.rows = width, height, rows

    def at(self, x, y):
        return self.rows[y][3 * x:3 * x + 3]


class Display:
    def __init__(self, width=1500, height=960):
        self.folder = tempfile.mkdtemp(prefix="cmpg-display-")
        read_end, write_end = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write_end), "-screen", "0", f"{width}x{height}x24", "-fbdir", self.folder, "-nolisten", "tcp", "-noreset"],
            pass_fds=[write_end], stderr=subprocess.DEVNULL)
        os.close(write_end)
        with os.fdopen(read_end) as pipe:
            number = pipe.readline().strip()
        if not number:
            raise AssertionError("Xvfb did not start")
        self.environment = dict(os.environ, DISPLAY=":" + number)
        self.environment.pop("WAYLAND_DISPLAY", None)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def xdotool(self, *arguments):
        run = subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, capture_output=True, text=True, timeout=60)
        return run.stdout.strip()

    def screen(self):
        """What the display shows: Xvfb keeps it in a file in the format of xwd."""
        with open(os.path.join(self.folder, "Xvfb_screen0"), "rb") as file, mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ) as data:
            header = struct.unpack(">25I", data[:100])
            header_size, width, height = header[0], header[4], header[5]
            bits, line, colors = header[11], header[12], header[19]
            assert bits == 32 and header[7] == 0, "32 bits a pixel, least significant byte first"  # blue, green, red, unused
            start = header_size + 12 * colors
            rows = []
            for y in range(height):
                row = data[start + y * line:start + y * line + 4 * width]
                rgb = bytearray(3 * width)
                rgb[0::3], rgb[1::3], rgb[2::3] = row[2::4], row[1::4], row[0::4]
                rows.append(bytes(rgb))
            return Picture(width, height, rows)
