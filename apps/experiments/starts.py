#!/usr/bin/env python3
"""Starts without a first pose, on recorded sequences: found, found wrongly, found again; writes docs/results/starts.md.

  starts.py --program build/release/apps/holdfast --sequences FOLDER [--parts starts,foreign,...] [--demo FOLDER]
            [--document FILE]

The parts demo and focal use what `make demo` leaves in its folder. FOLDER holds sequences (NAME_.../frames, K.txt, poses_gt.txt, visible.txt) and models/NAME/{model.obj, mesh_plain.obj}.
Parts that are left out keep their tables.
"""
import argparse
import csv
import math
import os
import pathlib
import random
import re
import resource
import subprocess
import tempfile

from document import fill, table
from measures_of_poses import error, read_poses, turned, write_pose

TEXTURED = ["box_a_regular", "box_b_light", "box_c_noisy", "box_e_fast", "bottle_a_regular", "bottle_e_fast"]
OCCLUDED = ["box_d_occl", "bottle_d_occl"]
FOREIGN = [("box", "bottle_a_regular"), ("box", "palm_b_light"), ("bottle", "box_a_regular"),
           ("bottle", "statue_b_light"), ("box", "bread_a_regular")]
GUIDED = [("statue", "statue_a_regular"), ("palm", "palm_b_light"), ("box", "box_a_regular")]
GUIDED_FOREIGN = [("statue", "statue_a_regular", "bread_a_regular"), ("statue", "statue_a_regular", "palm_b_light"),
                  ("palm", "palm_b_light", "bottle_a_regular"), ("box", "box_a_regular", "bottle_a_regular"),
                  ("box", "box_a_regular", "palm_b_light")]
REMEMBERED = [("box", "box_a_regular", "box_e_fast"), ("bottle", "bottle_a_regular", "bottle_e_fast"),
              ("bread", "bread_a_regular", "bread_d_occl"), ("statue", "statue_a_regular", "statue_b_light"),
              ("palm", "palm_b_light", "palm_d_occl")]
FOCAL = ["box_a_regular", "box_b_light", "box_c_noisy", "bottle_a_regular"]
DEMO_FOCAL = 660
MARKS = pathlib.Path(__file__).resolve().parents[2] / "tests/data/box_real_corners.csv"
SAME_SIDE_DEGREES = 30
WITHIN_MM, WITHIN_DEGREES, WITHIN_FRAMES = 10, 5, 5


def processor_seconds():
    """Of all that was run: what else the machine does counts little."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Bench:
    def __init__(self, program, sequences, work, demo):
        self.program, self.sequences, self.work, self.demo = program, sequences, pathlib.Path(work), demo
        self.environment = {**os.environ, "HOLDFAST_CACHE_DIR": str(self.work / "cache")}

    def model(self, name, plain=False):
        return self.sequences / "models" / name / ("mesh_plain.obj" if plain else "model.obj")

    def poses(self, sequence):
        return read_poses(self.sequences / sequence / "poses_gt.txt")

    def visible(self, sequence):
        return [float(word) for word in (self.sequences / sequence / "visible.txt").read_text().split()]

    def track(self, frames, model, camera, *more):
        """The rows of a run."""
        rows = self.work / "rows.csv"
        rows.unlink(missing_ok=True)
        before = processor_seconds()
        calibration = self.sequences / camera / "K.txt" if isinstance(camera, str) else camera
        run = subprocess.run([self.program, "track", frames, "--model", model, *(("--camera", calibration) if calibration else ()),
                              "--poses", rows, "--quiet", *map(str, more)], env=self.environment, capture_output=True,
                             text=True)
        self.said, self.seconds = run.stderr, processor_seconds() - before
        if run.returncode not in (0, 6):
            raise SystemExit("starts: " + run.stderr)
        with open(rows, newline="") as lines:
            return list(csv.DictReader(lines))


def first_held(rows):
    return next((row for row in rows if row["status"] == "held"), None)


def is_right(row, poses):
    mm, degrees = error(row, poses[int(row["frame"])])
    return mm <= WITHIN_MM and degrees <= WITHIN_DEGREES


def starts(bench, step):
    lines = []
    for sequence in TEXTURED + OCCLUDED:
        name, poses = sequence.split("_")[0], bench.poses(sequence)
        visible = bench.visible(sequence)
        least = 0.5 if sequence in OCCLUDED else 0
        tried = at_once = right = wrong = 0
        for frame in range(0, len(poses) - WITHIN_FRAMES, step):
            if visible[frame] < least:
                continue
            row = first_held(bench.track(bench.sequences / sequence / "frames", bench.model(name), sequence, "--start",
                                         frame, "--stop", frame + WITHIN_FRAMES))
            tried += 1
            if row is None:
                continue
            good = is_right(row, poses)
            right += good
            wrong += not good
            at_once += good and int(row["frame"]) == frame
        print("starts:", sequence, right, "of", tried, flush=True)
        lines.append((sequence, tried, at_once, right, "{:.0f} %".format(100 * right / tried), wrong))
    open_ones = [line for line in lines if line[0] in TEXTURED]
    total, found = sum(line[1] for line in open_ones), sum(line[3] for line in open_ones)
    return "Every {}th frame is a start of its own.\n\n".format(step) + \
        table(["sequence", "starts", "right in the first frame", "right within 5 frames", "share", "wrong"], lines) + \
        "\nWithout occluders {} of {} ({:.0f} %) are right within 5 frames.\n".format(found, total, 100 * found / total)


def foreign(bench, step):
    del step
    lines, seconds = [], 0
    for name, sequence in FOREIGN:
        rows = bench.track(bench.sequences / sequence / "frames", bench.model(name), sequence)
        held = sum(row["status"] == "held" for row in rows)
        seconds += bench.seconds
        print("foreign:", name, sequence, held, flush=True)
        lines.append((name, sequence, len(rows), held))
    return table(["model", "frames of", "frames", "held"], lines) + \
        "\nA frame takes {:.0f} ms of processor time.\n".format(1e3 * seconds / sum(line[2] for line in lines))


def views(bench, step):
    """Processor seconds that a first and a second run of one frame take: the difference is making the views."""
    del step
    lines = []
    for name in ("box", "bottle"):
        sequence = name + "_a_regular"
        seconds = []
        for run in range(3):
            cache = bench.work / ("views_" + name) if run else bench.work / "cache"
            kept = cache / "kept.views"
            cache.mkdir(exist_ok=True)
            bench.track(bench.sequences / sequence / "frames", bench.model(name), sequence, "--stop", 1, "--views", kept)
            seconds.append(bench.seconds)
            if not run:
                kept.unlink()
        lines.append((name, "{:.1f} s".format(seconds[1] - seconds[2])))
    return table(["model", "making its views, processor time"], lines)


def guide_for(random_, truth, center_z_scale=0.2, pixels=60, focal=650):
    """A pose up to 20 degrees, a fifth of the distance and 60 pixels off."""
    axis = [random_.gauss(0, 1) for _ in range(3)]
    pose = turned(truth, axis, math.radians(20) * random_.random() ** (1 / 3))
    farther = 1 + center_z_scale * random_.uniform(-1, 1)
    way, off = random_.uniform(0, 2 * math.pi), pixels * math.sqrt(random_.random())
    z = pose[2][3] * farther
    shift = (off * math.cos(way) * z / focal, off * math.sin(way) * z / focal, 0)
    for axis_index in range(3):
        pose[axis_index][3] = pose[axis_index][3] * farther + shift[axis_index]
    return pose


def guided(bench, step):
    lines = []
    for name, sequence in GUIDED:
        random_, poses = random.Random(7), bench.poses(sequence)
        tried = right = wrong = 0
        for _ in range(max(3, 340 // step)):
            frame = random_.randrange(len(poses) - WITHIN_FRAMES)
            guide = bench.work / "guide.txt"
            write_pose(guide, guide_for(random_, poses[frame]))
            row = first_held(bench.track(bench.sequences / sequence / "frames", bench.model(name, True), sequence,
                                         "--start", frame, "--stop", frame + WITHIN_FRAMES, "--guide", guide))
            tried += 1
            if row is not None:
                good = is_right(row, poses)
                right += good
                wrong += not good
        print("guided:", sequence, right, "of", tried, flush=True)
        lines.append((sequence, tried, right, "{:.0f} %".format(100 * right / tried), wrong))
    return table(["shape and frames of", "guides", "right within 5 frames", "share", "wrong"], lines)


def guided_foreign(bench, step):
    del step
    lines = []
    for name, guided_by, sequence in GUIDED_FOREIGN:
        guide = bench.work / "guide.txt"
        write_pose(guide, bench.poses(guided_by)[0])
        rows = bench.track(bench.sequences / sequence / "frames", bench.model(name, True), sequence, "--guide", guide)
        held = sum(row["status"] == "held" for row in rows)
        print("guided, foreign:", name, sequence, held, flush=True)
        lines.append((name, sequence, len(rows), held))
    return table(["shape", "frames of", "frames", "held"], lines)


def back(bench, step):
    """Ten frames of the object, fifteen of another scene, fifteen of the object turned by 60 to 180 degrees."""
    trials = max(3, 200 // step)
    random_ = random.Random(3)
    again = wrong = 0
    for trial in range(trials):
        sequence = ("box_a_regular", "bottle_a_regular")[trial % 2]
        poses = bench.poses(sequence)
        while True:
            before, after = (random_.randrange(len(poses) - 16) for _ in range(2))
            degrees = error(None, poses[before + 9], poses[after])[1]
            if 60 <= degrees <= 180:
                break
        folder = bench.work / "back_{}".format(trial)
        folder.mkdir()
        shown = [(sequence, before + i) for i in range(10)] + [("bread_a_regular", i) for i in range(15)] + \
            [(sequence, after + i) for i in range(15)]
        for number, (of, frame) in enumerate(shown):
            (folder / "{:06d}.jpg".format(number)).symlink_to(bench.sequences.resolve() / of /
                                                               "frames/{:06d}.jpg".format(frame))
        first = bench.work / "first.txt"
        write_pose(first, poses[before])
        rows = bench.track(folder, bench.model(sequence.split("_")[0]), sequence, "--init", first)
        found = False
        for number, row in enumerate(rows[10:], 10):
            if row["status"] == "held":
                good = number >= 25 and max(v / w for v, w in zip(error(row, poses[after + number - 25]),
                                                                   (WITHIN_MM, WITHIN_DEGREES))) <= 1
                found = found or good
                wrong += not good
        again += found
        print("back:", trial, sequence, round(degrees), "degrees", found, flush=True)
    return table(["trials", "held again within 15 frames", "frames held wrongly"], [(trials, again, wrong)])


def seen_from(pose):
    """The direction in which the camera lies, object frame."""
    direction = [-sum(pose[row][column] * pose[row][3] for row in range(3)) for column in range(3)]
    length = math.sqrt(sum(value * value for value in direction))
    return [value / length for value in direction]


def remembered(bench, step):
    """A run over one sequence from a pose, then starts in another without one, where it shows a side that was shown."""
    lines = []
    for name, learned, tried_in in REMEMBERED:
        model, poses = bench.model(name, True), bench.poses(tried_in)
        first, kept = bench.work / "first.txt", bench.work / (name + ".seen")
        write_pose(first, bench.poses(learned)[0])
        bench.track(bench.sequences / learned / "frames", model, learned, "--init", first, "--remember", kept)
        if not kept.exists():
            lines.append((name, learned, tried_in, "nothing", "-", "-", "-", "-"))
            continue
        shown = [seen_from(pose) for pose in bench.poses(learned)]
        visible = bench.visible(tried_in)
        tried = right = wrong = 0
        for frame in range(0, len(poses) - WITHIN_FRAMES, step):
            nearest = max(sum(a * b for a, b in zip(seen_from(poses[frame]), side)) for side in shown)
            if nearest < math.cos(math.radians(SAME_SIDE_DEGREES)) or visible[frame] < 0.5:
                continue
            own = bench.work / "own.seen"  # each start knows the first run only
            own.write_bytes(kept.read_bytes())
            row = first_held(bench.track(bench.sequences / tried_in / "frames", model, tried_in, "--start", frame,
                                         "--stop", frame + WITHIN_FRAMES, "--remember", own))
            tried += 1
            if row is not None:
                good = is_right(row, poses)
                right += good
                wrong += not good
        print("remembered:", name, right, "of", tried, flush=True)
        lines.append((name, learned, tried_in, "{:.0f} kB".format(kept.stat().st_size / 1e3), tried, right,
                      "{:.0f} %".format(100 * right / tried), wrong))
    return table(["shape", "learned from", "starts in", "file", "starts", "right within 5 frames", "share", "wrong"], lines)


def demo(bench, step):
    del step
    video, model, camera = bench.demo / "box.mp4", bench.demo / "box_textured.obj", bench.demo / "camera.yml"
    lines, poses, marks = [], bench.work / "rows.csv", bench.work / "marks.csv"
    marked = [line for line in MARKS.read_text().splitlines() if line and not line.startswith("#")]
    for frame in range(0, 500, 100):
        rows = bench.track(video, model, camera, "--start", frame)
        row, lost = first_held(rows), sum(row["status"] != "held" for row in rows)
        marks.write_text("\n".join(line for line in marked if int(line.split(",")[0]) >= frame) + "\n")
        run = subprocess.run([bench.program, "evaluate", "--marks", marks, "--poses", poses, "--camera", camera],
                             env=bench.environment, capture_output=True, text=True)
        pixels = re.search(r"median ([0-9.]+), .*largest ([0-9.]+)", run.stdout)
        print("demo:", frame, row and row["frame"], run.stderr, flush=True)
        lines.append((frame, row["frame"] if row else "never", lost, *(pixels.groups() if pixels else ("-", "-"))))
    return table(["looked for from frame", "found in frame", "frames lost", "median, px", "largest, px"], lines)


def focal(bench, step):
    del step
    of_demo = (bench.demo / "box.mp4", bench.demo / "box_textured.obj", DEMO_FOCAL, 455, "the demo's video")
    recordings = [of_demo] + [(bench.sequences / name / "frames", bench.model(name.split("_")[0]), 650,
                               len(bench.poses(name)), name) for name in FOCAL]
    lines = []
    for frames, model, truth, count, name in recordings:
        for part, (first, last) in enumerate([(0, count)] + [(count * i // 4, count * (i + 1) // 4) for i in range(4)]):
            kept = bench.work / "camera.yml"
            rows = bench.track(frames, model, None, "--start", first, "--stop", last, "--camera-out", kept)
            value, sigma = (float(word) for word in re.search(r"estimated: ([0-9.]+) \+- ([0-9.]+)", bench.said).groups())
            lost = sum(row["status"] != "held" for row in rows)
            print("focal:", name, part, value, sigma, lost, flush=True)
            lines.append((name, "{} to {}".format(first, last - 1), truth, "{:.0f} ± {:.0f}".format(value, sigma),
                          "{:.1f}".format((value - truth) / sigma), lost))
    return table(["frames of", "frames", "true, px", "estimated, px", "deviations", "frames lost"], lines)


PARTS = {"starts": starts, "foreign": foreign, "views": views, "guided": guided, "guided_foreign": guided_foreign,
         "back": back, "remembered": remembered, "demo": demo, "focal": focal}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--sequences", type=pathlib.Path, required=True)
    parser.add_argument("--demo", type=pathlib.Path, default=pathlib.Path("out/demo"))
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--step", type=int, default=10, help="frames from a start to the next; the fewer, the more trials")
    parser.add_argument("--document", type=pathlib.Path, default=pathlib.Path("docs/results/starts.md"))
    arguments = parser.parse_args()
    for part in arguments.parts.split(","):
        with tempfile.TemporaryDirectory() as work:
            bench = Bench(arguments.program, arguments.sequences, work, arguments.demo)
            fill(arguments.document, {part: PARTS[part](bench, arguments.step)})


if __name__ == "__main__":
    main()
