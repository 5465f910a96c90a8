"""Remarks: what the logs cannot tell about the numbers that were fitted, one sentence each."""

from collections.abc import Sequence

import numpy as np

from rwjax.diagnosis.settings import RemarkSettings
from rwjax.effects.library import thresholds
from rwjax.errors import in_two_digits
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.questions.ask import ask
from rwjax.fitting.segments import said
from rwjax.fitting.uncertainty import Uncertainty
from rwjax.kinds import TWO_AXIS
from rwjax.logs.log import Log
from rwjax.plant.from_rig import theta_of
from rwjax.rig.model import Rig


def remarks(
    rig: Rig,
    logs: Sequence[Log],
    train: Sequence[int],
    base: Fit,
    fits: Sequence[Fit],
    spread: Uncertainty,
    diverged: tuple[str, ...],
    limits: RemarkSettings,
) -> tuple[str, ...]:
    """Remarks on the fits of the named hypothesis and of those that cannot be told apart from it.

    Args:
        rig: the rig as it is.
        logs: all runs.
        train: numbers of the training runs.
        base: the fit of the rig as it is.
        fits: the fits to remark on, that of the named hypothesis first.
        spread: uncertainty of the first of them.
        diverged: the rig's numbers that diverged in its fit.
        limits: when a remark is made.

    Returns:
        The remarks, one sentence each.
    """
    believed = base.problem.expand(theta_of(rig, base.problem.structure))
    found = [*ask(base.problem, believed), *spread.notes, *(remark for log in logs for remark in log.remarks())]
    if not rig.free:
        found.append(
            "the rig file frees no number, so that each counts as exact; one that is wrong shows as an effect or as a wrong number: "
            "name in `fit.free` what is not known well"
        )
    known = set() if rig.kind in TWO_AXIS else thresholds(rig.kind)  # of one command
    widths = [(name.rpartition(".")[0], f.numbers()[name]) for f in fits for name in f.free if name in known]
    if widths:
        sizes = np.unique(np.abs(np.concatenate([logs[k].at_drive for k in train])))
        found += _on_threshold(*widths[0], sizes, limits)
    found += said(logs)
    if fits[0] is not base:
        found += _far_from_the_file(rig, fits[0], limits.far)
    if diverged:
        found.append(
            f"{', '.join(diverged)}: more than {limits.diverged:g} times what the rig file says, so that part hardly moves in "
            "these logs and what holds it is not told: use runs in which it turns"
        )
    if rig.per_run:
        found.append(
            f"{', '.join(rig.per_run)}: one value for all runs, since a held-out run's own value (fit.per_run) is not known"
        )
    if all(np.ptp(logs[k].command, axis=0).max() == 0.0 for k in train):
        found.append(
            "the command changes in no run that was fitted, so that nothing is told of the drive: add runs in which it does"
        )
    if len(train) == 1:
        found.append("one run was fitted: nothing says how well runs repeat, so the floor is a lower bound")
    return tuple(found)


def _far_from_the_file(rig: Rig, named: Fit, far: float) -> list[str]:
    """The remark on free numbers that are far from the rig file's beside what is named, the farthest first; a guess says nothing."""
    numbers, said = named.numbers(), rig.values
    known = [name for name in rig.free if name in numbers and name not in rig.guessed and said.get(name, 0.0) > 0.0]
    times = {name: numbers[name] / said[name] for name in known}
    away = {name: x for name, x in times.items() if x > 0.0 and not 1.0 / far <= x <= far}
    if not away:
        return []
    order = sorted(away, key=lambda name: -abs(np.log(away[name])))
    told = ", ".join(f"{name} ({in_two_digits(away[name])} times)" for name in order)
    return [
        f"with what is named, numbers are far from the rig file's: {told}; where that cannot be, the name stands in for something else"
    ]


def _on_threshold(effect: str, width: float, sizes: np.ndarray, limits: RemarkSettings) -> list[str]:
    """The remark on an effect beside whose threshold [V] lies a wide range without commands."""
    near = limits.near_width
    ends = [(a, b) for a, b in zip(sizes[:-1], sizes[1:], strict=True) if a <= near * width < near * b]
    low, high = max(ends, key=lambda gap: gap[1] - gap[0], default=(0.0, 0.0))
    if high - low <= limits.wide * sizes[-1]:
        return []
    return [
        f"no command lies between {low:.3g} and {high:.3g} V, so the voltage at which the drive begins to act is "
        f"unidentifiable there: the {width:.3g} V of {effect} is where its line meets zero, "
        "and a threshold anywhere between, with a step, gives the same logs"
    ]
