"""Stops diagnoses at random moments: is every answer whole, and does one name what the full diagnosis does not?

`python -m experiments.anytime.run [--stops 100] [--each 4] [-o build/anytime.jsonl] [--processes 2 | --scheduler ADDRESS]` takes simulated cases spread over
a set. Each is diagnosed once to its end by `rwjax diagnose --budget inf`, and then stopped `--each` times, by Ctrl-C and by a budget
in turn, at moments drawn evenly over the time that the whole command took. It skips the cases that the file holds already, and ends
with the counts. Stopped by Ctrl-C before its search, a command writes nothing and says one line; that is counted apart.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

import numpy as np

from experiments.blind.campaign import run, spread
from experiments.blind.cases import make_case, write_case
from experiments.blind.draw import SETS, read
from experiments.workers import Workers

CLAIMS = ("effect", "ambiguous", "partial")
INTERRUPTED = 130  # status after Ctrl-C
SMALLEST_BUDGET = 0.1  # s
ROOT = Path(__file__).parents[2]


def hears_ctrl_c() -> None:
    """Lets a command hear Ctrl-C even where the campaign was begun in the background."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def called(folder: Path, budget: float, ctrl_c_s: float | None) -> dict:
    """What `rwjax diagnose` gives in a folder with a case, interrupted after so many seconds where any are given."""
    logs, begin = sorted(path.name for path in folder.glob("*.csv")), perf_counter()
    options = ("--json", "--quiet", "--force", "--budget", str(budget))
    with tempfile.TemporaryDirectory() as out:
        process = subprocess.Popen(
            [*(sys.executable, "-m", "rwjax", "diagnose", "rig.toml", *logs), *options, "-o", f"{out}/diagnosis"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            preexec_fn=hears_ctrl_c,
        )
        try:
            said, told = process.communicate(timeout=ctrl_c_s)
            stopped = 0.0
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
            stopped = perf_counter()
            said, told = process.communicate()
        end = perf_counter()
        found = {"status": process.returncode, "seconds": round(end - begin, 2)}
        found |= {"after_s": round(end - stopped, 2)} if stopped else {}
        return found | answer(Path(out) / "diagnosis", said, told.decode(errors="replace"))


def answer(folder: Path, said: bytes, told: str) -> dict:
    """What a command has left: its answer, nothing and a line, or what is wrong."""
    if not folder.exists():
        return {"answer": None} if not said and told.count("\n") == 1 else {"wrong": f"no answer: {told[-300:]}"}
    try:
        found = json.loads((folder / "diagnosis.json").read_text())
        if found != json.loads(said):
            return {"wrong": "the file and stdout differ"}
        missing = [name for name in ("corrected.toml", "report.html") if not (folder / name).stat().st_size]
        keys = ("verdict", "complete", "untried", "effects", "alternatives")
        return {"wrong": f"empty: {missing}"} if missing else {"answer": {key: found[key] for key in keys}}
    except (OSError, ValueError, KeyError) as error:
        return {"wrong": f"{type(error).__name__}: {error}"}


def claimed(found: dict | None) -> set[str]:
    """Names that an answer claims."""
    if not found or found["verdict"] not in CLAIMS:
        return set()
    return {*found["effects"], *(name for names in found["alternatives"] for name in names)}


def stopped(row: dict) -> dict:
    """One case's line: its full diagnosis, and what it gave at every stop."""
    case, rng = (
        make_case(row["kind"], row["effect"], row["seed"], row["amplitude"], raw=False),
        np.random.default_rng(row["seed"]),
    )
    line = {key: row[key] for key in ("index", "kind", "effect", "seed")}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_case(case, folder)
        called(folder, np.inf, None)  # which compiles what is not there yet
        full = called(folder, np.inf, None)
        stops = []
        for k in range(row["each"]):
            moment = float(rng.uniform(0.0, full["seconds"]))
            budget, ctrl_c = (np.inf, moment) if k % 2 == 0 else (max(moment, SMALLEST_BUDGET), None)
            found = called(folder, budget, ctrl_c)
            withdrawn = sorted(claimed(found.get("answer")) - claimed(full.get("answer")))
            stops.append(
                {"by": "budget" if k % 2 else "Ctrl-C", "at_s": round(moment, 2), **found, "withdrawn": withdrawn}
            )
    return line | {"full": full, "stops": stops}


def counts(lines: list[dict]) -> Iterator[tuple[str, int]]:
    """What the stops have given.

    Yields:
        A count with its words.
    """
    stops = [(line["full"], stop) for line in lines for stop in line["stops"]]
    answers = [(full, stop) for full, stop in stops if stop.get("answer")]
    yield "stops", len(stops)
    yield "that gave an answer, whole and the same in file and on stdout", len(answers)
    yield (
        "that came before the search: no file, one line, status 130",
        sum("wrong" not in s and not s.get("answer") and s["status"] == INTERRUPTED for _, s in stops),
    )
    yield (
        "with anything wrong",
        sum(
            "wrong" in s or (not s.get("answer") and s["status"] != INTERRUPTED) or s["status"] not in (0, INTERRUPTED)
            for _, s in stops
        ),
    )
    yield "answers that say `complete`: false", sum(not s["answer"]["complete"] for _, s in answers)
    yield "answers that name what the full diagnosis does not", sum(bool(s["withdrawn"]) for _, s in answers)
    unfinished = [
        (f["answer"], s["answer"]) for f, s in answers if not s["answer"]["complete"] and claimed(f["answer"])
    ]
    yield "unfinished ones of cases with a named cause", len(unfinished)
    yield "whose leader is in the full answer", sum(bool({*s["effects"]} & claimed(f)) for f, s in unfinished)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--stops", type=int, default=100)
    parser.add_argument("--each", type=int, default=4, help="stops of one case")
    parser.add_argument("--set", default="explore")
    parser.add_argument("--group", default="single")
    parser.add_argument("-o", dest="path", type=Path, default=Path("build/anytime.jsonl"))
    Workers.options(parser)
    a = parser.parse_args()
    every = [row for row in read(SETS / f"{a.set}.jsonl") if row.get("seed") is not None and row["group"] == a.group]
    rows = [row | {"each": a.each} for row in spread(every, -(-a.stops // a.each))]
    a.path.parent.mkdir(parents=True, exist_ok=True)
    run(rows, a.path, Workers.of(a), stopped)
    lines = list(read(a.path))
    for words, count in counts(lines):
        print(f"{count:4d} {words}")
    waits = sorted(stop["after_s"] for line in lines for stop in line["stops"] if "after_s" in stop)
    if waits:
        print(f"seconds from Ctrl-C to the end: median {waits[len(waits) // 2]:.1f}, most {waits[-1]:.1f}")


if __name__ == "__main__":
    main()
