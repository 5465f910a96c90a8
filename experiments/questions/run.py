"""How often right logs are asked about, and how often wrong ones are.

`python -m experiments.questions.run [--set explore] [--rigs 200]` takes simulated rigs spread over a set of cases, and the published
logs of real rigs, with the rig files of their experiments. All are right: any question is false. Then every mistake is made
on each simulated rig.
"""

import argparse
import tempfile
from collections.abc import Iterator
from pathlib import Path

from rich.progress import track

from experiments.blind.campaign import spread
from experiments.blind.cases import make_case, write_case
from experiments.blind.draw import SETS, read
from experiments.questions.measured import measured
from experiments.questions.mistakes import MISTAKES, Logs, differs
from rwjax import read_logs, read_rig
from rwjax.fitting.questions.ask import questions
from rwjax.rig.model import Rig


def simulated(name: str, count: int) -> Iterator[tuple[str, Rig, Logs]]:
    """Rigs of a set with their logs, of which each lacks an effect or has one number wrong, as its label says."""
    rows = [row for row in read(SETS / f"{name}.jsonl") if row.get("seed") is not None]
    for row in track(spread(rows, count), description="simulated rigs"):
        case = make_case(row["kind"], row["effect"], row["seed"], row["amplitude"], raw=False)
        with tempfile.TemporaryDirectory() as folder:
            write_case(case, Path(folder))
            rig = read_rig(Path(folder) / "rig.toml")
            yield f"{row['kind']} {row['effect']}", rig, read_logs(sorted(Path(folder).glob("*.csv")), rig)


def main(name: str, count: int) -> None:
    """Prints false questions, and how often each mistake is asked about."""
    asked, false = dict.fromkeys(MISTAKES, 0), 0
    shown = dict.fromkeys(MISTAKES, 0)
    for what, rig, logs in simulated(name, count):
        if found := questions(rig, logs):
            false += 1
            print(f"false: {what}: {found[0]}")
        for mistake, make in MISTAKES.items():
            wrong = make(logs)
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
    options = parser.parse_args()
    main(options.set, options.rigs)
