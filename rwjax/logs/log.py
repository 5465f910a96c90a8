"""The log file (CSV): one run of the rig. `read_log`, `read_logs`, `write_log` and the `Log` between."""

from dataclasses import dataclass, field, replace

import numpy as np


@dataclass(frozen=True, eq=False)
class Log:
    """One run of the rig, or a stretch of it. Arrays have shape (n,), the command of a two-axis rig (n, 2); the input is held
    between samples."""

    name: str  # the file name, as shown to users
    time: np.ndarray  # s, as in the file, strictly increasing
    command: np.ndarray  # V
    outputs: dict[str, np.ndarray]  # by the names of `Column.output`, in SI; NaN where a reading is missing
    resolution: dict[str, float]  # quantisation step of each output in SI; 0.0 where the file holds SI
    notes: dict[str, str]
    validate: bool  # never used to fit or to select
    supply: np.ndarray | None  # V
    origin: float  # s, time of the run's first sample, kept by `cut`
    added: dict[str, float] = field(default_factory=dict)  # known differences of the rig's numbers in this run
    left_out: dict[str, np.ndarray] = field(default_factory=dict)  # times [s] of outliers, which `outputs` do not hold
    earlier: tuple[np.ndarray, np.ndarray] = (np.zeros(0), np.zeros(0))  # time and command before a cut

    def remarks(self) -> list[str]:
        """What a user should know about the readings, one sentence each."""
        return [
            f"{self.name}: outliers among the readings of {name}, which are left out: {len(times)}, the first at {times[0]:.6g} s"
            for name, times in self.left_out.items()
        ]

    def cut(self, first: int, last: int) -> "Log":
        """The samples `first` to `last - 1`; the name says which ("square.csv[12.0 s…]")."""
        first, last, _ = slice(first, last).indices(len(self.time))
        start = f"{self.time[first]:.1f} s" if first > 0 else ""
        end = f"{self.time[last - 1]:.1f} s" if last < len(self.time) else ""
        return replace(
            self,
            name=f"{self.name}[{start}…{end}]" if start or end else self.name,
            time=self.time[first:last],
            command=self.command[first:last],
            outputs={name: y[first:last] for name, y in self.outputs.items()},
            supply=None if self.supply is None else self.supply[first:last],
            left_out=_within(self.left_out, self.time[first], self.time[last - 1]),
            earlier=(
                np.append(self.earlier[0], self.time[:first]),
                after(self.earlier[1], self.command[:first]),
            ),
        )


def after(before: np.ndarray, command: np.ndarray) -> np.ndarray:
    """Samples of a command `(n, …)` with those before them."""
    return np.concatenate([before.reshape(len(before), *command.shape[1:]), command])


def _within(times: dict[str, np.ndarray], first: float, last: float) -> dict[str, np.ndarray]:
    kept = {name: t[(t >= first) & (t <= last)] for name, t in times.items()}
    return {name: t for name, t in kept.items() if len(t)}
