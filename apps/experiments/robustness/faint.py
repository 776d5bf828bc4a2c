"""Objects with little print: tracked by texture alone, and by texture and contour together."""

import statistics

import measures
import paths
from bench import Subject
from document import table
from measures import text

HEAD = ["object", "condition", "texture alone: frames lost or failed", "held but wrong", "median, mm / deg",
        "with the contour: frames lost or failed", "held but wrong", "median, mm / deg", "inside the 95 % ellipsoid, %",
        "ms"]


def figures(run):
    mm, degrees = run.median()
    return [run.bad(), run.wrong(), "{} / {}".format(text(mm), text(degrees))]


def part(bench, recorded):
    asked = bench.scenario["faint"]
    rows = []
    for kind, seed in asked["objects"].items():
        model = bench.model(kind, seed)
        scenes = [(condition, {**changes, "seed": asked["seed"]}, None)
                  for condition, changes in asked["conditions"].items()]
        if kind in asked["turning"]:
            scenes.append(("turning its back", {},
                           paths.turning(asked["turning"][kind], asked["turn"], asked["turn_frames"])))
        for condition, changes, poses in scenes:
            name = "faint-{}-{}".format(kind, condition.replace(" ", "-"))
            seen = bench.simulated(name, model, changes, poses=poses)
            subject = Subject(name, seen.folder, model, seen.stamp)
            alone = bench.track(name + "-texture", subject, "--no-contour")
            both = bench.track(name, subject)
            rows.append([kind, condition, *figures(alone), *figures(both), text(both.covered()[0], 1),
                         text(statistics.median(measures.number(r, "ms") for r in both.rows))])
    return table(HEAD, rows)
