#!/usr/bin/env python3
"""Runs `holdfast evaluate --protocol rbot` on sequences with their model and with its shape alone, and writes the table
docs/results/rbot.md and from it the README's.

  rbot.py --program build/release/apps/holdfast --sequences FOLDER [--compare OTHER_PROGRAM] [--document FILE]
  rbot.py --readme README.md      fills the README's table from docs/results/rbot.md, without running anything

FOLDER holds sequences (NAME_.../frames, K.txt, poses_gt.txt, visible.txt) and models/NAME/{model.obj, mesh_plain.obj}.
"""
import argparse
import csv
import pathlib
import subprocess
import tempfile

import document

# The README's lines: title, whether a sequence belongs to it, model.
KINDS = (
    ("printed box", lambda name: name.startswith("box"), "textured"),
    ("printed bottle", lambda name: name.startswith("bottle"), "textured"),
    ("clay figure, metal part, loaf", lambda name: not name.startswith(("box", "bottle")) and "_occl" not in name, "textured"),
    ("the same, behind others", lambda name: not name.startswith(("box", "bottle")) and "_occl" in name, "textured"),
    ("all of these, by shape alone", lambda name: True, "shape alone"),
)


def median(values, share=0.5):
    values = sorted(values)
    return values[min(len(values) - 1, int(share * len(values)))] if values else float("nan")


def run(program, sequence, model, *options, protocol="rbot"):
    """The counted frames of a sequence, a dictionary each; `options` of holdfast evaluate."""
    with tempfile.TemporaryDirectory() as folder:
        table = pathlib.Path(folder) / "frames.csv"
        subprocess.run([program, "evaluate", sequence, "--model", model, "--protocol", protocol, "--min-visible", "0.25",
                        "--csv", table, "--quiet", *options], check=True, stdout=subprocess.DEVNULL)
        with open(table, newline="") as lines:
            return [row for row in csv.DictReader(lines) if row["counted"] == "1"]


def figures(rows):
    """Success, median errors of the frames that did not fail, frames held and, of these, more than 20 mm or 5 degrees off."""
    good = [r for r in rows if r["failed"] == "0"]
    held = [r for r in rows if r["status"] == "held"]
    wrong = [r for r in held if float(r["error_mm"]) > 20 or float(r["error_deg"]) > 5]
    return (100 * len(good) / max(1, len(rows)), median([float(r["error_mm"]) for r in good]),
            median([float(r["error_deg"]) for r in good]), len(held), len(wrong), len(rows))


def cells(rows):
    success, mm, degrees, held, wrong, frames = figures(rows)
    return "{:.1f} | {:.2f} / {:.2f} | {} of {} | {}".format(success, mm, degrees, held, frames, wrong)


def kept(rows):
    """The share of frames held and right, and the number held and wrong."""
    held, wrong, frames = figures(rows)[3:]
    return "{:.0f} | {}".format(100 * (held - wrong) / max(1, frames), wrong)


def accuracy(text):
    """The README's table, from the table of docs/results/rbot.md."""
    cut = [[cell.strip() for cell in line.strip("| ").split("|")] for line in text.splitlines() if line.startswith("| ")]
    rows = []
    for title, belongs, model in KINDS:
        some = [row for row in cut if row[1] == model and belongs(row[0])]
        success = [row[2] for row in some]
        mm, degrees = zip(*(row[3].split(" / ") for row in some))
        ranges = [" to ".join(dict.fromkeys((min(each, key=float), max(each, key=float)))) for each in (success, mm, degrees)]
        rows.append([title, len(some), *ranges])
    return document.table(["object", "sequences", "success, %", "median error, mm", "median error, degrees"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program")
    parser.add_argument("--sequences", type=pathlib.Path)
    parser.add_argument("--compare", help="another build of the program, measured beside it")
    parser.add_argument("--document", type=pathlib.Path, default=pathlib.Path("docs/results/rbot.md"))
    parser.add_argument("--readme", type=pathlib.Path, help="whose table of five lines to fill")
    arguments = parser.parse_args()
    if arguments.sequences:
        arguments.document.parent.mkdir(parents=True, exist_ok=True)
        arguments.document.write_text(measured(arguments))
    if arguments.readme:
        document.fill(arguments.readme, {"accuracy": accuracy(arguments.document.read_text())})


def measured(arguments):
    """The document: every sequence with its model and with the shape alone."""
    programs = [("", arguments.program)] + ([(" (compared)", arguments.compare)] if arguments.compare else [])
    lines = [
        "# RBOT protocol",
        "",
        "`make results SEQUENCES=FOLDER` writes this table. A sequence starts at the true pose and is put back to it after an",
        "error of 50 mm or 5 degrees, which counts as a failure; frames less than 25 % visible do not count. Errors are medians",
        "of the frames that did not fail, mm / degrees. Wrong: frames called held that are more than 20 mm or 5 degrees off.",
        "*Never put back*: from the first true pose on nothing is told; what is lost is found again by itself or not at all.",
        "Right: share of the frames that are held and not wrong.",
        "",
        "| sequence | model | success % | median error | held | wrong | never put back: right % | wrong |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for sequence in sorted(p for p in arguments.sequences.iterdir() if (p / "visible.txt").exists()):
        models = arguments.sequences / "models" / sequence.name.split("_")[0]
        for title, model in (("textured", models / "model.obj"), ("shape alone", models / "mesh_plain.obj")):
            for suffix, program in programs:
                print("results:", sequence.name, title + suffix, flush=True)
                lines.append("| {} | {} | {} | {} |".format(
                    sequence.name, title + suffix, cells(run(program, sequence, model)),
                    kept(run(program, sequence, model, protocol="never-reset"))))
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
