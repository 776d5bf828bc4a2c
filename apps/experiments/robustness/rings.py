"""Objects of revolution printed with nothing but rings: nothing in view tells how far they have turned about their
axis."""

import math
import statistics

import measures
import numpy
from document import table
from measures import text

HEAD = ["object", "condition", "mode", "frames held", "median, mm", "axis off by, deg: median / largest",
        "turn about the axis goes astray, deg a frame: median / largest",
        "its standard deviation as reported, deg: median", "frames lost or failed", "held but wrong"]
AXIS = numpy.array([0.0, 1.0, 0.0])  # models.turned() turns profiles about it


def rotation(row, whose):
    return numpy.array([[measures.number(row, "{}_{}{}".format(whose, i, j)) for j in range(3)] for i in range(3)])


def errors(row):
    """The angle between the true axis and the estimated one, and the turn about it that is left: degrees."""
    off = rotation(row, "true").T @ rotation(row, "estimated")
    axis = math.degrees(math.acos(min(1.0, max(-1.0, AXIS @ off @ AXIS))))
    return axis, math.degrees(math.atan2(off[0, 2], off[0, 0]))


def reported_deviation(row):
    """Of the turn about the axis, degrees, in the information that came with the pose (twist order v, w, camera axes);
    infinite where it says nothing of some motion."""
    upper = numpy.zeros((6, 6))
    for i in range(6):
        for j in range(i, 6):
            upper[i, j] = measures.number(row, "information_{}{}".format(i, j))
    information = upper + numpy.triu(upper, 1).T
    try:
        covariance = numpy.linalg.inv(information)
    except numpy.linalg.LinAlgError:
        return math.inf
    axis = rotation(row, "estimated") @ AXIS
    square = axis @ covariance[3:, 3:] @ axis
    return math.degrees(math.sqrt(square)) if square > 0 else math.inf


def part(bench, recorded):
    asked = bench.scenario["rings"]
    rows = []
    for kind, seed in asked["objects"].items():
        for condition, changes in asked["conditions"].items():
            name = "rings-{}-{}".format(kind, condition)
            subject = bench.simulated(name, bench.model(kind, seed), {**changes, "seed": asked["seed"]})
            for mode in asked["modes"]:
                run = bench.track("{}-{}".format(name, mode), subject, "--mode", mode)
                axis, about = zip(*map(errors, run.rows))
                astray = [abs((b - a + 180) % 360 - 180) for a, b in zip(about, about[1:])]
                held = sum(map(measures.held, run.rows))
                distance = statistics.median(measures.error(r)[0] for r in run.rows)
                deviation = statistics.median(reported_deviation(r) for r in run.rows)
                rows.append([kind, condition, mode, "{} of {}".format(held, len(run)), text(distance),
                             *("{} / {}".format(text(statistics.median(v)), text(max(v))) for v in (axis, astray)),
                             text(deviation), run.bad(), run.wrong()])
    return table(HEAD, rows)
