#!/usr/bin/env python3
"""What texture, contour and edges do alone and together, by `holdfast evaluate --protocol rbot`, and how grey recordings
are followed by shape alone. Writes docs/results/modalities.md.

  modalities.py --program build/release/apps/holdfast --sequences FOLDER [--document FILE]

FOLDER is as rbot.py takes it. Its grey recordings are folders with frames/, K.txt, model.obj, init.txt and
poses_reference.txt (another tracker's poses, 3x4 a line).
"""
import argparse
import concurrent.futures
import pathlib
import shutil
import tempfile

import document
import holdfast
import numpy
import rbot

HEAD = """# Modalities

`make modalities SEQUENCES=FOLDER` writes these tables.

## Each alone, in pairs, all

The RBOT protocol as in [every sequence](rbot.md): success in per cent, mean over the sequences, and frames that are
held and wrong. Models without texture have snapshots beside contour and edges (pixels that an earlier frame showed of
the object); the last column is without them.
"""

SETS = (("printed", ("box", "bottle"), "model.obj", False),
        ("weakly textured: clay, metal, crust", ("statue", "palm", "bread"), "model.obj", False),
        ("shape alone", ("",), "mesh_plain.obj", False),
        ("shape alone, grey frames", ("",), "mesh_plain.obj", True))

TEXTURED = (("texture", ("--no-contour",)), ("texture, contour", ("--ablate", "edges")),
            ("texture, edges", ("--ablate", "colors")))
OTHERS = (("contour", ("--ablate", "texture,edges")), ("edges", ("--ablate", "texture,colors")),
          ("contour, edges", ("--ablate", "texture")), ("all", ()),
          ("all but snapshots", ("--ablate", "snapshot")))

GREY = """
## Grey recordings

Models without texture, from the first pose of a reference that another tracker made. Corners of the model beside the
reference's, pixels: of a frame, their mean and the worst of them.
"""


def grey_copy(sequence, folder):
    """The sequence with grey frames, in a folder of this name."""
    copy = folder / sequence.name
    if not copy.exists():
        (copy / "frames").mkdir(parents=True)
        for name in ("K.txt", "poses_gt.txt", "visible.txt"):
            shutil.copy(sequence / name, copy)
        for number, frame in enumerate(holdfast.Video(sequence / "frames")):
            luma = numpy.rint(frame.image @ (0.114, 0.587, 0.299)).astype(numpy.uint8)
            header = "P5\n{} {}\n255\n".format(luma.shape[1], luma.shape[0]).encode()
            (copy / "frames" / "{:06d}.pgm".format(number)).write_bytes(header + luma.tobytes())
    return copy


def combinations(arguments, folder):
    columns = TEXTURED + OTHERS
    rows = []
    for title, objects, model, grey_frames in SETS:
        sequences = sorted(p for p in arguments.sequences.iterdir()
                           if (p / "visible.txt").exists() and p.name.startswith(objects))
        row = [title]
        for name, options in columns:
            if model != "model.obj" and ("texture" in name or name == "contour, edges"):
                row.append("")
                continue
            print("modalities:", title, "by", name, flush=True)

            def run(sequence):
                frames = grey_copy(sequence, folder) if grey_frames else sequence
                mesh = arguments.sequences / "models" / sequence.name.split("_")[0] / model
                return rbot.figures(rbot.run(arguments.program, frames, mesh, *options))

            with concurrent.futures.ThreadPoolExecutor(arguments.threads) as pool:
                all_figures = list(pool.map(run, sequences))
            row.append("{:.1f}, {}".format(numpy.mean([f[0] for f in all_figures]), sum(f[4] for f in all_figures)))
        rows.append(row)
    return document.table(["models", *(name for name, _ in columns)], rows)


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
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--document", type=pathlib.Path, default=pathlib.Path("docs/results/modalities.md"))
    arguments = parser.parse_args()
    arguments.document.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        table = combinations(arguments, pathlib.Path(folder))
    arguments.document.write_text(HEAD + "\n" + table + GREY + "\n" + grey(arguments))


if __name__ == "__main__":
    main()
