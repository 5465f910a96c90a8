r"""Which rigs of a fleet changed: each against its siblings, and against itself in earlier sessions.

An estimate $\hat\theta_i$ of a rig has the covariance $\Sigma_i$ that its logs leave, and rigs differ: $\hat\theta_i \sim N(\mu, \Sigma_i + D)$
with $D$ diagonal. Both come from medians over the fleet, which a tenth of worn rigs does not spoil, and then from mean and variance of what lies
within 2.5 standard deviations of them. Against itself the same holds of $\hat\theta_i$ less the mean of the rig's $n$ earlier estimates. $\mu$ is then what all rigs changed by in
the same time, and $D$, which counts $1 + 1/n$ times, what a sound rig changes by from session to session.

Where number $k$ alone moved, its change is estimated by

$$\delta_k = \frac{(V^{-1}d)_k}{(V^{-1})_{kk}}, \qquad z_k = \frac{(V^{-1}d)_k}{\sqrt{(V^{-1})_{kk}}},$$

with $d = \hat\theta_i - \mu$ and $V = \Sigma_i + D$. The sum of squares falls by $z_k^2$: the largest names the number, and others that fall
nearly as much stand beside it. Where more than chance is left, a further number moved: numbers are added while they are needed, and left
out again where they are not, and the changes are those of all of them together. The misfit of a fit, RMS error over noise, is one more number, whose spread is the fleet's alone: an effect
that appears raises it.

A rig has one probability of chance, that of its most striking number, corrected for how many there are (Šidák). Few rigs tell their spread
badly, so that it is Student's. Alarms are those that Benjamini and Hochberg (1995) let through of all comparisons together: the stated share of
them is false at most, on average.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import polars as pl
from scipy.special import ndtr, ndtri, stdtr, stdtrit

from rwjax.fleet import FALSE
from rwjax.report.fleet import MISFIT

FEWEST = 8
"""Rigs below which their spread is not known, and nothing is said."""
COMMON = 0.5
"""Share of the rigs that have to tell a number for it to be compared [1]."""
FURTHER = 1e-3
"""Probability of chance below which a further number of a rig that changed counts as one that moved, too [1]."""
NEAR = 9.0
"""Fall of the sum of squares, against the best, within which another number may be the one that moved: three standard deviations."""
WITHIN = 2.5
"""Standard deviations from the median within which numbers count for mean and spread [1]."""
OF_VARIANCE = float(1.0 - 2.0 * WITHIN * np.exp(-0.5 * WITHIN**2) / np.sqrt(2.0 * np.pi) / (2.0 * ndtr(WITHIN) - 1.0))
"""Mean square of normal numbers within that [1]."""
EFFICIENCY = 0.7
"""Degrees of freedom of such a spread, against those of a standard deviation of as many normal numbers [1]; the tests hold it against fleets
where nothing changed."""
OF_MEDIAN = float(ndtri(0.75))
"""Median absolute deviation of a standard normal number."""
TINY, SMALL = np.finfo(float).tiny, 1e-9
"""What stands for 0 in a divisor; an information below which nothing is told [1]."""
STEPS = 60
"""Halvings of the interval in which a spread lies."""
FAILED: dict[tuple[str, str], float] = {}
"""Covariance of a session that failed."""
OF_A_RUN = " in "
"""What stands in the name of a number that a run has of its own, which no other rig has."""


class Estimates(NamedTuple):
    """Estimates of several rigs, NaN where a rig does not tell a number.

    Attributes:
        names: Names of the numbers.
        rigs: Names of the rigs.
        whens: Their sessions.
        value: Numbers, or what they have changed by (rigs, numbers) [SI].
        covariance: What the logs leave of each rig's (rigs, numbers, numbers) [SI²].
        sessions: How many times the spread from session to session counts (rigs, numbers) [1].
        before: Numbers from which a change is counted (rigs, numbers) [SI], 0 where none is.
    """

    names: tuple[str, ...]
    rigs: tuple[str, ...]
    whens: tuple[str, ...]
    value: np.ndarray
    covariance: np.ndarray
    sessions: np.ndarray
    before: np.ndarray


class Compared(NamedTuple):
    """Numbers of several rigs against what is expected of them, each in a unit of its own.

    Attributes:
        information: Inverse of the covariance of what is expected (rigs, numbers, numbers) [1].
        pull: That times the difference (rigs, numbers) [1]; 0 of a number that a rig does not tell.
        unit: The units (numbers,) [SI].
        expected: What is expected of each number (numbers,) [SI].
        spread: Standard deviation over sound rigs, beyond that of the estimates (numbers,) [SI].
        freedom: Degrees of freedom of that (numbers,) [1].
    """

    information: np.ndarray
    pull: np.ndarray
    unit: np.ndarray
    expected: np.ndarray
    spread: np.ndarray
    freedom: np.ndarray

    @property
    def z(self) -> np.ndarray:
        """Change of each number where it alone changed, in standard deviations (rigs, numbers) [1]."""
        return self.pull / np.sqrt(np.maximum(np.diagonal(self.information, axis1=1, axis2=2), TINY))

    def beside(self, rig: int, moved: list[int]) -> np.ndarray:
        """The same of one rig where some numbers changed besides.

        Args:
            rig: Index of the rig.
            moved: Indices of the numbers.

        Returns:
            Changes in standard deviations (numbers,) [1], 0 of those that moved.
        """
        W, pull = self.information[rig], self.pull[rig]
        gain = W[:, moved] @ np.linalg.pinv(W[np.ix_(moved, moved)])
        left, own = pull - gain @ pull[moved], np.diag(W - gain @ W[moved])
        return np.where(
            np.isin(np.arange(len(pull)), moved) | (own < SMALL), 0.0, left / np.sqrt(np.maximum(own, TINY))
        )

    def change(self, rig: int, moved: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """Changes of the numbers of a rig that moved together.

        Args:
            rig: Index of the rig.
            moved: Indices of the numbers.

        Returns:
            Changes, and their standard deviations, both (moved,) [SI].
        """
        covariance = np.linalg.pinv(self.information[rig][np.ix_(moved, moved)])
        return covariance @ self.pull[rig][moved] * self.unit[moved], np.sqrt(np.diag(covariance)) * self.unit[moved]


class Changes(NamedTuple):
    """What changed.

    Attributes:
        alarms: One number that moved a line, those of the surest rig first: `rig`, `when`, `against` (`siblings` or `itself`), `number`, others that it may be in its place
            (`or`), `change` [SI; of the misfit a ratio], `from_95`, `to_95`, `expected`, and the probability of chance `p` of the rig.
        rigs: Rigs that were compared with their siblings.
        earlier: Rigs that were compared with themselves in earlier sessions.
        lacking: `rig`, `when` and the `numbers` that most others tell and it does not.
    """

    alarms: pl.DataFrame
    rigs: tuple[str, ...]
    earlier: tuple[str, ...]
    lacking: pl.DataFrame


ALARM = {
    **{name: pl.String for name in ("rig", "when", "against", "number", "or")},
    **{name: pl.Float64 for name in ("change", "from_95", "to_95", "expected", "p")},
}
"""Columns of alarms."""


def changes(rows: pl.DataFrame, false: float = FALSE) -> Changes:
    """Rigs that differ from their siblings, or from themselves in earlier sessions.

    Args:
        rows: Results of a fleet (`rwjax.fleet.store.schema`), all of one design.
        false: Share of the alarms that may be false, on average [1].

    Returns:
        What changed.
    """
    told = rows.filter(pl.col("numbers").is_not_null() | (pl.col("status") != "done")).sort("rig", "when")
    sessions: dict[str, list[tuple[str, dict[str, float], dict[tuple[str, str], float]]]] = {}
    for row in told.iter_rows(named=True):
        sessions.setdefault(row["rig"], []).append((row["when"], *_estimate(row)))
    names = _common(sessions)
    latest, since = _latest(sessions, names), _since_before(sessions, names)
    both = ((latest, "siblings"), (since, "itself"))
    judged = [_judged(one, against) for one, against in both if len(one.rigs) >= FEWEST]
    through = let_through(np.concatenate([np.zeros(0), *(one.p for one in judged)]), false)
    ends = np.cumsum([len(one.p) for one in judged])
    found = [_alarms(one, which) for one, which in zip(judged, np.split(through, ends[:-1]), strict=False)]
    alarms = pl.concat([pl.DataFrame(schema=ALARM), *found]).sort("p", "rig", "when", maintain_order=True)
    rigs, earlier = (one.rigs if len(one.rigs) >= FEWEST else () for one in (latest, since))
    return Changes(alarms, rigs, earlier, _lacking(sessions, latest.names))


def _estimate(row: dict) -> tuple[dict[str, float], dict[tuple[str, str], float]]:
    """Numbers of a row by name, the misfit with them, and their covariances by both names."""
    told = row["numbers"] if row["status"] == "done" else []
    names = [one["name"] for one in told]
    value = {one["name"]: one["value"] for one in told if OF_A_RUN not in one["name"]}
    pairs = ((a, b) for a in names for b in names)
    covariance: dict[tuple[str, str], float] = dict(zip(pairs, row["covariance"] if told else (), strict=True))
    if row["status"] == "done" and row["misfit"]:
        value[MISFIT] = float(np.log(row["misfit"]))
    return value, covariance if row["status"] == "done" else FAILED


def _common(sessions: dict[str, list]) -> tuple[str, ...]:
    """Names of the numbers that most rigs tell in their latest session."""
    counts: dict[str, int] = {}
    for own in sessions.values():
        for name in own[-1][1]:
            counts[name] = counts.get(name, 0) + 1
    return tuple(name for name, count in counts.items() if count > COMMON * len(sessions))


def _arrays(
    names: tuple[str, ...], value: dict[str, float], covariance: dict[tuple[str, str], float]
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers in the order of their names, NaN where there is none, and their covariance."""
    return (
        np.array([value.get(name, np.nan) for name in names]),
        np.array([[covariance.get((a, b), 0.0) for b in names] for a in names]).reshape(len(names), len(names)),
    )


def _together(
    names: tuple[str, ...], found: list[tuple[str, str, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
) -> Estimates:
    """Estimates of several rigs as arrays, without numbers that too few tell, and without rigs that tell none."""
    count = len(names)
    value = np.array([one[2] for one in found]).reshape(len(found), count)
    told = np.isfinite(value).sum(axis=0) >= FEWEST
    kept = [k for k, own in enumerate(value) if np.isfinite(own[told]).any()]
    _, _, _, covariance, sessions, before = zip(*(found[k] for k in kept), strict=True) if kept else ((),) * 6
    return Estimates(
        tuple(name for name, enough in zip(names, told, strict=True) if enough),
        tuple(found[k][0] for k in kept),
        tuple(found[k][1] for k in kept),
        value[kept][:, told],
        np.array(covariance).reshape(len(kept), count, count)[:, told][:, :, told],
        np.array(sessions).reshape(len(kept), count)[:, told],
        np.array(before).reshape(len(kept), count)[:, told],
    )


def _latest(sessions: dict[str, list], names: tuple[str, ...]) -> Estimates:
    """The latest session of every rig."""
    return _together(
        names,
        [
            (rig, own[-1][0], *_arrays(names, *own[-1][1:]), np.ones(len(names)), np.zeros(len(names)))
            for rig, own in sessions.items()
        ],
    )


def _since_before(sessions: dict[str, list], names: tuple[str, ...]) -> Estimates:
    """What the numbers of every rig with several sessions have changed by in the latest, against the mean of those before."""
    found = []
    for rig, (*earlier, (when, *last)) in sessions.items():
        if earlier:
            values, covariances = zip(*(_arrays(names, *one[1:]) for one in earlier), strict=True)
            value, covariance = _arrays(names, *last)
            seen = np.isfinite(values)
            count = seen.sum(axis=0)
            each = np.maximum(count, 1)
            mean = np.where(count > 0, np.where(seen, values, 0.0).sum(axis=0) / each, np.nan)
            spread = covariance + np.sum(covariances, axis=0) / np.outer(each, each)
            found.append((rig, when, value - mean, spread, 1.0 + 1.0 / each, mean))
    return _together(names, found)


def _lacking(sessions: dict[str, list], names: tuple[str, ...]) -> pl.DataFrame:
    """Which of the compared numbers a rig does not tell in its latest session; one that failed is told of elsewhere."""
    rows = []
    for rig, own in sessions.items():
        when, value, covariance = own[-1]
        without = [name for name in names if name not in value]
        if without and covariance is not FAILED:
            rows.append((rig, when, ", ".join(without)))
    return pl.DataFrame(rows, dict.fromkeys(("rig", "when", "numbers"), pl.String), orient="row")


def compared(of: Estimates) -> Compared:
    """Every rig against all of them.

    Args:
        of: Estimates of the rigs.

    Returns:
        What differs.
    """
    variance = np.diagonal(of.covariance, axis1=1, axis2=2)
    expected, spread = _centre_and_spread(of.value, variance, of.sessions)
    # in units of each number's own deviation, since numbers differ by powers of ten
    unit = np.sqrt(np.median(variance, axis=0) + spread**2) if len(of.rigs) else np.ones(len(of.names))
    unit = np.where(unit > 0.0, unit, 1.0)
    told = np.isfinite(of.value)
    V = np.where(told[:, :, None] & told[:, None, :], of.covariance / np.outer(unit, unit), 0.0)
    V += of.sessions[:, :, None] * np.diag((spread / unit) ** 2)
    information = np.linalg.pinv(V, hermitian=True)
    pull = np.einsum("rjk,rk->rj", information, np.where(told, (of.value - expected) / unit, 0.0))
    freedom = EFFICIENCY * (told.sum(axis=0) - 1)
    return Compared(information, np.where(told, pull, 0.0), unit, expected, spread, freedom)


def _centre_and_spread(value: np.ndarray, variance: np.ndarray, sessions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is expected of each number, and its spread beyond the variances (numbers,)."""

    def sizes(centre: np.ndarray, spread: np.ndarray) -> np.ndarray:
        off = np.abs(value - centre)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(off == 0.0, 0.0, off / np.sqrt(variance + sessions * spread**2))

    centre = np.nanmedian(value, axis=0)
    highest = 10.0 * np.nanmedian(np.abs(value - centre), axis=0) / OF_MEDIAN + TINY
    spread = _spread(lambda s: np.nanmedian(sizes(centre, s), axis=0) > OF_MEDIAN, highest)
    kept = np.where(sizes(centre, spread) < WITHIN, value, np.nan)
    weight = np.where(np.isfinite(kept), 1.0 / np.maximum(variance + sessions * spread**2, TINY), 0.0)
    weight = np.where(np.isfinite(kept) & (weight.max(axis=0) >= 1.0 / TINY), 1.0, weight)
    mean = np.nansum(weight * kept, axis=0) / weight.sum(axis=0)

    def beyond(s: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore"):
            squares = np.where(np.isfinite(kept), sizes(mean, s) ** 2, np.nan)
        return np.nanmean(squares, axis=0) > OF_VARIANCE

    return mean, _spread(beyond, highest)


def _spread(beyond: Callable[[np.ndarray], np.ndarray], highest: np.ndarray) -> np.ndarray:
    """The spread up to which numbers lie beyond it, found by halving; 0 where they do not even there."""
    low, high, none = np.zeros(len(highest)), highest, ~beyond(np.zeros(len(highest)))
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        more = beyond(middle)
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.where(none, 0.0, 0.5 * (low + high))


class _Judged(NamedTuple):
    """Rigs against what is expected of them: how striking each number's change is (rigs, numbers), and how probable by chance a rig's."""

    of: Estimates
    against: str
    found: Compared
    striking: np.ndarray
    p: np.ndarray


def _judged(of: Estimates, against: str) -> _Judged:
    """Rigs against what is expected of them."""
    found = compared(of)
    striking = _striking(of.names, found.z)
    sides = np.array([1.0 if name == MISFIT else 2.0 for name in of.names])
    p = (sides * stdtr(found.freedom, -striking)).min(axis=1)
    return _Judged(of, against, found, striking, -np.expm1(len(of.names) * np.log1p(-np.minimum(p, 1.0 - 1e-16))))


def _striking(names: tuple[str, ...], z: np.ndarray) -> np.ndarray:
    """Sizes of changes, in standard deviations; of the misfit only a rise says anything."""
    return np.where(np.array(names) == MISFIT, np.maximum(z, 0.0), np.abs(z))


def _moved(judged: _Judged, rig: int, needed: np.ndarray) -> list[int]:
    """The numbers of a rig that moved, the most striking one first: added while they are needed, the least one left out where it is not."""
    of, found = judged.of, judged.found
    moved = [int(np.argmax(judged.striking[rig]))]
    while len(moved) < len(of.names):
        further = _striking(of.names, found.beside(rig, moved)) - needed
        if further.max() < 0.0:
            break
        moved.append(int(np.argmax(further)))
        change, deviation = found.change(rig, moved)
        least = int(np.argmin(np.abs(change) / deviation - needed[moved]))
        if abs(change[least]) < needed[moved[least]] * deviation[least]:
            del moved[least]
            break
    return moved


def _alarms(judged: _Judged, through: np.ndarray) -> pl.DataFrame:
    """The alarms, by which rigs are let through: one line for each number that moved."""
    of, against, found, striking, p = judged
    quantile, needed = (stdtrit(found.freedom, 1.0 - 0.5 * q) for q in (0.05, FURTHER))
    rows = []
    for rig in map(int, np.flatnonzero(through)):
        moved = _moved(judged, rig, needed)
        near = (striking[rig] ** 2 > striking[rig, moved[0]] ** 2 - NEAR) & (striking[rig] > quantile)
        others = (
            ", ".join(name for j, name in enumerate(of.names) if near[j] and j not in moved) if len(moved) == 1 else ""
        )
        for k, change, deviation in zip(moved, *found.change(rig, moved), strict=True):
            ends = change + quantile[k] * deviation * np.array([-1.0, 1.0])
            expected = of.before[rig, k] + found.expected[k]
            if of.names[k] == MISFIT:
                change, ends, expected = np.exp(change), np.exp(ends), np.exp(expected)
            rows.append((of.rigs[rig], of.whens[rig], against, of.names[k], others, change, *ends, expected, p[rig]))
    return pl.DataFrame(rows, schema=ALARM, orient="row")


def let_through(p: np.ndarray, false: float) -> np.ndarray:
    """The tests that the procedure of Benjamini and Hochberg lets through.

    Args:
        p: Probability of chance of each (tests,) [1].
        false: Share of what is let through that may be false, on average [1].

    Returns:
        Whether each is let through (tests,) [1].
    """
    order = np.argsort(p)
    allowed = false * np.arange(1, len(p) + 1) / max(len(p), 1)
    below = np.flatnonzero(p[order] <= allowed)
    found = np.zeros(len(p), bool)
    if len(below):
        found[order[: below[-1] + 1]] = True
    return found
