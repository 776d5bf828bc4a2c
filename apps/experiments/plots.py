"""Errors over time, as the paper draws them."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

import measures

DPI = 75


def pose(row, which):
    return numpy.array([[float(row["{}_{}{}".format(which, i, j)]) for j in range(4)] for i in range(3)])


def rotation_errors(row):
    """Rotation vector from the true to the estimated orientation, camera axes, degrees."""
    turn = pose(row, "estimated")[:, :3] @ pose(row, "true")[:, :3].T
    axis = numpy.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    length = numpy.linalg.norm(axis)
    if length < 1e-12:
        return numpy.zeros(3)
    return numpy.degrees(numpy.arctan2(length, numpy.trace(turn) - 1)) * axis / length


def axis_limit(columns):
    """As large as needed, at least the paper's own scale's hundredth, and cut off where the object is lost."""
    most = max(numpy.max(numpy.abs(column)) for column in columns)
    return most * 1.1


def shade(axes, rows):
    visible = [measures.number(row, "visible") for row in rows]
    hidden = axes.twinx()
    hidden.fill_between(range(len(rows)), [1 - v for v in visible], color="0.85", lw=0, zorder=0)
    hidden.set_ylim(0, 1)
    hidden.set_yticks([])
    axes.set_zorder(hidden.get_zorder() + 1)
    axes.patch.set_visible(False)
    for i, row in enumerate(rows):
        if not measures.held(row):
            axes.axvspan(i - 0.5, i + 0.5, color="#f4b6b6", lw=0, zorder=0.5)


def errors_over_time(runs, scenario, images, cut=(25.0, 6.0)):
    """A picture a scene for the first seed: a line a tracker, position at the left, orientation at the right."""
    for scene in scenario["scenes"]:
        trackers = [t for t in scenario["runs"][scene] if not t.endswith("-channels")]
        figure, grid = plt.subplots(len(trackers), 2, sharex=True, figsize=(11, 1.75 * len(trackers) + 0.4), squeeze=False)
        for (position, turn), tracker in zip(grid, trackers):
            rows = runs[scene, tracker].frames()[0]
            for columns, axes, names, most in (
                    (numpy.array([[measures.number(r, "error_{}_mm".format(k)) for k in "xyz"] for r in rows]), position,
                     ("x", "y", "depth"), cut[0]),
                    (numpy.array([rotation_errors(r) for r in rows]), turn, ("about x", "about y", "about z"), cut[1])):
                for column, name in zip(columns.T, names):
                    axes.plot(column, lw=0.9, label=name)
                limit = min(axis_limit([columns]), most)
                axes.set_ylim(-limit, limit)
                axes.grid(alpha=0.3)
                shade(axes, rows)
                largest = numpy.max(numpy.linalg.norm(columns, axis=1))
                unit = "mm" if axes is position else "deg"
                axes.set_title("{}: largest {:.3g} {}".format(scenario["trackers"][tracker]["title"], largest, unit), fontsize=9)
            position.set_ylabel("mm")
            turn.set_ylabel("deg")
        grid[0, 0].legend(loc="upper left", fontsize=7, ncol=3)
        grid[0, 1].legend(loc="upper left", fontsize=7, ncol=3)
        for axes in grid[-1]:
            axes.set_xlabel("frame")
        figure.suptitle("{}, the first seed: errors (grey: share of the box that is hidden; red: reported lost)".format(
            scenario["scenes"][scene]["title"]), fontsize=10)
        figure.tight_layout()
        figure.savefig(images / "errors_{}.png".format(scene), dpi=DPI)
        plt.close(figure)
