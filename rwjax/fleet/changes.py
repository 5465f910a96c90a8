r"""Which rigs of a fleet changed: each against its siblings, and against itself in earlier sessions.

An estimate $\hat\theta_i$ of a rig has the covariance $\Sigma_i$ that its logs leave, and rigs differ: $\hat\theta_i \sim N(\mu,
\Sigma_i + D)$ with $D$ diagonal. $\mu$ and $D$ come from the median and the median absolute deviation over the fleet, so that a tenth of
worn rigs does not spoil them; then once more without those that changed. Against itself the same holds of $\hat\theta_i$ less the weighted mean of the rig's earlier estimates, where
$\mu$ is what all rigs changed by in the same time, and $D$ what a sound rig changes by from one session to the next.

Where number $k$ alone moved, its change is estimated by

$$\delta_k = \frac{(V^{-1}d)_k}{(V^{-1})_{kk}}, \qquad z_k = \frac{(V^{-1}d)_k}{\sqrt{(V^{-1})_{kk}}},$$

with $d = \hat\theta_i - \mu$ and $V = \Sigma_i + D$. $\sum$ of squares falls by $z_k^2$, so that the largest names the number, and others that
fall nearly as much stand beside it. The misfit of a fit, RMS error over noise, is one more number, whose spread is the fleet's alone: an
effect that appears raises it.

A rig has one probability of chance, that of its most striking number, corrected for how many there are (Šidák). Alarms are those that
Benjamini and Hochberg (1995) let through: the stated share of them is false at most, on average.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import polars as pl
from scipy.special import ndtri, stdtr

from rwjax.report.fleet import MISFIT

FALSE = 0.05
"""Share of false alarms among alarms [1]."""
FEWEST = 8
"""Rigs below which their spread is not known, and nothing is said."""
NEAR = 9.0
"""Fall of the sum of squares, against the best, within which another number may be the one that moved: three standard deviations."""
EFFICIENCY = 0.37
"""Degrees of freedom of a median absolute deviation, against those of a standard deviation of as many normal numbers [1]."""
OF_MEDIAN = float(ndtri(0.75))
"""Median absolute deviation of a standard normal number."""
PASSES = 2
"""How often the fleet is looked at, from the second time on without the rigs that changed."""
STEPS = 60
"""Halvings of the interval in which a spread lies."""


class Compared(NamedTuple):
    """Numbers of several rigs against what is expected of them.

    Attributes:
        z: Change of each number where it alone changed, in standard deviations (rigs, numbers) [1].
        change: The same [SI] (rigs, numbers).
        deviation: Its standard deviation [SI] (rigs, numbers).
        expected: What is expected of each number [SI] (numbers,).
        spread: Standard deviation over sound rigs, beyond that of the estimates [SI] (numbers,).
    """

    z: np.ndarray
    change: np.ndarray
    deviation: np.ndarray
    expected: np.ndarray
    spread: np.ndarray


def compared(value: np.ndarray, covariance: np.ndarray, sound: np.ndarray) -> Compared:
    """Every rig against the sound ones.

    Args:
        value: Numbers of the rigs (rigs, numbers) [SI].
        covariance: What the logs leave of each (rigs, numbers, numbers) [SI²].
        sound: Which rigs say what is expected (rigs,) [1].

    Returns:
        What differs.
    """
    variance = np.diagonal(covariance, axis1=1, axis2=2)
    expected, spread = _centre_and_spread(value[sound], variance[sound])
    # in units of each number's own deviation, since numbers differ by powers of ten
    unit = np.sqrt(np.median(variance, axis=0) + spread**2)
    unit = np.where(unit > 0.0, unit, 1.0)
    V = covariance / np.outer(unit, unit) + np.diag((spread / unit) ** 2)
    information = np.linalg.pinv(V, hermitian=True)
    pull = np.einsum("rjk,rk->rj", information, (value - expected) / unit)
    own = np.maximum(np.diagonal(information, axis1=1, axis2=2), np.finfo(float).tiny)
    return Compared(pull / np.sqrt(own), pull / own * unit, unit / np.sqrt(own), expected, spread)


def _centre_and_spread(value: np.ndarray, variance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Median, and the spread beyond the variances for which the median absolute deviation is that of normal numbers (numbers,)."""
    centre = np.median(value, axis=0)
    off = np.abs(value - centre)
    low, high = np.zeros(len(centre)), 10.0 * np.median(off, axis=0) / OF_MEDIAN + np.finfo(float).tiny

    def beyond(spread: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore", invalid="ignore"):
            size = np.where(off > 0.0, off / np.sqrt(variance + spread**2), 0.0)
        return np.median(size, axis=0) > OF_MEDIAN

    none = ~beyond(low)
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        more = beyond(middle)
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return centre, np.where(none, 0.0, 0.5 * (low + high))


def changes(rows: pl.DataFrame, false: float = FALSE) -> pl.DataFrame:
    """Rigs that differ from their siblings, or from themselves in earlier sessions.

    Args:
        rows: Results of a fleet (`rwjax.fleet.store.schema`).
        false: Share of the alarms that may be false, on average [1].

    Returns:
        One alarm a line, the surest first: `rig`, `when`, `against` (`siblings` or `itself`), `number`, others that it may be in its
        place (`or`), `change` [SI; of the misfit as a ratio], `from_95`, `to_95`, `expected`, and the probability of chance `p` of
        the rig.
    """
    told = rows.filter(pl.col("status") == "done", pl.col("numbers").list.len() > 0)
    judged = [
        *(_judged(group, "siblings", false) for group in _alike(_latest(told))),
        *(_judged(group, "itself", false) for group in _alike(_since_before(told))),
    ]
    through = let_through(np.concatenate([np.zeros(0), *(one.p for one in judged)]), false)
    ends = np.cumsum([len(one.p) for one in judged])
    found = [_alarms(one, which, false) for one, which in zip(judged, np.split(through, ends[:-1]), strict=False)]
    return pl.concat([pl.DataFrame(schema=_SCHEMA), *found]).sort("p", "rig", "when")


_SCHEMA = {
    **{name: pl.String for name in ("rig", "when", "against", "number", "or")},
    **{name: pl.Float64 for name in ("change", "from_95", "to_95", "expected", "p")},
}


class _Group(NamedTuple):
    """Rigs with the same numbers: names of both, sessions, and estimates; `expected` of what is 0 where a change is looked at."""

    names: tuple[str, ...]
    rigs: list[str]
    whens: list[str]
    value: np.ndarray
    covariance: np.ndarray
    before: np.ndarray


Estimate = tuple[tuple[str, ...], np.ndarray, np.ndarray]
"""Names of numbers, their values and their covariance."""


def _estimate(row: dict) -> Estimate:
    """The estimate of a row, with the misfit as its last number."""
    names = tuple(one["name"] for one in row["numbers"])
    count = len(names)
    value = np.array([one["value"] for one in row["numbers"]])
    covariance = np.array(row["covariance"]).reshape(count, count)
    if not row["misfit"]:
        return names, value, covariance
    whole = np.zeros((count + 1, count + 1))
    whole[:count, :count] = covariance
    return (*names, MISFIT), np.append(value, np.log(row["misfit"])), whole


Sessions = list[tuple[str, str, Estimate, np.ndarray]]
"""Rig, session, estimate, and what the rig's numbers were before."""


def _latest(rows: pl.DataFrame) -> Sessions:
    """The latest session of every rig."""
    last = rows.sort("when").unique("rig", keep="last", maintain_order=True)
    return [
        (row["rig"], row["when"], found := _estimate(row), np.zeros(len(found[0])))
        for row in last.iter_rows(named=True)
    ]


def _since_before(rows: pl.DataFrame) -> Sessions:
    """What the numbers of every rig with several sessions have changed by in the latest, against the mean of those before."""
    found: Sessions = []
    for _, own in rows.sort("rig", "when").group_by("rig", maintain_order=True):
        *earlier, last = [(row["when"], _estimate(row)) for row in own.iter_rows(named=True)]
        when, (names, value, covariance) = last
        alike = [one for _, one in earlier if one[0] == names]
        if alike:
            mean, left = _mean(alike)
            found.append((own["rig"][0], when, (names, value - mean, covariance + left), mean))
    return found


def _mean(estimates: Sequence[Estimate]) -> tuple[np.ndarray, np.ndarray]:
    """The mean of several estimates, weighted by their variances, and its covariance."""
    variance = np.array([np.diag(c) for _, _, c in estimates])
    weight = np.where(variance > 0.0, 1.0 / np.where(variance > 0.0, variance, 1.0), 1.0)
    weight /= weight.sum(axis=0)
    value = sum(w * v for w, (_, v, _) in zip(weight, estimates, strict=True))
    covariance = sum(np.outer(w, w) * c for w, (_, _, c) in zip(weight, estimates, strict=True))
    return np.asarray(value), np.asarray(covariance)


def _alike(sessions: Sessions) -> list[_Group]:
    """Rigs by the numbers that they have; groups of too few are left out."""
    by_names: dict[tuple[str, ...], Sessions] = {}
    for one in sessions:
        by_names.setdefault(one[2][0], []).append(one)
    return [
        _Group(
            names,
            [one[0] for one in of],
            [one[1] for one in of],
            np.array([one[2][1] for one in of]),
            np.array([one[2][2] for one in of]),
            np.array([one[3] for one in of]),
        )
        for names, of in by_names.items()
        if len(of) >= FEWEST
    ]


class _Judged(NamedTuple):
    """A group against what is expected of it: how probable each number's change is by chance, and each rig's most striking one."""

    group: _Group
    against: str
    found: Compared
    p_of: np.ndarray
    p: np.ndarray


def _judged(group: _Group, against: str, false: float) -> _Judged:
    """A group, looked at once more without the rigs that changed: medians are then closer to what the others are like."""
    sound = np.ones(len(group.rigs), bool)
    for _ in range(PASSES):
        found = compared(group.value, group.covariance, sound)
        p_of, p = _by_chance(group, found.z)
        sound = ~let_through(p, false)
    return _Judged(group, against, found, p_of, p)


def _alarms(judged: _Judged, through: np.ndarray, false: float) -> pl.DataFrame:
    """The alarms of one group, by which of its rigs are let through."""
    group, against, found, p_of, p = judged
    rows = []
    for k in np.flatnonzero(through):
        best = int(np.argmin(p_of[k]))
        near = [
            n
            for j, n in enumerate(group.names)
            if j != best and found.z[k, j] ** 2 > found.z[k, best] ** 2 - NEAR and p_of[k, j] < false
        ]
        change, deviation = found.change[k, best], found.deviation[k, best]
        ends = change + 1.96 * deviation * np.array([-1.0, 1.0])
        expected = group.before[k, best] + found.expected[best]
        if group.names[best] == MISFIT:
            change, ends, expected = np.exp(change), np.exp(ends), np.exp(expected)
        rows.append(
            (group.rigs[k], group.whens[k], against, group.names[best], ", ".join(near), change, *ends, expected, p[k])
        )
    return pl.DataFrame(rows, schema=_SCHEMA, orient="row")


def _by_chance(group: _Group, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How probable such changes are by chance: of each number (rigs, numbers), and of the most striking one of each rig (rigs,)."""
    freedom = EFFICIENCY * (len(group.rigs) - 1)  # few rigs tell their spread badly
    p_of = 2.0 * stdtr(freedom, -np.abs(z))
    if MISFIT in group.names:  # only a worse one says anything
        at = group.names.index(MISFIT)
        p_of[:, at] = stdtr(freedom, -z[:, at])
    return p_of, -np.expm1(len(group.names) * np.log1p(-np.minimum(p_of.min(axis=1), 1.0 - 1e-16)))


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
