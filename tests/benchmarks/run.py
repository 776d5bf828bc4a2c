#!/usr/bin/env python3
"""run.py BUILD FOLDER: runs all benchmarks of a build folder and writes FOLDER/result.json.

Threads are counted per process, because OpenCL and drawing drivers read their number once, when they start."""
import argparse
import csv
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile
import time

import instructions


def figures_of(result):
    """Medians over the repetitions of every benchmark, but the best of what a device can do: {name: {figure: value}}."""
    runs = {}
    for run in result["benchmarks"]:
        if run["run_type"] == "iteration":
            name = run["run_name"].replace("/process_time", "").replace("/real_time", "")
            runs.setdefault(name, []).append(run)
    skipped = ("family_index", "per_family_instance_index", "repetitions", "repetition_index", "threads", "iterations")
    figures = {}
    for name, repetitions in runs.items():
        keys = [key for key, value in repetitions[0].items() if isinstance(value, (int, float)) and key not in skipped]
        figures[name] = {key: (max if key.endswith("_per_s") else statistics.median)(run[key] for run in repetitions)
                         for key in keys}
    return figures


def one_thread(holdfast):
    """The environment in which kernels run in the calling thread: PoCL has a driver for that, by one of two names."""
    for driver in ("basic", "cpu-minimal"):
        environment = {"POCL_DEVICES": driver, **os.environ}
        if subprocess.run([holdfast, "devices"], env=environment, stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL).returncode == 0:
            return environment
    return None


def run_benchmarks(program, threads, wanted, repetitions, environment=None):
    """The repetitions of all benchmarks are interleaved at random: the machine's other load then falls on all alike."""
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        command = [program, "--threads", str(threads), f"--benchmark_filter={wanted}",
                   f"--benchmark_repetitions={repetitions}", "--benchmark_min_time=0.1",
                   "--benchmark_enable_random_interleaving=true", "--benchmark_display_aggregates_only=true",
                   f"--benchmark_out={file.name}"]
        subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return json.load(file)


def lines_of(path):
    """None yet where there is no file, or it has just been replaced."""
    try:
        return path.read_bytes().count(b"\n")
    except FileNotFoundError:
        return 0


def first_frames(holdfast, repetitions):
    """Of the program itself, on 640x480 pictures: from process start to the first row of poses; the first frame's time
    over the median. The first run fills the caches of compiled kernels and is not counted."""
    starts, ratios = [], []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        subprocess.run([holdfast, "simulate", folder / "sequence", "--frames", "40"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        first_pose = (folder / "sequence" / "poses_gt.txt").read_text().splitlines()[0]
        (folder / "pose.txt").write_text(first_pose + "\n")
        poses = folder / "poses.csv"
        for repetition in range(repetitions + 1):
            poses.unlink(missing_ok=True)
            begin = time.monotonic()
            process = subprocess.Popen(
                [holdfast, "track", folder / "sequence" / "frames", "--model",
                 folder / "sequence" / "model" / "model.obj", "--camera", folder / "sequence" / "K.txt", "--init",
                 folder / "pose.txt", "--poses", poses, "--quiet"],
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while process.poll() is None and lines_of(poses) < 2:
                time.sleep(0.001)
            start = time.monotonic() - begin
            if process.wait() != 0:
                raise SystemExit("run.py: holdfast track failed on its own sequence")
            with open(poses, newline="") as file:
                ms = [float(row["ms"]) for row in csv.DictReader(file)]
            if repetition > 0:
                starts.append(start)
                ratios.append(ms[0] / statistics.median(ms))
    return {"seconds_to_first_pose": statistics.median(starts), "first_over_median": statistics.median(ratios)}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--repetitions", type=int, default=9)
    parser.add_argument("--start", action="store_true", help="time the program's start only, and print that")
    arguments = parser.parse_args()
    program = arguments.build / "tests" / "benchmarks" / "holdfast_bench"
    kernels = arguments.build / "tests" / "benchmarks" / "holdfast_kernel_bench"
    holdfast = arguments.build / "apps" / "holdfast"
    if arguments.start:
        first = first_frames(holdfast, arguments.repetitions)
        print(f"process start to first pose {first['seconds_to_first_pose']:.2f} s, "
              f"first frame / median frame {first['first_over_median']:.1f}")
        return
    arguments.folder.mkdir(parents=True, exist_ok=True)

    result = {"threads": {}, "kernels": {}}
    counts = [1, 2] if (os.cpu_count() or 1) > 1 else [1]
    environments = {1: one_thread(holdfast), 2: None}
    for threads in counts:
        print(f"bench: whole frames, {threads} thread{'s' if threads > 1 else ''}", flush=True)
        run = run_benchmarks(program, threads, "frame/|opencv/|limit/|occlusion/", arguments.repetitions,
                             environments[threads])
        result["machine"] = {key: run["context"][key] for key in ("num_cpus", "mhz_per_cpu", "load_avg", "date")}
        result["machine"]["device"] = run["context"]["device"]
        result["threads"][str(threads)] = figures_of(run)
    print("bench: sizes of object, frame and mesh, and levels, 1 thread", flush=True)
    sweeps = run_benchmarks(program, 1, "object_pixels/|frame_size/|triangles/|levels/", arguments.repetitions,
                            environments[1])
    result["sweeps"] = figures_of(sweeps)
    for threads in counts:
        print(f"bench: kernels, {threads} thread{'s' if threads > 1 else ''}", flush=True)
        output = subprocess.run([kernels, "--threads", str(threads)], check=True, capture_output=True, text=True,
                                env=environments[threads]).stdout
        result["kernels"][str(threads)] = json.loads(output)
    if "PoCL" in result["machine"]["device"]:
        result["instructions"] = {kernel: instructions.instructions(kernels, kernel)
                                  for kernel in ("flow_constraints", "occlusion_tests")}
    print("bench: first frames of the program", flush=True)
    result["first"] = first_frames(holdfast, arguments.repetitions)

    path = arguments.folder / "result.json"
    if path.exists():
        shutil.copy(path, arguments.folder / "previous.json")
    path.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
