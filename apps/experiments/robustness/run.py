"""How much the tracker bears: wrong first poses, other light, small and half-seen objects, objects of other kinds, models
and calibrations that are a little wrong; whether its covariance is right; what each part is good for.

python3 run.py --program holdfast --work out/robustness --document docs/results/robustness.md
               [--ablation-document docs/results/experiments.md] [--sequences FOLDER]
               [--demo FOLDER] [--only PART,...]

What is asked stands in scenario.toml. Without recorded sequences, simulated ones stand in for them, and the tables that
need them stay as they are.
"""

import argparse
import sys
import tomllib
from pathlib import Path

try:
    import numpy  # noqa: F401: said here, not after minutes of work
    from PIL import Image  # noqa: F401
except ImportError as error:
    sys.exit("robustness: python3 has no {}; install python3-numpy and python3-pil".format(error.name))

sys.path.insert(1, str(Path(__file__).resolve().parent.parent))  # modules shared with the paper's experiments
import parts
from bench import HERE, Bench, Subject
from work import digest

import document
from recorded import folders_below


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--work", required=True, type=Path, help="models, sequences and results; kept from run to run")
    parser.add_argument("--document", required=True, type=Path)
    parser.add_argument("--ablation-document", type=Path, help="where the table of parts switched off goes [--document]")
    parser.add_argument("--sequences", type=Path, help="folder of recorded sequences with true poses")
    parser.add_argument("--demo", type=Path, help="folder that `make demo` filled")
    parser.add_argument("--only", help="some of: " + ", ".join(parts.PARTS))
    parser.add_argument("--threads", type=int, default=0, help="of simulation; 0: one a core")
    return parser.parse_args()


def recorded_subjects(folder):
    """Every sequence with the model whose name its own begins with."""
    found = {path.parent.name: path for path in sorted((folder / "models").glob("*/model.obj"))}
    subjects = {}
    for sequence in folders_below(folder):
        model = next((path for name, path in found.items() if sequence.name.startswith(name)), None)
        if model:
            subjects[sequence.name] = Subject(sequence.name, sequence, model,
                                              digest(sequence / "poses_gt.txt", model, *model.parent.glob("*.png")))
    return subjects


def main():
    given = arguments()
    scenario = tomllib.loads((HERE / "scenario.toml").read_text(encoding="utf-8"))
    bench = Bench(given.program, given.work, scenario, given.threads, given.demo)
    recorded = recorded_subjects(given.sequences) if given.sequences and given.sequences.is_dir() else {}
    chosen = given.only.split(",") if given.only else list(parts.PARTS)
    for name in chosen:
        if name not in parts.PARTS:
            sys.exit("robustness: --only: '{}' is none of {}".format(name, ", ".join(parts.PARTS)))
        text = parts.PARTS[name](bench, recorded)
        if text is None:
            continue
        print("\n" + name + "\n" + text, flush=True)
        # After every part, so that an interrupted run leaves what it knows.
        other = given.ablation_document if name == "ablation" else None
        document.fill(other or given.document, {name: text})


if __name__ == "__main__":
    main()
