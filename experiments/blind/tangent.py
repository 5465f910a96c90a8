"""How large a small cause is, in floors, without a refit: what it changes in the readings, less what the free numbers can follow.

The free numbers move by one step of least squares on the runs that are fitted; what is left of the runs held out is the size. That is
the end of a refit where readings are linear in the free numbers, as they are about a change of a few floors. There is no noise in it, so
sizes far below a floor can be told. One size takes one free run of every log.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.blind.cases import Prepared, settled
from experiments.blind.oracle import Run, floor, free_run
from experiments.blind.rigs import number, with_number
from experiments.blind.sensors import Recorded, readings
from experiments.blind.sizes import COARSE
from experiments.blind.truth import Truth

STEP = 1e-3  # relative change of a number (angle: rad) of which the derivative is taken
FAR = 1e6  # floors, of a run that runs away


@dataclass(frozen=True)
class Tangent:
    """A rig without effects, and how its readings follow its free numbers."""

    truth: Truth
    records: list[Recorded]
    noise: dict[str, float]  # floor of each column [SI]
    held_out: np.ndarray  # of every reading, whether its run is held out
    column: np.ndarray  # of every reading, the number of its column
    slopes: np.ndarray  # of every reading by each free number [floors per relative change; angle: per rad]

    def size(self, truth: Truth, records: Sequence[Recorded] | None = None, believed: Truth | None = None) -> float:
        """What the rig as `believed` leaves of runs of `truth` once its free numbers have followed, in floors."""
        change = traces(truth, self.records if records is None else records, believed or self.truth, self.noise)
        train = ~self.held_out
        moves = np.linalg.lstsq(self.slopes[train], change[train], rcond=1e-9)[0]
        left = change - self.slopes @ moves
        columns = (left[self.held_out & (self.column == c)] for c in range(len(self.noise)))
        return max(float(np.sqrt(np.mean(one**2))) for one in columns)


def tangent(prepared: Prepared) -> Tangent:
    """The tangent of a rig at its true numbers, which the fit of a rig that lacks nothing would find."""
    rig, noise = prepared.rig, floor(prepared)
    records = [record for record, _ in prepared.runs.values()]
    marks = [validate for _, validate in prepared.runs.values()]
    if not any(marks):
        marks[-1] = True
    slopes = []
    for name in rig.free:
        value = number(rig.truth, name)
        move = STEP if name == "axis.gravity.angle" else STEP * value
        slopes.append(-traces(rig.truth, records, with_number(rig.truth, name, value + move), noise) / STEP)
    lengths = [len(record.at) for record in records]
    return Tangent(
        truth=rig.truth,
        records=records,
        noise=noise,
        held_out=np.repeat(marks, [n * len(noise) for n in lengths]),
        column=np.concatenate([np.repeat(np.arange(len(noise)), n) for n in lengths]),
        slopes=np.stack(slopes, axis=1),
    )


def traces(truth: Truth, records: Sequence[Recorded], believed: Truth, noise: dict[str, float]) -> np.ndarray:
    """Readings of `truth` less free runs of the rig as `believed`, run by run and column by column, in floors."""
    parts = []
    for record in records:
        record = replace(record, start=settled(truth, record.start))
        read = readings(truth, record, noise, COARSE)
        with np.errstate(over="ignore", invalid="ignore"):
            clean = free_run(believed, Run(replace(record, friction=1.0, rumble=0.0), read, False), COARSE)
            parts += [(read[c] - clean[c]) / noise[c] for c in noise]
    return np.clip(np.nan_to_num(np.concatenate(parts), nan=FAR), -FAR, FAR)
