"""Mutants of the modules that read, step and predict: which of a drawn sample do their own tests notice?

`python -m experiments.mutants --count 150 --seed 2` prints the table of docs/results.md; the same seed on the same sources draws the same
mutants. Each stands in a copy of the checkout; a test that fails, or takes longer than LIMIT in trial.py, has noticed it. Its own tests
are those of the file that mirrors the module (`tests/logs/test_read.py` for `rwjax/logs/read.py`), and no others. A survivor that is no
mistake at all still counts as one.

The mutants are made here, since the maintained tools do not fit. mutmut 3 puts all mutants of a module into one source and chooses
at the call, after which traced programs on disk, named by the source, serve all of them; it forks a process in which JAX already has
threads, and leaves out constants of modules and decorated functions. cosmic-ray has one test command for all modules, draws no sample,
changes the checkout itself, changes annotations too, and leaves out neither statements nor arguments.
"""

import argparse
import os
import random
import sys
import time
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

from experiments.mutants.mutations import Mutant, mutants
from experiments.mutants.trial import Copy

ROOT = Path(__file__).parents[2]
GROUPS = {
    "log": ("rwjax/logs/*.py",),
    "rig": ("rwjax/rig/*.py",),
    "step": tuple(f"rwjax/simulation/{name}.py" for name in ("exponential_step", "stepper", "commands", "reading")),
    "predict": ("rwjax/fitting/predict.py", "rwjax/fitting/prediction.py"),
    "frames": ("rwjax/link/frames.py", "rwjax/link/messages.py"),
}
"""Modules by the name of the group."""


def mirrored(path: str) -> str:
    """The test file of a module."""
    folder, _, name = path.removeprefix("rwjax/").rpartition("/")
    return f"tests/{folder}/test_{name}"


def drawn(group: str, count: int, seed: int) -> list[Mutant]:
    """A sample of a group's mutants, in the order of the source."""
    paths = sorted(path for pattern in GROUPS[group] for path in ROOT.glob(pattern))
    every = [mutant for path in paths for mutant in mutants(path.relative_to(ROOT).as_posix(), path.read_text())]
    print(f"{group}: {count} of {len(every)} mutants", flush=True)
    return sorted(random.Random(f"{seed} {group}").sample(every, count))


def main() -> None:
    """Draws mutants, tries each, and prints how many were noticed."""
    parser = argparse.ArgumentParser(prog="python -m experiments.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=150, help="mutants, shared evenly by the groups")
    parser.add_argument("--seed", type=int, default=1, help="another seed draws others")
    parser.add_argument("--group", action="append", choices=GROUPS, help="only this group's share of them")
    asked = parser.parse_args()
    groups, count = asked.group or list(GROUPS), asked.count // len(GROUPS)
    sample = [(group, mutant) for group in groups for mutant in drawn(group, count, asked.seed)]
    noticed = Counter()
    with TemporaryDirectory() as folder:
        os.environ["JAX_COMPILATION_CACHE_DIR"] = f"{folder}/cache"
        copy = Copy(ROOT, Path(folder))
        for path in sorted({mutant.path for _, mutant in sample}):
            if not copy.passes(path, (ROOT / path).read_text(), mirrored(path), keep_bytecode=True):
                sys.exit(f"{mirrored(path)} fails or finds no test without any change")
        for group, mutant in sample:
            began = time.monotonic()
            survives = copy.passes(mutant.path, mutant.source, mirrored(mutant.path))
            noticed[group] += not survives
            said, taken = "survived" if survives else "noticed", time.monotonic() - began
            print(f"{said:8} {taken:4.0f} s  {mutant.path}:{mutant.line}: {mutant.change}", flush=True)
    for group in groups:
        print(f"{group:8} {noticed[group]:3} of {count}")
    print(f"all      {noticed.total():3} of {len(sample)}: {100.0 * noticed.total() / len(sample):.1f} %")


if __name__ == "__main__":
    main()
