#!/usr/bin/env python3
"""plots.py RESULT FOLDER: what run.py measured, as pictures (stages.svg, sweeps.svg)."""
import json
import pathlib
import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "holdfast"  # the same picture for the same figures
from matplotlib import pyplot  # noqa: E402

SIZES = ("512x256", "640x480", "1280x720")
MODES = ("default", "fast", "paper")
STAGES = ("upload", "filter", "render", "search", "solve")


def stages(result, path):
    """A bar a mode, size and number of threads, in multiples of (a)."""
    figure, axes = pyplot.subplots(1, len(result["threads"]), figsize=(10, 3.6), squeeze=False, sharey=True)
    for axis, (threads, runs) in zip(axes[0], result["threads"].items()):
        labels = [f"{mode}\n{size}" for size in SIZES for mode in MODES]
        left = [0.0] * len(labels)
        for stage in STAGES + ("other",):
            values = []
            for size in SIZES:
                for mode in MODES:
                    run = runs[f"frame/{mode}/{size}"]
                    ms = (run["frame_ms"] - sum(run[s + "_ms"] for s in STAGES) if stage == "other"
                          else run[stage + "_ms"])
                    values.append(max(0.0, ms) / runs[f"opencv/{size}"]["frame_ms"])
            axis.barh(labels, values, left=left, label=stage)
            left = [a + b for a, b in zip(left, values)]
        axis.axvline(1, color="black", linewidth=0.8)
        axis.set_title(f"{threads} thread" + ("" if threads == "1" else "s"))
        axis.set_xlabel("ms a frame / ms OpenCV takes to filter two images")
    axes[0][0].invert_yaxis()  # shared
    axes[0][-1].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def sweeps(result, path):
    """ms a frame against sizes of object, frame and mesh, and against the most pyramid levels."""
    panels = (("object_pixels", "thousand pixels of the object", lambda value: int(value) / 1e3, "linear"),
              ("frame_size", "million pixels of the frame (object fixed)",
               lambda value: int(value.split("x")[0]) * int(value.split("x")[1]) / 1e6, "linear"),
              ("triangles", "triangles", int, "log"),
              ("levels", "most pyramid levels", int, "linear"))
    figure, axes = pyplot.subplots(1, len(panels), figsize=(13, 3.4))
    for axis, (sweep, label, x_of, scale) in zip(axes, panels):
        for mode in MODES:
            points = sorted((x_of(name.split("/")[2]), run["frame_ms"], run["render_ms"])
                            for name, run in result["sweeps"].items() if name.startswith(f"{sweep}/{mode}/"))
            if points:
                line = axis.plot([p[0] for p in points], [p[1] for p in points], marker="o", label=mode)
                axis.plot([p[0] for p in points], [p[2] for p in points], linestyle=":", color=line[0].get_color(),
                          label=f"{mode}, render")
        axis.set_xscale(scale)
        axis.set_ylim(bottom=0)
        if scale == "linear":
            axis.set_xlim(left=0)
        axis.set_xlabel(label)
    axes[0].set_ylabel("ms a frame, 1 thread")
    axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})


def main(result_path, folder):
    result = json.loads(pathlib.Path(result_path).read_text())
    stages(result, pathlib.Path(folder) / "stages.svg")
    sweeps(result, pathlib.Path(folder) / "sweeps.svg")


if __name__ == "__main__":
    main(*sys.argv[1:])
