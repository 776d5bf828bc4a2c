"""Objects of revolution printed with nothing but rings: nothing in view tells how far they have turned about their
axis."""

import math
import statistics

import measures
import numpy
from document import table
from measures import text

HEAD = ["object", "condition", "frames held", "median, mm", "axis off by, deg: median / largest",
        "turn about the axis goes astray, deg a frame: median / largest", "the object's own, deg a frame: median",
        "its standard deviation as reported, deg: median", "inside two of them, % of frames held"]
AXIS = numpy.array([0.0, 1.0, 0.0])  # models.turned() turns profiles about it


def rotation(row, whose):
    return numpy.array([[measures.number(row, "{}_{}{}".format(whose, i, j)) for j in range(3)] for i in range(3)])


def about_axis(turn):
    """Degrees."""
    return math.degrees(math.atan2(turn[0, 2] - turn[2, 0], turn[0, 0] + turn[2, 2]))


def errors(row):
    """The angle between the true axis and the estimated one, and the turn about it that is left: degrees."""
    off = rotation(row, "true").T @ rotation(row, "estimated")
    axis = math.degrees(math.acos(min(1.0, max(-1.0, AXIS @ off @ AXIS))))
    return axis, about_axis(off)


def reported_deviation(row):
    """Of the turn about the axis, degrees, in the information that came with the pose (twist order v, w, object axes);
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
    square = AXIS @ covariance[3:, 3:] @ AXIS
    return math.degrees(math.sqrt(square)) if square > 0 else math.inf


def part(bench, recorded):
    asked = bench.scenario["rings"]
    rows = []
    for kind, seed in asked["objects"].items():
        for condition, changes in asked["conditions"].items():
            name = "rings-{}-{}".format(kind, condition)
            subject = bench.simulated(name, bench.model(kind, seed), {**changes, "seed": asked["seed"]})
            run = bench.track(name, subject)
            axis, about = zip(*map(errors, run.rows))
            astray = [abs((b - a + 180) % 360 - 180) for a, b in zip(about, about[1:])]
            held = sum(map(measures.held, run.rows))
            distance = statistics.median(measures.error(r)[0] for r in run.rows)
            own = statistics.median(abs(about_axis(rotation(a, "true").T @ rotation(b, "true")))
                                    for a, b in zip(run.rows, run.rows[1:]))
            deviations = [reported_deviation(r) for r in run.rows]
            inside = [abs(a) <= 2 * d for a, d, r in zip(about, deviations, run.rows) if measures.held(r)]
            rows.append([kind, condition, "{} of {}".format(held, len(run)), text(distance),
                         *("{} / {}".format(text(statistics.median(v)), text(max(v))) for v in (axis, astray)),
                         text(own), text(statistics.median(deviations)), text(100 * sum(inside) / len(inside))])
    return table(HEAD, rows)
