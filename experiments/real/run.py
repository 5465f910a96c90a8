"""Is what was changed on a measured rig named? `python -m experiments.real.run [--set develop] [--most SECONDS] [-o build/real.jsonl]`

Each pair of `manifest.toml` takes two set-ups of one rig: another payload, arm or gain. The rig is fitted to the logs of the first one.
With all its numbers fixed, it is then given to `rwjax diagnose` with the logs of the second one. The diagnosis sees the rig file and the
logs alone. It is given three runs, of which it leaves each out in turn. The fourth one that was published, `sin_time_square`, is left out of it:
it goes so fast that no fitted set-up follows even its own (the first pair's rig leaves 135 mrad of it, and 0 to 8 of the others). A line is
appended for each pair, with the commit; pairs that the file holds are skipped. The table counts what is claimed: all that was changed, a
part of it, or a name that is wrong.
"""

import argparse
import json
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from experiments.commit import commit
from experiments.realdata import ROOT, need
from experiments.servos.cases import (
    DUTY_PER_RAD,
    ENABLED,
    GOAL,
    LOADS,
    POSITION,
    PUBLISHED,
    SUPPLY,
    rig_file,
)
from experiments.speed.table import machine, show
from rwjax import fit, parse_rig, read_logs
from rwjax.diagnosis.diagnosis import Diagnosis, diagnose
from rwjax.diagnosis.verdict import CLAIMS
from rwjax.fitting.processes import Team
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

MANIFEST = Path(__file__).with_name("manifest.toml")
RUNS = "sin_sin", "lift_and_drop", "up_and_down"
FIRST_LOAD = "L100_m0535"
"""Load of the first guess where a set-up's name says no other."""
SAME_LOAD = {"parameter.axis.inertia": "parameter.motor.inertia"}
"""Names of what the library says is the same thing."""


class Pair(NamedTuple):
    """A line of the manifest."""

    set: str
    data: str
    fitted: str
    given: str
    changed: list[str]

    @property
    def name(self) -> str:
        """What it is called in the results."""
        return f"{self.data}: {self.fitted} to {self.given}"


def pairs() -> list[Pair]:
    """All pairs of the manifest."""
    return [Pair(**line) for line in tomllib.loads(MANIFEST.read_text())["pair"]]


def plain_rig(data: str, setup: str) -> str:
    """Rig file of a set-up before any fit."""
    if data == "unitree_go1_pendulum":
        servo = 'acts_on = "torque"\nkp = 10.0\nkd = 0.3\ndamping_on = "speed"\nlimit = 23.7'
        return rig_file(PUBLISHED[data], servo, "", ['time_s = "time_s"', GOAL, ENABLED, POSITION], LOADS[setup], True)
    load, _, kp = setup.rpartition("kp")
    servo = f'acts_on = "duty"\nkp = {DUTY_PER_RAD[data] * float(kp)}\nperiod = 0.005'
    columns = ['time_s = "time_s"', GOAL, ENABLED, SUPPLY, POSITION]
    return rig_file(PUBLISHED[data], servo, "", columns, LOADS.get(load.rstrip("_"), LOADS[FIRST_LOAD]), False)


def fixed(pair: Pair) -> Rig:
    """The rig as fitted to the first set-up's logs, with every number fixed."""
    rig = parse_rig(plain_rig(pair.data, pair.fitted), f"{pair.fitted}.toml")
    return replace(fit(rig, logs_of(pair.data, pair.fitted, rig)).rig, free=(), prior={})


def logs_of(data: str, setup: str, rig: Rig) -> list[Log]:
    """Those runs of a set-up that were published."""
    files = [need() / data / f"{run}_{setup}.csv" for run in RUNS]
    return read_logs([file for file in files if file.exists()], rig)


def diagnosed(pair: Pair, most: float) -> Diagnosis:
    """What the second set-up's logs are said to lack."""
    rig = fixed(pair)
    with Team() as team:
        return diagnose(rig, logs_of(pair.data, pair.given, rig), budget=most, team=team)


def outcome(verdict: str, sets: Sequence[Sequence[str]], changed: Sequence[str]) -> str:
    """What an answer is worth: `named`, `in part`, `wrong` or the verdict that claims nothing.

    Args:
        verdict: the verdict.
        sets: the named set and its alternatives.
        changed: what was changed.
    """
    if verdict not in CLAIMS:
        return verdict
    right = {*changed, *(SAME_LOAD[name] for name in changed if name in SAME_LOAD)}
    inside = [e for e in sets if {*e} <= right]
    if any(len(e) == len(changed) for e in inside):
        return "named"
    return "in part" if inside else "wrong"


def line(pair: Pair, most: float) -> dict:
    """The result of a pair."""
    begin = perf_counter()
    found = diagnosed(pair, most).json()
    sets = [found["effects"], *found["alternatives"]]
    return {
        **pair._asdict(),
        "commit": commit(),
        "outcome": outcome(found["verdict"], sets, pair.changed),
        **{key: found[key] for key in ("verdict", "complete", "effects", "alternatives", "remarks")},
        **{key: found["gap"][key] for key in ("before", "after", "floor", "closed", "ci95")},
        "ranking": found["ranking"][:10],
        "seconds": round(perf_counter() - begin, 1),
    }


def report(lines: Sequence[dict]) -> None:
    """Prints the table."""
    rows = [
        [
            f"{one['data']}: {one['fitted']} to {one['given']}",
            " + ".join(one["changed"]),
            one["outcome"],
            f"{one['verdict']}: {' + '.join(one['effects']) or '-'}",
            *(f"{1e3 * one[key]:.1f}" for key in ("before", "after", "floor")),
            f"{one['seconds']:.0f}",
        ]
        for one in lines
    ]
    head = ["rig", "changed", "outcome", "answer", "before [mrad]", "after [mrad]", "floor [mrad]", "time [s]"]
    show(f"Measured rigs with a withheld label; {machine()}", head, rows)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="path", type=Path, default=ROOT / "build" / "real.jsonl")
    parser.add_argument("--set", dest="name", choices=("develop", "frozen"), default="develop")
    parser.add_argument("--most", type=float, default=float("inf"), metavar="SECONDS", help="of a diagnosis")
    a = parser.parse_args()
    a.path.parent.mkdir(parents=True, exist_ok=True)
    held = a.path.read_text().splitlines() if a.path.exists() else []
    known = {Pair(*(json.loads(text)[field] for field in Pair._fields)).name for text in held}
    for pair in pairs():
        if pair.set == a.name and pair.name not in known:
            with a.path.open("a") as file:
                file.write(json.dumps(line(pair, a.most)) + "\n")
    report([json.loads(text) for text in a.path.read_text().splitlines()])


if __name__ == "__main__":
    main()
