# A display without a screen, for tests of the window: Xvfb, synthetic input by xdotool, pictures of what is shown.
import ctypes
import ctypes.util
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

    def manage(self):
        """Messages that a window manager sends; there is none here."""
        return WindowManager(self.environment["DISPLAY"])

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


class WindowManager:
    """What a window manager does to a window by the conventions between clients (ICCCM 4.1.4 and 4.2.8.1)."""

    NORMAL, ICONIC = 1, 3
    REPLACE, CLIENT_MESSAGE = 0, 33

    class Message(ctypes.Structure):  # XClientMessageEvent
        _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                    ("window", ctypes.c_ulong), ("message_type", ctypes.c_ulong), ("format", ctypes.c_int), ("data", ctypes.c_long * 5),
                    ("room", ctypes.c_long * 12)]  # of XEvent, which is larger

    def __init__(self, name):
        self.x = ctypes.CDLL(ctypes.util.find_library("X11"))
        self.x.XOpenDisplay.restype = ctypes.c_void_p
        self.x.XInternAtom.restype = ctypes.c_ulong
        self.display = ctypes.c_void_p(self.x.XOpenDisplay(name.encode()))
        assert self.display, name

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.x.XCloseDisplay(self.display)

    def atom(self, name):
        return self.x.XInternAtom(self.display, name.encode(), 0)

    def close(self, window):
        """The button in the corner."""
        message = self.Message(type=self.CLIENT_MESSAGE, window=window, message_type=self.atom("WM_PROTOCOLS"), format=32)
        message.data[0] = self.atom("WM_DELETE_WINDOW")
        assert self.x.XSendEvent(self.display, ctypes.c_ulong(window), 0, ctypes.c_long(0), ctypes.byref(message))
        self.x.XSync(self.display, 0)

    def set_state(self, window, state):
        atom = ctypes.c_ulong(self.atom("WM_STATE"))
        values = (ctypes.c_long * 2)(state, 0)
        self.x.XChangeProperty(self.display, ctypes.c_ulong(window), atom, atom, 32, self.REPLACE, values, 2)

    def minimise(self, window):
        self.set_state(window, self.ICONIC)
        self.x.XUnmapWindow(self.display, ctypes.c_ulong(window))
        self.x.XSync(self.display, 0)

    def restore(self, window):
        self.set_state(window, self.NORMAL)
        self.x.XMapWindow(self.display, ctypes.c_ulong(window))
        self.x.XSync(self.display, 0)
