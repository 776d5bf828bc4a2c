"""The measures, a function each: given a Bench and the recorded sequences, the Markdown that the document shows."""

import statistics

import numpy

import ablation
import contour
import faint
import frame0
import light
import measures
import models
import paths
import rings
from bench import CAMERA, Subject, joined
from document import table
from measures import text


def verdict(good):
    return "met" if good else "**missed**"


def mm_deg(run):
    return "{} / {}".format(*map(text, run.median()))


def regular(bench, recorded):
    """The regular recorded sequences, or simulated ones where there are none."""
    chosen = [subject for name, subject in recorded.items() if name.endswith("a_regular")]
    if chosen:
        return chosen
    return [bench.simulated("regular-" + kind, bench.model(kind, bench.scenario["objects"][kind]))
            for kind in ("crate", "vase")]


def starts(bench, recorded):
    asked = bench.scenario["starts"]
    rows = []
    for subject in regular(bench, recorded):
        run = bench.track("starts-" + subject.name, subject, "--protocol", "starts", "--starts", asked["count"],
                          "--start-error", asked["error"], "--start-frames", asked["frames"], "--start-seed",
                          asked["seed"])
        good = sum(measures.held(r) and measures.within(r, asked["converged_mm"], asked["converged_deg"])
                   for r in run.rows)
        rows.append([subject.name, "{} of {}".format(good, len(run)), mm_deg(run), run.wrong(),
                     verdict(good >= asked["wanted"] * len(run))])
    return table(["sequence", "converged", "median error then, mm / deg", "held but wrong", "95 % wanted"], rows)


def other_light(bench, recorded):
    """A row a change, a column a sequence."""
    asked = bench.scenario["light"]
    subjects = regular(bench, recorded)
    rows, good = {}, {}
    for subject in subjects:
        plain = bench.track("light/{}-plain".format(subject.name), subject)
        rows.setdefault("as it is", []).append("{}, {}".format(plain.bad(), mm_deg(plain)))
        for name, changed in light_variants(bench, subject, asked):
            run = bench.track("light/" + changed.name, changed)
            ratio = max(a / b for a, b in zip(run.median(), plain.median()))
            rows.setdefault(name, []).append("{}, {}".format(run.bad(), mm_deg(run)))
            good[name] = good.get(name, True) and run.bad() <= plain.bad() and ratio <= asked["most_median_ratio"]
    return table(["video over texture", *(subject.name for subject in subjects), "no loss, at most doubled"],
                 [[name, *cells, verdict(good[name]) if name in good else ""] for name, cells in rows.items()])


def light_variants(bench, subject, asked):
    def frames(name, curve):
        return bench.changed_frames("{}-{}".format(subject.name, name), subject, curve)

    def texture(name, curve):
        return bench.with_texture("{}-{}".format(subject.name, name), subject,
                                  lambda folder: light.curved_model(subject.model, folder, curve))

    for gain in asked["gains"]:
        name = "gain-{:g}".format(gain)
        yield ("gain {:g}".format(gain), frames(name, lambda v: gain * v) if gain < 1
               else texture(name, lambda v: v / gain))
    yield ("gain {:g}, clipped".format(asked["over"]),
           frames("over-{:g}".format(asked["over"]), lambda v: asked["over"] * v))
    for gamma in asked["gammas"]:
        yield "gamma {:g}".format(gamma), frames("gamma-{:g}".format(gamma), lambda v: v ** gamma)
    for cast in asked["casts"]:
        name = "-".join("{:g}".format(c) for c in cast)
        yield ("colours times " + name.replace("-", ", "),
               frames("cast-" + name, lambda v: v * numpy.array(cast)))
    for i, lamp in enumerate(asked["shades"]):
        yield ("shaded faces, lamp {}".format(i + 1), bench.with_texture(
            "{}-shade-{}".format(subject.name, i), subject,
            lambda folder: light.shaded_model(subject.model, folder, lamp, asked["shade_least"])))


def covered_row(name, condition, run, asked):
    inside, middle = run.covered()
    return [name, condition, text(inside, 1), text(middle), run.bad(), mm_deg(run),
            verdict(asked["least"] <= inside <= asked["most"])]


COVERED = ["object or sequence", "condition", "inside the 95 % ellipsoid, %", "median square (5.35 if right)",
           "frames lost or failed", "median, mm / deg", "88 to 97 %"]


def covariance(bench, recorded):
    """Frames of one motion resemble each other: a hundred of them say little, so that motions are taken together."""
    asked = bench.scenario["covariance"]
    rows = []
    for kind, seed in asked["objects"].items():
        every = []
        for condition, changes in asked["conditions"].items():
            runs = []
            for motion in asked["motions"]:
                name = "covariance-{}-{}-{}".format(kind, condition, motion)
                runs.append(bench.track(name, bench.simulated(name, bench.model(kind, seed), {**changes, "seed": motion})))
            rows.append(covered_row(kind, condition, joined(runs), asked))
            every += runs
        rows.append(covered_row(kind, "all", joined(every), asked))
    rows += [covered_row(name, "recorded", bench.track("recorded/" + name, subject), asked)
             for name, subject in recorded.items()]
    return table(COVERED, rows)


def made_objects(bench, kinds):
    """Of each kind its name, its model's path and the model's points."""
    for kind in kinds:
        model = bench.model(kind, bench.scenario["objects"][kind])
        yield kind, model, models.read(model).points


def small(bench, recorded):
    asked = bench.scenario["small"]
    rows = []
    for kind, model, points in made_objects(bench, asked["objects"]):
        across = 0.9 * numpy.linalg.norm(points.max(0) - points.min(0))
        distance = across * CAMERA[2] / asked["pixels"]
        subject = bench.simulated("small-" + kind, model, {
            "distance": "{:.3f},{:.3f}".format(distance, 1.02 * distance), "speed": 3})
        run = bench.track("small-" + kind, subject)
        rows.append([kind, asked["pixels"], text(distance), *losses(run)])
    return table(["object", "pixels across", "distance, m", *LOSSES], rows)


def outside(bench, recorded):
    asked = bench.scenario["outside"]
    rows = []
    for kind, model, points in made_objects(bench, asked["objects"]):
        points = paths.outermost(points)
        poses = paths.leaving(points, CAMERA, 0.55, asked["inside"], 160)
        run = bench.track("outside-" + kind, bench.simulated("outside-" + kind, model, {}, poses=poses))
        inside = [paths.share_inside(points, pose, CAMERA) for pose in poses]
        errors = [measures.error(r) for r in run.rows if inside[int(r["frame"])] < 0.6]
        rows.append([kind, text(100 * min(inside), 0), *losses(run), "{}: {} / {}".format(
            len(errors), *(text(statistics.median(e[i] for e in errors)) for i in (0, 3)))])
    return table(["object", "least inside, %", *LOSSES, "frames less than 60 % inside: median, mm / deg"], rows)


LOSSES = ["frames lost or failed", "median, mm / deg", "held but wrong", "no loss"]


def losses(run):
    return [run.bad(), mm_deg(run), run.wrong(), verdict(run.bad() == 0)]


def object_row(name, changed, run):
    return [name, changed, text(run.success(), 1), run.bad(), run.wrong(), mm_deg(run),
            "{} / {}".format(*map(text, run.largest()))]


OBJECTS = ["object", "what is the matter", "success, %", "frames lost or failed", "held but wrong", "median, mm / deg",
           "largest, mm / deg"]


def objects(bench, recorded):
    rows = []
    for kind, seed in bench.scenario["objects"].items():
        changes = bench.scenario["objects_simulate"].get(kind, {})
        subject = bench.simulated("object-" + kind, bench.model(kind, seed), changes)
        rows.append(object_row(kind, "", bench.track("object-" + kind, subject)))
    for kind in bench.scenario["wrong"]["objects"]:
        for what, subject in wrong_variants(bench, kind):
            rows.append(object_row(kind, what, bench.track(subject.name, subject)))
    return table(OBJECTS, rows)


def wrong_variants(bench, kind):
    asked = bench.scenario["wrong"]
    model = bench.model(kind, bench.scenario["objects"][kind])
    plain = bench.simulated("object-" + kind, model)
    for factor in asked["focal"]:
        subject = bench.changed_frames("focal-{:g}-{}".format(factor, kind), plain, lambda v: v)
        width, height, f, cx, cy = CAMERA
        (subject.folder / "K.txt").write_text("{0} {0} {1} {2}\n".format(factor * f, cx, cy))
        yield "focal length times {:g}".format(factor), subject
    for distance in asked["inflated_mm"]:
        name = "inflated-{:g}-{}".format(distance, kind)
        changed = bench.changed_model(name, model, lambda m: m.inflated(1e-3 * distance))
        yield ("mesh {:g} mm {}".format(abs(distance), "outside" if distance > 0 else "inside"),
               Subject(name, plain.folder, changed, plain.stamp + name))
    for factor in asked["scaled"]:
        name = "scaled-{:g}-{}".format(factor, kind)
        changed = bench.changed_model(name, model, lambda m: models.Model(
            factor * m.points, m.coordinates, m.corners, m.materials, m.pictures))
        yield "mesh times {:g}".format(factor), Subject(name, plain.folder, changed, plain.stamp + name)
    for axis, factor in asked["stretched"]:
        name = "stretched-{}-{:g}-{}".format(axis, factor, kind)
        changed = bench.changed_model(name, model, lambda m: models.Model(
            m.points * numpy.where(numpy.arange(3) == axis, factor, 1), m.coordinates, m.corners, m.materials,
            m.pictures))
        yield "mesh times {:g} along {}".format(factor, "xyz"[axis]), Subject(name, plain.folder, changed,
                                                                              plain.stamp + name)
    # Three fingers over the front; they stay where they hold.
    size = models.read(model).points
    place = numpy.eye(4)
    place[:3, 3] = [0.15 * size[:, 0].max(), -0.05, size[:, 2].max() + 0.01]
    name = "fingers-" + kind
    subject = bench.simulated(name, model, {}, occluder=(
        bench.model("fingers", 1), paths.held_by(paths.read_poses(plain.folder / "poses_gt.txt"), place)))
    seen = [float(line) for line in (subject.folder / "visible.txt").read_text().split()]
    yield "fingers over {:.0f} %".format(100 * (1 - statistics.mean(seen))), subject


PARTS = {
    "starts": starts, "other-light": other_light, "covariance": covariance,
    "small": small, "outside": outside, "objects": objects, "faint": faint.part, "contour": contour.part,
    "rings": rings.part, "frame0": frame0.part,
    "ablation": ablation.part,
}
