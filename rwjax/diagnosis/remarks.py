"""Remarks: what these logs cannot tell about the numbers that were fitted, one sentence each."""

from collections.abc import Sequence

import numpy as np

from rwjax.effects.library import thresholds
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.uncertainty import Uncertainty
from rwjax.fitting.unit_check import check_units
from rwjax.kinds import TWO_AXIS
from rwjax.logs.log import Log
from rwjax.logs.noise import noise_by_output
from rwjax.plant.from_rig import theta_of
from rwjax.rig.model import Rig

WIDE = 0.2  # of the command's largest size: a stretch without commands that is worth a remark
NEAR = 1.1  # a command this little above the width moves nothing that could be seen

RAN_AWAY = 1e4
"""Times the rig file's value above which a fitted number says that its part does not move in these logs."""


MOVES, TOGETHER = 4.0, 25
"""Range of the readings' mean over so many samples, in units of their noise, above which they tell of a motion: of white noise it
is below 2, of a counter between two counts 3.5."""


def moves(log: Log) -> bool:
    """Whether any reading of a log changes by more than its noise."""
    noise = noise_by_output(log)
    for name, value in log.outputs.items():
        seen = value[np.isfinite(value)]
        mean = np.convolve(seen, np.full(TOGETHER, 1.0 / TOGETHER), "valid") if len(seen) >= TOGETHER else seen
        if len(seen) and np.ptp(mean) > MOVES * noise[name]:
            return True
    return False


def ran_away(rig: Rig, fitted: Fit) -> tuple[str, ...]:
    """Free numbers of the rig that left their size altogether: what holds a part at rest looks like no end of it."""
    value = fitted.numbers()
    return tuple(name for name in rig.free if 0.0 < rig.numbers.get(name, 0.0) * RAN_AWAY < value[name])


def remarks(
    rig: Rig,
    logs: tuple[Log, ...],
    train: tuple[int, ...],
    base: Fit,
    fits: Sequence[Fit],
    spread: Uncertainty,
    lost: tuple[str, ...] = (),
) -> tuple[str, ...]:
    """Remarks on the fits of the named hypothesis and of those that cannot be told apart from it; `base`: the fit without
    any; `lost`: numbers that ran away."""
    believed = base.problem.expand(theta_of(rig, base.problem.structure))
    found = [*check_units(base.problem, believed), *spread.notes, *(remark for log in logs for remark in log.remarks())]
    known = set() if rig.kind in TWO_AXIS else thresholds(rig.kind)  # of one command
    widths = [(name.rpartition(".")[0], f.numbers()[name]) for f in fits for name in f.free if name in known]
    if widths:
        sizes = np.unique(np.abs(np.concatenate([logs[k].command for k in train])))
        effect, width = widths[0]
        ends = [(a, b) for a, b in zip(sizes[:-1], sizes[1:], strict=True) if a <= NEAR * width < NEAR * b]
        low, high = max(ends, key=lambda gap: gap[1] - gap[0], default=(0.0, 0.0))
        if high - low > WIDE * sizes[-1]:
            found.append(
                f"no command lies between {low:.3g} and {high:.3g} V, so the voltage at which the drive begins to act is "
                f"unidentifiable there: the {width:.3g} V of {effect} is where its line meets zero, "
                "and a threshold anywhere between, with a step, gives the same logs"
            )
    if lost:
        found.append(
            f"{', '.join(lost)}: more than {RAN_AWAY:g} times what the rig file says, so that part hardly moves in these logs "
            "and what holds it is not told: use runs in which it turns"
        )
    if rig.per_run:
        found.append(
            f"{', '.join(rig.per_run)}: one value for all runs, since a held-out run's own value (fit.per_run) is not known"
        )
    if len(train) == 1:
        found.append("one run was fitted: nothing says how well runs repeat, so the floor is a lower bound")
    return tuple(found)
