"""What a kernel that PoCL compiled for this processor consists of: instructions of its innermost loop that holds most
multiply-adds, by kind, and what share of the multiply-add peak they could reach at most: when two vectors are worked on
and two are loaded or stored in every cycle, all lanes are wanted and nothing waits for a cache."""

import os
import pathlib
import re
import subprocess
import tempfile

ARITHMETIC = re.compile(r"v(add|sub|mul|div|max|min|sqrt|rcp|rsqrt|round|rndscale|cvt|range|scale)")
MULTIPLY_ADD = re.compile(r"vfn?m(add|sub)")
MOVE = re.compile(r"v(mov|broadcast)|mov")
JUMP = re.compile(r"j[a-z]+\s+([0-9a-f]+)")
LINE = re.compile(r"\s*([0-9a-f]+):\s+(\S+)\s*(.*)")


def compiled(program, kernel):
    """Disassembly of the kernel, compiled into a folder of its own: (address, mnemonic, operands) of each line."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "POCL_CACHE_DIR": cache, "HOLDFAST_CACHE_DIR": cache}
        subprocess.run([program, "--threads", "1"], check=True, capture_output=True, env=environment)
        libraries = sorted(pathlib.Path(cache).glob(f"**/{kernel}.so"))
        if not libraries:
            return []
        text = subprocess.run(["objdump", "-d", "--no-show-raw-insn", libraries[0]], check=True, capture_output=True,
                              text=True).stdout
    body = text.split(f"<_pocl_kernel_{kernel}_workgroup>:\n", 1)[-1].split("\n\n", 1)[0]
    return [(int(found[1], 16), found[2], found[3]) for found in map(LINE.match, body.split("\n")) if found]


def main_loop(lines):
    """The shortest loop with at least two fifths of all multiply-adds (the compiler may keep the loop twice)."""
    most = sum(1 for _, name, _ in lines if MULTIPLY_ADD.match(name))
    best = lines
    for address, name, operands in lines:
        jump = JUMP.match(f"{name} {operands}")
        if jump is None or int(jump[1], 16) >= address:
            continue
        loop = [line for line in lines if int(jump[1], 16) <= line[0] <= address]
        held = sum(1 for _, mnemonic, _ in loop if MULTIPLY_ADD.match(mnemonic))
        if held >= 0.4 * most and len(loop) < len(best):
            best = loop
    return best


def instructions(program, kernel):
    counts = {"multiply-adds": 0, "other arithmetic": 0, "compare, choose, shuffle": 0, "loads and stores": 0,
              "addresses, branches": 0}
    memory_operations = 0
    for _, name, operands in main_loop(compiled(program, kernel)):
        memory = "(" in operands and not name.startswith("lea")
        wide = "zmm" in operands or "ymm" in operands
        if MULTIPLY_ADD.match(name):
            kind = "multiply-adds"
        elif wide and ARITHMETIC.match(name):
            kind = "other arithmetic"
        elif MOVE.match(name) and memory:
            kind = "loads and stores"
        elif wide or name.startswith("k"):
            kind = "compare, choose, shuffle"
        else:
            kind = "addresses, branches"
        counts[kind] += 1
        memory_operations += memory
    vector = sum(counts[kind] for kind in ("multiply-adds", "other arithmetic", "compare, choose, shuffle"))
    flops = 2 * counts["multiply-adds"] + counts["other arithmetic"]
    return {"kinds": counts, "memory_operations": memory_operations,
            "most_of_peak": flops / max(1, 2 * vector, 2 * memory_operations)}
