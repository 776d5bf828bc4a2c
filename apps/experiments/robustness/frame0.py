"""A model with the texture of its first frame alone: what turns into view later is not known."""

import csv
import math
import statistics

import numpy

import measures
import models
import paths
from bench import Subject
from document import table
from measures import text


def known_shares(model, poses):
    """Of what is seen of a convex model at each of these poses, the share that was seen at the first."""
    corner = [model.points[model.corners[:, i, 0]] for i in range(3)]
    across = numpy.cross(corner[1] - corner[0], corner[2] - corner[0])
    middle = sum(corner) / 3

    def seen_areas(pose):
        # Looking at a triangle along its middle's ray: its area as seen, where it faces the camera.
        ray = middle + pose[:, :3].T @ pose[:, 3]
        distance = numpy.linalg.norm(ray, axis=1)
        return numpy.maximum(0, -(across * ray).sum(1)) / distance ** 3

    known = seen_areas(poses[0]) > 0
    return [areas[known].sum() / areas.sum() for areas in map(seen_areas, poses)]


def bake(bench, folder, frames, model, camera, pose):
    first = folder / "first.txt"
    paths.write_poses(first, [pose])
    bench.call("bake", frames, "--model", model, "--camera", camera, "--init", first, "--keep-pose", "--stop", 1,
               "--unwrap", "--quiet", "--out", folder / "model.obj")


def simulated(bench, kind, asked):
    """Frames of an object that turns its back and comes round again: known share, whether held, mm and degrees off."""
    plain = bench.model(kind, bench.scenario["objects"][kind])
    poses = paths.turning(asked["distance"], asked["turn"], asked["frames"])
    subject = bench.simulated("frame0-" + kind, plain, {}, poses=poses)
    baked = bench.folder / "models" / ("frame0-" + kind)
    stamp = bench.keep(baked, bench.program_digest + subject.stamp, lambda: bake(
        bench, baked, subject.folder / "frames", plain, subject.folder / "K.txt", poses[0]))
    run = bench.track("frame0-" + kind, Subject(subject.name, subject.folder, baked / "model.obj", stamp))
    shares = known_shares(models.read(plain), numpy.asarray(poses))
    for row in run.rows:
        distance, _, _, turn = measures.error(row)
        yield shares[int(row["frame"])], measures.held(row), distance, turn


def poses_of(path):
    """Frames of a table of `holdfast track`: whether held, and the pose."""
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            x, y, z, w = (float(row[name]) for name in ("qx", "qy", "qz", "qw"))
            rotation = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
            yield row["status"] == "held", numpy.column_stack([rotation, [float(row[n]) for n in ("tx", "ty", "tz")]])


def demo(bench, folder):
    """The demo's video; what it found with the texture of all frames stands for the truth."""
    work = bench.folder / "frame0-demo"
    model, camera = folder / "box_textured.obj", folder / "camera.yml"
    reference = [pose for _, pose in poses_of(folder / "poses.csv")]

    def make():
        bake(bench, work, folder / "box.mp4", model, camera, reference[0])
        bench.call("track", folder / "box.mp4", "--model", work / "model.obj", "--camera", camera, "--init",
                   work / "first.txt", "--poses", work / "poses.csv", "--quiet")

    bench.progress("track frame0-demo")
    bench.keep(work, bench.program_digest + (folder / "poses.csv").read_text(), make)
    shares = known_shares(models.read(model), numpy.asarray(reference))
    for share, true, (held, pose) in zip(shares, reference, poses_of(work / "poses.csv")):
        cosine = 0.5 * (numpy.trace(true[:, :3] @ pose[:, :3].T) - 1)
        yield (share, held, 1000 * numpy.linalg.norm(true[:, 3] - pose[:, 3]),
               math.degrees(math.acos(min(1.0, max(-1.0, cosine)))))


def row_of(name, frames, least):
    frames = list(frames)
    enough = [frame for frame in frames if frame[0] >= least]
    hidden = [frame for frame in frames if frame[0] < least]
    # After each stay below, frames until held and right once enough is seen again.
    again, waiting = [], None
    for before, (share, held, mm, degrees) in zip([None] + frames[:-1], frames):
        if before and before[0] < least <= share:
            waiting = 0
        elif share < least:
            waiting = None
        if waiting is not None:
            if held and mm < 20 and degrees < 5:
                again.append(waiting)
                waiting = None
            else:
                waiting += 1
    good = [frame for frame in enough if frame[1]]
    wrong = sum(frame[1] and (frame[2] > 20 or frame[3] > 5) for frame in frames)
    middle = " / ".join(text(statistics.median(frame[i] for frame in good)) for i in (2, 3)) if good else "-"
    return [name, "{} of {}".format(len(enough) - len(good), len(enough)), middle,
            "{} of {}".format(sum(frame[1] for frame in hidden), len(hidden)), wrong,
            ", ".join(map(str, again)) if again else "-"]


def part(bench, recorded):
    asked = bench.scenario["frame0"]
    rows = [row_of(kind, simulated(bench, kind, asked), asked["least"]) for kind in asked["objects"]]
    if bench.demo and (bench.demo / "poses.csv").exists():
        rows.append(row_of("the demo's video", demo(bench, bench.demo), asked["least"]))
    return table(["object", "lost while a fifth of what is seen has texture", "median then, mm / deg",
                  "held while less has", "held but wrong", "held again after, frames"], rows)
