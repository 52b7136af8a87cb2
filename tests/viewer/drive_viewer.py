# Drives the window as a user would, on a display without a screen. usage: drive_viewer.py SCENARIO PROGRAM SOURCE_FOLDER [TEST_PROGRAM]
# Every scenario runs with the validation layers on; any message of theirs ends the program with an error, which fails the scenario.
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

import pictures
from display import Display, Picture, require_tools, wait_until

PROGRAM, SOURCE = "", ""
PATIENCE = 240  # seconds for anything: kernels are compiled on a busy machine


def run_headless(*arguments):
    subprocess.run([PROGRAM, "--headless", *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


class Viewer:
    """The program with its window on `display`; files are saved in `folder`."""

    def __init__(self, display, folder, scene, *options):
        self.display, self.folder = display, folder
        self.errors = open(os.path.join(folder, "errors.txt"), "w+")
        self.process = subprocess.Popen(
            [PROGRAM, os.path.join(SOURCE, "scenes", scene, "scene.gltf"), "-o", folder, *map(str, options)], stderr=self.errors,
            env=dict(display.environment, CMPG_VALIDATION="1"))
        self.window = wait_until(self.find_window, PATIENCE, "window")
        self.park()

    def find_window(self):
        assert self.process.poll() is None, self.said()
        return self.display.xdotool("search", "--name", "cmpg-vk").split("\n")[0]

    def said(self):
        self.errors.flush()
        self.errors.seek(0)
        return self.errors.read()

    def title(self):
        assert self.process.poll() is None, self.said()
        return self.display.xdotool("getwindowname", self.window)

    def wait_title(self, pattern):
        return wait_until(lambda: re.search(pattern, self.title()), PATIENCE, f"title like '{pattern}' but '{self.title()}'")

    def key(self, *keys):
        self.display.xdotool("key", "--delay", 60, *keys)

    def park(self):
        """The cursor where it marks nothing, but over the window, which takes keys from there."""
        self.display.xdotool("mousemove", 60, 880)
        time.sleep(0.5)

    def save(self, name, keys="ctrl+s"):
        """Saves the picture under the cursor, as the user's shortcut does."""
        path = os.path.join(self.folder, name)
        self.key(keys)
        wait_until(lambda: os.path.exists(path), 60, name)
        return path

    def shown(self, picture, what):
        """Where `picture` is on the screen, once it is shown well there; the screen is kept where it is not."""
        qualities = []  # of what looks like it: another exposure does, until all keys have arrived
        def look():
            screen = self.display.screen()
            place = pictures.find(picture, screen)
            if place:
                qualities.append(pictures.psnr(picture, screen, *place))
            return place if place and qualities[-1] > 40 else None
        try:
            place = wait_until(look, 30, what)
        except AssertionError:
            pictures.write_png("viewer-" + what + ".png", self.display.screen())
            print(f"{what}: shown with {qualities} dB")
            raise
        print(f"{what}: shown at {place} with {qualities[-1]:.1f} dB")
        return place

    def quit(self, seconds=30):
        self.key("ctrl+q")
        assert self.process.wait(seconds) == 0, self.said()
        assert self.said() == "", self.said()


def cropped(picture, height):
    return Picture(picture.width, height, picture.rows[:height])


def middle(place, picture):
    return place[0] + picture.width // 2, place[1] + picture.height // 2


def render(display, folder):
    viewer = Viewer(display, folder, "box", "--width", 160, "--spp", 4)
    viewer.wait_title("render, 4 samples, at rest")
    viewer.key("z")
    saved = pictures.read_png(viewer.save("box-image.png"))
    viewer.shown(saved, "saved-image")
    # The same state by the headless command.
    exr, png = os.path.join(folder, "a.exr"), os.path.join(folder, "a.png")
    run_headless("render", os.path.join(SOURCE, "scenes/box/scene.gltf"), "--width", 160, "--spp", 4, "-o", exr)
    run_headless("view", exr, "-o", png)
    viewer.shown(pictures.read_png(png), "headless-image")
    viewer.key("bracketright", "bracketright")  # one stop
    run_headless("view", exr, "-o", png, "--exposure", 1)
    viewer.shown(pictures.read_png(png), "exposed-image")
    # Turning the camera makes another image, and C brings the first back.
    place = viewer.shown(pictures.read_png(png), "exposed-image")
    x, y = middle(place, saved)
    rest = ("sleep", 0.3)  # a hand is slower than a frame
    display.xdotool("mousemove", x, y, "mousedown", 1, *rest, "mousemove_relative", 60, 10, *rest, "mousemove_relative", 60, 10, *rest, "mouseup", 1)
    viewer.park()
    wait_until(lambda: pictures.find(pictures.read_png(png), display.screen()) is None, 60, "turn of the camera")
    viewer.key("c")
    viewer.shown(pictures.read_png(png), "camera-reset")
    viewer.quit()


def gradient(display, folder):
    viewer = Viewer(display, folder, "box", "--width", 160, "--spp", 4)
    viewer.wait_title("render, 4 samples, at rest")
    viewer.key("2")
    viewer.wait_title("gradient, 4 samples, at rest")
    viewer.key("z")
    exr, png = os.path.join(folder, "d.exr"), os.path.join(folder, "d.png")
    run_headless("gradient", os.path.join(SOURCE, "scenes/box/scene.gltf"), "--param", "painting.baseColor", "--width", 160, "--spp-gradient", 4,
                 "-o", exr)
    run_headless("view", exr, "-o", png, "--signed")
    headless = cropped(pictures.read_png(png), 160)  # without its legend
    place = viewer.shown(headless, "headless-gradient")
    display.xdotool("mousemove", *middle(place, headless))
    time.sleep(1)
    saved = pictures.read_png(viewer.save("box-gradient.png"))
    assert saved.rows[:160] == headless.rows, "the file saved is not the headless one"
    viewer.quit()


def optimize(display, folder):
    target = os.path.join(folder, "target.exr")
    scene = os.path.join(SOURCE, "scenes/box/scene.gltf")
    run_headless("render", scene, "--width", 128, "--spp", 16, "-o", target)
    viewer = Viewer(display, folder, "box", "--target", target, "--param", "painting.baseColor", "--set", "painting.baseColor=0.5", "--spp", 4)
    viewer.key("3")
    viewer.wait_title("optimise, step [3-9]")
    viewer.key("space")
    viewer.wait_title("at rest")
    step = int(re.search(r"step (\d+)", viewer.title()).group(1))
    viewer.key("n")
    viewer.wait_title(f"step {step + 1}")
    viewer.wait_title("at rest")
    assert f"step {step + 1}," in viewer.title(), viewer.title()  # one step and no more
    viewer.key("z")
    viewer.shown(pictures.read_png(viewer.save("box-image.png")), "image-optimised")
    run_headless("view", target, "-o", os.path.join(folder, "target.png"))
    viewer.shown(pictures.read_png(os.path.join(folder, "target.png")), "target")
    # The curve of the loss, at the bottom, as a picture and as values.
    display.xdotool("mousemove", 800, 840)
    time.sleep(0.5)
    viewer.save("box-loss.png")
    with open(viewer.save("box-loss.csv", "ctrl+e")) as rows:
        assert len(rows.readlines()) == step + 2  # with the header
    viewer.park()
    viewer.key("ctrl+shift+s")
    wait_until(lambda: os.path.exists(os.path.join(folder, "box-recovered", "scene.gltf")), 60, "scene saved")
    viewer.key("r")
    viewer.wait_title("step 0")
    viewer.quit()


def inspector(display, folder):
    viewer = Viewer(display, folder, "box", "--width", 160, "--spp", 4)
    viewer.wait_title("render, 4 samples, at rest")
    viewer.key("t", "z")
    place = viewer.shown(pictures.read_png(viewer.save("box-image.png")), "image")
    before = display.screen()
    display.xdotool("mousemove", place[0] + 80, place[1] + 120, "sleep", 0.3, "click", 1, "sleep", 0.5)
    viewer.park()
    # The column of the maps stands at the right: warm colours of the map of light, where nothing but the image's ground was.
    def warm(screen):
        return sum(1 for y in range(200, 860, 4) for x in range(1180, 1420, 4) if screen.at(x, y)[0] > screen.at(x, y)[2] + 60)
    try:
        wait_until(lambda: warm(display.screen()) > warm(before) + 200, PATIENCE, "maps of the guide")
    except AssertionError:
        pictures.write_png("viewer-inspector.png", display.screen())
        raise
    viewer.key("Escape")
    viewer.quit()


def storm(display, folder):
    """Sizes and visibility change faster than frames are drawn, while the work goes on."""
    viewer = Viewer(display, folder, "box", "--width", 128, "--spp", 65536)
    viewer.wait_title(r"render, \d+ sample")
    generator = random.Random(4)
    for i in range(60):
        display.xdotool("windowsize", viewer.window, generator.randrange(480, 1500), generator.randrange(320, 960))
        if i % 6 == 5:
            display.xdotool("windowunmap", viewer.window)
            time.sleep(generator.uniform(0, 0.3))
            display.xdotool("windowmap", viewer.window)
    with display.manage() as manager:
        for i in range(20):
            manager.minimise(int(viewer.window))
            time.sleep(generator.uniform(0, 0.2))
            manager.restore(int(viewer.window))
        manager.minimise(int(viewer.window))
        samples = int(re.search(r"(\d+) sample", viewer.title()).group(1))
        wait_until(lambda: int(re.search(r"(\d+) sample", viewer.title()).group(1)) > samples, PATIENCE, "work while minimised")
        manager.restore(int(viewer.window))
    display.xdotool("windowsize", "--sync", viewer.window, 1440, 900)
    viewer.park()
    viewer.key("space")
    viewer.wait_title("at rest")
    viewer.key("z")
    viewer.shown(pictures.read_png(viewer.save("box-image.png")), "image-after-storm")
    viewer.quit()


def processor_seconds(pid):
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def idle(display, folder):
    """A window that shows a finished image uses next to no processor time."""
    viewer = Viewer(display, folder, "box", "--width", 64, "--spp", 1)
    viewer.wait_title("render, 1 sample, at rest")
    time.sleep(2)
    before = processor_seconds(viewer.process.pid)
    time.sleep(10)
    used = processor_seconds(viewer.process.pid) - before
    print(f"{used:.2f} s of processor time in 10 s")
    assert used < 1, used
    viewer.quit()


def small_display(_, folder):
    """A window is no larger than what the display shows, though no window manager sees to it."""
    with Display(1024, 700) as small:
        viewer = Viewer(small, folder, "box", "--width", 64, "--spp", 1)
        viewer.wait_title("render, 1 sample, at rest")
        size = dict(line.split("=") for line in small.xdotool("getwindowgeometry", "--shell", viewer.window).splitlines())
        assert (size["WIDTH"], size["HEIGHT"]) == ("1024", "700"), size
        viewer.quit()


def close_midstep(display, folder):
    """Closing never waits for a step or a compilation to end."""
    for wait, end in (("step 0", "key"), ("step [1-9]", "key"), ("step 0", "button"), ("step 0", "signal")):
        viewer = Viewer(display, folder, "box", "--param", "painting.baseColor", "--set", "painting.baseColor=0.5", "--spp", 1024)
        viewer.key("3")
        viewer.wait_title(wait if wait == "step 0" else "optimise")
        time.sleep(3)
        began = time.monotonic()
        if end == "key":
            viewer.quit(60)
        elif end == "button":
            with display.manage() as manager:
                manager.close(int(viewer.window))
            assert viewer.process.wait(60) == 0 and viewer.said() == "", viewer.said()
        else:
            viewer.process.send_signal(signal.SIGTERM)
            assert viewer.process.wait(60) == 130, viewer.said()
        print(f"ended within {time.monotonic() - began:.1f} s")


def no_presentation(display, folder):
    """Without a device that presents, the message says how to work all the same."""
    scene = os.path.join(SOURCE, "scenes/box/scene.gltf")
    for variables in ({"VK_ICD_FILENAMES": "/nonexistent.json", "VK_DRIVER_FILES": "/nonexistent.json"}, {"DISPLAY": ":9999"}):
        run = subprocess.run([PROGRAM, scene], env=dict(display.environment, **variables), capture_output=True, text=True, timeout=60)
        print(run.stderr)
        assert run.returncode == 4 and "--headless" in run.stderr, variables


def drop(display, folder):
    """The callback of dropped files, in a window and with the work behind it: a C++ test that needs a display."""
    subprocess.run([sys.argv[4], "--gtest_filter=Drop.*"], env=dict(display.environment, CMPG_VALIDATION="1", CMPG_NEED_DISPLAY="1"), check=True)


SCENARIOS = {f.__name__: f for f in (render, gradient, optimize, inspector, storm, idle, small_display, close_midstep, no_presentation, drop)}

if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[2], sys.argv[3]
    require_tools()
    with Display() as the_display, tempfile.TemporaryDirectory(prefix="cmpg-viewer-") as the_folder:
        SCENARIOS[sys.argv[1]](the_display, the_folder)
    print("passed")
