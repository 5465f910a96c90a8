"""Does `ci95` hold what fresh runs of the rig close? `python -m experiments.promised [--set fourth] [--cases 60] [-o build/promised.jsonl]`

The cases are those of a set whose stored answer (`experiments/blind/results`) names what is missing and has a `ci95`. Each is diagnosed again.
Then its rig runs further, under commands drawn like its own, that the diagnosis has not seen. Their errors with the rig as it is and with the corrected
one say which share of the gap is closed there, all runs together. A line is appended for each case; those that the file holds are skipped.
"""

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

from experiments.blind.campaign import run, spread
from experiments.blind.cases import TRAINING, Case, split, write_case
from experiments.blind.commands import command
from experiments.blind.draw import PLANS, cases, read
from experiments.blind.further import recorded, with_run
from experiments.blind.messy import case_from, prepared_of
from experiments.blind.score import share
from experiments.commit import commit
from experiments.realdata import ROOT
from experiments.speed.table import machine, show
from experiments.workers import Workers
from rwjax import diagnose, predict, read_logs, read_rig
from rwjax.diagnosis.gap import closure
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

RESULTS = ROOT / "experiments" / "blind" / "results"
RUNS, SECONDS = 12, (10.0, 15.0)  # fresh runs of a case, and their length [s] as that of its own
FRESH = 311  # apart from other random numbers of a case


def fresh_names(count: int) -> list[str]:
    """Names of the fresh runs' files, behind those of the case."""
    return [f"zz_fresh_{k:02d}.csv" for k in range(count)]


def with_fresh_runs(row: dict, count: int = RUNS) -> Case:
    """The case of a line with further runs under commands of the families and sizes of its own."""
    prepared, rng = prepared_of(row), np.random.default_rng([row["seed"], FRESH])
    for name in fresh_names(count):
        top = prepared.rig.top * float(rng.choice([1.0, 1.0, rng.uniform(0.5, 1.0)]))
        volts = command(str(rng.choice(TRAINING)), float(rng.uniform(*SECONDS)), top, rng)
        prepared = with_run(prepared, name, recorded(prepared, row, volts))
    return case_from(prepared, row)


def rms(rig: Rig, logs: Sequence[Log], signal: str) -> float:
    """RMS error of a rig's free runs over logs [SI]."""
    square = [(log.outputs[signal] - predict(rig, log)[signal]) ** 2 for log in logs]
    return float(np.sqrt(np.nanmean(np.concatenate(square))))


def kept(row: dict) -> dict:
    """One case's line: what the diagnosis promises of new runs, and what they close."""
    begin, case = perf_counter(), with_fresh_runs(row)
    line = {key: row[key] for key in ("set", "index", "kind", "effect")} | {"commit": commit()}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_case(case, folder)
        fresh = [folder / name for name in fresh_names(RUNS)]
        rig = read_rig(folder / "rig.toml")
        found = diagnose(rig, read_logs(sorted({*folder.glob("*.csv")} - {*fresh}), rig))
        logs, gap = read_logs(fresh, rig), found.gaps[found.signal]
    as_it_is = rig.with_values({name: value for name, (value, _) in found.waterfall[0].numbers.items()})
    before, after = (rms(one, logs, found.signal) for one in (as_it_is, found.corrected))
    return line | {
        "verdict": found.verdict,
        "effects": list(found.effects),
        "closed": gap.closed,
        "ci95": gap.ci95,
        "fresh": closure(before, after, gap.floor),
        **{"before": before, "after": after, "floor": gap.floor},
        "seconds": round(perf_counter() - begin, 1),
    }


def wanted(name: str) -> list[dict]:
    """Cases whose stored answer names what is missing, all large causes and no other, and promises something of new runs."""
    stored = {line["index"]: line for line in read(RESULTS / f"{name}.jsonl")}
    return [
        row for row in cases(name) if (line := stored.get(row["index"])) and line.get("ci95") and names_the_truth(line)
    ]


def held(line: dict) -> bool | None:
    """Whether `ci95` holds what fresh runs close; None of an answer that does not name the truth, or promises nothing."""
    if line["ci95"] is None or line["fresh"] is None or not names_the_truth(line):
        return None
    low, high = line["ci95"]
    return low <= line["fresh"] <= high


def names_the_truth(line: dict) -> bool:
    """Whether an answer names all large causes and no other."""
    return {*line["effects"]} == {*split(line["effect"])}


def report(lines: Sequence[dict]) -> None:
    """Prints how often the interval holds what fresh runs close, by kind of rig."""
    told = [line for line in lines if held(line) is not None]
    rows = []
    for kind in (*dict.fromkeys(line["kind"] for line in told), "all"):
        of = [line for line in told if kind in (line["kind"], "all")]
        low = sum(line["fresh"] < line["ci95"][0] for line in of)
        inside = sum(bool(held(line)) for line in of)
        rows.append([kind, f"{len(of)}", share(inside, len(of)), f"{low}", f"{len(of) - low - inside}"])
    head = ["kind", "cases", "ci95 holds what fresh runs close", "they close less", "they close more"]
    show(f"{RUNS} fresh runs of each rig; {machine()}", head, rows)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", dest="name", choices=PLANS, default="fourth")
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("-o", dest="path", type=Path, default=ROOT / "build" / "promised.jsonl")
    Workers.options(parser)
    a = parser.parse_args()
    run(spread(wanted(a.name), a.cases), a.path, Workers.of(a), kept)
    report([*read(a.path)])


if __name__ == "__main__":
    main()
