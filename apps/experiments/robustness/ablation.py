"""Default mode with one part switched off at a time: what each is good for."""

import statistics

import measures
from document import table
from measures import text


class Figures:
    """What runs over several sequences come to."""

    def __init__(self):
        self.success, self.wrong, self.errors, self.ms = [], 0, [], []

    def add(self, run):
        counted = [r for r in run.rows if r["counted"] == "1"]
        self.success.append(100 * sum(measures.within(r, 50, 5) for r in counted) / len(counted))
        self.wrong += sum(map(measures.wrong, counted))
        self.errors += map(measures.error, counted)
        self.ms += [measures.number(r, "ms") for r in run.rows]

    def mean_success(self):
        return text(statistics.mean(self.success), 1)

    def median(self):
        """Of all frames, the lost ones too."""
        return "{} / {}".format(*(text(statistics.median(e[i] for e in self.errors)) for i in (0, 3)))


def simulated(bench):
    """Sequences for this alone: objects, motion, light, occluders and cameras of several kinds."""
    for name, settings in bench.scenario["ablation"]["sequences"].items():
        changes = dict(settings)
        model = bench.model(changes.pop("object"), changes.pop("object-seed"))
        power = changes.pop("power", 1)
        subject = bench.simulated("ablation-" + name, model, changes)
        yield subject if power == 1 else bench.changed_frames(subject.name + "-encoded", subject, lambda v: v ** power)


def figures_of(bench, name, options, subjects, kinds):
    """By the RBOT protocol: of all sequences together, and of each kind (what a sequence's name begins with) alone."""
    everything, by_kind = Figures(), {kind: Figures() for kind in kinds}
    for subject in subjects:
        run = bench.track("ablation/{}/{}".format(name.replace(" ", "_"), subject.name), subject, "--protocol", "rbot",
                          "--min-visible", "0.25", *options)
        everything.add(run)
        by_kind[next(kind for kind in kinds if subject.name.startswith(kind))].add(run)
    return everything, by_kind


def short_name(name):
    return name.replace("ablation-", "").replace("-encoded", "").replace("_", " ")


def part(bench, recorded):
    variants = {"nothing": [], **bench.scenario["ablation"]["parts"]}
    made = list(simulated(bench))
    groups = [(made, [subject.name for subject in made])]
    if recorded:
        groups.insert(0, (list(recorded.values()), sorted({name.split("_")[0] for name in recorded}, reverse=True)))
    tables = []
    for subjects, kinds in groups:
        rows = []
        for name, options in variants.items():
            every, by_kind = figures_of(bench, name, options, subjects, kinds)
            rows.append([name, " ".join(options), *(text(s, 1) for s in every.success), every.mean_success(), every.wrong,
                         *(figures.median() for figures in by_kind.values()), text(statistics.median(every.ms))])
        short = [short_name(subject.name) for subject in subjects]
        medians = ["median of {}, mm / deg".format(short_name(kind)) for kind in kinds]
        tables.append(table(["without", "options", *(s + ", %" for s in short), "mean, %", "held but wrong", *medians,
                             "median ms"], rows))
    return "\n".join(tables)
