"""Models, sequences and runs of the robustness measures: each made only where it is not there already."""

import json
import shutil
import statistics
from pathlib import Path

import light
import measures
import models
import paths
from work import Work, digest, options_of

HERE = Path(__file__).resolve().parent
CAMERA = (640, 480, 650.0, 319.5, 239.5)


class Subject:
    """A sequence and the model of the object in it."""

    def __init__(self, name, folder, model, stamp):
        self.name, self.folder, self.model, self.stamp = name, folder, model, stamp


class Bench(Work):
    def __init__(self, program, folder, scenario, threads, demo=None):
        super().__init__(program, folder, scenario, threads)
        self.demo = demo
        self.maker_digest = digest(*(HERE / name for name in ("light.py", "models.py", "paths.py")))

    def keep(self, folder, wanted, make):
        """`make()` fills `folder`, unless it holds what is wanted."""
        stamp = folder / "stamp"
        if not self.fresh(stamp, wanted):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            make()
            stamp.write_text(wanted)
        return wanted

    def model(self, kind, seed):
        folder = self.folder / "models" / "{}-{}".format(kind, seed)
        self.keep(folder, digest(self.maker_digest, kind, seed), lambda: models.KINDS[kind](seed).write(folder))
        return folder / "model.obj"

    def changed_model(self, name, path, change):
        """`change(model)` gives another Model."""
        folder = self.folder / "models" / name
        self.keep(folder, digest(self.maker_digest, path, name), lambda: change(models.read(path)).write(folder))
        return folder / "model.obj"

    def simulated(self, name, model, changes=(), poses=None, occluder=None):
        """`poses`, and (model, poses) of an occluder, are lists of poses; a sequence's own ones where there are none."""
        settings = {**self.scenario["simulate"], **dict(changes)}
        folder = self.folder / "sequences" / name
        given = [] if poses is None else poses
        if poses is not None:
            settings["frames"] = len(poses)
        behind = [] if occluder is None else [occluder[0], occluder[1]]
        wanted = digest(self.simulator_digest, self.maker_digest, model, json.dumps(settings, sort_keys=True),
                        *(p.tobytes() for p in given), *(str(b) for b in behind))

        def make():
            motion = ("motion", "speed") if poses is not None else ()
            words = options_of({name: value for name, value in settings.items() if name not in motion})
            if poses is not None:
                paths.write_poses(folder / "path.txt", poses)
                words += ["--trajectory", folder / "path.txt"]
            if occluder is not None:
                paths.write_poses(folder / "occluder.txt", occluder[1])
                words += ["--occluder-model", occluder[0], "--occluder-trajectory", folder / "occluder.txt"]
            self.progress("simulate {}".format(name))
            self.call("simulate", folder, "--overwrite", "--model", model, *words, "--threads", self.threads)

        return Subject(name, folder, model, self.keep(folder, wanted, make))

    def changed_frames(self, name, subject, curve):
        folder = self.folder / "sequences" / name
        stamp = self.keep(folder, digest(self.maker_digest, subject.stamp, name),
                          lambda: light.curved_sequence(subject.folder, folder, curve))
        return Subject(name, folder, subject.model, stamp)

    def grey_frames(self, name, subject):
        """The same as one channel."""
        folder = self.folder / "sequences" / name
        stamp = self.keep(folder, digest(self.maker_digest, subject.stamp, name),
                          lambda: light.grey_sequence(subject.folder, folder))
        return Subject(name, folder, subject.model, digest(subject.stamp, stamp))

    def with_texture(self, name, subject, write):
        """`write(folder)` makes another model."""
        folder = self.folder / "models" / name
        stamp = self.keep(folder, digest(self.maker_digest, subject.stamp, name), lambda: write(folder))
        return Subject(name, subject.folder, folder / "model.obj", digest(subject.stamp, stamp))

    def track(self, name, subject, *options):
        report = self.folder / "runs" / (name + ".json")
        words = [subject.folder, "--model", subject.model, *options]
        return Rows(self.evaluate(report, report.with_suffix(".csv"), words, [subject.stamp], name).frames()[0])


class Rows:
    """Figures of a run's frames."""

    def __init__(self, rows):
        self.rows = rows
        self.good = [r for r in rows if measures.within(r, 50, 5)]

    def __len__(self):
        return len(self.rows)

    def bad(self):
        """Frames lost, or beyond 50 mm or 5 degrees."""
        return sum(not (measures.held(r) and measures.within(r, 50, 5)) for r in self.rows)

    def wrong(self):
        return sum(map(measures.wrong, self.rows))

    def median(self):
        """mm and degrees, of the frames within 50 mm and 5 degrees."""
        if not self.good:
            return float("nan"), float("nan")
        errors = [measures.error(r) for r in self.good]
        return statistics.median(e[0] for e in errors), statistics.median(e[3] for e in errors)

    def largest(self):
        return max(measures.error(r)[0] for r in self.rows), max(measures.error(r)[3] for r in self.rows)

    def success(self):
        return 100 * len(self.good) / len(self.rows)

    def covered(self):
        """Of the held frames, per cent inside the 95 % ellipsoid; median of the squared normalised error."""
        values = [measures.number(r, "normalized_error_squared") for r in self.rows if measures.held(r)]
        return 100 * sum(v <= 12.592 for v in values) / len(values), statistics.median(values)


def joined(runs):
    return Rows([row for run in runs for row in run.rows])
