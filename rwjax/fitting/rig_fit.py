"""A fitted rig with what its optimum says, for people and for programs."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rwjax.fitting.initial_state_from_start import COMPLETE
from rwjax.fitting.intervals import Intervals, interval_words
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.segments import segment_s
from rwjax.fitting.uncertainty import Uncertainty
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Rig
from rwjax.rig.number_unit import unit_in_rig

if TYPE_CHECKING:
    import polars as pl


@dataclass(frozen=True)
class RigFit:
    """Fitted rig with what the optimum says. Prints as text.

    Attributes:
        rig: The rig with estimates and standard errors in place [SI]. A number that every run has of its own is the
            mean over the runs, with the standard error of that mean.
        fit: The fit.
        uncertainty: Covariance of the free numbers.
        interval: 95 % of each estimated number [SI]: by the standard error; by the profile where a bound is near or the
            logs say little; by the bootstrap where one was made.
        rms: Free-run RMS error of every output over the fitted logs [SI].
        notes: What a user should know, one sentence each.
    """

    rig: Rig
    fit: Fit
    uncertainty: Uncertainty
    interval: Intervals
    rms: dict[str, float]
    notes: tuple[str, ...]

    @property
    def lacks_something(self) -> bool:
        """Whether the logs say that the model is wrong: it misses them by much more than their noise."""
        return misfit(self.fit) ** 2 > COMPLETE

    @property
    def tells_something(self) -> bool:
        """Whether the logs tell anything of the free numbers: one at least leaves a trace, if only together with others.

        A number that leaves none where it sits on its bound may leave one off it: then its profile has two ends.
        """
        told = (
            np.all(np.isfinite(ends)) and not (ends[0] <= self.allowed[name][0] and ends[1] >= self.allowed[name][1])
            for name, ends in self.interval.items()
        )
        return self.uncertainty.tells_something or any(told)

    @property
    def allowed(self) -> dict[str, tuple[float, float]]:
        """Least and largest value [SI] that each fitted number may have, by its name."""
        return {
            name: (float(low), float(high))
            for name, (low, high) in zip(self.fit.free, self.fit.coordinates.bounds, strict=True)
        }

    def __str__(self) -> str:
        rows = [
            _row(name, value, error, self._unit(name), self.interval_words(name))
            for name, value, error in self._estimates()
        ]
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        lines = [f"fit of {self.rig.name} to {', '.join(dict.fromkeys(log.name for log in self.fit.problem.logs))}"]
        lines += ["  " + "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in rows]
        lines += [f"  RMS error of {name}: {value:.4g} {unit_of(name)}" for name, value in self.rms.items()]
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])

    def _estimates(self) -> list[tuple[str, float, float]]:
        """Name, value and standard error [SI] of every estimated number."""
        values, errors = self.fit.numbers() | self.rig.values, self.uncertainty.standard_error | self.rig.standard_error
        names = dict.fromkeys((*self.rig.free, *self.uncertainty.names, *self.rig.tied))
        return [(name, values[name], errors.get(name, np.inf)) for name in names]

    def to_frame(self) -> "pl.DataFrame":
        """The estimates as a table, one number a row.

        Returns:
            Columns `number`, `value`, `standard_error`, `from_95` and `to_95` (the ends of its 95 % interval), all in the number's unit and
            null where there is none, and `unit`.
        """
        import polars as pl  # a tenth of a second, which a fit does not need

        columns = ("number", "value", "standard_error", "from_95", "to_95", "unit")
        rows = [
            (name, value, _finite(error), *map(_finite, self.interval.get(name, (np.nan, np.nan))), self._unit(name))
            for name, value, error in self._estimates()
        ]
        return pl.DataFrame(
            rows, schema=dict.fromkeys(columns, pl.Float64) | {"number": pl.String, "unit": pl.String}, orient="row"
        )

    def _unit(self, name: str) -> str:
        """Unit of a number, also of one that a run has of its own."""
        return unit_in_rig(self.rig, name.partition(" ")[0])

    def of_runs(self) -> list[str]:
        """Numbers that a run has of its own.

        Returns:
            One line for each, with its interval [SI].
        """
        value = self.fit.numbers()
        own = [name for name in self.fit.free if name not in self.rig.free]
        return [f"{name} = {value[name]:.6g} ({self.interval_words(name)})" for name in own]

    def interval_words(self, name: str) -> str:
        """The 95 % interval of a number in words.

        Args:
            name: Its name.

        Returns:
            Both ends, with one that only the limits of the number make said as open. Empty where it has no interval.
        """
        if name not in self.interval:
            return ""
        return interval_words(*self.interval[name], allowed=self.allowed.get(name, (-np.inf, np.inf)))

    def json(self) -> dict:
        """Plain objects for `rwjax fit --json`.

        Returns:
            Numbers, intervals and errors [SI] by name; null where a value is infinite.
        """
        return {
            "schema": "rwjax.fit/1",
            "rig": self.rig.name,
            "numbers": {
                name: {"value": value, "standard_error": _finite(error)} for name, value, error in self._estimates()
            },
            "interval95": {name: [_finite(end) for end in ends] for name, ends in self.interval.items()},
            "covariance_of": list(self.uncertainty.names),
            "covariance": [[_finite(v) for v in row] for row in self.uncertainty.covariance],
            "rms": self.rms,
            "solver": self.fit.problem.solver.name,
            "smooth": self.fit.problem.solver.sign_width,
            "noise": self.fit.problem.noise,
            "segment_s": segment_s(self.fit.problem.logs),
            "converged": self.fit.converged,
            "notes": list(self.notes),
        }


def misfit(fitted: Fit) -> float:
    """How far a fit misses its readings.

    Args:
        fitted: The fit.

    Returns:
        Root of the mean square of its residual, in units of the noise [1].
    """
    problem = fitted.problem
    return float(np.sqrt(2.0 * (fitted.cost - problem.prior_cost(fitted.theta)[0]) / problem.batch.readings))


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _row(name: str, value: float, error: float, unit: str, interval: str) -> tuple[str, str, str, str]:
    """Name, value, standard error with unit, and interval of a number, as text."""
    spread = (f"± {error:.2g}" if np.isfinite(error) else "(no standard error)") + (f" {unit}" if unit else "")
    return name, f"{value:.6g}", spread, interval
