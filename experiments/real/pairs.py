"""Pairs of set-ups: the rig as it was fitted to the first one, and the logs of the second one."""

import tomllib
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

from experiments.real.setups import SETS
from rwjax import fit
from rwjax.logs.log import Log
from rwjax.rig.model import Driven, Rig

MANIFEST = Path(__file__).with_name("manifest.toml")
FRICTION = "axis.friction.viscous", "axis.friction.coulomb"
"""Numbers that change with load, wear and temperature."""


class Pair(NamedTuple):
    """A line of the manifest.

    Attributes:
        set: "develop" or "frozen".
        data: Folder of the published logs.
        fitted: Set-up that the rig is fitted to.
        given: Set-up whose logs are diagnosed.
        changed: Names of what differs, none where nothing does.
        given_data: Folder of the given set-up where it is another one.
        fitted_runs: Runs that are fitted, those of `SETS` where none are named.
        given_runs: Runs that are diagnosed, likewise.
        withheld: Columns that the given logs lose, though they were logged.
        told: Numbers that the rig file has right for the given set-up, though they differ.
        free: Numbers that the rig file leaves free.
    """

    set: str
    data: str
    fitted: str
    given: str
    changed: list[str]
    given_data: str = ""
    fitted_runs: tuple[str, ...] = ()
    given_runs: tuple[str, ...] = ()
    withheld: tuple[str, ...] = ()
    told: tuple[str, ...] = ()
    free: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """What it is called in the results."""
        first = f"{self.data}: {' '.join([self.fitted, *self.fitted_runs])}"
        second = " ".join([*([self.given_data] if self.given_data else []), self.given, *self.given_runs])
        known = ("without", self.withheld), ("told", self.told), ("free", self.free)
        return f"{first} to {second}" + "".join(f" {word} {', '.join(names)}" for word, names in known if names)


def pairs() -> list[Pair]:
    """All pairs of the manifest."""
    lines = tomllib.loads(MANIFEST.read_text())["pair"]
    several = "fitted_runs", "given_runs", "withheld", "told"
    return [Pair(**line | {name: tuple(line[name]) for name in several if name in line}) for line in lines]


def with_friction_free(pair: Pair) -> Pair:
    """The pair with a rig file that leaves the axis's friction free, as whoever knows that friction changes would write it.

    What is to be named stays fixed.
    """
    known = {*SETS[pair.data].rig(pair.fitted).values} - {name.removeprefix("parameter.") for name in pair.changed}
    return pair._replace(free=tuple(name for name in FRICTION if name in known))


def rig_of(pair: Pair) -> Rig:
    """The rig as fitted to the first set-up's logs, with every number fixed that the pair does not leave free."""
    return replace(fitted(pair.data, pair.fitted, pair.fitted_runs), free=pair.free)


@cache
def fitted(data: str, setup: str, runs: tuple[str, ...]) -> Rig:
    """A set-up's rig as fitted to runs of it, with every number fixed."""
    rig = SETS[data].rig(setup)
    found = fit(rig, SETS[data].logs(data, setup, rig, runs)).rig
    return replace(found, free=(), prior={}, driven=Driven())


def own(pair: Pair, rig: Rig) -> Sequence[Log]:
    """The logs that a pair's rig was fitted to."""
    return SETS[pair.data].logs(pair.data, pair.fitted, rig, pair.fitted_runs)


def given(pair: Pair, rig: Rig) -> tuple[Rig, Sequence[Log]]:
    """A fitted rig and the second set-up's logs as they are diagnosed.

    Where the supply is withheld, the rig file holds the voltage that was read before the runs, the mean of their first readings.
    """
    data = pair.given_data or pair.data
    logs = SETS[data].logs(data, pair.given, rig, pair.given_runs)
    right = SETS[data].rig(pair.given).numbers
    rig = rig.with_values({name: right[name] for name in pair.told})
    if "supply_V" in pair.withheld:
        first = [float(log.supply[0]) for log in logs if log.supply is not None]
        rig = replace(rig, numbers=rig.numbers | {"drive.supply": sum(first) / len(first)})
        logs = [replace(log, supply=None) for log in logs]
    return rig, logs
