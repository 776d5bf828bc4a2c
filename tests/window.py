"""window.py PROGRAM FOLDER: `holdfast track --show` in a virtual display: the contour is seen, keys do what they say.

Xvfb keeps its picture in a file (XWD), and xdotool presses keys.
"""

import os
import shutil
import struct
import subprocess
import sys
import time
from pathlib import Path

HELD = (90, 255, 120)  # the contour of an object that is held, RGB
PATIENCE = 300  # seconds: only a failure takes so long, and a busy machine draws late
STILL = 2  # seconds, in which four frames would be shown


def pixels(screen):
    """The screen's pixels as a list of (red, green, blue)."""
    data = screen.read_bytes()
    header = struct.unpack(">25I", data[:100])
    size, height, bytes_per_line, colors = header[0], header[5], header[12], header[19]
    little = header[7] == 0
    body = data[size + 12 * colors:size + 12 * colors + height * bytes_per_line]
    blue, green, red = (body[i::4] for i in range(3)) if little else (body[3 - i::4] for i in range(3))
    return list(zip(red, green, blue))


def contour(screen):
    return sum(all(abs(a - b) < 12 for a, b in zip(pixel, HELD)) for pixel in pixels(screen))


def wait_for(what, condition, program=None):
    """Until the condition holds; a program that ends before that is a failure at once."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if program is not None and program.poll() is not None:
            sys.exit(f"The program ended with exit code {program.returncode} before this: {what}")
        if condition():
            return
        time.sleep(0.3)
    sys.exit(f"Not within {PATIENCE} s: {what}")


class Display:
    def __init__(self, folder):
        self.folder = folder
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "900x700x24", "-fbdir", str(folder), "-nolisten", "tcp"],
            pass_fds=(write,), stderr=subprocess.DEVNULL)
        os.close(write)
        number = os.read(read, 20).decode().strip()
        if not number:
            sys.exit("Xvfb does not start")
        self.environment = {**os.environ, "DISPLAY": f":{number}", "QT_LOGGING_RULES": "*=false"}
        self.environment.pop("WAYLAND_DISPLAY", None)
        self.screen = folder / "Xvfb_screen0"

    def press(self, key):
        found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "holdfast track"],
                               env=self.environment, capture_output=True, text=True)
        window = found.stdout.split()[-1]
        subprocess.run(["xdotool", "windowfocus", window, "key", key], env=self.environment, check=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()


def check(condition, what):
    if not condition:
        sys.exit(f"Not so: {what}")


def main():
    program, folder = sys.argv[1], Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "screen").mkdir(parents=True)
    subprocess.run([program, "simulate", "seq", "--frames", "40", "--quiet"], cwd=folder, check=True)
    (folder / "first.txt").write_text((folder / "seq/poses_gt.txt").read_text().splitlines()[0])
    track = [program, "track", "seq/frames", "--model", "seq/model/model.obj", "--camera", "seq/K.txt", "--init",
             "first.txt", "--poses", "poses.csv", "--quiet", "--show", "--frame-rate", "2"]

    nowhere = {**os.environ}
    nowhere.pop("DISPLAY", None)
    nowhere.pop("WAYLAND_DISPLAY", None)
    refused = subprocess.run(track, cwd=folder, env=nowhere, capture_output=True, text=True)
    check(refused.returncode == 2, "without a display the exit code is 2")
    check(refused.stderr.count("\n") == 1 and "--show needs a display" in refused.stderr, "and one line says why")

    with Display(folder / "screen") as display:
        with open(folder / "errors.txt", "w") as errors:
            run = subprocess.Popen(track, cwd=folder, env=display.environment, stdout=errors, stderr=errors)
        try:
            def rows():
                return (folder / "poses.csv").read_text().count("\n")

            def stands_still():
                before = rows(), pixels(display.screen)
                time.sleep(STILL)
                return before == (rows(), pixels(display.screen))

            wait_for("the contour of the box on the screen", lambda: contour(display.screen) > 200, run)
            display.press("space")
            wait_for("space pauses, and the picture stands still", stands_still, run)
            paused_at, before = rows(), pixels(display.screen)
            check(paused_at < 35, "before the last frame")
            display.press("s")
            wait_for("a saved picture", lambda: list(folder.glob("holdfast-*.png")), run)
            display.press("c")
            display.press("period")
            wait_for("a step by one frame, to the classes of pixels", lambda: rows() == paused_at + 1 and
                     sum(a != b for a, b in zip(before, pixels(display.screen))) > 50000, run)
            time.sleep(STILL)
            check(rows() == paused_at + 1, "a step is one frame")
            display.press("q")
            wait_for("the end of the program", lambda: run.poll() is not None)
            check(run.returncode == 0, "q ends it as a run that came to its end")
            errors = (folder / "errors.txt").read_text()
            check(errors == "" or "saved to" in errors, f"nothing else is said: {errors}")
        finally:
            run.kill()
            run.wait()
            print((folder / "errors.txt").read_text(), end="")
    print("shown, paused, stepped, saved and ended")


if __name__ == "__main__":
    main()
