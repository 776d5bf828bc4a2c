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
        ours = [e["summary"] for e in run.evaluations() if e["sequence"].startswith(name) and e["step"] > 1]
        if ours:
            out.append([name, " / ".join(text(100 * s["success"]["share"], 1) for s in ours), *others])
    return table(["success %, every 2nd / 3rd / 4th frame", "Holdfast", *peers["step_systems"]], out)


def recorded(work, folder):
    sequences = folders_below(folder)
    if not sequences:
        sys.exit("experiments: {} holds no sequences with poses_gt.txt".format(folder))
    models = []
    for model in sorted((folder / "models").glob("*/model.obj")):
        models += ["--model", "{}={}".format(model.parent.name, model)]
    sources = [digest(sequence / "poses_gt.txt") for sequence in sequences]
    words = [*sequences, *models, "--protocol", "rbot", "--step", "1,2,3,4"]
    report = work.folder / "runs" / "recorded.json"
    return work.evaluate(report, report.with_suffix(".csv"), words, sources, "recorded sequences")


def tables(work, folder):
    run = recorded(work, folder)
    peers = tomllib.loads(PEERS.read_text(encoding="utf-8"))
    rows = []
    for evaluation in run.evaluations():
        if evaluation["step"] == 1:
            name = evaluation["sequence"]
            rows.append([name, table_row(evaluation["summary"]), *peers["sequences"].get(name, [""] * len(peers["systems"]))])
    return table(["sequence", "Holdfast", *peers["systems"]], rows) + "\n" + table_of_steps(run, peers)
