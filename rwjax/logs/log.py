"""A log in memory: one run of the rig, or a stretch of it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rwjax.errors import InputError, LogError, nearest, printable, refuses_other_types
from rwjax.logs.array_sheet import ArraySheet
from rwjax.logs.fields import fields_of
from rwjax.logs.frame_sheet import frame_sheet
from rwjax.rig.columns import COLUMNS, COMMANDS, unit_of
from rwjax.rig.model import Rig

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

OUTPUTS = tuple(dict.fromkeys(column.output for column in COLUMNS.values()))
"""Names of everything that a log may hold as a reading."""


class Segments(NamedTuple):
    """How a run is followed by free runs: as a whole, or in segments each of which starts anew.

    Attributes:
        seconds: Length of a segment [s], infinite for whole runs.
        why: Why runs are cut, as a clause; empty for whole runs.
        number: Which segment of its run a log is, 0 for a whole run and for the first.
    """

    seconds: float = math.inf
    why: str = ""
    number: int = 0


@dataclass(frozen=True, eq=False)
class Log:
    """One run of the rig, or a stretch of it, with `n` samples. The command, as all that was given, is held between samples.

    Attributes:
        name: The file name, as shown to users.
        time: Time [s] (n,), as in the file, strictly increasing.
        command: What was given, in the unit of `input` (n,); of a two-axis rig (n, 2) [V].
        outputs: Readings [SI] (n,) by the names of `Column.output`; NaN where a reading is missing.
        resolution: Size of a count [SI] of each output; 0.0 where the file holds SI.
        notes: The notes above the header, by key in small letters.
        validate: Whether the log is kept out of every fit and every choice.
        supply: Voltage of the supply [V] (n,), None where it was not logged.
        origin: Time [s] of the run's first sample, kept by `cut`.
        added: Known differences [SI] of the rig's numbers in this run, by name.
        left_out: Times [s] of the outliers of each output, which are NaN in `outputs`.
        earlier: Time [s] (m,) and command (m,) or (m, 2) of the run's samples before a cut.
        input: Column of the command, one of `columns.COMMANDS`.
        enabled: Whether torque was on (n,), None where it always was.
        acting: What a servo gave its drive (n,) [V, 1, A or N m], worked out from the readings; None where the command says it.
        segments: How free runs follow the run; None where that is not decided.
    """

    name: str
    time: np.ndarray
    command: np.ndarray
    outputs: dict[str, np.ndarray]
    resolution: dict[str, float]
    notes: dict[str, str]
    validate: bool
    supply: np.ndarray | None
    origin: float
    added: dict[str, float] = field(default_factory=dict)
    left_out: dict[str, np.ndarray] = field(default_factory=dict)
    earlier: tuple[np.ndarray, np.ndarray] = (np.zeros(0), np.zeros(0))
    input: str = "voltage_V"
    enabled: np.ndarray | None = None
    acting: np.ndarray | None = None
    segments: Segments | None = None

    @property
    def at_drive(self) -> np.ndarray:
        """What the drive was given (n,), of a two-axis rig (n, 2): the command, or as nearly as readings tell what a servo gave."""
        return self.command if self.acting is None else self.acting

    @property
    def goes_on(self) -> bool:
        """Whether it is a segment that goes on from the one before it, in a state that no run begins in."""
        return self.segments is not None and self.segments.number > 0

    def __post_init__(self) -> None:
        """Checks that the arrays belong together, that time goes on, and that command and readings have names that mean something.

        Raises:
            LogError: With the log's name, what is wrong and what would be right.
        """
        _check(self)

    @classmethod
    @refuses_other_types
    def from_arrays(
        cls,
        rig: Rig,
        *,
        time: "ArrayLike | None" = None,
        name: str = "run",
        notes: Mapping[str, str] | None = None,
        outputs_required: bool = True,
        **columns: "ArrayLike",
    ) -> "Log":
        """A log of arrays, checked as a file is.

        Args:
            rig: The rig that was logged.
            time: Time [s] (n,), strictly increasing. No log is without it.
            name: Name of the log.
            notes: Notes as in a file, such as `{"role": "validate"}`.
            outputs_required: Whether a log without any measured output is an error.
            columns: Command and readings (n,) by the names of a log file's columns, in the units of the names.

        Returns:
            The log in SI.

        Raises:
            LogError: As `read_log`, with the argument and the number of the sample.
            InputError: There is no time, or an argument is of another type.
        """
        if time is None or "time_s" in columns:
            raise InputError(
                "from_arrays: the times of the samples [s] are given as `time`, "
                + ("not `time_s`" if "time_s" in columns else "which is missing")
            )
        held = {"time_s": time, **columns}
        given = {f"{key}".lower(): f"{value}" for key, value in (notes or {}).items()}
        table = ArraySheet(printable(name), given, list(held), held, "sample")
        return cls(printable(name), **fields_of(table, replace(rig, sources={}), outputs_required))

    @classmethod
    @refuses_other_types
    def from_frame(
        cls,
        rig: Rig,
        frame: Any,
        *,
        name: str = "frame",
        notes: Mapping[str, str] | None = None,
        outputs_required: bool = True,
    ) -> "Log":
        """A log of a data frame, whose columns mean what `[columns]` of the rig file says, checked as a file is.

        Args:
            rig: The rig that was logged.
            frame: Data frame of pandas or polars, one row a sample. Dates count as seconds from the first.
            name: Name of the log.
            notes: Notes as in a file, such as `{"role": "validate"}`.
            outputs_required: Whether a log without any measured output is an error.

        Returns:
            The log in SI.

        Raises:
            LogError: As `read_log`, with the column and the number of the row.
            InputError: An argument is of another type.
        """
        given = {f"{key}".lower(): f"{value}" for key, value in (notes or {}).items()}
        table = replace(frame_sheet(frame, printable(name)), notes=given)
        return cls(printable(name), **fields_of(table, rig, outputs_required))

    def remarks(self) -> list[str]:
        """What a user should know about the readings.

        Returns:
            One sentence for every output with outliers.
        """
        return [
            f"{self.name}: outliers among the readings of {name}, which are left out: {len(times)}, the first at {times[0]:.6g} s"
            for name, times in self.left_out.items()
        ]

    def cut(self, first: int, last: int) -> "Log":
        """A stretch of the log.

        Args:
            first: Index of its first sample, counted as by a slice.
            last: Index of the sample after its last one.

        Returns:
            The stretch; its name says which ("square.csv[12.0 s…]").
        """
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
            enabled=None if self.enabled is None else self.enabled[first:last],
            acting=None if self.acting is None else self.acting[first:last],
            left_out=_within(self.left_out, self.time[first], self.time[last - 1]),
            earlier=(
                np.append(self.earlier[0], self.time[:first]),
                with_earlier(self.earlier[1], self.command[:first]),
            ),
        )

    def __repr__(self) -> str:
        """The same as printed: arrays of thousands of samples would flood a console."""
        return f"{self}"

    def __str__(self) -> str:
        """Name, duration, samples and rate, then a line each for the command, every output and every note."""
        n, seconds = len(self.time), float(np.ptp(self.time)) if len(self.time) else 0.0
        rate = f" at {1.0 / np.median(np.diff(self.time)):.4g} Hz" if n > 1 else ""
        role = ", kept for validation" if self.validate else ""
        lines = [
            f"log `{self.name}`: {seconds:.6g} s, {n} samples{rate}{role}",
            f"  command: {_range(self.command, unit_of(self.input))}",
        ]
        for name, y in self.outputs.items():
            missing = int(np.isnan(y).sum())
            lines.append(f"  {name}: {_range(y, unit_of(name))}" + (f", {missing} missing" if missing else ""))
        return "\n".join([*lines, *(f"  # {key}: {value}" for key, value in self.notes.items())])


def _check(log: Log) -> None:
    """`LogError` where the arrays of a log do not belong together."""

    def wrong(message: str) -> LogError:
        return LogError(f"log {log.name}: {message}")

    n = len(log.time)
    if np.ndim(log.time) != 1:
        raise wrong(f"`time` has the shape {np.shape(log.time)}; it has one value for each sample")
    if len(bad := np.flatnonzero(~(np.diff(log.time) > 0.0))):
        k = int(bad[0])
        raise wrong(
            f"`time` is {log.time[k + 1]} after {log.time[k]} (sample {k + 2}); time has to increase from sample to sample"
        )
    if log.input not in COMMANDS:
        raise wrong(f"`input` is {log.input!r}; the nearest command is `{nearest(f'{log.input}', COMMANDS)}`")
    if unknown := next((name for name in log.outputs if name not in OUTPUTS), None):
        raise wrong(f"unknown output `{unknown}`; the nearest is `{nearest(f'{unknown}', OUTPUTS)}`")
    shapes = {"command": np.shape(log.command)[:1] if np.ndim(log.command) == 2 else np.shape(log.command)}
    shapes |= {name: np.shape(y) for name, y in log.outputs.items()}
    shapes |= {name: np.shape(y) for name, y in (("supply", log.supply), ("enabled", log.enabled)) if y is not None}
    if other := next((name for name, shape in shapes.items() if shape != (n,)), None):
        raise wrong(f"`{other}` has the shape {shapes[other]}, and there are {n} samples; give one value for each")


def with_earlier(earlier: np.ndarray, command: np.ndarray) -> np.ndarray:
    """A command together with its samples before a cut.

    Args:
        earlier: Samples [V] before the cut (m, …), or none as `(0,)`.
        command: Samples [V] from the cut on (n, …).

    Returns:
        Samples [V] (m + n, …).
    """
    return np.concatenate([earlier.reshape(len(earlier), *command.shape[1:]), command])


def _within(times: dict[str, np.ndarray], first: float, last: float) -> dict[str, np.ndarray]:
    """Those of the times of each output that lie within a stretch; no entry where there are none."""
    kept = {name: t[(t >= first) & (t <= last)] for name, t in times.items()}
    return {name: t for name, t in kept.items() if len(t)}


def _range(values: np.ndarray, unit: str) -> str:
    """Lowest and highest of the values that are there, in words."""
    seen = values[np.isfinite(values)] + 0.0  # no negative zero
    return f"{seen.min():.4g} to {seen.max():.4g} {unit}".rstrip() if len(seen) else "no reading"
