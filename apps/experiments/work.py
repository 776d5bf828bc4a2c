"""Simulates sequences and runs the tracker over them, each only where its result is not there already.

Every result has a stamp: what it was made from. A result whose stamp is still right is kept; so a run may be interrupted
and goes on where it was.
"""

import csv
import hashlib
import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

REJECTION_OFF = ["--no-gradient-test", "--no-angle-test", "--no-magnitude-test", "--no-block-vote"]


def digest(*parts):
    """Of texts and of files' contents."""
    sha = hashlib.sha256()
    for part in parts:
        sha.update(part.read_bytes() if isinstance(part, Path) else str(part).encode())
        sha.update(b"\0")
    return sha.hexdigest()


def options_of(settings):
    """Command line of a table of options: true is a flag, a list is an option given several times."""
    words = []
    for name, value in settings.items():
        if value is True:
            words.append("--" + name)
            continue
        for one in value if isinstance(value, list) else [value]:
            words += ["--" + name, str(one)]
    return words


def tracker_options(settings):
    """Of a table below [trackers]; any other key is an option with a value."""
    words = []
    for name, value in settings.items():
        if name == "title":
            continue
        if name == "rejection":
            words += [] if value else REJECTION_OFF
        elif isinstance(value, bool):
            words.append(("--" if value else "--no-") + name)
        else:
            words += ["--" + name, str(value)]
    return words


class Work:
    """The folder of results, and the program that makes them."""

    def __init__(self, program, folder, scenario, threads):
        self.program = Path(program).resolve()
        self.folder = Path(folder).resolve()
        self.scenario = scenario
        self.threads = threads
        simulator = Path(__file__).resolve().parent.parent / "simulation"
        self.simulator_digest = digest(*sorted(simulator.iterdir()))
        self.program_digest = digest(self.program)
        self.made = 0
        self.reused = 0
        self.expected = 0
        self.seen = set()
        self.start = time.monotonic()

    def call(self, *words):
        done = subprocess.run([self.program, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if done.returncode not in (0, 6):  # 6: the object is held in no frame, which is a result too
            sys.exit("experiments: holdfast {} failed:\n{}".format(" ".join(map(str, words)), done.stderr.strip()))

    def progress(self, what):
        self.made += 1
        seconds = time.monotonic() - self.start
        print("{:5.0f} s  {} of {}: {}".format(seconds, self.made + self.reused, self.expected, what), flush=True)

    def fresh(self, stamp, wanted):
        if stamp.exists() and stamp.read_text() == wanted:
            self.reused += stamp not in self.seen
            self.seen.add(stamp)
            return True
        self.seen.add(stamp)
        return False

    def sequence(self, name, seed, changes=()):
        """Folder of the sequence of this name and seed: [simulate] with `changes`."""
        folder = self.folder / "sequences" / name / "seed{}".format(seed)
        settings = {**self.scenario["simulate"], **dict(changes), "seed": seed, "box-seed": seed}
        settings.pop("title", None)
        wanted = digest(self.simulator_digest, json.dumps(settings, sort_keys=True))
        stamp = folder / "stamp"
        if not self.fresh(stamp, wanted):
            self.progress("simulate {}, seed {}".format(name, seed))
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            self.call("simulate", folder, *options_of(settings), "--threads", self.threads)
            stamp.write_text(wanted)
        return folder

    def run(self, name, sequences, options, extra=()):
        """The report of `holdfast evaluate` on sequence folders (with their own models), and its table a frame."""
        report = self.folder / "runs" / (name + ".json")
        frames = report.with_suffix(".csv")
        models = []
        for folder in sequences:
            models += ["--model", "{}={}".format(folder.name, folder / "model" / "model.obj")]
        return self.evaluate(report, frames, [*sequences, *models, *options, *extra],
                             [(folder / "stamp").read_text() for folder in sequences], name)

    def evaluate(self, report, frames, words, sources, name):
        wanted = digest(self.program_digest, json.dumps([str(word) for word in words]), *sources)
        stamp = report.with_suffix(".stamp")
        if not self.fresh(stamp, wanted):
            self.progress("track {}".format(name))
            report.parent.mkdir(parents=True, exist_ok=True)
            stamp.unlink(missing_ok=True)
            self.call("evaluate", *words, "--quiet", "--json", report, "--csv", frames)
            stamp.write_text(wanted)
        return Run(report, frames)


class Run:
    """What one tracker did on the sequences of one scene."""

    def __init__(self, report, frames):
        with open(report, encoding="utf-8") as file:
            self.report = json.load(file)
        self.frames_path = frames
        self._frames = None

    def summaries(self):
        return [evaluation["summary"] for evaluation in self.report["evaluations"]]

    def evaluations(self):
        return self.report["evaluations"]

    def frames(self):
        """Rows of every sequence (and step): a list of lists of dictionaries."""
        if self._frames is None:
            groups = {}
            with open(self.frames_path, newline="", encoding="utf-8") as file:
                for row in csv.DictReader(file):
                    groups.setdefault((row["sequence"], int(row["step"])), []).append(row)
            self._frames = list(groups.values())
        return self._frames
