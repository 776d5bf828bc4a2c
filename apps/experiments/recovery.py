"""Is the object held again after it was covered or out of the picture? Seeded trials, simulated and tracked.

python3 recovery.py --program holdfast --work out/recovery [--trials 40] [--first-seed 1] [--document docs/results/recovery.md]

Each trial is an object (a printed box, a can, a vase) that is followed, then covered by a plate for 30 frames or out of the
picture for 30, and meanwhile turns by 5 to 40 degrees, comes nearer or goes farther by up to a quarter, and appears
elsewhere. All numbers come from `holdfast simulate` and `holdfast evaluate`; results that are there already are kept.
"""

import argparse
import csv
import itertools
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

try:
    import numpy as np
    import matplotlib  # noqa: F401: writes the textures
except ImportError:
    sys.exit("recovery: python3 has no numpy or matplotlib; install python3-matplotlib")

import document
import measures
import recovery_scenes as scenes
from work import digest

WITHIN = 10  # frames of half the object being seen


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, type=Path)
    parser.add_argument("--work", required=True, type=Path, help="sequences and results; kept from run to run")
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--document", type=Path, help="whose table of trials to fill")
    parser.add_argument("--option", action="append", default=[], help="of the tracker, as in --option=--no-recovery")
    return parser.parse_args()


def call(program, *words):
    done = subprocess.run([program, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit("recovery: holdfast {} failed:\n{}".format(" ".join(map(str, words)), done.stderr.strip()))


def fresh(stamp, wanted):
    return stamp.exists() and stamp.read_text() == wanted


def simulated(program, simulator, work, seed):
    """The sequence's folder, its model, its kind and turn, and the share of the object inside the picture."""
    model_name = scenes.MODELS[seed % len(scenes.MODELS)]
    kind = scenes.KINDS[seed // len(scenes.MODELS) % len(scenes.KINDS)]
    folder = work / "sequences" / "seed{}".format(seed)
    stamp = folder / "stamp"
    rng = np.random.default_rng(seed)
    contrast = rng.uniform(0.3, 1)
    made = folder / "made"
    model = "box"
    positions = np.array(list(itertools.product((-0.1, 0.1), (-0.075, 0.075), (-0.04, 0.04))))
    wanted = digest(simulator, Path(scenes.__file__), seed)
    keep = fresh(stamp, wanted)
    if not keep:
        shutil.rmtree(folder, ignore_errors=True)
    made.mkdir(parents=True, exist_ok=True)
    if model_name != "box":
        model = made / "model.obj"
        positions = (scenes.write_can if model_name == "can" else scenes.write_vase)(model, rng, contrast)
    poses, plate, turn = scenes.trial(rng, kind, positions)
    if not keep:
        scenes.write_poses(made / "poses.txt", poses)
        words = ["--model", model, "--trajectory", made / "poses.txt", "--seed", seed, "--noise", 2,
                 "--background-pan", 0.5, "--size", "{}x{}".format(*scenes.SIZE)]
        if model == "box":
            words += ["--box-seed", seed, "--box-contrast", contrast]
        if plate is not None:
            plates, side = plate
            scenes.write_plate(made / "plate.obj", rng, side)
            scenes.write_poses(made / "plates.txt", plates)
            words += ["--occluder-model", made / "plate.obj", "--occluder-trajectory", made / "plates.txt"]
        call(program, "simulate", folder, "--quiet", *words)
        stamp.write_text(wanted)
    if model_name == "box":
        model = folder / "model" / "model.obj"
    return folder, model, "{}, {}".format(model_name, kind), turn, scenes.share_inside(poses, positions), wanted


def tracked(program, work, folder, model, seed, options, source):
    table = work / "runs" / "seed{}.csv".format(seed)
    stamp = table.with_suffix(".stamp")
    wanted = digest(program, " ".join(options), source)
    if not fresh(stamp, wanted):
        table.parent.mkdir(parents=True, exist_ok=True)
        stamp.unlink(missing_ok=True)
        call(program, "evaluate", folder, "--model", model, "--quiet", "--csv", table, *options)
        stamp.write_text(wanted)
    with open(table, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def judged(rows, inside):
    """Frames until held again since half of it is seen, frames held while off, frames held, and when it was lost."""
    numbers = [int(row["frame"]) for row in rows]
    seen = [float(row["visible"]) * inside[i] for row, i in zip(rows, numbers)]
    hidden = min(range(len(rows)), key=lambda i: seen[i])
    half = next(i for i in range(hidden, len(rows)) if seen[i] >= 0.5)
    again = next((i for i in range(half, len(rows))
                  if measures.held(rows[i]) and measures.within(rows[i], 20, 5)), None)
    stays = again is not None and all(measures.held(row) and measures.within(row, 20, 5) for row in rows[again:])
    early = again == half and measures.held(rows[half - 1])
    return {
        "waited": None if again is None else 0 if early else again - half,
        "stays": stays,
        "wrong": sum(map(measures.wrong, rows)),
        "held": sum(map(measures.held, rows)),
        "first": next((i for i, row in enumerate(rows) if not measures.held(row)), None),
        "ms_lost": [float(row["ms"]) for row in rows if not measures.held(row)],
        "ms_held": [float(row["ms"]) for row in rows if measures.held(row)],
    }


def main():
    given = arguments()
    program, work = given.program.resolve(), given.work.resolve()
    simulator = digest(*sorted((Path(__file__).resolve().parent.parent / "simulation").iterdir()))
    rows, back, wrong, held, ms_lost, ms_held = [], 0, 0, 0, [], []
    for seed in range(given.first_seed, given.first_seed + given.trials):
        folder, model, what, turn, inside, source = simulated(program, simulator, work, seed)
        result = judged(tracked(program, work, folder, model, seed, given.option, source), inside)
        good = result["waited"] is not None and result["waited"] <= WITHIN
        back += good
        wrong += result["wrong"]
        held += result["held"]
        ms_lost += result["ms_lost"]
        ms_held += result["ms_held"]
        rows.append([seed, what, "{:.0f}".format(turn), "never" if result["waited"] is None else result["waited"],
                     "yes" if result["stays"] else "**no**", result["wrong"]])
        print("seed {:3d}  {:13s} turned {:2.0f} deg: held again after {} frames{}; held while off {}"
              .format(seed, what, turn, rows[-1][3], "" if result["stays"] else ", not to the end",
                                 result["wrong"]), flush=True)
    total = ("held again within {} frames of half the object being seen in {} of {} trials; {} of {} frames called held were "
             "more than 20 mm or 5 degrees off; a lost frame took {:.0f} ms (median; 95 %: {:.0f}), a held one {:.1f} ms"
             .format(WITHIN, back, given.trials, wrong, held, statistics.median(ms_lost),
                     sorted(ms_lost)[int(0.95 * len(ms_lost))], statistics.median(ms_held)))
    print(total)
    if given.document:
        heading = ["seed", "object, how it was lost", "turned, degrees", "held again after, frames", "and to the end",
                   "held while off, frames"]
        document.fill(given.document, {"recovery": total[0].upper() + total[1:] + ".\n\n" + document.table(heading, rows)})


if __name__ == "__main__":
    main()
