"""Draws a report of `holdfast evaluate --json` as PNG files.

python3 plot.py REPORT.json FOLDER

FOLDER/SEQUENCE_stepN.png: errors over time, with frames reported lost and frames too little visible to count marked.
FOLDER/accuracy.png: share of frames below a threshold of ADD and ADD-S, for every sequence.
"""

import json
import math
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def numbers(values):
    """Gaps where the report has no figure (null: unknown, or infinitely far off)."""
    return [math.nan if value is None else value for value in values]


def offsets(frames):
    """The rows of every run, by the offset of its first frame."""
    return {offset: [i for i, o in enumerate(frames["offset"]) if o == offset]
            for offset in sorted(set(frames["offset"]))}


def shade(axes, frames, rows, keep, color, label):
    """Marks stretches of frames; `keep` says which rows."""
    first = True
    for i in rows:
        if keep(i):
            axes.axvspan(frames["frame"][i] - 0.5, frames["frame"][i] + 0.5, color=color, lw=0,
                         label=label if first else None)
            first = False


def limit(axes, values):
    """All values, unless a few (a lost object) would hide the rest: then those are cut off."""
    known = sorted(abs(v) for v in values if math.isfinite(v))
    if known:
        most = known[int(0.98 * (len(known) - 1))]
        top = 1.1 * (known[-1] if known[-1] <= 5 * most else 1.5 * most) + 1e-3
        low = axes.get_ylim()[0]
        axes.set_ylim(-top if low < 0 else 0, top)


def label(name, values):
    """With the largest value, which the axis may cut off."""
    return "{}, largest {:.3g}".format(name, max((abs(v) for v in values if math.isfinite(v)), default=math.nan))


def errors_over_time(report, evaluation, path):
    frames = evaluation["per_frame"]
    x, y, z = (numbers(frames[name]) for name in ("x_mm", "y_mm", "z_mm"))
    rotation = numbers(frames["rotation_deg"])
    runs = offsets(frames)
    figure, (position, depth, turn) = plt.subplots(3, 1, sharex=True, figsize=(10, 7.5))
    first = True
    for rows in runs.values():
        at = [frames["frame"][i] for i in rows]
        position.plot(at, [x[i] for i in rows], color="C0", lw=0.9, label=label("x", x) if first else None)
        position.plot(at, [y[i] for i in rows], color="C1", lw=0.9, label=label("y", y) if first else None)
        depth.plot(at, [z[i] for i in rows], color="C2", lw=0.9, label=label("depth", z) if first else None)
        turn.plot(at, [rotation[i] for i in rows], color="C3", lw=0.9, label=label("rotation", rotation) if first else None)
        first = False
    rows = next(iter(runs.values()))
    for axes in (position, depth, turn):
        every = range(len(frames["frame"]))
        shade(axes, frames, every, lambda i: not frames["held"][i], "#f4b6b6", "reported lost")
        shade(axes, frames, every, lambda i: not frames["counted"][i], "#d9d9d9", "not counted")
        axes.grid(alpha=0.3)
    position.set_ylabel("lateral error, mm")
    depth.set_ylabel("depth error, mm")
    turn.set_ylabel("rotation error, deg")
    turn.set_xlabel("frame")
    turn.set_ylim(bottom=0)
    limit(position, x + y)
    limit(depth, z)
    limit(turn, rotation)
    if min(frames["visible"]) < 0.999:
        share = turn.twinx()
        share.plot([frames["frame"][i] for i in rows], [frames["visible"][i] for i in rows], color="0.5", lw=0.8)
        share.set_ylim(0, 1.02)
        share.set_ylabel("visible share (grey)")
    for axes in (position, depth, turn):
        axes.legend(loc="upper right", fontsize=8)
    summary = evaluation["summary"]
    figure.suptitle("{}, step {}: {:.1f} % within {:g} mm and {:g} deg".format(
        evaluation["sequence"], evaluation["step"], 100 * (summary["success"]["share"] or 0),
        report["failure"]["mm"], report["failure"]["deg"]))
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def accuracy_over_threshold(report, path):
    known = [e for e in report["evaluations"] if e["diameter_mm"] and e["summary"]["add"]]
    if not known:
        return
    figure, pair = plt.subplots(1, 2, sharey=True, figsize=(10, 4.2))
    for axes, name, title in zip(pair, ("add_mm", "add_s_mm"), ("ADD", "ADD-S")):
        for evaluation in known:
            frames = evaluation["per_frame"]
            errors = sorted(math.inf if value is None else value / evaluation["diameter_mm"]
                            for value, counted in zip(frames[name], frames["counted"]) if counted)
            at = [0.0] + errors + [0.2]
            share = [0.0] + [(i + 1) / len(errors) for i in range(len(errors))]
            share.append(sum(e <= 0.2 for e in errors) / len(errors))
            points = [(a, s) for a, s in zip(at, share) if a <= 0.2]
            axes.step([100 * a for a, _ in points], [100 * s for _, s in points], where="post", lw=1,
                      label="{}, step {}".format(evaluation["sequence"], evaluation["step"]))
        axes.set_xlim(0, 20)
        axes.set_ylim(0, 101)
        axes.set_xlabel("{} threshold, % of the diameter".format(title))
        axes.grid(alpha=0.3)
    pair[0].set_ylabel("frames below, %")
    pair[1].legend(loc="lower right", fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main():
    report_path, folder = sys.argv[1:3]
    with open(report_path, encoding="utf-8") as file:
        report = json.load(file)
    for evaluation in report["evaluations"]:
        name = "{}_step{}.png".format(evaluation["sequence"], evaluation["step"])
        errors_over_time(report, evaluation, os.path.join(folder, name))
    accuracy_over_threshold(report, os.path.join(folder, "accuracy.png"))


main()
