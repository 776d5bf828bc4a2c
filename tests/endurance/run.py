#!/usr/bin/env python3
"""run.py PROGRAM WORK_FOLDER: 500 starts of the program in a row in a large environment, none of which may crash, and
tens of thousands of frames in default mode, over which memory must stay flat."""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

MEGABYTE = 1 << 20


def starts(program, count):
    """Drivers read and change the environment while they start: in one of 2000 variables that takes long enough."""
    environment = dict(os.environ, **{f"HOLDFAST_FILLING_{i}": "x" * 200 for i in range(2000)})
    failed = {}
    for i in range(count):
        run = subprocess.run([program, "devices"], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        if run.returncode != 0:
            failed[run.returncode] = failed.get(run.returncode, 0) + 1
        if (i + 1) % 100 == 0:
            print(f"{i + 1} starts, {sum(failed.values())} failed", flush=True)
    if failed:
        print("exit codes of those that failed:", failed)
    return not failed


def resident(process):
    for line in pathlib.Path(f"/proc/{process.pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) * 1024
    return 0


def frames(program, work, count, bounds):
    """A short sequence to and fro. `bounds`: frames, and by how much memory may grow after each."""
    sequence = work / "sequence"
    made = 200
    subprocess.run([program, "simulate", sequence, "--model", "box", "--frames", str(made), "--size", "320x240",
                    "--speed", "2", "--quiet", "--overwrite"], check=True)
    pictures = sorted((sequence / "frames").iterdir())
    to_and_fro = pictures + pictures[-2:0:-1]
    played = work / "played"
    shutil.rmtree(played, ignore_errors=True)
    played.mkdir()
    for i in range(count):
        (played / f"{i:06}.png").symlink_to(to_and_fro[i % len(to_and_fro)].resolve())
    first = work / "first.txt"
    first.write_text((sequence / "poses_gt.txt").read_text().splitlines()[0] + "\n")
    poses = work / "poses.csv"
    poses.write_text("")
    tracking = subprocess.Popen([program, "track", played, "--model", sequence / "model" / "model.obj", "--camera",
                                 sequence / "K.txt", "--init", first, "--poses", poses, "--quiet"])
    seen, said = [], 0
    with open(poses, "rb") as table:
        done = -1  # the heading
        while tracking.poll() is None:
            time.sleep(0.5)
            done += table.read().count(b"\n")
            try:
                seen.append((done, resident(tracking)))
            except OSError:
                break
            if done >= said + 5000:
                said = done
                print(f"{done} frames, {seen[-1][1] / MEGABYTE:.1f} MB", flush=True)
        done += table.read().count(b"\n")
    code = tracking.wait()
    rows = poses.read_text().splitlines()[1:]
    held = sum(",held," in row for row in rows)
    flat = True
    for settled, allowed in bounds:
        before = [memory for at, memory in seen if at <= settled]
        after = [memory for at, memory in seen if at > settled and memory > 0]
        growth = max(after) - max(before) if before and after else 0
        print(f"memory up to frame {settled}: {max(before, default=0) / MEGABYTE:.1f} MB, "
              f"after it {growth / MEGABYTE:+.1f} MB at most, {allowed / MEGABYTE:.1f} MB allowed")
        flat = flat and bool(after) and growth <= allowed
    print(f"{len(rows)} frames, {held} held, exit code {code}")
    return code == 0 and len(rows) == count and flat


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--starts", type=int, default=500)
    parser.add_argument("--frames", type=int, default=50000)
    given = parser.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    program = str(pathlib.Path(given.program).resolve())
    good = starts(program, given.starts)
    if given.frames > 0:
        # Mesa begins another block of 1 MB for what it uploads about every 5000 frames, three in all, and then takes
        # turns.
        bounds = [(min(5000, given.frames // 4), 4 * MEGABYTE), (min(20000, given.frames // 2), MEGABYTE // 2)]
        good = frames(program, given.work, given.frames, bounds) and good
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
