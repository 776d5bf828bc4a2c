#!/usr/bin/env python3
"""What the model's edges add beside contour and texture, by `holdfast evaluate --protocol rbot`, and how grey recordings
are followed by shape alone. Writes docs/results/modalities.md.

  modalities.py --program build/release/apps/holdfast --sequences FOLDER [--document FILE]

FOLDER is as rbot.py takes it. Its grey recordings are folders with frames/, K.txt, model.obj, init.txt and
poses_reference.txt (another tracker's poses, 3x4 a line).
"""
import argparse
import pathlib

import holdfast
import numpy
import rbot

HEAD = """# Modalities

`make modalities SEQUENCES=FOLDER` writes these tables.

## With and without edges

The RBOT protocol as in [every sequence](rbot.md): success in per cent, median errors in mm / degrees, frames that are
held and wrong.
"""

GREY = """
## Grey recordings

Models without texture, from the first pose of a reference that another tracker made. Corners of the model beside the
reference's, pixels: of a frame, their mean and the worst of them.
"""


def edges(arguments):
    lines = ["| sequence | model | with edges | wrong | without | wrong |", "|---|---|---|---|---|---|"]
    for sequence in sorted(p for p in arguments.sequences.iterdir() if (p / "visible.txt").exists()):
        models = arguments.sequences / "models" / sequence.name.split("_")[0]
        for title, model in (("textured", models / "model.obj"), ("shape alone", models / "mesh_plain.obj")):
            print("modalities:", sequence.name, title, flush=True)
            row = [sequence.name, title]
            for options in ((), ("--ablate", "edges")):
                success, mm, degrees, _, wrong, _ = rbot.figures(rbot.run(arguments.program, sequence, model, *options))
                row += ["{:.1f}, {:.2f} / {:.2f}".format(success, mm, degrees), str(wrong)]
            lines.append("| " + " | ".join(row) + " |")
    return "\n".join(lines) + "\n"


def grey(arguments):
    lines = ["| recording | held | mean corner: median, 95 % | within 3 | worst corner: median, 95 % | within 3 |",
             "|---|---|---|---|---|---|"]
    for folder in sorted(p for p in arguments.sequences.iterdir() if (p / "poses_reference.txt").exists()):
        print("modalities:", folder.name, flush=True)
        video, mesh = holdfast.Video(folder / "frames"), holdfast.Mesh.load(folder / "model.obj")
        camera = holdfast.Camera.load(folder / "K.txt", video.width, video.height)
        corners = numpy.unique(mesh.vertices, axis=0)

        def pixels(pose):
            return camera.project(corners @ pose[:3, :3].T + pose[:3, 3])

        tracker = holdfast.Tracker(mesh, camera)
        tracker.reset(holdfast.load_pose(folder / "init.txt"))
        found = [tracker.track(frame.image, frame.time) for frame in video]
        off = [numpy.linalg.norm(pixels(result.T_camera_object) - pixels(reference), axis=1)
               for result, reference in zip(found, holdfast.load_poses(folder / "poses_reference.txt")) if result.held]
        row = [folder.name, "{} of {}".format(len(off), len(found))]
        for values in ([frame.mean() for frame in off], [frame.max() for frame in off]):
            row += ["{:.2f}, {:.2f}".format(*numpy.quantile(values, [0.5, 0.95])) if off else "",
                    "{:.0f} %".format(100 * numpy.mean(numpy.array(values) < 3)) if off else ""]
        lines.append("| " + " | ".join(row) + " |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--sequences", type=pathlib.Path, required=True)
    parser.add_argument("--document", type=pathlib.Path, default=pathlib.Path("docs/results/modalities.md"))
    arguments = parser.parse_args()
    arguments.document.parent.mkdir(parents=True, exist_ok=True)
    arguments.document.write_text(HEAD + "\n" + edges(arguments) + GREY + "\n" + grey(arguments))


if __name__ == "__main__":
    main()
