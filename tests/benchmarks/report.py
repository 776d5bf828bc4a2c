#!/usr/bin/env python3
"""report.py RESULT.json...: holdfast_bench's results as tables (medians of its repetitions), with the ratios to OpenCV."""
import json
import re
import statistics
import sys


def read(path):
    """Medians of every benchmark of a result file: {name: {figure: value}}, and the number of threads."""
    with open(path) as file:
        result = json.load(file)
    runs = {}
    for run in result["benchmarks"]:
        if run["run_type"] != "iteration":
            continue
        name = run["run_name"].replace("/process_time", "").replace("/real_time", "")
        runs.setdefault(name, []).append(run)
    skipped = ("family_index", "per_family_instance_index", "repetitions", "repetition_index", "threads", "iterations")
    figures = {}
    for name, repetitions in runs.items():
        keys = [key for key, value in repetitions[0].items() if isinstance(value, (int, float)) and key not in skipped]
        figures[name] = {key: statistics.median(run[key] for run in repetitions) for key in keys}
    return figures, int(result["context"]["threads"])


def frames_table(figures, threads):
    print(f"Whole frames, {threads} thread{'s' if threads > 1 else ''} (ms; (a): OpenCV filters two images of that size)")
    print(f"{'':22}{'frame':>8}{'CPU':>8}{'upload':>8}{'render':>8}{'filter':>8}{'search':>8}{'solve':>8}"
          f"{'iter.':>7}{'(a)':>7}{'frame/(a)':>11}{'no render/(a)':>15}{'lost':>6}{'worst mm':>10}")
    for name, run in figures.items():
        match = re.fullmatch(r"frame/(.*)/(\d+x\d+)", name)
        if not match:
            continue
        reference = figures.get(f"opencv/{match[2]}", {}).get("real_time", float("nan"))
        total = run["real_time"]
        print(f"{match[1] + ' ' + match[2]:22}{total:8.2f}{run['cpu_time']:8.2f}{run['upload_ms']:8.2f}"
              f"{run['render_ms']:8.2f}{run['filter_ms']:8.2f}{run['search_ms']:8.2f}{run['solve_ms']:8.2f}"
              f"{run['solutions']:7.1f}{reference:7.2f}{total / reference:11.2f}"
              f"{(total - run['render_ms']) / reference:15.2f}{run['lost']:6.2g}{run['worst_mm']:10.2f}")
    print()


def main(paths):
    for path in paths:
        frames_table(*read(path))


if __name__ == "__main__":
    main(sys.argv[1:])
