"""Sequences of the tests' other renderer, where they are at hand, beside what other systems do on them."""

import sys
import tomllib
from pathlib import Path

from document import table
from measures import text
from work import digest

PEERS = Path(__file__).resolve().parent / "peers.toml"


def folders_below(folder):
    return sorted(path for path in folder.iterdir() if (path / "poses_gt.txt").exists())


def table_row(summary):
    first = summary["success"]["first_beyond"]
    mm, degrees = summary["translation_mm_not_failed"], summary["rotation_deg_not_failed"]
    return "{}, {}, {} / {}, {} / {}".format(
        text(100 * summary["success"]["share"], 1) if summary["success"]["share"] < 0.9995 else "100",
        "-" if first is None else first, text(mm["median"]), text(mm["p95"]), text(degrees["median"]), text(degrees["p95"]))


def table_of_steps(run, peers):
    out = []
    for name, others in peers["steps"].items():
        ours = [e["summary"] for e in run.evaluations() if e["sequence"] == name]
        if ours:
            out.append([name, " / ".join(text(100 * s["success"]["share"], 1) for s in ours), *others])
    return table(["success %, every 2nd / 3rd / 4th frame", "Holdfast", *peers["step_systems"]], out)


def recorded(work, folder, peers):
    sequences = [sequence for sequence in folders_below(folder) if sequence.name in peers["sequences"]]
    if not sequences:
        sys.exit("experiments: {} holds none of {}".format(folder, ", ".join(peers["sequences"])))
    models = []
    for model in sorted((folder / "models").glob("*/model.obj")):
        models += ["--model", "{}={}".format(model.parent.name, model)]
    sources = [digest(sequence / "poses_gt.txt") for sequence in sequences]
    common = [*models, "--protocol", "rbot"]

    def run(name, chosen, steps):
        report = work.folder / "runs" / (name + ".json")
        return work.evaluate(report, report.with_suffix(".csv"), [*chosen, *common, "--step", steps], sources, name)

    # Faster motion only where there is something to compare with.
    fast = [sequence for sequence in sequences if sequence.name in peers["steps"]]
    return run("recorded", sequences, "1"), run("recorded-faster", fast, "2,3,4") if fast else None


def tables(work, folder):
    peers = tomllib.loads(PEERS.read_text(encoding="utf-8"))
    run, faster = recorded(work, folder, peers)
    rows = []
    for evaluation in run.evaluations():
        name = evaluation["sequence"]
        rows.append([name, table_row(evaluation["summary"]), *peers["sequences"][name]])
    text = table(["sequence", "Holdfast", *peers["systems"]], rows)
    return text + "\n" + table_of_steps(faster, peers) if faster else text
