#!/usr/bin/env python3
"""Cases in which a tracker may hold a wrong pose: simulated, tracked, judged. Writes docs/results/hazards.md.

  hazards.py --program build/release/apps/holdfast --work out/hazards [--cases a,b] [--seeds 3] [--jumps 20]
             [--sequences FOLDER] [--threads N] [--document docs/results/hazards.md]

FOLDER is as rbot.py takes it; case f then jumps within its sequences too. Without --document nothing is written.
"""
import argparse
import concurrent.futures
import csv
import hashlib
import os
import pathlib
import shutil
import subprocess

import cv2
import numpy as np

import hazard_scenes as scenes
from document import table
from hazard_scenes import Box, Cylinder, Ellipsoid, Scene, Sway, pose_of, rotation

BEFORE_JUMP, AFTER_JUMP, GONE_FROM = 12, 20, 30
WRONG_MM, WRONG_DEGREES, SEEN = 20, 5, 0.4

HEAD = """# Hazards

`make hazards` writes this table: cases in which a tracker may report `held` while it is wrong, {seeds} seeds each,
drawn by a ray caster that shares nothing with the tracker. The tracker starts from the first true pose and is never
put back. *Wrong* counts frames that are held more than {mm} mm or {degrees} degrees off, or held where the object is
another one or gone. It should be 0; where it is not, the tracker has that weakness. *Truly held* is the share of frames
held and right, among those in which at least {seen:.0f} % of the silhouette is seen. It should be high, so that 0 wrong
is not got by holding nothing. Turns that a shape without print does not show are no errors: any about a tube's axis, and
those that map a cube or box onto itself, as long as the choice among them stays the same while the object is held. A
jump is a cut to another moment of the same sequence; `SEQUENCES=FOLDER` adds jumps within recorded ones, `JUMPS=500`
makes them more.

"""


# ---- Cases: each makes a scene from random numbers.

def moving(rng, z, R, turn=(13, 13, 13), way=(0.05, 0.035, 0.04), fastest=0.55):
    turning, going = Sway(rng, turn, fastest), Sway(rng, way, fastest)
    return lambda time: pose_of(rotation(*turning(time)) @ R, (0, 0, z) + going(time))


def three_faces(rng):
    return rotation(rng.uniform(20, 40), 0, 0) @ rotation(0, rng.uniform(25, 60), 0)


def grey(rng):
    return np.full(3, rng.uniform(90, 190)) * rng.uniform(0.93, 1.07, 3)


def step(time, start, length):
    s = np.clip((time - start) / length, 0, 1)
    return s * s * (3 - 2 * s)


def attached(parts, pose, R0):
    """Parts given by shape and offset in the camera's axes at the first frame, then moving with the pose."""
    def at(time):
        T = pose(time)
        turn = T[:, :3] @ R0.T
        return [(shape, pose_of(turn @ R, T[:, 3] + turn @ np.array(offset))) for shape, R, offset in parts]
    return at


def hand(side, half, fingers):
    """A palm at one side, fingers before a corner of the object."""
    parts = [(Ellipsoid((0.034, 0.04, 0.03), scenes.SKIN), np.eye(3), (side * (half + 0.018), half + 0.012, 0.02))]
    length = 0.018 + 0.004 * fingers
    for i in range(fingers):
        parts.append((Ellipsoid((length, 0.0085, 0.009), scenes.SKIN * (1 - 0.03 * i)), rotation(0, 15 * side, -12 * side),
                      (side * (half * 0.85 + 0.03 - length), half * (0.35 + 0.42 * i), -half * 1.25)))
    return parts


def mug(rng):
    color = rng.uniform(40, 220, 3)
    parts = [(Cylinder(0.04, 0.047, color, end=0.35 * color), np.eye(3), np.zeros(3))]
    for angle in np.radians(np.linspace(-80, 80, 9)):
        parts.append((Ellipsoid((0.007, 0.009, 0.007), color), np.eye(3),
                      np.array((0.036 + 0.03 * np.cos(angle), 0.03 * np.sin(angle), 0))))
    return parts


def cube_and_mug(rng, seed):
    half, base = 0.0325, grey(rng)
    colors = base * (1 + (0.07 if seed % 3 else 0.0) * rng.uniform(-1, 1, (6, 1)))
    R0 = three_faces(rng)
    pose = moving(rng, 0.52, R0)
    holding = attached(hand(rng.choice((-1, 1)), half, 1 + (seed - 1) % 3), pose, pose(0)[:, :3])
    cup, side, sway = mug(rng), rng.choice((-1, 1)), Sway(rng, (0.006, 0.006), 0.5)

    def others(time):
        # The mug's edge stands a third of the cube's width inside its silhouette.
        near, away = 0.8, 0.3 * (1 - step(time, 50, 35) + step(time, 125, 35))
        offset = side * (half * 1.3 / 3 * near + 0.04 + away)
        T = pose_of(rotation(18, 0, 0) @ rotation(0, 40 if side > 0 else 140, 0),
                    pose(time)[:, 3] * near + (offset, 0.01, 0) + (*sway(time), 0))
        return holding(time) + [(shape, pose_of(T[:, :3] @ R, T[:, 3] + T[:, :3] @ p)) for shape, R, p in cup]
    return Scene(Box([half] * 3, colors), pose, 200, others)


def tube_and_sleeve(rng, seed):
    del seed
    color, side = grey(rng), rng.choice((-1, 1))
    tube = Cylinder(0.02, 0.075, color, end=0.7 * color)
    inside = moving(rng, 0.5, rotation(0, 0, -side * rng.uniform(25, 45)) @ rotation(rng.uniform(10, 30), 0, 0))
    # A shift that puts 70 % of the points of the surface beyond the picture's edge at the turning point.
    angles, T = np.linspace(0, 2 * np.pi, 40), inside(95)
    surface = np.array([(0.02 * np.sin(a), y, 0.02 * np.cos(a)) for a in angles for y in np.linspace(-0.075, 0.075, 40)])
    p = surface @ T[:, :3].T + T[:, 3]
    shift = (np.quantile(side * p[:, 0], 0.3) * -1 + 320 / scenes.FOCAL * T[2, 3]) * side

    def pose(time):
        return inside(time) + pose_of(np.zeros((3, 3)), (shift * (step(time, 40, 45) - step(time, 105, 45)), 0, 0))
    sleeve = Cylinder(0.034, 0.12, color * rng.uniform(0.94, 1.06, 3), end=0.6 * color)

    def others(time):
        T = pose(time - 2)
        return [(sleeve, pose_of(T[:, :3] @ rotation(8, 0, 5), T @ (0, 0.075 + 0.12 - 0.025, 0.008, 1)))]
    return Scene(tube, pose, 200, others, shadow=True)


def tilt(rng, seed):
    del seed
    axis, phase = rotation(0, 0, rng.uniform(0, 180)) @ (1, 0, 0), rng.uniform(0, 6)
    slow = moving(rng, 1.0, np.eye(3), turn=(2, 2, 6), way=(0.06, 0.04, 0.05))

    def pose(time):
        T = slow(time)
        return pose_of(rotation(*(33 * np.sin(2 * np.pi * time / 150 + phase) * axis)) @ T[:, :3], T[:, 3])
    return Scene(Box((0.075, 0.05, 0.0075), atlas=scenes.atlas_of(rng, 0.35)), pose, 200, has_print=True, shutter=0.8,
                 blur=2)


def faint_can(rng, seed):
    del seed
    label = scenes.print_of(rng, 1024, 512, 0.2)
    label[448:] = 160
    slow = moving(rng, 0.6, rotation(rng.uniform(15, 30), 0, rng.uniform(-15, 15)), turn=(5, 2, 5))

    def pose(time):
        T = slow(time)
        return pose_of(T[:, :3] @ rotation(0, 60 * np.sin(2 * np.pi * time / 240), 0), T[:, 3])
    return Scene(Cylinder(0.033, 0.055, label=label), pose, 240, has_print=True, blur=1.5)


def other_print(rng, seed):
    del seed
    half = (0.06, 0.04, 0.025)
    return Scene(Box(half, atlas=scenes.atlas_of(rng, 1)), moving(rng, 0.5, three_faces(rng)), 150, has_print=True,
                 model_shape=Box(half, atlas=scenes.atlas_of(rng, 1)))


def printed_box(rng, seed):
    del seed
    return Scene(Box((0.06, 0.04, 0.025), atlas=scenes.atlas_of(rng, 0.8)), moving(rng, 0.5, three_faces(rng)), 240,
                 has_print=True)


def plain_box(rng, seed):
    del seed
    colors = grey(rng) * rng.uniform(0.93, 1.07, (6, 1))
    return Scene(Box((0.06, 0.04, 0.025), colors), moving(rng, 0.5, three_faces(rng)), 240)


def plain_tube(rng, seed):
    del seed
    color = grey(rng)
    R = rotation(0, 0, rng.uniform(-50, 50)) @ rotation(rng.uniform(10, 30), 0, 0)
    return Scene(Cylinder(0.02, 0.075, color, end=0.7 * color), moving(rng, 0.5, R), 240)


def leaving(make):
    def scene(rng, seed):
        made = make(rng, seed)
        made.frames, made.gone_from = GONE_FROM + 150, GONE_FROM
        return made
    return scene


# Letter, name of folders, title, scene; and whether its windows are put together with jumps.
CASES = [
    ("a", "cube", "plain cube in a hand, a mug before a third of it", cube_and_mug, False),
    ("b", "tube", "plain tube leaves the picture by 70 %, a sleeve of its colour follows", tube_and_sleeve, False),
    ("c", "tilt", "faintly printed flat box, far, blurred, tilting by 33 degrees", tilt, False),
    ("d", "can", "can with a label of 20 % contrast, blurred, turning by 60 degrees", faint_can, False),
    ("e", "print", "box with another print than the model's", other_print, False),
    ("f", "jump-printed", "jumps, printed box", printed_box, True),
    ("f", "jump-plain", "jumps, plain box", plain_box, True),
    ("g", "gone-printed", "printed box gone after 30 frames", leaving(printed_box), False),
    ("g", "gone-plain", "plain box gone after 30 frames", leaving(plain_box), False),
    ("g", "gone-tube", "plain tube gone after 30 frames", leaving(plain_tube), False),
]


# ---- Folders

def rendered(work, name, seed):
    """Folder of this case's sequence; drawn where it is not there yet."""
    folder = work / "sequences" / "{}-{}".format(name, seed)
    here = pathlib.Path(__file__).resolve()
    cases = here.read_bytes().split(b"\n# ---- ")[1]
    wanted = hashlib.sha256(here.with_name("hazard_scenes.py").read_bytes() + cases)
    stamp = folder / "stamp"
    if stamp.exists() and stamp.read_text() == wanted.hexdigest():
        return folder
    cv2.setNumThreads(1)
    shutil.rmtree(folder, ignore_errors=True)
    scene = next(case[3] for case in CASES if case[1] == name)(np.random.default_rng([seed, *name.encode()]), seed)
    model = scene.model_shape or scene.shape
    picture = getattr(model, "atlas", None) if isinstance(model, Box) else model.label
    scenes.write_model(folder / "model", model, picture if scene.has_print else None)
    (folder / "frames").mkdir()
    renderer, shares = scenes.Renderer(scene, [seed, *name.encode()]), []
    for number in range(scene.frames):
        picture, share = renderer.frame(number)
        cv2.imwrite(str(folder / "frames" / "{:06d}.jpg".format(number)), picture, [cv2.IMWRITE_JPEG_QUALITY, 95])
        shares.append(share)
    write_truth(folder, [scene.pose(number) for number in range(scene.frames)], shares)
    (folder / "K.txt").write_text("{0} {0} {1} {2}\n".format(scenes.FOCAL, *scenes.CENTER))
    stamp.write_text(wanted.hexdigest())
    print("hazards: drawn", folder.name, flush=True)
    return folder


def write_truth(folder, poses, shares):
    np.savetxt(folder / "poses_gt.txt", [pose.ravel() for pose in poses], "%.9g")
    np.savetxt(folder / "visible.txt", shares, "%.4f")


def jumping(folders, models, out, count):
    """Folders of 12 frames and then 20 from elsewhere in the same sequence; models: a file each."""
    shutil.rmtree(out, ignore_errors=True)
    rng = np.random.default_rng(7)
    made = []
    for number in range(count):
        source, model = (kind[number * len(folders) // count] for kind in (folders, models))
        frames, poses = sorted((source / "frames").iterdir()), np.loadtxt(source / "poses_gt.txt").reshape(-1, 3, 4)
        shares = np.loadtxt(source / "visible.txt")
        # The first frame tells the tracker where the object is: it must show it.
        starts = [i for i in range(len(frames) - BEFORE_JUMP) if shares[i] >= 0.7]
        one, two = rng.choice(starts), rng.integers(0, len(frames) - AFTER_JUMP + 1)
        chosen = [*range(one, one + BEFORE_JUMP), *range(two, two + AFTER_JUMP)]
        folder = out / "{}-{:03d}".format(out.name, number)
        (folder / "frames").mkdir(parents=True)
        for i, k in enumerate(chosen):
            (folder / "frames" / "{:06d}{}".format(i, frames[k].suffix)).symlink_to(frames[k])
        shutil.copy(source / "K.txt", folder)
        write_truth(folder, poses[chosen], shares[chosen])
        if model.name == "model.obj":
            (folder / "model").symlink_to(model.parent)
        else:
            (folder / "model").mkdir()
            (folder / "model" / "model.obj").symlink_to(model)
        made.append(folder)
    return made


# ---- Judging

def tracked(program, out, folders):
    """Rows of each sequence."""
    out.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run([program, "evaluate", *folders, "--protocol", "never-reset", "--csv", out, "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)
    sequences = {}
    with open(out, newline="") as lines:
        for row in csv.DictReader(lines):
            sequences.setdefault(row["sequence"], []).append(row)
    return sequences


def pose_in(row, which):
    return np.array([float(row["{}_{}{}".format(which, i, j)]) for i in range(3) for j in range(4)]).reshape(3, 4)


def turn_between(A, B, about_y):
    if about_y:
        return np.degrees(np.arccos(np.clip(A[:, 1] @ B[:, 1], -1, 1)))
    return np.degrees(np.arccos(np.clip((np.trace(A.T @ B) - 1) / 2, -1, 1)))


def judge(rows, symmetries, about_y, never_right=lambda row: False):
    """Frames, held, held and wrong, seen, held and right of the seen. Of poses that look the same, the nearest when the
    object is taken up is the one to keep."""
    held = wrong = seen = right = 0
    choice = None
    for row in rows:
        good = False
        if row["status"] == "held":
            held += 1
            truth, found = pose_in(row, "true"), pose_in(row, "estimated")
            turns = [turn_between(truth[:, :3] @ S, found[:, :3], about_y) for S in symmetries]
            choice = int(np.argmin(turns)) if choice is None else choice
            good = (1e3 * np.linalg.norm(found[:, 3] - truth[:, 3]) <= WRONG_MM and turns[choice] <= WRONG_DEGREES and
                    not never_right(row))
            wrong += not good
        else:
            choice = None
        visible = float(row["visible"]) >= SEEN
        seen += visible
        right += visible and good
    return np.array([len(rows), held, wrong, seen, right])


def symmetries_of(scene):
    if scene.has_print:
        return [np.eye(3)], False
    return scene.shape.symmetries(), isinstance(scene.shape, Cylinder)


def line(letter, title, counts, expect_held=True):
    frames, held, wrong, seen, right = counts
    share = "{:.0f} %".format(100 * right / seen) if expect_held and seen else "-"
    print("hazards: {} {}: {} frames, {} held, {} wrong, truly held {}".format(letter, title, frames, held, wrong, share),
          flush=True)
    return [letter, title, frames, held, wrong, share]


def simulated(given, pool, case):
    """The table's line of a case."""
    letter, name, title, make, jumps = case
    folders = list(pool.map(rendered, *zip(*((given.work, name, seed) for seed in range(1, given.seeds + 1)))))
    scene = make(np.random.default_rng(1), 1)
    if jumps:
        folders = jumping(folders, [folder / "model" / "model.obj" for folder in folders], given.work / name,
                          given.jumps or 20)
        title = "{} {}".format(len(folders), title)
    never = (lambda row: True) if scene.model_shape else (lambda row: int(row["frame"]) >= scene.gone_from)
    sequences = tracked(given.program, given.work / "runs" / (name + ".csv"), folders)
    counts = [judge(rows, *symmetries_of(scene), never) for rows in sequences.values()]
    return line(letter, title, sum(counts), scene.model_shape is None)


def recorded(given):
    """Jumps within recorded sequences: with textured models, and by shapes alone that look alike from no two sides."""
    lines, found = [], sorted(p for p in given.sequences.iterdir() if (p / "visible.txt").exists())
    for title, file, wanted in (("recorded, textured", "model.obj", lambda name: True),
                                ("recorded, shape alone", "mesh_plain.obj", lambda name: name not in ("bottle", "box"))):
        folders = [p.resolve() for p in found if wanted(p.name.split("_")[0])]
        models = [p.parent / "models" / p.name.split("_")[0] / file for p in folders]
        name = "jump-" + title.replace(", ", "-").replace(" ", "-")
        trials = jumping(folders, models, given.work / name, (given.jumps or 20) // 2)
        sequences = tracked(given.program, given.work / "runs" / (name + ".csv"), trials)
        counts = sum(judge(rows, [np.eye(3)], False) for rows in sequences.values())
        lines.append(line("f", "{} jumps, {}".format(len(trials), title), counts))
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("out/hazards"))
    parser.add_argument("--cases", default="a,b,c,d,e,f,g")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--jumps", type=int, default=0, help="of each kind of case f [20]; in recorded sequences in all")
    parser.add_argument("--sequences", type=pathlib.Path)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--document", type=pathlib.Path)
    given = parser.parse_args()
    given.program, given.work = given.program.resolve(), given.work.resolve()
    lines, wanted = [], given.cases.split(",")
    with concurrent.futures.ProcessPoolExecutor(given.threads) as pool:
        lines += [simulated(given, pool, case) for case in CASES if case[0] in wanted]
    if given.sequences and "f" in wanted:
        lines += recorded(given)
    if given.document:
        head = HEAD.format(seeds=given.seeds, mm=WRONG_MM, degrees=WRONG_DEGREES, seen=100 * SEEN)
        given.document.write_text(head + table(["case", "scene", "frames", "held", "wrong", "truly held"], sorted(lines, key=lambda row: row[0])))


if __name__ == "__main__":
    main()
