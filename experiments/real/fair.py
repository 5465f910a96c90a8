"""Is a pair a fair question? What the fitted rig leaves of its own logs, and of the given ones.

`python -m experiments.real.run --fair` prints both for every pair, and diagnoses nothing. A question is fair where the rig follows its own
logs: where something was changed, it leaves of them at most a third of what it leaves of the given ones. Where nothing was, it leaves of
the given ones at most three times what it leaves of its own: then no more is there to be found than in the logs that it was fitted to.

Besides it says what is left of the given logs once the changed numbers are put right, and whether they can be named: whether that is at
most half of what is left with them wrong, as every claim of a diagnosis has to reach. Where it is more, something changes besides, as
friction that grows with the load does, and `unknown` is the best answer. Last it says what a diagnosis can reach that is told the right names:
what is left of each run where the changed numbers are estimated from the others. Numbers that the rig file leaves free, as with `--friction`,
are estimated from the given logs throughout.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from experiments.real.pairs import Pair, given, own, rig_of
from experiments.speed.table import show
from rwjax import fit, predict
from rwjax.errors import InputError
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

TIMES = 3.0
"""How many times more a rig leaves of a set-up that differs than of its own, at least [1]."""
MOST_LEFT = 0.5
"""Share of the given logs' error that the right numbers leave at most where they can be named [1]."""
WORDS = {True: "yes", False: "no", None: "-"}


def left(rig: Rig, logs: Sequence[Log]) -> float:
    """Free-run RMS error of all logs together [rad, or rad/s of a wheel]; infinite where a run goes further than any rig."""
    return _rms([_square(rig, log) for log in logs])


def _square(rig: Rig, log: Log) -> np.ndarray:
    """Squared errors of a free run of a log."""
    signal, measured = next(iter(log.outputs.items()))
    try:
        return np.square(predict(rig, log)[signal] - measured)
    except InputError:
        return np.full(len(measured), np.inf)


def _rms(square: Sequence[np.ndarray]) -> float:
    return float(np.sqrt(np.nanmean(np.concatenate(square))))


def left_of_others(rig: Rig, logs: Sequence[Log], free: Sequence[str]) -> float:
    """Free-run RMS error of all logs [rad, or rad/s of a wheel], each with numbers that were estimated from the others.

    Args:
        rig: The rig.
        logs: Its logs, two at least.
        free: The numbers, beside those that the rig leaves free.

    Returns:
        The error.
    """
    square = []
    for log in logs:
        others = [other for other in logs if other is not log]
        square.append(_square(fit(replace(rig, free=(*rig.free, *free)), others).rig, log))
    return _rms(square)


def left_of_fitted(rig: Rig, logs: Sequence[Log]) -> float:
    """Free-run RMS error of all logs together, once what the rig leaves free is estimated from them [rad, or rad/s of a wheel]."""
    return left(fit(rig, logs).rig if rig.free else rig, logs)


def is_fair(changed: bool, of_own: float, of_given: float) -> bool:
    """Whether a pair is a fair question.

    Args:
        changed: Whether something differs.
        of_own: What the fitted rig leaves of its own logs [rad].
        of_given: What it leaves of the given ones [rad].

    Returns:
        Whether it is.
    """
    if not np.isfinite(of_own):
        return False
    return of_given >= TIMES * of_own if changed else of_given <= TIMES * of_own


def put_right(pair: Pair) -> Pair | None:
    """The pair with its changed numbers told, None where the given set-up's rig file does not say them all."""
    numbers = tuple(name.removeprefix("parameter.") for name in pair.changed if name.startswith("parameter."))
    if pair.given_data or not numbers or len(numbers) < len(pair.changed):
        return None
    return pair._replace(told=(*pair.told, *numbers), changed=[])


class Left(NamedTuple):
    """What a pair's rig leaves of its own logs, of the given ones, and of these with the changed numbers put right, or estimated from the other
    runs [rad]."""

    own: float
    given: float
    right: float | None
    estimated: float | None


def can_be_named(given: float, right: float | None) -> bool | None:
    """Whether what was changed explains half of the gap, None where nobody knows.

    Args:
        given: What the fitted rig leaves of the given logs [rad].
        right: What it leaves with the changed numbers put right [rad].

    Returns:
        Whether it does.
    """
    return None if right is None else right <= MOST_LEFT * given


def errors(pair: Pair) -> Left:
    """What a pair's rig leaves."""
    rig, right = rig_of(pair), put_right(pair)
    (wrong, logs), of_own = given(pair, rig), left(rig, own(pair, rig))
    of_given = left_of_fitted(wrong, logs)
    if right is None:
        return Left(of_own, of_given, None, None)
    free = [name.removeprefix("parameter.") for name in pair.changed]
    return Left(of_own, of_given, left_of_fitted(given(right, rig)[0], logs), left_of_others(wrong, logs, free))


def report(pairs: Sequence[Pair]) -> None:
    """Prints the table."""
    rows = []
    for pair in pairs:
        found = errors(pair)
        said = is_fair(bool(pair.changed), found.own, found.given), can_be_named(found.given, found.right)
        numbers = ["-" if one is None else f"{1e3 * one:.1f}" for one in found]
        rows.append(
            [pair.name, pair.set, " + ".join(pair.changed) or "nothing", *numbers, *(WORDS[one] for one in said)]
        )
        print(" ".join(rows[-1]), flush=True)
    errors_of = [f"{what} [10⁻³ SI]" for what in ("own", "given", "put right", "estimated from others")]
    head = ["pair", "set", "changed", *errors_of, "fair", "can be named"]
    show("What fitted rigs leave", head, rows)
