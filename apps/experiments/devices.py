#!/usr/bin/env python3
"""How long a frame takes on this machine's processor and on its graphics processor, drawn by OSMesa and by EGL, and how
far apart the poses are. Writes docs/results/devices.md.

  devices.py --program build/release/apps/holdfast --sequences FOLDER [--frames N] [--document FILE]

FOLDER is as rbot.py takes it; of its sequences those named *_a_* are tracked.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import tempfile

import numpy

import modalities

HEAD = """# Devices

`make devices SEQUENCES=FOLDER` writes these tables, on a machine with a processor and a graphics processor for OpenCL:

{machine}
The first {frames} frames of each sequence, with the textured model and with its shape alone. EGL draws on the graphics
processor, OSMesa on the processor.

## Time

Milliseconds of tracking a frame: median, 95 %.

{speed}
## Poses

How far from the CPU's they are in default mode, and how far those are from the truth: millimetres (median, largest) /
degrees (median, largest). "CPU, groups" is the same processor with the kernels' other partition.

{agreement}"""

WAYS = {"CPU": ("--device", "cpu", "--renderer", "osmesa"),
        "CPU, groups": ("--device", "cpu", "--renderer", "osmesa", "--partition", "groups"),
        "GPU, OSMesa": ("--device", "gpu", "--renderer", "osmesa"),
        "GPU, EGL": ("--device", "gpu", "--renderer", "egl")}
TIMED = ("CPU", "GPU, OSMesa", "GPU, EGL")


def track(arguments, sequence, model, mode, way):
    """The rows of a run's table of poses."""
    truth = (sequence / "poses_gt.txt").read_text().splitlines()
    with tempfile.TemporaryDirectory() as work:
        first, table = pathlib.Path(work) / "first.txt", pathlib.Path(work) / "poses.csv"
        first.write_text(truth[0] + "\n")
        subprocess.run([arguments.program, "track", sequence / "frames", "--model", model, "--camera",
                        sequence / "K.txt", "--init", first, "--stop", str(arguments.frames), "--mode", mode,
                        "--poses", table, "--quiet", *WAYS[way]], check=True)
        with open(table, newline="") as rows:
            return list(csv.DictReader(rows))


def times(frames):
    """Without the first, in which light and colours are learned."""
    ms = [float(frame["ms"]) for frame in frames[1:]]
    return "{:.1f}, {:.1f}".format(*numpy.quantile(ms, [0.5, 0.95]))


def apart(poses, others):
    mm = [1e3 * numpy.linalg.norm(T[:, 3] - U[:, 3]) for T, U in zip(poses, others)]
    sines = [numpy.linalg.norm(T[:, :3] - U[:, :3]) / 8 ** 0.5 for T, U in zip(poses, others)]  # of half the angle
    degrees = numpy.degrees(2 * numpy.arcsin(numpy.clip(sines, 0, 1)))
    return "{:.3f}, {:.2f} / {:.3f}, {:.2f}".format(numpy.median(mm), max(mm), numpy.median(degrees), max(degrees))


def row(cells):
    return "| " + " | ".join(cells) + " |\n"


def machine(program):
    listed = json.loads(subprocess.run([program, "devices", "--json"], check=True, capture_output=True,
                                       text=True).stdout)["devices"]
    return "".join("- {}: {} ({}, driver {})\n".format(d["type"].upper(), d["name"],
                                                              d["platform_version"].split("  ")[0], d["driver"])
                   for d in listed)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--sequences", type=pathlib.Path, required=True)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--document", type=pathlib.Path, default=pathlib.Path("docs/results/devices.md"))
    arguments = parser.parse_args()
    others = [way for way in WAYS if way != "CPU"]
    speed = row(["sequence", "model", "mode", *TIMED]) + row(["---"] * (3 + len(TIMED)))
    agreement = row(["sequence", "model", *others, "CPU beside the truth"]) + row(["---"] * (3 + len(others)))
    for sequence in sorted(arguments.sequences.glob("*_a_*")):
        models = arguments.sequences / "models" / sequence.name.split("_")[0]
        for title, model in (("textured", models / "model.obj"), ("shape alone", models / "mesh_plain.obj")):
            print("devices:", sequence.name, title, flush=True)
            runs = {way: track(arguments, sequence, model, "default", way) for way in WAYS}
            fast = {way: track(arguments, sequence, model, "fast", way) for way in TIMED}
            for mode, timed in (("default", runs), ("fast", fast)):
                speed += row([sequence.name, title, mode, *(times(timed[way]) for way in TIMED)])
            poses = {way: [modalities.pose_of(frame) for frame in frames] for way, frames in runs.items()}
            truth = modalities.poses(sequence / "poses_gt.txt")
            agreement += row([sequence.name, title, *(apart(poses["CPU"], poses[way]) for way in others),
                              apart(poses["CPU"], truth)])
    arguments.document.write_text(HEAD.format(machine=machine(arguments.program), frames=arguments.frames, speed=speed,
                                              agreement=agreement))


if __name__ == "__main__":
    main()
