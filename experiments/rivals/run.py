"""Lets every rival name what each labelled case lacks, one JSON line each.

`python -m experiments.rivals.run explore --index 3 17 -o build/rivals.jsonl [--group single none] [--limit N] [--rivals stlsq …]` skips the
cases that the file holds. `experiments.rivals.score` reads the lines.
"""

import argparse
import json
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from experiments.blind.campaign import COPIED, spread
from experiments.blind.cases import make_case, write_case
from experiments.blind.draw import PLANS, appending, cases, read
from experiments.rivals.equations import LENGTHS_S, motion_of
from experiments.rivals.friction_list import friction_list
from experiments.rivals.problem import Problem, pose
from experiments.rivals.selection import forward, lasso, stlsq
from rwjax import fit, read_logs, read_rig
from rwjax.diagnosis.hypothesis import candidates
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

BY_REGRESSION = {"stlsq": stlsq, "lasso": lasso, "forward": forward}
RIVALS = (*BY_REGRESSION, "friction_list")


def split(logs: Sequence[Log]) -> tuple[list[Log], list[Log]]:
    """Logs to fit and logs held out: those marked, else the last one."""
    marked = [log for log in logs if log.validate]
    if marked:
        return [log for log in logs if not log.validate], marked
    return list(logs[:-1]), list(logs[-1:])


def regressions(rig: Rig, train: Sequence[Log], held_out: Sequence[Log]) -> list[Problem]:
    """The regressions of a fitted rig's logs, one for each length of the test functions."""
    runs = [motion_of(rig, log) for log in (*train, *held_out)]
    out = [False] * len(train) + [True] * len(held_out)
    return [pose([replace(m, length=s) for m in runs], out, rig.free, candidates(rig)) for s in LENGTHS_S]


def surest(rival: str, problems: Sequence[Problem]) -> tuple[list[str], float]:
    """Names of a rival, and the share of the squared error that they remove, at the length where that share is largest."""
    found = [(BY_REGRESSION[rival](problem), problem) for problem in problems]
    return max(((names, problem.removed(names)) for names, problem in found), key=lambda one: one[1])


def answers(row: dict, rivals: Sequence[str]) -> list[dict]:
    """The lines of one case, one for each rival."""
    case = make_case(row["kind"], row["effect"], row["seed"], row["amplitude"], raw=False)
    about = {key: row[key] for key in COPIED if key in row} | {"same_as": case.truth["same_as"]}
    with tempfile.TemporaryDirectory() as folder:
        write_case(case, Path(folder))
        rig = read_rig(Path(folder) / "rig.toml")
        train, held_out = split(read_logs(sorted(Path(folder).glob("*.csv")), rig))
    begin = perf_counter()
    fitted = fit(rig, train).rig
    first = perf_counter() - begin
    begin = perf_counter()
    problems = regressions(fitted, train, held_out) if {*rivals} & {*BY_REGRESSION} else []
    posed = perf_counter() - begin
    lines = []
    for rival in rivals:
        begin = perf_counter()
        if rival in BY_REGRESSION:
            (names, sure), spent = surest(rival, problems), first + posed
        else:
            (names, sure), spent = friction_list(fitted, train, held_out), first
        seconds = round(spent + perf_counter() - begin, 2)
        lines.append(about | {"rival": rival, "names": names, "confidence": round(sure, 5), "seconds": seconds})
    return lines


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=PLANS)
    parser.add_argument("-o", dest="path", type=Path, required=True)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--group", nargs="+", choices=("single", "outside", "pair", "none"), default=("single", "none"))
    parser.add_argument("--index", nargs="+", type=int, help="these cases alone")
    parser.add_argument("--rivals", nargs="+", choices=RIVALS, default=RIVALS)
    a = parser.parse_args()
    done = {(line["index"], line["rival"]) for line in read(a.path)}
    wanted = [row for row in cases(a.name) if row["group"] in a.group and (not a.index or row["index"] in a.index)]
    with appending(a.path) as file:
        for row in spread(wanted, a.limit):
            if open_ones := [rival for rival in a.rivals if (row["index"], rival) not in done]:
                file.writelines(json.dumps(line) + "\n" for line in answers(row, open_ones))
                file.flush()


if __name__ == "__main__":
    main()
