"""Plain objects, simulated, followed by their shape alone."""

import statistics

import measures
import models
from bench import Subject
from document import table
from measures import text
from PIL import Image
from work import digest


def painted(model, color):
    return models.Model(model.points, model.coordinates, model.corners, None, [Image.new("RGB", (8, 8), tuple(color))])


def shape_of(bench, name, model):
    """The model's surface without anything on it."""
    folder = bench.folder / "models" / ("shape-" + name)
    stamp = bench.keep(folder, digest(bench.maker_digest, model), lambda: models.read(model).write_shape(folder))
    return folder / "shape.obj", stamp


def row(run):
    counted = [r for r in run.rows if r["counted"] == "1"]
    good = [r for r in counted if r["failed"] != "1"]
    errors = [measures.error(r) for r in good]

    def spread(i):
        values = sorted(e[i] for e in errors)
        return "{} / {}".format(text(statistics.median(values)), text(values[int(0.95 * (len(values) - 1))]))

    squares = [measures.number(r, "normalized_error_squared") for r in good if measures.held(r)]
    inside = 100 * sum(s <= 12.592 for s in squares) / max(1, len(squares))
    return [text(100 * len(good) / len(counted), 1), sum(measures.wrong(r) for r in counted), spread(0), spread(3),
            text(inside, 1)]


def kept(run):
    """Of the frames that count, those held and right, and those held and wrong."""
    counted = [r for r in run.rows if r["counted"] == "1"]
    held, wrong = (sum(map(of, counted)) for of in (measures.held, measures.wrong))
    return [text(100 * (held - wrong) / len(counted), 1), wrong]


HEAD = ["success, %", "held but wrong", "mm: median / 95 %", "deg: median / 95 %", "inside the 95 % ellipsoid, %",
        "never put back: right, %", "held but wrong", "the same in grey: right, %", "held but wrong"]
LEAST = ["--min-visible", "0.25"]


def part(bench, recorded):
    asked = bench.scenario["contour"]
    rows = []
    for kind, color in asked["colors"].items():
        model = bench.changed_model("painted-" + kind, bench.model(kind, asked["seeds"][kind]),
                                    lambda m, color=color: painted(m, color))
        shape, stamp = shape_of(bench, kind, model)
        for condition, changes in asked["conditions"].items():
            name = "contour-{}-{}".format(kind, condition.replace(" ", "-"))
            seen = bench.simulated(name, model, changes)
            subject = Subject(name, seen.folder, shape, digest(seen.stamp, stamp))
            grey = bench.grey_frames(name + "-grey", subject)
            rows.append([kind, condition, *row(bench.track(name, subject, "--protocol", "rbot", *LEAST)),
                         *kept(bench.track(name + "-kept", subject, "--protocol", "never-reset", *LEAST)),
                         *kept(bench.track(name + "-grey", grey, "--protocol", "never-reset", *LEAST))])
    return table(["object", "condition", *HEAD], rows)
