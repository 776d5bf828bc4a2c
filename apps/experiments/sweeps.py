"""One thing varied at a time: thresholds, speed, contrast, distance."""

import statistics

from document import table
from measures import text
from work import tracker_options

LABELS = {
    "speed": "fastest corner, pixels a frame",
    "box-contrast": "contrast of the print",
    "distance": "nearest distance, m",
}
# Thresholds, in words, and the units that they are shown in.
THRESHOLDS = {
    "gradient-minimum": ("(5) t_gm, grey levels a pixel", 255),
    "angle-maximum": ("(6) t_θ, degrees", 57.29578),
    "difference-maximum": ("(7) t_md, grey levels a pixel", 255),
}


def values_of(settings):
    return [settings["base"] * factor for factor in settings["factors"]]


def trackers_of(scenario, name):
    sweeps = scenario["sweeps"]
    return {**sweeps.get(name, {}), **sweeps["thresholds"].get(name, {})}.get("trackers", sweeps["trackers"])


def steps(scenario, seeds):
    """How many results a run makes, at most."""
    sweeps = scenario["sweeps"]
    seeds = min(seeds, sweeps["seeds"])
    total = sum(len(trackers_of(scenario, name)) * len(values_of(sweeps["thresholds"][name])) for name in THRESHOLDS)
    trackers = len(sweeps["trackers"])
    total += len(sweeps["speed"]["simulated"]) * (seeds + trackers) + trackers
    return total + sum(len(sweeps[name]["values"]) * (seeds + trackers) for name in ("box-contrast", "distance"))


def middle(values, digits=2):
    return text(statistics.median(values), digits) if values else "-"


def figures(evaluations):
    """Per cent within 10 mm and 2 degrees, and median error (mm) of frames that did not fail, a sequence each."""
    shares = [100 * e["summary"]["within_10mm_2deg"]["share"] for e in evaluations]
    errors = [e["summary"]["translation_mm_not_failed"]["median"] for e in evaluations]
    return shares, [error for error in errors if error is not None]


def sequences_with(work, sweep, seeds, value, settings, changes):
    name = "{}/{:g}".format(sweep, value)
    common = {key: settings[key] for key in ("frames", "turns")}
    return [work.sequence(name, seed, {**common, **changes}) for seed in seeds]


def thresholds(work, scenario, seeds, folders):
    """A row a threshold's value and tracker."""
    settings = scenario["sweeps"]["thresholds"]
    rows = []
    for name, (label, unit) in THRESHOLDS.items():
        for tracker in trackers_of(scenario, name):
            for value in values_of(settings[name]):
                options = tracker_options({**scenario["trackers"][tracker], name: "{:.6g}".format(value)})
                run = work.run("sweeps/{}/{}-{:.4g}".format(name, tracker, value),
                               folders[settings["scene"]][:len(seeds)], options)
                shares, errors = figures(run.evaluations())
                rows.append([label, scenario["trackers"][tracker]["title"], "{:.3g}".format(value * unit),
                             middle(shares, 1), middle(errors)])
    return table(["threshold of test", "tracker", "value", "frames within 10 mm and 2 deg, %", "median, mm"], rows)


def of_scene(work, scenario, name, seeds):
    settings = scenario["sweeps"][name]
    curves = {}
    for tracker in trackers_of(scenario, name):
        points = []
        for value in settings["values"]:
            changes = {"distance": "{:g},{:g}".format(value, 1.2 * value)} if name == "distance" else {name: value}
            sequences = sequences_with(work, name, seeds, value, settings, changes)
            run = work.run("sweeps/{}/{}-{:g}".format(name, tracker, value), sequences,
                           tracker_options(scenario["trackers"][tracker]))
            points.append((value, *figures(run.evaluations())))
        curves[scenario["trackers"][tracker]["title"]] = points
    return curves


def of_speed(work, scenario, seeds, folders):
    settings = scenario["sweeps"]["speed"]
    curves = {}
    for tracker in trackers_of(scenario, "speed"):
        options = tracker_options(scenario["trackers"][tracker])
        points = []
        for value in settings["simulated"]:
            sequences = sequences_with(work, "speed", seeds, value, settings, {"speed": value})
            run = work.run("sweeps/speed/{}-{:g}".format(tracker, value), sequences, options)
            points.append((value, *figures(run.evaluations())))
        run = work.run("sweeps/speed/{}-steps".format(tracker), folders["free"][:len(seeds)], options,
                       ["--step", ",".join(map(str, settings["steps"]))])
        for step in settings["steps"]:
            points.append((step * scenario["simulate"]["speed"],
                           *figures([e for e in run.evaluations() if e["step"] == step])))
        curves[scenario["trackers"][tracker]["title"]] = points
    return curves


def as_table(label, curves):
    rows = []
    for name, points in curves.items():
        rows.append([name + ": frames, %"] + [middle(shares, 1) for _, shares, _ in points])
        rows.append([name + ": median, mm"] + [middle(errors) for _, _, errors in points])
    at = [value for value, _, _ in next(iter(curves.values()))]
    return table([label] + ["{:.3g}".format(value) for value in at], rows)


def run(work, scenario, seeds, folders):
    """The tables of all sweeps, by name."""
    seeds = list(seeds)[:scenario["sweeps"]["seeds"]]
    parts = {"thresholds": thresholds(work, scenario, seeds, folders)}
    for name, label in LABELS.items():
        curves = (of_speed(work, scenario, seeds, folders) if name == "speed"
                  else of_scene(work, scenario, name, seeds))
        parts["sweep-" + name] = as_table(label, curves)
    return parts
