"""Whether held-out runs leave what the fitted runs cover, and which other split would not.

A gap on a run that is faster, turns the other way or is driven otherwise than all fitted runs tells of extrapolation,
besides of what the model lacks.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rwjax.kinds import is_angle
from rwjax.logs.held_out import Fold, folds
from rwjax.logs.log import Log
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Rig

LEAVES = 0.1
"""Share of a held-out run's samples outside what is covered from which it leaves that [1]."""
COVERED = (0.01, 0.99)
"""Shares of the fitted samples below and above which nothing counts as covered [1]."""
MARGIN = 0.1
"""How far beyond these ends still counts as covered, as a share of the distance between them [1]."""
SPAN_S = 0.1
"""Time over which the change of an angle or of a command is taken [s]."""
STILL = 0.02
"""Share of the largest command, or of the whole range of an output, up to which there is none [1]."""
HELD_OUT = ("marked", "last-third")
"""Rules by which what is judged is held out; by the others each run is fitted, too."""
NOT_STILL = 0.01
"""Share of samples without a command below which fitted runs are always driven [1]."""


class Outside(NamedTuple):
    """How far a run leaves what other runs cover, in the quantity in which it does so most.

    Attributes:
        log: Name of the run.
        quantity: What it leaves, with its unit.
        share: Share of its samples that lie outside [1].
        seen: Its own range, as `covered` [unit of the quantity].
        covered: Range of the other runs, without their outermost hundredths [unit of the quantity].
    """

    log: str
    quantity: str
    share: float
    seen: tuple[float, float]
    covered: tuple[float, float]

    @property
    def leaves(self) -> bool:
        """Whether that is extrapolation."""
        return self.share > LEAVES


@dataclass(frozen=True)
class Split:
    """What is said of a split.

    Attributes:
        outside: The held-out runs that leave what the fitted runs cover, the one that does so most first.
        proposed: Run, or part of the only run, that could be held out instead; None where none is covered.
        rule: The rule by which runs are held out, as `folds` names it.
    """

    outside: tuple[Outside, ...] = ()
    proposed: str | None = None
    rule: str = "marked"

    def json(self) -> dict:
        """Plain objects.

        Returns:
            The runs that leave what is covered [unit of the quantity], and the proposal.
        """
        return {"outside": [one._asdict() for one in self.outside], "proposed": self.proposed}

    def said(self) -> list[str]:
        """The same in words.

        Returns:
            One sentence, none where the split does not extrapolate.
        """
        if not self.outside:
            return []
        worst, *others = self.outside
        more = f" (and {len(others)} more)" if others else ""
        ranges = " against ".join(f"{low:.3g} to {high:.3g}" for low, high in (worst.seen, worst.covered))
        other = (
            f"; held out {'instead' if self.rule in HELD_OUT else 'alone'}, {self.proposed} would not: write `# role: validate` into that one"
            if self.proposed
            else "; no other split avoids that, so record a run between these"
        )
        return [
            f"{worst.log}{more}{_leaves(self.rule)}: {100 * worst.share:.0f} % of it lies outside in "
            f"{worst.quantity} ({ranges}), so that its gap tells of extrapolation as well{other}"
        ]


def _leaves(rule: str) -> str:
    """How a run is judged that leaves what is covered."""
    return {
        "each-on-the-other": ", judged by a fit to the other run, leaves what that one covers",
        "leave-one-run-out": ", judged by a fit to the other runs, leaves what they cover",
    }.get(rule, " is held out and leaves what the fitted runs cover")


WITHIN = Split()
"""A split that does not extrapolate."""


def split_of(rig: Rig, logs: Sequence[Log]) -> Split:
    """Whether the held-out rule makes a split that extrapolates, and another one that does not.

    Args:
        rig: The rig.
        logs: Whole runs.

    Returns:
        What there is to say of the split.
    """
    rule, splits = folds(logs)
    found = [_outside(rig, fold.train, log) for fold in splits for log in fold.test]
    leaving = sorted((one for one in found if one.leaves), key=lambda one: -one.share)
    if not leaving:
        return WITHIN
    kept = {one.log for one in found if not one.leaves} if rule != "marked" else set()
    held = {one.log for one in leaving}
    tried = [
        _outside(rig, fold.train, fold.test[0])._replace(log=words)
        for fold, words in _others(logs, rule)
        if _moves(fold.test[0], logs)
    ]
    covered = [one for one in tried if not one.leaves and one.log not in held]
    best = min(covered, key=lambda one: (one.log not in kept, one.share), default=None)
    return Split(tuple(leaving), best.log if best else None, rule)


def _others(logs: Sequence[Log], rule: str) -> list[tuple[Fold, str]]:
    """Splits that could be, with the names of what they hold out."""
    if rule != "last-third":
        return [(Fold(tuple(other for other in logs if other is not log), (log,)), log.name) for log in logs]
    (log,) = (log for log in logs if not log.validate)
    n = len(log.time)
    a, b = n // 3, n - n // 3
    first, middle, last = log.cut(0, a), log.cut(a, b), log.cut(b, n)
    t = log.time[[0, a, b]]
    return [
        (Fold((middle, last), (first,)), f"{t[0]:.4g} to {t[1]:.4g} s of {log.name} in a file of its own"),
        (Fold((first, last), (middle,)), f"{t[1]:.4g} to {t[2]:.4g} s of {log.name} in a file of its own"),
    ]


def _outside(rig: Rig, fitted: Sequence[Log], log: Log) -> Outside:
    """How far a run leaves what the fitted ones cover, in the quantity in which it does so most."""
    others = [_quantities(rig, other) for other in fitted]
    found = [Outside(log.name, "nothing", 0.0, (0.0, 0.0), (0.0, 0.0))]
    for name, values in _quantities(rig, log).items():
        known = [other[name] for other in others if name in other]
        if not known or not len(values):
            continue
        low, high = np.quantile(np.concatenate(known), COVERED)
        beyond = MARGIN * (high - low)
        share = float(np.mean((values < low - beyond) | (values > high + beyond)))
        seen = np.quantile(values, COVERED)
        found.append(Outside(log.name, name, share, (float(seen[0]), float(seen[1])), (float(low), float(high))))
    largest = max((float(np.max(np.abs(one.command), initial=0.0)) for one in (*fitted, log)), default=0.0)
    still, driven = _still(log, largest), [_still(other, largest) for other in fitted]
    if max(driven, default=1.0) < NOT_STILL:
        found.append(
            Outside(log.name, "stretches without a command [share of the run]", still, (0.0, still), (0.0, max(driven)))
        )
    return next(one for one in found if one.share >= 0.9 * max(other.share for other in found))


def _moves(log: Log, logs: Sequence[Log]) -> bool:
    """Whether an output of a run, or of a part of one, changes by more than a trifle of its range in all runs."""
    return any(
        _range(y) > STILL * max(_range(one.outputs[name]) for one in logs if name in one.outputs)
        for name, y in log.outputs.items()
    )


def _range(values: np.ndarray) -> float:
    """Distance from the least to the largest of the readings; 0 where there are none."""
    seen = values[np.isfinite(values)]
    return float(np.ptp(seen)) if len(seen) else 0.0


def _still(log: Log, largest: float) -> float:
    """Share of a run without a command."""
    size = np.abs(log.command) if log.command.ndim == 1 else np.max(np.abs(log.command), axis=1)
    return float(np.mean(size <= STILL * largest))


def _quantities(rig: Rig, log: Log) -> dict[str, np.ndarray]:
    """What a run covers: commands and how fast they change, rates, and angles where gravity makes them matter."""
    found: dict[str, np.ndarray] = {}
    t = log.time - log.time[0]
    command = log.command.reshape(len(t), -1)
    for k, u in enumerate(command.T):
        which = f" {k + 1}" if command.shape[1] > 1 else ""
        unit = unit_of(log.input)
        found[f"command{which} [{unit}]"] = u
        found[f"change of command{which} [{unit}/s]"] = np.abs(_change(t, t, u))
    heavy = any(value for name, value in rig.numbers.items() if name.endswith("gravity.torque"))
    for name, values in log.outputs.items():
        seen = np.isfinite(values)
        if is_angle(name):
            if f"{name}_s" not in log.outputs and seen.sum() > 1:
                found[f"{name}_s [rad/s]"] = _change(t, t[seen], values[seen])
            if heavy and not name.startswith("wheel"):
                found[f"{name} [rad]"] = values[seen]
        elif name.endswith("_s"):
            found[f"{name} [{unit_of(name)}]"] = values[seen]
    return found


def _change(t: np.ndarray, at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Mean rate of change over `SPAN_S` after every time but the last ones [unit of the values per second]."""
    begin = t[t + SPAN_S <= t[-1]]
    return (np.interp(begin + SPAN_S, at, values) - np.interp(begin, at, values)) / SPAN_S
