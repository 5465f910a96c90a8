"""How often right logs are asked about, and how often wrong ones are.

`python -m experiments.questions.run [--set explore] [--rigs 200] [--off 5] [--mistakes sign degrees]` takes simulated rigs spread over a set of
cases, and the published logs of real rigs, with the rig files of their experiments. All are right: any question is false. Then every mistake is made
on each simulated rig. With `--off` the free numbers of its file are guesses, each off by up to that factor either way.
"""

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from rich.progress import track

from experiments.blind.campaign import spread
from experiments.blind.cases import make_case, write_case
from experiments.blind.draw import SETS, read
from experiments.questions.measured import measured
from experiments.questions.mistakes import MISTAKES, Logs, differs
from rwjax import read_logs, read_rig
from rwjax.fitting.questions.ask import questions
from rwjax.rig.model import Rig


def simulated(name: str, count: int, off: float = 1.0) -> Iterator[tuple[str, Rig, Logs]]:
    """Rigs of a set with their logs, of which each lacks an effect or has one number wrong, as its label says; free numbers off by a factor."""
    rows = [row for row in read(SETS / f"{name}.jsonl") if row.get("seed") is not None]
    for row in track(spread(rows, count), description="simulated rigs"):
        case = make_case(row["kind"], row["effect"], row["seed"], row["amplitude"], raw=False)
        with tempfile.TemporaryDirectory() as folder:
            write_case(case, Path(folder))
            rig = read_rig(Path(folder) / "rig.toml")
            factors = off ** np.random.default_rng(row["seed"]).uniform(-1.0, 1.0, len(rig.free))
            guessed = rig.with_values({n: rig.values[n] * f for n, f in zip(rig.free, factors, strict=True)})
            yield f"{row['kind']} {row['effect']}", guessed, read_logs(sorted(Path(folder).glob("*.csv")), rig)


def main(name: str, count: int, off: float, mistakes: Sequence[str]) -> None:
    """Prints false questions, and how often each mistake is asked about."""
    asked, false = dict.fromkeys(mistakes, 0), 0
    shown = dict.fromkeys(mistakes, 0)
    for what, rig, logs in simulated(name, count, off):
        if found := questions(rig, logs):
            false += 1
            print(f"false: {what}: {found[0]}")
        for mistake in mistakes:
            wrong = MISTAKES[mistake](logs)
            shown[mistake] += differs(logs, wrong)
            asked[mistake] += differs(logs, wrong) and bool(questions(rig, wrong))
    print(f"simulated rigs asked about: {false} of {count}")
    runs, false = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for what, rig, logs in measured(Path(folder)):
            runs += len(logs)
            for question in questions(rig, logs):
                false += 1
                print(f"false: {what}: {question}")
    print(f"questions about measured runs: {false} of {runs}")
    for mistake, many in asked.items():
        print(f"{mistake:24s} asked about {many} of {shown[mistake]}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", default="explore")
    parser.add_argument("--rigs", type=int, default=200)
    parser.add_argument(
        "--off", type=float, default=1.0, metavar="FACTOR", help="by which free numbers are off at most"
    )
    parser.add_argument("--mistakes", nargs="+", choices=MISTAKES, default=[*MISTAKES])
    options = parser.parse_args()
    main(options.set, options.rigs, options.off, options.mistakes)
