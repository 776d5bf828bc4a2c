#!/usr/bin/env python3
"""report.py RESULT [BASELINE]: what run.py measured, as tables, and beside an earlier result where there is one."""
import json
import os
import sys

SIZES = ("512x256", "640x480", "1280x720")
MODES = ("default", "fast", "paper")
# Of each kernel, a pixel: bytes read and written and floating-point operations (a multiply-add is two, a division or root
# one, comparisons none), counted in its source with a blur of 7 taps. What is read again from a cache counts once. Of
# kernels that skip vectors without any wanted pixel, only the others' pixels count (known in paper mode); template_planes
# skips only the last step there, and is counted as if it did not, and as if it took all pixels from renders.
WORK = {
    "write": ("region", 1, 0),
    "read": ("region", 1, 0),
    "convert_bgr8": ("region", 19, 3),
    "halve": ("region", 80, 16),
    "halve_bgr8": ("region", 28, 28),
    "halve_depth": ("region", 20, 8),
    "unpack_view": ("region", 28, 9),
    "unpack_depth": ("region", 8, 4),
    "blur": ("region", 32, 85),
    "blur_bgr8": ("region", 19, 66),
    "template_planes": ("region", 45, 120),
    "occlusion_tests": ("active", 82, 314),
    "flow_constraints": ("active", 54, 397),
}


def threads_text(threads):
    return f"{threads} thread" + ("" if threads == "1" else "s")


def table(title, head, rows):
    widths = [max(len(str(row[i])) for row in [head] + rows) for i in range(len(head))]
    print(title)
    for row in [head] + rows:
        print("  " + "  ".join(str(cell).ljust(width) if i == 0 else str(cell).rjust(width)
                              for i, (cell, width) in enumerate(zip(row, widths))))
    print()


def reference(runs, size):
    return runs[f"opencv/{size}"]["frame_ms"]


def frames(result):
    for threads, runs in result["threads"].items():
        rows = []
        for size in SIZES:
            for mode in MODES:
                run = runs[f"frame/{mode}/{size}"]
                total, a = run["frame_ms"], reference(runs, size)
                rows.append([f"{mode} {size}", f"{total:.2f}"]
                            + [f"{run[stage + '_ms']:.2f}" for stage in ("upload", "render", "filter", "search", "solve", "contour")]
                            + [f"{run['solutions']:.0f}", f"{a:.2f}", f"{total / a:.2f}",
                               f"{run['without_render_ms'] / a:.2f}", f"{run['cpu_time']:.2f}",
                               f"{run['cpu_time'] / runs[f'opencv/{size}']['cpu_time']:.2f}",
                               f"{100 * run['lost']:.0f} %", f"{run['worst_mm']:.2f}"])
        table(f"Whole frames, {threads_text(threads)}: ms a frame; (a) is OpenCV blurring and differentiating two images",
              ["", "frame", "upload", "render", "filter", "search", "solve", "contour", "solutions", "(a)", "frame/(a)",
               "no render/(a)", "CPU", "CPU/(a)", "lost", "worst mm"], rows)


def limits(result):
    rows = []
    for threads, runs in result["threads"].items():
        rows.append([threads_text(threads), f"{runs['limit/copy/4096']['GB_per_s']:.1f}",
                     f"{runs['limit/copy/65536']['GB_per_s']:.1f}", f"{runs['limit/multiply_add']['GFLOP_per_s']:.0f}"])
    table("Limits of the device", ["", "copy 4 MB, GB/s", "copy 64 MB, GB/s", "multiply-add, GFLOP/s"], rows)


def kernels(result):
    for threads, profile in result["kernels"].items():
        rows = []
        for size in SIZES[:2]:
            for mode in MODES:
                kernels_of = dict(profile[f"{mode}/{size}"])
                limits_then = kernels_of.pop("limits")
                peak, copy = limits_then["GFLOP_per_s"], limits_then["GB_per_s"]
                for name, figures in sorted(kernels_of.items(), key=lambda item: -item[1]["ms"]):
                    row = [f"{mode} {size} {name}", f"{figures['calls']:.1f}", f"{figures['ms']:.3f}"]
                    basis, size_bytes, operations = WORK.get(name, ("", 0, 0))
                    pixels = figures.get(basis, 0)
                    if pixels > 0 and figures["ms"] > 0:
                        seconds = 1e-3 * figures["ms"]
                        gb, gflop = 1e-9 * pixels * size_bytes / seconds, 1e-9 * pixels * operations / seconds
                        row += [f"{1e9 * seconds / pixels:.2f}", f"{gb:.1f}", f"{100 * gb / copy:.0f} %",
                                f"{gflop:.1f}", f"{100 * gflop / peak:.0f} %"]
                    else:
                        row += [""] * 5
                    rows.append(row)
        table(f"Kernels, {threads_text(threads)}, a frame that they run in, on the device's clock; shares of copying 4 MB and of multiply-adds in the"
              " same minute",
              ["", "calls", "ms", "ns a pixel", "GB/s", "of copy", "GFLOP/s", "of peak"], rows)


def instructions(result):
    rows = []
    for kernel, figures in result.get("instructions", {}).items():
        if sum(figures["kinds"].values()) == 0:
            continue
        rows += [[f"{kernel}: {kind}", str(count)] for kind, count in figures["kinds"].items()]
        rows.append([f"{kernel}: of all, that touch memory", str(figures["memory_operations"])])
        rows.append([f"{kernel}: at most, of peak", f"{100 * figures['most_of_peak']:.0f} %"])
    if rows:
        table("Machine instructions of the main loop, 16 pixels", ["", "count"], rows)


def occlusion(result):
    rows = []
    for threads, runs in result["threads"].items():
        for size in SIZES:
            on, off = (runs[f"occlusion/{state}/{size}"]["frame_ms"] for state in ("on", "off"))
            rows.append([f"{size}, {threads_text(threads)}", f"{on:.2f}", f"{off:.2f}", f"{on / off:.2f}"])
    table("Occlusion tests, paper mode from given poses: ms a frame", ["", "on", "off", "on/off"], rows)


def sweeps(result):
    titles = {"object_pixels": "pixels of the object (640x480)", "frame_size": "size of the frame (20,000 pixels of object)",
              "triangles": "triangles (32,000 pixels of object)", "levels": "most pyramid levels"}
    for sweep, title in titles.items():
        rows = []
        for name, run in result["sweeps"].items():
            kind, mode, value = name.split("/")
            if kind == sweep:
                rows.append([f"{mode} {value}", f"{run['frame_ms']:.2f}", f"{run['render_ms']:.2f}",
                             f"{run['without_render_ms']:.2f}", f"{run['solutions']:.0f}", f"{100 * run['lost']:.0f} %"])
        rows.sort(key=lambda row: (row[0].split()[0], int(row[0].split()[1].split("x")[0])))
        table(f"Against {title}, 1 thread: ms a frame", ["", "frame", "render", "the rest", "solutions", "lost"],
              rows)


def first(result):
    figures = result["first"]
    table("First frame of the program, 640x480, compiled kernels cached", ["", ""],
          [["process start to first pose, s", f"{figures['seconds_to_first_pose']:.2f}"],
           ["first frame / median frame", f"{figures['first_over_median']:.1f}"]])


def against(result, baseline):
    """In multiples of (a) of the same run, because machines and their load differ from run to run."""
    rows = []
    for threads, runs in result["threads"].items():
        for size in SIZES:
            for mode in MODES:
                name = f"frame/{mode}/{size}"
                before = baseline["threads"].get(threads, {})
                if name not in before:
                    continue
                then, now = (figures[name]["frame_ms"] / reference(figures, size) for figures in (before, runs))
                rows.append([f"{mode} {size}, {threads_text(threads)}", f"{then:.2f}", f"{now:.2f}",
                             f"{100 * (now / then - 1):+.0f} %"])
    table("Frame/(a), compared with the baseline", ["", "baseline", "now", "change"], rows)


def main(paths):
    with open(paths[0]) as file:
        result = json.load(file)
    machine = result["machine"]
    print(f"{machine['device']}; {machine['num_cpus']} cores, load {machine['load_avg'][0]:.1f} at the end;"
          f" {machine['date']}\n")
    frames(result)
    limits(result)
    occlusion(result)
    first(result)
    kernels(result)
    instructions(result)
    sweeps(result)
    if len(paths) > 1 and os.path.exists(paths[1]):
        with open(paths[1]) as file:
            against(result, json.load(file))


if __name__ == "__main__":
    main(sys.argv[1:])
