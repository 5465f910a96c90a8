"""The set-ups of the measured rigs: the rig file of each before any fit, as its owner would write it, and its runs."""

import tempfile
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from experiments.questions.measured import SOURCES, rig_of, runs_of
from experiments.realdata import need
from experiments.servos.cases import (
    DUTY_PER_RAD,
    ENABLED,
    GOAL,
    LOADS,
    POSITION,
    PUBLISHED,
    SUPPLY,
    cases,
    rig_file,
)
from rwjax import parse_rig, read_logs
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

ESTIMATED = (
    "axis.inertia",
    "axis.friction.viscous",
    "axis.friction.coulomb",
    "axis.gravity.torque",
    "wheel.inertia",
    "motor.friction",
)
"""Numbers that a plain fit estimates where a rig file holds them."""


class Joints(NamedTuple):
    """Set-ups of which each has files of its own.

    Attributes:
        text: Text of a set-up's rig file.
        runs: Runs that are taken where no others are asked for.
        file: Name of a run's file.
    """

    text: Callable[[str], str]
    runs: tuple[str, ...]
    file: str = "{run}_{setup}.csv"

    def rig(self, setup: str) -> Rig:
        """A set-up's rig before any fit."""
        return parse_rig(self.text(setup), f"{setup}.toml")

    def logs(self, data: str, setup: str, rig: Rig, runs: Collection[str]) -> Sequence[Log]:
        """Runs of a set-up, those of them that were published."""
        files = [need() / data / self.file.format(run=run, setup=setup) for run in runs or self.runs]
        return read_logs([file for file in files if file.exists()], rig)


class Servos(NamedTuple):
    """A servo under several loads at several gains.

    A set-up is a load with a gain, such as `L100_m0535_kp16`. A load alone takes the runs at every gain, and a gain alone (`kp16`) those of
    every load: what differs from the rig file of the first of them is known run by run, as by notes such as `# add drive.servo.kp: 2.6`.

    Attributes:
        data: Folder of its logs.
        loads: Names of its loads.
        gains: Its gains, as the names of its files say them.
    """

    data: str
    loads: tuple[str, ...]
    gains: tuple[str, ...]

    def _members(self, setup: str) -> list[str]:
        """The loads with a gain that a set-up holds."""
        every = [f"{load}_{gain}" for load in self.loads for gain in self.gains]
        return [one for one in every if setup in (one, *one.rsplit("_", 1))]

    def _rig_of(self, member: str) -> Rig:
        load, _, kp = member.rpartition("_kp")
        return parse_rig(_by_duty(self.data, LOADS[load], kp), f"{member}.toml")

    def rig(self, setup: str) -> Rig:
        """A set-up's rig before any fit, that of the first load or gain where it holds several."""
        return self._rig_of(self._members(setup)[0])

    def logs(self, data: str, setup: str, rig: Rig, runs: Collection[str]) -> Sequence[Log]:
        """Runs of a set-up, those of them that were published."""
        first, found = self.rig(setup), list[Log]()
        told = {name: value for name, value in first.numbers.items() if name not in first.free}
        for member in self._members(setup):
            files = [need() / data / f"{run}_{member}.csv" for run in runs or THREE]
            own = self._rig_of(member).numbers
            differs = {name: own[name] - value for name, value in told.items() if own[name] != value}
            found += [
                replace(log, added=log.added | differs) for log in read_logs([f for f in files if f.exists()], rig)
            ]
        return found


class Plain(NamedTuple):
    """A rig of `experiments.questions.measured` with every number free, the same in all of its files.

    Attributes:
        name: Its name there.
        added: Numbers and effects that a set-up's file holds besides [SI], by the set-up.
    """

    name: str
    added: Mapping[str, dict[str, float]] = MappingProxyType({})

    def rig(self, setup: str) -> Rig:
        """The rig before any fit."""
        rig, added = rig_of(self.name), self.added.get(setup, {})
        numbers = {name: value for name, value in added.items() if name != "axis.bias_torque.T"}
        if len(numbers) < len(added):
            rig = replace(rig, effects={"axis.bias_torque": {"T": added["axis.bias_torque.T"]}})
        rig = replace(rig, numbers=rig.numbers | numbers)
        return replace(rig, free=tuple(name for name in rig.values if name in (*ESTIMATED, *added)))

    def logs(self, data: str, setup: str, rig: Rig, runs: Collection[str]) -> Sequence[Log]:
        """Runs by the names of their files, all of them where none are asked for."""
        with tempfile.TemporaryDirectory() as folder:
            every = runs_of(self.name, rig, Path(folder))
        return [log for log in every if not runs or Path(log.name).stem.removeprefix(f"{data}_") in runs]


def _by_duty(data: str, load: tuple[float, float], kp: str) -> str:
    """A servo whose own loop gives a duty, with a load [kg m2, N m] at a gain as its files say it."""
    servo = f'acts_on = "duty"\nkp = {DUTY_PER_RAD[data] * float(kp)}\nperiod = 0.005'
    columns = ['time_s = "time_s"', GOAL, ENABLED, SUPPLY, POSITION]
    return rig_file(PUBLISHED[data], servo, "", columns, load, False)


def _by_torque(data: str, loads: dict[str, tuple[float, float]], setup: str) -> str:
    """A motor whose own loop gives a torque; the set-up is its load."""
    servo = 'acts_on = "torque"\nkp = 10.0\nkd = 0.3\ndamping_on = "speed"\nlimit = 23.7'
    return rig_file(PUBLISHED[data], servo, "", ['time_s = "time_s"', GOAL, ENABLED, POSITION], loads[setup], True)


def _of_case(data: str, setup: str) -> str:
    """A joint of `experiments.servos.cases`."""
    return next(case.rig for case in cases() if (case.data, case.name) == (data, setup))


THREE = "sin_sin", "lift_and_drop", "up_and_down"
"""Runs of the pendulums. A fourth, `sin_time_square`, goes so fast that no fitted Feetech follows even its own."""
SETS: dict[str, Joints | Servos | Plain] = {
    "feetech_sts3215_pendulum": Servos(
        "feetech_sts3215_pendulum",
        ("L100_m0535", "L100_m0741", "L100_m1168", "L150_m0535", "L150_m0741", "L150_m1168"),
        ("kp16", "kp04", "kp32"),
    ),
    "feetech_sts3250_pendulum": Servos(
        "feetech_sts3250_pendulum", ("L100_m0535", "L100_m1168", "L150_m0535", "L150_m1168"), ("kp08", "kp32")
    ),
    "bam_xl330_pendulum": Joints(
        lambda setup: _by_duty("bam_xl330_pendulum", (0.0049, 0.4807), setup.removeprefix("kp")), THREE
    ),
    "unitree_go1_pendulum": Joints(partial(_by_torque, "unitree_go1_pendulum", LOADS), THREE),
    "so101_arm": Joints(
        partial(_of_case, "so101_arm"), ("backlash_detection", "friction_gravity", "static_holding"), "{run}.csv"
    ),
    "emps": Plain("emps", {"four terms": {"axis.friction.coulomb": 10.0, "axis.bias_torque.T": 0.0}}),
    "dcmotor_deadzone_l298n": Plain("dcmotor"),
    **{source.files.split("/")[0]: Plain(name) for name, source in SOURCES.items()},
}
"""What of each folder of the published logs can be simulated."""
