"""One more run of a case's rig: a given command, played on the same true rig and read by the same sensors.

The run comes last, so that the case's own logs keep every byte. Where it starts, when it is sampled and its noise depend on the case and
the run's length alone. So two commands of one length, each played as the run after the case's own, differ in nothing else.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from experiments.blind.cases import JITTER, KINDS, Case, Prepared, sampled
from experiments.blind.commands import TICK
from experiments.blind.messy import Mess, case_from, friction, prepared_of
from experiments.blind.sensors import Recorded
from experiments.blind.truth import PSI, THETA

FURTHER = 111  # apart from the random numbers of `cases` and `messy`
NEAR = 0.3  # rad, about the mean angle at which the case's own runs start


def with_run(prepared: Prepared, name: str, record: Recorded, validate: bool = False) -> Prepared:
    """A rig with one more run under a file name of its own; it starts where the rig comes to rest near its start."""
    if name in prepared.runs:
        raise ValueError(f"{name}: there is a run of this name")
    return replace(prepared, runs=prepared.runs | {name: (record, validate)})


def recorded(prepared: Prepared, row: Mapping, command: np.ndarray) -> Recorded:
    """Inputs of a further run of a line's rig, whose command [V] begins with a rest and holds 10 ms a value."""
    rig, seed, count = prepared.rig, row["seed"], len(prepared.runs)
    rng = np.random.default_rng([seed, KINDS.index(rig.kind), FURTHER])
    start = np.zeros(5)
    if rig.kind != "wheel":
        start[PSI] = np.mean([record.start[PSI] for record, _ in prepared.runs.values()]) + rng.uniform(-NEAR, NEAR)
    start[THETA] = rng.uniform(-np.pi, np.pi)
    time = np.arange(len(command)) * TICK
    late = rng.uniform(-JITTER, JITTER, len(time))
    if "mess" not in row:
        return Recorded(time, command, sampled(rig, time, late), start, float(count))
    mess = Mess(**row["mess"])
    late = late + rng.uniform(-mess.jitter, mess.jitter, len(time))
    factor = float(friction(rig.kind, seed, count + 1, mess.friction)[-1])
    return Recorded(time, command, sampled(rig, time, late), start, float(count), factor, mess.torque)


def with_command(row: Mapping, name: str, command: np.ndarray) -> Case:
    """The case of a line of a set with one more run, of a command [V] at 100 Hz, which is there to be fitted."""
    prepared = prepared_of(row)
    return case_from(with_run(prepared, name, recorded(prepared, row, np.round(command, 3))), row)
