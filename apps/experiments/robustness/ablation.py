"""Default mode with one part switched off at a time: what each is good for."""

import statistics

import measures
from document import table
from measures import text


def simulated(bench):
    """Sequences for this alone: objects, motion, light and occluders of several kinds."""
    for name, settings in bench.scenario["ablation"]["sequences"].items():
        changes = dict(settings)
        model = bench.model(changes.pop("object"), changes.pop("object-seed"))
        yield bench.simulated("ablation-" + name, model, changes)


def cell(rows):
    """Success in per cent; median mm and degrees of all frames, the lost ones too."""
    errors = [measures.error(row) for row in rows]
    success = 100 * sum(measures.within(row, 50, 5) for row in rows) / len(rows)
    return "{}, {} / {}".format(text(success, 1), *(text(statistics.median(e[i] for e in errors)) for i in (0, 3)))


def part(bench, recorded):
    """By the RBOT protocol, the recorded sequences first."""
    subjects = [recorded[name] for name in bench.scenario["ablation"]["recorded"] if name in recorded]
    subjects += simulated(bench)
    rows = []
    for name, options in {"nothing": [], **bench.scenario["ablation"]["parts"]}.items():
        runs = [bench.track("ablation/{}/{}".format(name.replace(" ", "_"), subject.name), subject, "--protocol", "rbot",
                            "--min-visible", "0.25", *options).rows for subject in subjects]
        counted = [[row for row in run if row["counted"] == "1"] for run in runs]
        rows.append([name, " ".join(options), *map(cell, counted),
                     sum(measures.wrong(row) for run in counted for row in run)])
    return table(["without", "options", *(subject.name.replace("ablation-", "") for subject in subjects), "held but wrong"],
                 rows)
