"""Is the object held again after it was covered or out of the picture? Seeded trials, simulated and tracked.

python3 recovery.py [--trials 40] [--first-seed 1] [--document docs/results/recovery.md]

Each trial is an object (a printed box, a can, a vase; by their shape alone a printed box and a part of one colour) that is
followed, then covered by a plate for 30 frames or out of the picture for 30, and meanwhile turns by 5 to 40 degrees, comes
nearer or goes farther by up to a quarter, and appears elsewhere.
"""

import argparse
import concurrent.futures
import itertools
import statistics
from pathlib import Path

import numpy as np

import document
import holdfast
import recovery_scenes as scenes

WITHIN = 10  # frames of half the object being seen
CAMERA = holdfast.Camera(scenes.FOCAL, scenes.FOCAL, *(np.array(scenes.SIZE) - 1) / 2, *scenes.SIZE)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--document", type=Path, help="whose table of trials to fill")
    return parser.parse_args()


def simulated(seed, names):
    """The model, the sequence, what kind of trial it is, its turn, and the share of the object inside the picture."""
    name = names[seed % len(names)]
    kind = scenes.KINDS[seed // len(names) % len(scenes.KINDS)]
    rng = np.random.default_rng(seed)
    contrast = rng.uniform(0.3, 1)
    positions = np.array(list(itertools.product((-0.1, 0.1), (-0.075, 0.075), (-0.04, 0.04))))
    if name == "box":
        mesh = holdfast.textured_box(seed, contrast)
    else:
        arrays = scenes.part(rng) if name == "part" else (scenes.can if name == "can" else scenes.vase)(rng, contrast)
        mesh, positions = holdfast.Mesh(*arrays), arrays[0]
    poses, plate, turn = scenes.trial(rng, kind, positions)
    occluders = [] if plate is None else [(holdfast.Mesh(*scenes.plate(rng, plate[1])), plate[0])]
    sequence = holdfast.Simulation(mesh, CAMERA, poses=poses, occluders=occluders, seed=seed,
                                   sensor={"noise": 2.0}, background={"pan": 0.5})
    model = holdfast.Mesh(mesh.vertices, mesh.faces) if names == scenes.SHAPES else mesh
    return model, sequence, "{}, {}".format(name, kind), turn, scenes.share_inside(poses, positions)


def right(record):
    return record.result.held and record.translation_error <= 0.02 and record.rotation_error <= np.radians(5)


def judged(records, inside):
    """Frames until held again since half of it is seen, whether it then stays held, and frames held while off."""
    seen = [record.visible * inside[record.frame] for record in records]
    hidden = min(range(len(records)), key=seen.__getitem__)
    half = next(i for i in range(hidden, len(records)) if seen[i] >= 0.5)
    again = next((i for i in range(half, len(records)) if right(records[i])), None)
    early = again == half and records[half - 1].result.held
    return (None if again is None else 0 if early else again - half, again is not None and all(map(right, records[again:])),
            sum(record.result.held and not right(record) for record in records))


def run(names, first_seed, count):
    """Trials of these objects: the sentence and the table."""
    trials, held, lost = {}, [], []
    with concurrent.futures.ThreadPoolExecutor() as pool:
        for seed in range(first_seed, first_seed + count):
            mesh, sequence, what, turn, inside = simulated(seed, names)
            frames = list(pool.map(sequence.__getitem__, range(len(sequence))))
            records = holdfast.evaluate(holdfast.Tracker(mesh, CAMERA), [frame.image for frame in frames], sequence.poses,
                                        [frame.visible_share for frame in frames])
            waited, stays, off = judged(records, inside)
            trials.setdefault(what, []).append((waited, stays, off))
            for record in records:
                (held if record.result.held else lost).append(record.result.ms.total)
            print("seed {:3d}  {:13s} turned {:2.0f} deg: held again after {} frames, to the end: {}; held while off {}"
                  .format(seed, what, turn, "never" if waited is None else waited, "yes" if stays else "no", off), flush=True)
    every = [trial for some in trials.values() for trial in some]
    total = ("Held again within {} frames of half the object being seen in {} of {} trials; {} of {} frames called held were "
             "more than 20 mm or 5 degrees off; a lost frame took {:.0f} ms (median; 95 %: {:.0f}), a held one {:.1f} ms."
             .format(WITHIN, sum(waited is not None and waited <= WITHIN for waited, _, _ in every), count,
                     sum(off for _, _, off in every), len(held), statistics.median(lost),
                     sorted(lost)[int(0.95 * len(lost))], statistics.median(held)))
    heading = ["object, how it was lost", "trials", "held again after, frames", "lost again", "held while off, frames"]
    rows = [[what, len(some), ", ".join("never" if w is None else str(w) for w, _, _ in some),
             sum(not stays for _, stays, _ in some), sum(off for _, _, off in some)] for what, some in sorted(trials.items())]
    text = total + "\n\n" + document.table(heading, rows)
    print(text)
    return text


def main():
    given = arguments()
    printed = run(scenes.MODELS, given.first_seed, given.trials)
    alone = run(scenes.SHAPES, given.first_seed, given.trials)
    if given.document:
        document.fill(given.document, {"recovery": printed, "alone": alone})


if __name__ == "__main__":
    main()
