"""Plays the proposed next experiment on the simulated rig, and a random one of its length, and diagnoses again with each.

`python -m experiments.played.run [--set fourth] [--cases N] [--index 214 …] [-o build/played.jsonl] [--processes 2 | --scheduler ADDRESS]`

The cases are those whose stored answer (`experiments/blind/results`) is `ambiguous` with a rival that the label does not declare to be the
same thing as the truth. What the oracle calls inseparable stays: it says so of the case's own logs, and a further run is to change that.
Of a set without stored answers every case with a cause of the list is diagnosed, and most lines then say that there was nothing to play.
Both runs go on the same true rig, from the same start and with the same noise. The random command has the largest voltage of the proposed
one. A line is appended for each case; those that the file holds are skipped. The tables are those of `experiments.played.score`.
"""

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from time import perf_counter

from experiments.blind.campaign import run, spread
from experiments.blind.cases import Case, write_case
from experiments.blind.draw import PLANS, cases, read
from experiments.blind.further import with_command
from experiments.blind.messy import case_of
from experiments.commit import commit
from experiments.played.rival import random_command
from experiments.played.score import left_open, outcome, tables
from experiments.realdata import ROOT
from experiments.speed.table import show
from experiments.workers import Workers
from rwjax import read_logs, read_rig
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.planning.experiment import Experiment

RESULTS = ROOT / "experiments" / "blind" / "results"
LOG = "next.csv"
COPIED = ("set", "index", "group", "kind", "effect", "seed", "amplitude", "size")


def wanted(name: str, stored: Sequence[dict]) -> list[dict]:
    """Cases of a set with causes of the list, and where answers are stored only those that these leave open."""
    known = [row for row in cases(name) if row["group"] in ("single", "pair")]
    still = {line["index"] for line in stored if left_open(line, line)}
    return [row for row in known if row["index"] in still] if stored else known


def answered(case: Case, label: dict) -> tuple[dict, str, Experiment | None]:
    """The answer to a case, what it says of the next experiment, and its command where one can be played."""
    begin = perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        write_case(case, Path(folder))
        try:
            rig = read_rig(Path(folder) / "rig.toml")
            found = diagnose(rig, read_logs(sorted(Path(folder).glob("*.csv")), rig))
        except Exception as error:  # whatever it is, it belongs to this case and not to the campaign
            failed = {"error": f"{type(error).__name__}: {error}", "seconds": round(perf_counter() - begin, 2)}
            return failed | {"outcome": "error"}, "", None
    kept = {key: found.json()[key] for key in ("verdict", "effects", "alternatives")}
    answer = kept | {"outcome": outcome(kept, label), "seconds": round(perf_counter() - begin, 2)}
    return answer, found.next_experiment, found.proposal.runs[0].experiment if found.proposal else None


def played(row: dict) -> dict:
    """One case's line: the answer before, after the proposed run and after a random one, None where none was played."""
    begin, case = perf_counter(), case_of(row)
    line = {key: row[key] for key in COPIED if key in row} | {"same_as": case.truth["same_as"], "commit": commit()}
    before, sentence, experiment = answered(case, line)
    line |= {"before": before, "proposal": sentence, "experiment": None, "proposed": None, "random": None}
    if experiment is not None and left_open(before, line):
        _, volts = experiment.command()
        family, other = random_command(volts.round(3), row["seed"])
        line |= {"experiment": asdict(experiment), "random_command": family}
        line["proposed"], _, _ = answered(with_command(row, LOG, volts), line)
        line["random"], _, _ = answered(with_command(row, LOG, other), line)
    return line | {"seconds": round(perf_counter() - begin, 2)}


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", dest="name", choices=PLANS, default="fourth")
    parser.add_argument("--cases", type=int, help="at most so many, evenly over those that are open")
    parser.add_argument("--index", nargs="+", type=int, help="these cases alone")
    parser.add_argument("-o", dest="path", type=Path, default=ROOT / "build" / "played.jsonl")
    Workers.options(parser)
    a = parser.parse_args()
    if {line["set"] for line in read(a.path)} - {a.name}:
        parser.error(f"{a.path} holds cases of another set")
    rows = [
        row for row in wanted(a.name, read(RESULTS / f"{a.name}.jsonl")) if a.index is None or row["index"] in a.index
    ]
    run(spread(rows, a.cases), a.path, Workers.of(a), played)
    for table in tables(read(a.path)):
        show(*table)


if __name__ == "__main__":
    main()
