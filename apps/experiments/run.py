"""The paper's experiments: simulates, tracks, and writes the tables and pictures of docs/results/experiments.md.

python3 run.py --program holdfast --work out/experiments --document docs/results/experiments.md [--seeds N] [--sequences FOLDER]

What is to be done stands in scenario.toml. All numbers come from `holdfast evaluate`; here they are only put together.
"""

import argparse
import shutil
import sys
import time
import tomllib
from pathlib import Path

try:
    import matplotlib  # noqa: F401: said here, not after minutes of work
except ImportError:
    sys.exit("experiments: python3 has no matplotlib; install python3-matplotlib")

import document
import pictures
import plots
import recorded
import sweeps
import tables
from work import Work, tracker_options

HERE = Path(__file__).resolve().parent


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--work", required=True, type=Path, help="sequences and results; kept from run to run")
    parser.add_argument("--document", required=True, type=Path)
    parser.add_argument("--seeds", type=int, default=0, help="a quick pass with fewer; written below --work instead")
    parser.add_argument("--sequences", type=Path, help="folder of recorded sequences with true poses")
    parser.add_argument("--threads", type=int, default=0, help="of simulation; 0: one a core")
    return parser.parse_args()


def simulate_and_track(work, scenario, seeds):
    """Runs by scene and tracker, and the sequences' folders by scene."""
    folders, runs = {}, {}
    for scene, settings in scenario["scenes"].items():
        folders[scene] = [work.sequence(scene, seed, settings) for seed in seeds]
        for tracker in scenario["runs"][scene]:
            options = tracker_options(scenario["trackers"][tracker])
            runs[scene, tracker] = work.run("{}/{}".format(scene, tracker), folders[scene], options)
    return folders, runs


def paper_parts(work, scenario, folders, runs):
    """Runs of paper mode by scene, whole and with each part of what steadies it left out."""
    parts = scenario["paper-parts"]
    out = {"nothing": {scene: runs[scene, "paper"] for scene in parts["scenes"]}}
    for part, changes in parts["options"].items():
        options = tracker_options({**scenario["trackers"]["paper"], **changes})
        name = "parts/" + part.replace(" ", "-") + "/"
        out[part] = {scene: work.run(name + scene, folders[scene], options) for scene in parts["scenes"]}
    return out


def main():
    given = arguments()
    scenario = tomllib.loads((HERE / "scenario.toml").read_text(encoding="utf-8"))
    seeds = range(scenario["first"], scenario["first"] + (given.seeds or scenario["seeds"]))
    whole = len(seeds) == scenario["seeds"]
    work = Work(given.program, given.work, scenario, given.threads)
    work.expected = (len(seeds) * len(scenario["scenes"]) + sum(map(len, scenario["runs"].values()))
                     + len(scenario["paper-parts"]["scenes"]) * len(scenario["paper-parts"]["options"])
                     + sweeps.steps(scenario, len(seeds)) + pictures.STEPS + 2)
    print("experiments: {} seeds; five take a quarter of an hour on two cores. What {} holds already is kept."
          .format(len(seeds), given.work), flush=True)

    # A quick pass must not replace the evidence.
    target = given.document
    if not whole:
        target = given.work / given.document.name
        given.work.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(given.document, target)
    images = target.parent / "experiments"
    shutil.rmtree(images, ignore_errors=True)
    images.mkdir(parents=True)

    folders, runs = simulate_and_track(work, scenario, seeds)
    # After every stage, so that an interrupted run leaves what it knows.
    document.fill(target, {"bounds": tables.bounds(runs), "scenes": tables.scenes(runs, scenario)})
    plots.errors_over_time(runs, scenario, images)
    pictures.draw(work, folders, scenario, images)
    document.fill(target, {"parts": tables.paper_parts(paper_parts(work, scenario, folders, runs))})
    document.fill(target, sweeps.run(work, scenario, seeds, folders))
    if given.sequences and given.sequences.is_dir():
        document.fill(target, {"recorded": recorded.tables(work, given.sequences)})
    print("experiments: {} written in {:.0f} s ({} results made, {} kept)".format(
        target, time.monotonic() - work.start, work.made, work.reused))
    print(tables.verdict(runs))


if __name__ == "__main__":
    main()
