"""What every identification method returns."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import CommandDelay, EncoderDelay
from rwjax.errors import RigError
from rwjax.fitting.intervals import interval_words
from rwjax.kinds import GOAL
from rwjax.logs.driven import without_servo
from rwjax.logs.log import Log
from rwjax.plant.from_rig import structure_of
from rwjax.rig.model import Driven, Rig
from rwjax.simulation.solver import Solver

NORMAL_95 = 1.96
"""Standard errors to either end of a 95 % interval [1]."""


def student(degrees: float) -> float:
    """Factor by which a standard error from few readings is too small for a 95 % interval of `NORMAL_95`.

    Args:
        degrees: Degrees of freedom that it rests on [1].

    Returns:
        The factor [1], above 1.
    """
    return float(stdtrit(degrees, 0.975)) / NORMAL_95


@dataclass(frozen=True)
class Identified:
    """Estimates of a method.

    Attributes:
        rig: The rig with estimates and standard errors in place [SI].
        notes: What a user should know, one sentence each.
        solver: Solver that the estimates belong to, by whose free run they are judged; None for any.
    """

    rig: Rig
    notes: tuple[str, ...] = ()
    solver: Solver | None = None

    @property
    def interval(self) -> dict[str, tuple[float, float]]:
        """95 % interval of each estimated number by its standard error [SI]."""
        errors = self.rig.standard_error
        return {n: (self.rig.values[n] - NORMAL_95 * e, self.rig.values[n] + NORMAL_95 * e) for n, e in errors.items()}

    def interval_words(self, name: str) -> str:
        """The 95 % interval of a number in words.

        Args:
            name: Its name.

        Returns:
            Both ends. Empty where it has no interval.
        """
        return interval_words(*self.interval[name]) if name in self.interval else ""

    def of_runs(self) -> list[str]:
        """Numbers that a run has of its own.

        Returns:
            None: only the end-to-end fit estimates them.
        """
        return []

    def json(self) -> dict:
        """Plain objects for `rwjax fit --json`.

        Returns:
            Estimates and standard errors [SI] by name.
        """
        errors = self.rig.standard_error
        return {
            "schema": "rwjax.fit/1",
            "rig": self.rig.name,
            "numbers": {
                name: {"value": self.rig.values[name], "standard_error": errors.get(name)} for name in self.rig.free
            },
            "notes": list(self.notes),
        }


def left_out(rig: Rig, *, prior: bool) -> tuple[str, ...]:
    """A note where a method does not use what the rig file says of the fit.

    Args:
        rig: The rig.
        prior: Whether the method uses priors.

    Returns:
        The note, or none.
    """
    keys = [*(["fit.prior"] if rig.prior and not prior else []), *(["fit.per_run"] if rig.per_run else [])]
    return (f"does not know {' and '.join(keys)} of the rig file",) if keys else ()


def at_the_drive(rig: Rig, logs: Sequence[Log], method: str) -> tuple[Rig, tuple[Log, ...], tuple[str, ...]]:
    """A rig and its logs for a method that simulates no loop: what a servo gave stands for its goal.

    Args:
        rig: The rig with its free numbers.
        logs: The logs.
        method: The method in words.

    Returns:
        The rig, of whose numbers those are free that act in these logs, the logs, and notes on both.

    Raises:
        RigError: None of the free numbers acts.
        LogError: The rig cannot be driven as the logs say.
    """
    by_goal = any(log.input == GOAL for log in logs)
    opened, logs = without_servo(rig, logs)
    acts = structure_of(opened).names
    if rig.free and not any(name in acts for name in rig.free):
        raise RigError(
            f"rig `{rig.name}`: no free number acts in these logs; the {method} simulates no loop of a servo"
        )
    notes = ["what the servo gave is worked out from the readings"] if by_goal else []
    notes += [f"{name} is not estimated by the {method}" for name in rig.free if name not in acts]
    return replace(opened, free=tuple(name for name in rig.free if name in acts)), logs, tuple(notes)


def undelayed(rig: Rig, method: str) -> None:
    """Refuses a rig with a delay, for a method that knows none.

    Args:
        rig: The rig.
        method: The method in words.

    Raises:
        RigError: The rig's commands act late, or its readings come late.
    """
    for port, takes in ((CommandDelay, "commands to act at once"), (EncoderDelay, "readings to be at once")):
        for name in (name for name in rig.effects if issubclass(BY_NAME[name], port)):
            raise RigError(f"rig `{rig.name}`: has {name}; the {method} takes {takes}")


def within_bounds(rig: Rig, method: str, names: Sequence[str], values: np.ndarray) -> None:
    """Refuses estimates outside their bounds, for a method that cannot heed these.

    Args:
        rig: The rig with its bounds.
        method: The method in words.
        names: Names of the numbers.
        values: Their estimates `(k,)` [SI].

    Raises:
        RigError: An estimate lies outside its bounds.
    """
    for name, value in zip(names, values, strict=True):
        low, high = rig.bounds.get(name, (-np.inf, np.inf))
        if not low <= value <= high:
            raise RigError(
                f"rig `{rig.name}`: `{name}` comes out as {value:.4g}, outside its `fit.bounds` [{low:.4g}, {high:.4g}], which "
                f"the {method} cannot heed; take them out"
            )


def estimated(rig: Rig, names: Sequence[str], values: np.ndarray, errors: np.ndarray) -> Rig:
    """The rig with estimates in place.

    Args:
        rig: The rig.
        names: Names of the numbers.
        values: Their estimates `(k,)` [SI].
        errors: Their standard errors `(k,)` [SI]; those that are not finite are left out.

    Returns:
        A copy of the rig, which says no more how it was driven.
    """
    known = {name: float(e) for name, e in zip(names, errors, strict=True) if np.isfinite(e)}
    found = rig.with_values(dict(zip(names, map(float, values), strict=True)))
    return replace(found.with_standard_errors(known), driven=Driven())
