"""What is said of every set of published logs, from a plain rig file. `python -m experiments.real.sets [--only NAME] [-o build/sets.jsonl]`

Each set is diagnosed with the rig file that its owner would write from data sheets, its numbers free, and with runs held out. Beside the
answer stand what a plain baseline leaves of the same held-out runs (`arx.py`), and what the authors say of their rig (`published.toml`). A
line is appended for each set, with the commit; sets that the file holds are skipped. Those of which nothing can be simulated are listed
with the reason.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

from experiments.commit import commit
from experiments.real.arx import best, square_errors
from experiments.real.published import PUBLISHED
from experiments.real.setups import SETS
from experiments.realdata import ROOT
from experiments.speed.table import machine, show
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.fitting.processes import Team
from rwjax.fitting.segments import with_segments
from rwjax.logs.driven import driven
from rwjax.logs.held_out import folds
from rwjax.logs.log import Log
from rwjax.logs.segments import cut_up
from rwjax.rig.model import Rig


def baseline(rig: Rig, logs: Sequence[Log], signal: str) -> float:
    """Free-run RMS error of linear difference equations on the data that the diagnosis holds out [SI].

    Args:
        rig: The rig, which decides whether runs are followed whole or in segments.
        logs: Its logs.
        signal: Output that is judged.

    Returns:
        The error.
    """
    rig, logs = driven(rig, logs)
    square = [
        square_errors(found, log, signal)
        for fold in folds(with_segments(rig, logs))[1]
        for found in [best(cut_up(fold.train), signal)]
        for log in cut_up(fold.test)
    ]
    return float(np.sqrt(np.nanmean(np.concatenate(square))))


def line(data: str, most: float) -> dict:
    """The result of a set."""
    said = PUBLISHED[data]
    told = {"data": data, "commit": commit(), "source": said.source}
    if said.reason:
        return told | {"verdict": "not asked", "reason": said.reason}
    rig = SETS[data].rig(said.setup)
    logs = SETS[data].logs(data, said.setup, rig, said.runs)
    begin = perf_counter()
    with Team() as team:
        found = diagnose(rig, logs, budget=most, team=team).json()
    seconds = perf_counter() - begin
    sets, gap = [found["effects"], *found["alternatives"]], found["gap"]
    return {
        **told,
        "setup": said.setup,
        "logs": [log.name for log in logs],
        **{
            key: found[key]
            for key in ("verdict", "complete", "effects", "alternatives", "refused", "remarks", "held_out")
        },
        "published": said.present,
        "ruled_out": said.contradict,
        "beside_published": said.says(found["verdict"], sets),
        **{key: gap[key] for key in ("signal", "before", "after", "floor", "closed", "ci95")},
        "baseline": baseline(rig, logs, gap["signal"]),
        "ranking": found["ranking"][:10],
        "seconds": round(seconds, 1),
    }


def report(lines: Sequence[dict]) -> None:
    """Prints the table."""
    rows = [
        [one["data"], "not asked: " + one["reason"], *["-"] * 8]
        if "reason" in one
        else [
            f"{one['data']} {one['setup']}",
            f"{one['verdict']}: {' or '.join(' + '.join(e) for e in [one['effects'], *one['alternatives']]) or '-'}",
            one["beside_published"],
            one["signal"],
            *(f"{one[key]:.3g}" for key in ("before", "after", "floor", "baseline")),
            one["held_out"],
            f"{one['seconds']:.0f}",
        ]
        for one in lines
    ]
    head = [
        "set",
        "answer",
        "beside what is published",
        "signal",
        "before",
        "after",
        "floor",
        "ARX",
        "held out",
        "time [s]",
    ]
    show(f"Published logs from plain rig files, errors in SI; {machine()}", head, rows)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="path", type=Path, default=ROOT / "build" / "sets.jsonl")
    parser.add_argument("--only", nargs="+", choices=PUBLISHED, default=list(PUBLISHED), metavar="NAME")
    parser.add_argument("--most", type=float, default=float("inf"), metavar="SECONDS", help="of a diagnosis")
    a = parser.parse_args()
    a.path.parent.mkdir(parents=True, exist_ok=True)
    held = a.path.read_text().splitlines() if a.path.exists() else []
    known = {json.loads(text)["data"] for text in held}
    for data in a.only:
        if data not in known:
            with a.path.open("a") as file:
                file.write(json.dumps(line(data, a.most)) + "\n")
    report([json.loads(text) for text in a.path.read_text().splitlines()])


if __name__ == "__main__":
    main()
