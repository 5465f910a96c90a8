"""What a simulated run looks like to a user: outputs by name over time."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jax.tree_util import register_dataclass

from rwjax.logs.log import Log
from rwjax.plant.structure import Structure
from rwjax.rig.columns import unit_of
from rwjax.simulation.batch import Batch


@dataclass(frozen=True, eq=False)
class Trajectory(Mapping[str, Any]):
    """A simulated run: a mapping from each output's name to its values; arrays of JAX where JAX traces it.

    Attributes:
        name: What was simulated: the rig's name, or the log's.
        time: Times `(n,)` [s].
        outputs: Values `(n,)` of each output at these times, by names as `yaw_rad` and in the unit that the name ends with.
    """

    name: str
    time: Any
    outputs: dict[str, Any]

    def __getitem__(self, output: str) -> Any:
        """Values of one output `(n,)` [rad, rad/s or A]."""
        if output not in self.outputs:
            raise KeyError(f"no output `{output}`; this run has {', '.join(self.outputs)}")
        return self.outputs[output]

    def __iter__(self) -> Iterator[str]:
        """Names of the outputs, in the order of the kind of rig."""
        return iter(self.outputs)

    def __len__(self) -> int:
        """How many outputs there are."""
        return len(self.outputs)

    def __eq__(self, other: object) -> bool:
        """Whether another run has the same name and exactly the same values."""
        return (
            isinstance(other, Trajectory)
            and (self.name, *self) == (other.name, *other)
            and np.array_equal(self.time, other.time)
            and all(np.array_equal(self[y], other[y], equal_nan=True) for y in self)
        )

    def __str__(self) -> str:
        """Name, duration and samples, and the range of each output, one line each."""
        width = max((len(y) for y in self), default=0)
        lines = [f"{self.name}: {self.duration:.4g} s, {len(self.time)} samples"]
        lines += [
            f"  {y:<{width}}  {np.nanmin(v):.4g} to {np.nanmax(v):.4g} {unit_of(y)}" for y, v in self.outputs.items()
        ]
        return "\n".join(lines)

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def columns(self) -> dict[str, Any]:
        """Columns of a table: `time_s`, then the outputs, each `(n,)`."""
        return {"time_s": self.time, **self.outputs}


register_dataclass(Trajectory, data_fields=["time", "outputs"], meta_fields=["name"])


def trajectory_of(structure: Structure, batch: Batch, log: Log, readings: Any) -> Trajectory:
    """Run of one log from the readings of a free run.

    Args:
        structure: What the plant is made of.
        batch: The log as it was simulated, alone.
        log: The log.
        readings: Its readings by window and slot `(w, q, y)` [rad, rad/s or A].

    Returns:
        All outputs of the kind of rig at the log's times.
    """
    slots = batch.slot_sample.ravel()
    slot_of = np.argsort(np.where(slots < 0, len(slots), slots))[: len(log.time)]
    values = readings.reshape(-1, len(structure.outputs))[slot_of]
    return Trajectory(log.name, log.time, {y: values[:, j] for j, y in enumerate(structure.outputs)})
