"""The program takes the options that the experiments run it with. python3 experiments_options.py PROGRAM FOLDER"""

import subprocess
import sys
import tomllib
from pathlib import Path

sys.dont_write_bytecode = True
PROGRAM, FOLDER = sys.argv[1], Path(sys.argv[2])
sys.path.insert(0, str(FOLDER))

import sweeps
from work import tracker_options

NO_SUCH_FOLDER = 3  # the exit code when nothing else is wrong


def settings(folder):
    return tomllib.loads((folder / "scenario.toml").read_text(encoding="utf-8"))


def command_lines():
    """Every set of tracker options that scenarios ask for."""
    scenario = settings(FOLDER)
    trackers = scenario["trackers"]
    yield from map(tracker_options, trackers.values())
    for changes in scenario["paper-parts"]["options"].values():
        yield tracker_options({**trackers["paper"], **changes})
    for name in sweeps.THRESHOLDS:
        for tracker in sweeps.trackers_of(scenario, name):
            for value in sweeps.values_of(scenario["sweeps"]["thresholds"][name]):
                yield tracker_options({**trackers[tracker], name: "{:.6g}".format(value)})
    robustness = settings(FOLDER / "robustness")
    yield from robustness["ablation"]["parts"].values()
    yield ["--no-contour"]


def main():
    wrong = 0
    for options in command_lines():
        done = subprocess.run([PROGRAM, "evaluate", "no-such-folder", *options], capture_output=True, text=True)
        if done.returncode != NO_SUCH_FOLDER:
            wrong += 1
            print("{}: {}".format(" ".join(options), done.stderr.strip()))
    scenario = settings(FOLDER)
    named = {name for names in scenario["runs"].values() for name in names}
    named |= {name for sweep in [*sweeps.LABELS, *sweeps.THRESHOLDS] for name in sweeps.trackers_of(scenario, sweep)}
    for name in sorted(named - set(scenario["trackers"])):
        wrong += 1
        print("scenario.toml: there is no tracker '{}'".format(name))
    sys.exit(1 if wrong else 0)


main()
