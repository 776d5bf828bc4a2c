"""The tables of docs/results/experiments.md that compare with the paper, and what must hold."""

import statistics

import measures
from document import table
from measures import spread

QUARTER = 0.25


class Bound:
    """One thing that must hold: a figure a seed, and whether it is good."""

    def __init__(self, row, case, who, wanted, values, good, digits=2, needed=None):
        self.row, self.case, self.who, self.wanted = row, case, who, wanted
        self.values = list(values)
        self.good = [good(value) for value in self.values]
        self.needed = len(self.good) if needed is None else max(1, round(needed * len(self.good)))
        self.digits = digits

    def met(self):
        return sum(self.good) >= self.needed

    def cells(self):
        return [self.row, self.case, self.who, self.wanted, spread(self.values, self.digits),
                "{} of {}".format(sum(self.good), len(self.good)), "met" if self.met() else "**missed**"]


def below(limit):
    return lambda value: value is not None and value <= limit


def tests_off(row, case, who, sequences):
    """Without tests the object must be lost, or the occluder is too easy."""
    seen = [[r for r in rows if measures.number(r, "visible") > QUARTER] for rows in sequences]
    share = [100 * sum(not measures.within(r, 10, 2.5) for r in rows) / len(rows) for rows in seen]
    return [Bound(row, case, who + ", tests off", "leaves 10 mm / 2.5 deg on 80 % of the seeds (% of frames outside)",
                  share, lambda value: value > 0, 1, 0.8)]


def largest_errors(row, case, who, sequences, limits):
    """`limits`: what may be how large, of mm (in all), lateral, depth (mm) and deg."""
    names = {"mm": 0, "lateral": 1, "depth": 2, "deg": 3}
    units = {"mm": "position, mm", "lateral": "lateral, mm", "depth": "depth, mm", "deg": "rotation, deg"}
    largest = [measures.largest(rows) for rows in sequences]
    return [Bound(row, case, who, "largest {}: {:g}".format(units[name], limit),
                  [values[names[name]] for values in largest], below(limit)) for name, limit in limits.items()]


def held_throughout(row, case, who, sequences):
    values = [sum(not (measures.held(r) and measures.within(r, 50, 5)) for r in rows) for rows in sequences]
    return [Bound(row, case, who, "held on every seed (frames not held within 50 mm / 5 deg)", values, below(0), 0)]


def cube_default(row, case, sequences):
    who = "default mode"
    out = []
    seen = [measures.before_hidden(rows, 0.15) for rows in sequences]
    out += largest_errors(row, case + ", until 15 % visible", who, seen, {"mm": 2, "deg": 0.5})
    later = [[r for r in rows[len(before):] if measures.held(r) and measures.number(r, "visible") > 0.15]
             for rows, before in zip(sequences, seen)]
    out += largest_errors(row, case + ", later, held and over 15 % visible", who, later, {"mm": 2, "deg": 0.5})
    wrong = [sum(map(measures.wrong, rows)) for rows in sequences]
    out.append(Bound(row, case, who, "never held while over 20 mm / 5 deg off (frames)", wrong, below(0), 0))
    again = [measures.frames_until_held_again(rows, 0.5) for rows in sequences]
    out.append(Bound(row, case, who, "held again within 10 frames of 50 % visible (frames)", again, below(10), 0))
    return out


def median_error(rows):
    return statistics.median(measures.error(r)[0] for r in rows)


def behind_bar(who, sequences):
    out = held_throughout("2", "white bar", who, sequences)
    out += largest_errors("2", "white bar", who, sequences, {"lateral": 5, "depth": 8, "deg": 2})
    out.append(Bound("2", "white bar", who, "pixels on the occluder below 0.5 % of those used (%)",
                     [100 * measures.occluder_share(rows) for rows in sequences], lambda value: value < 0.5))
    return out


def behind_cube(who, sequences):
    seen = [measures.before_hidden(rows, QUARTER) for rows in sequences]
    return largest_errors("4", "lettered cube, until a quarter visible", who, seen, {"mm": 5, "deg": 2})


def one_solution_bounds(runs, tracker, who):
    """What is asked of a tracker that solves once a frame: rows 1 to 5."""
    def of(scene, name):
        return runs[scene, name].frames()

    out = tests_off("1", "white bar", who, of("bar", tracker + "-off"))
    out += behind_bar(who, of("bar", tracker))
    out += tests_off("3", "lettered cube", who, of("cube", tracker + "-off"))
    out += behind_cube(who, of("cube", tracker))
    off, on = of("free", tracker + "-off"), of("free", tracker)
    out += [Bound("5", "unoccluded", who, "on no worse than off ({} error on / off)".format(name),
                  [figure(b) / figure(a) for a, b in zip(off, on)], below(1.0))
            for name, figure in (("median", median_error), ("largest", lambda rows: measures.largest(rows)[0]))]
    return out + largest_errors("5", "unoccluded", who, on, {"mm": 4, "deg": 1.5})


def default_bounds(runs):
    who = "default mode"
    return (largest_errors("2", "white bar", who, runs["bar", "default"].frames(), {"mm": 1, "deg": 0.3})
            + cube_default("4", "lettered cube", runs["cube", "default"].frames())
            + largest_errors("5", "unoccluded", who, runs["free", "default"].frames(), {"mm": 0.5, "deg": 0.2}))


def redundancy_bounds(runs, tracker, who):
    rows, change, noise = redundancy_figures(runs, tracker)
    return [Bound("6", "redundancy, white bar", who, "rows at most half (share left)", rows, below(0.5)),
            Bound("6", "redundancy, white bar", who, "pose change below the noise (median mm / median error)",
                  [a / b for a, b in zip(change, noise)], below(1.0))]


def all_bounds(runs):
    every = one_solution_bounds(runs, "paper", "paper mode") + default_bounds(runs)
    every += redundancy_bounds(runs, "paper", "paper mode")
    return sorted(every, key=lambda bound: bound.row)


def bounds_table(every):
    heading = ["#", "case", "tracker", "wanted", "min / median / max over seeds", "seeds", ""]
    return table(heading, [bound.cells() for bound in every])


def bounds(runs):
    return bounds_table(all_bounds(runs))


def verdict(runs):
    every = all_bounds(runs)
    missed = [bound for bound in every if not bound.met()]
    lines = ["experiments: {} of {} bounds met".format(len(every) - len(missed), len(every))]
    lines += ["  missed: #{}, {}, {}: {}: {} ({} of {} seeds)".format(
        b.row, b.case, b.who, b.wanted, spread(b.values, b.digits), sum(b.good), len(b.good)) for b in missed]
    return "\n".join(lines)


# What the paper states, where it does.
PAPER = {
    ("free", "paper-off"): "±8 mm, 3.5 deg",
    ("free", "paper"): "±6 mm, 2.5 deg",
    ("bar", "paper-off"): "fails",
    ("bar", "paper"): "±10 mm, 2.5 deg",
    ("cube", "paper-off"): "fails",
    ("cube", "paper"): "accurate until mostly occluded",
}


def scenes(runs, scenario):
    """Every scene and tracker; errors while more than a quarter of the object is visible."""
    heading = ["scene", "tracker", "the paper", "frames within 10 mm and 2.5 deg, %", "median, mm", "largest, mm",
               "median, deg", "held but wrong, frames", "on occluder, % of used"]
    out = []
    for (scene, tracker), run in runs.items():
        kept = [[r for r in rows if measures.number(r, "visible") > QUARTER] for rows in run.frames()]
        errors = [[measures.error(r) for r in rows] for rows in kept]

        def each(figure):
            return [figure(rows) for rows in kept]

        out.append([
            scenario["scenes"][scene]["title"], scenario["trackers"][tracker]["title"],
            PAPER.get((scene, tracker), ""),
            spread(each(lambda rows: 100 * sum(measures.within(r, 10, 2.5) for r in rows) / len(rows)), 1),
            spread([statistics.median(e[0] for e in rows) for rows in errors]),
            spread([max(e[0] for e in rows) for rows in errors]),
            spread([statistics.median(e[3] for e in rows) for rows in errors]),
            spread([sum(map(measures.wrong, rows)) for rows in run.frames()], 0),
            spread([100 * measures.occluder_share(rows) for rows in run.frames()]) if "free" not in scene else "",
        ])
    return table(heading, out)


def redundancy_figures(runs, tracker):
    """A seed each: rows left, how far the pose changes (mm), the error it had (mm)."""
    left, change, noise = [], [], []
    for dropped, every in zip(runs["bar", tracker].frames(), runs["bar", tracker + "-channels"].frames()):
        left.append(sum(int(r["rows"]) for r in dropped) / sum(int(r["rows"]) for r in every))
        apart = []
        for a, b in zip(dropped, every):
            apart.append(sum((measures.number(a, "error_{}_mm".format(k)) - measures.number(b, "error_{}_mm".format(k))) ** 2
                             for k in "xyz") ** 0.5)
        change.append(statistics.median(apart))
        noise.append(statistics.median(measures.error(r)[0] for r in every))
    return left, change, noise


def paper_parts(runs):
    """A line a part of paper mode that is left out: errors by scene, and seeds that stay within what is asked."""
    heading = ["left out", "unoccluded: median, mm", "largest, mm", "white bar: largest, mm",
               "lettered cube, until a quarter visible: largest, mm", "seeds within 5 mm and 2 deg"]
    out = []
    for part, scenes in runs.items():
        free, bar = scenes["free"].frames(), scenes["bar"].frames()
        cube = [measures.largest(measures.before_hidden(rows, QUARTER)) for rows in scenes["cube"].frames()]
        out.append([part, spread([median_error(rows) for rows in free]),
                    spread([measures.largest(rows)[0] for rows in free]),
                    spread([measures.largest(rows)[0] for rows in bar]),
                    spread([largest[0] for largest in cube]),
                    "{} of {}".format(sum(largest[0] <= 5 and largest[3] <= 2 for largest in cube), len(cube))])
    return table(heading, out)
