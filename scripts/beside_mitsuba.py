"""What the comparisons with Mitsuba 3 share: starting it, running cmpg-vk, and listening to what cmpg-vk shows while it runs."""
import os
import pathlib
import socket
import struct
import subprocess
import sys
import threading
import time

import needs

root = pathlib.Path(__file__).resolve().parent.parent
sys.path += [str(root / "tests/reference"), str(root / "scenes")]


def add_variant(parser):
    parser.add_argument("--variant", default="llvm_ad_rgb", choices=["llvm_ad_rgb", "cuda_ad_rgb"],
                        help="of Mitsuba (llvm_ad_rgb); cuda_ad_rgb on the GPU that cmpg-vk takes too")


def start_mitsuba(threads, variant="llvm_ad_rgb"):
    """(drjit, mitsuba) in a variant, with our materials registered."""
    if threads < 2:
        sys.exit("Mitsuba's thread pool stands still with one thread: give it two, and one core by taskset")
    needs.packages("mitsuba", "numpy")
    import drjit as dr
    import mitsuba as mi
    mi.set_variant(variant)  # before the modules that build on its types
    import gltf_bsdf
    gltf_bsdf.register()
    dr.set_thread_count(threads)
    return dr, mi


def run_cmpg(program, arguments, threads, **environment):
    """Standard output of one run; ends this program if that failed."""
    command = [str(program), "--headless", *map(str, arguments)]
    try:
        done = subprocess.run(command, env=dict(os.environ, LP_NUM_THREADS=str(threads), **environment), stdout=subprocess.PIPE, text=True)
    except OSError as error:
        sys.exit(f"{program}: {error.strerror}")
    if done.returncode:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}")
    return done.stdout


def shader_caches(folder):
    """The environment by which cmpg-vk, Mesa and NVIDIA's driver keep compiled code in this folder alone."""
    return {"XDG_CACHE_HOME": folder, "MESA_SHADER_CACHE_DIR": folder, "__GL_SHADER_DISK_CACHE_PATH": folder}


class Display:
    """A display for --display-server (docs/display-stream.md) that keeps every image whose name ends in / and one of `names`, with its time of arrival.

    with Display("painting.baseColor") as display: ...; display.images["painting.baseColor"]: (time.perf_counter(), width, height, floats as bytes).
    """

    def __init__(self, *names):
        self.images = {name: [] for name in names}
        self.server = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.server.getsockname()[1]
        self.thread = threading.Thread(target=self.listen, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.thread.join(5)  # the connection ends with the run
        self.server.close()

    def listen(self):
        try:
            connection, _ = self.server.accept()
        except OSError:
            return
        with connection, connection.makefile("rb") as stream:
            while len(head := stream.read(4)) == 4:
                packet = stream.read(struct.unpack("<I", head)[0] - 4)
                if packet[0] == 6:
                    self.update(packet, time.perf_counter())

    def update(self, packet, now):
        end = packet.index(0, 2)
        name = packet[2:end].decode()
        images = self.images.get(name.rpartition("/")[2])
        if images is None:
            return
        (channels,) = struct.unpack_from("<i", packet, end + 1)
        at = end + 5
        for _ in range(channels):
            at = packet.index(0, at) + 1
        _, y, width, height = struct.unpack_from("<4i", packet, at)
        floats = packet[at + 16 + 16 * channels:]
        if y > 0:  # a large image comes in several packets, of whole rows
            _, _, above, before = images.pop()
            assert y == above, "rows of an image are missing"
            height, floats = y + height, before + floats
        images.append((now, width, height, floats))
