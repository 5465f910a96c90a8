r"""Which rigs of a fleet changed: each against its siblings, and against itself in earlier sessions.

An estimate $\hat\theta_i$ of a rig has the covariance $\Sigma_i$ that its logs leave, and rigs differ: $\hat\theta_i \sim N(\mu, \Sigma_i + D)$
with $D$ diagonal. Both come from Huber's second proposal (Robust Statistics, 1981, section 6.4), which counts what lies beyond one standard
deviation as if it lay there, so that a tenth of worn rigs does not spoil it, and then from mean and variance of what lies within a limit. That is
2.5 standard deviations of many rigs. Of few it is Student's quantile of the same probability: otherwise a spread that is too small by chance
leaves sound rigs out, and grows smaller for it. The limit is applied again to what came of it, so that rigs come back.
Against itself the same holds of $\hat\theta_i$ less the mean of the rig's $n$ earlier estimates. $\mu$ is then what all rigs changed by in
the same time, and $D$, which counts $1 + 1/n$ times, what a sound rig changes by from session to session.

Where number $k$ alone moved, its change is estimated by

$$\delta_k = \frac{(V^{-1}d)_k}{(V^{-1})_{kk}}, \qquad z_k = \frac{(V^{-1}d)_k}{\sqrt{(V^{-1})_{kk}}},$$

with $d = \hat\theta_i - \mu$ and $V = \Sigma_i + D$ plus the covariance of $\mu$. The sum of squares falls by $z_k^2$: the largest names the number,
and others that fall nearly as much stand beside it. Where more than chance is left, a further number moved: numbers are added while they are needed, and left
out again where they are not, and the changes are those of all of them together. The misfit of a fit, RMS error over noise, is one more number, whose spread is the fleet's alone: an effect
that appears raises it.

A rig has one probability of chance, that of its most striking number, corrected for how many there are (Šidák). Few rigs tell their spread
badly, so that it is Student's. Alarms are those that Benjamini and Hochberg (1995) let through of all comparisons together: the stated share of
them is false at most, on average.
"""

from collections.abc import Callable, Collection
from typing import NamedTuple

import numpy as np
import polars as pl
from scipy.special import ndtr, stdtr, stdtrit
from scipy.stats import false_discovery_control

from rwjax.fleet import FALSE
from rwjax.fleet.sessions import FEWEST, MISFIT, Estimates, common, lacking, latest, sessions_of, since_before

FURTHER = 1e-3
"""Probability of chance below which a further number of a rig that changed counts as one that moved, too [1]."""
NEAR = 9.0
"""Fall of the sum of squares, against the best, within which another number may be the one that moved: three standard deviations."""
BOUND = 1.0
"""Standard deviations to which Huber's second proposal brings in what lies beyond [1]."""
OF_BOUNDED = float(
    2.0 * (ndtr(BOUND) - 0.5 - BOUND * np.exp(-0.5 * BOUND**2) / np.sqrt(2.0 * np.pi) + BOUND**2 * ndtr(-BOUND))
)
"""Mean square of standard normal numbers that are brought in so [1]."""
WITHIN = 2.5
"""Standard deviations from the centre within which numbers of many rigs count for mean and spread [1]."""
OF_VARIANCE = float(1.0 - 2.0 * WITHIN * np.exp(-0.5 * WITHIN**2) / np.sqrt(2.0 * np.pi) / (2.0 * ndtr(WITHIN) - 1.0))
"""Mean square of normal numbers within that [1]."""
EFFICIENCY = 0.7
"""Degrees of freedom of such a spread, against those of a standard deviation of as many normal numbers [1]; the tests hold it against fleets
where nothing changed."""
ROUNDS = 5
"""How often centre and spread are found in turn, and how often the limit is applied."""
TINY, SMALL = np.finfo(float).tiny, 1e-9
"""What stands for 0 in a divisor; an information below which nothing is told [1]."""
STEPS = 60
"""Halvings of the interval in which a spread lies."""


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
        alarms: One number that moved a line, those of the surest rig first: `rig`, `when`, `against` (`siblings` or `itself`), `number`,
            others that it may be in its place (`or`), `change` [SI; of the misfit a ratio], `from_95`, `to_95`, `expected`, and the
            probability of chance `p` of the rig.
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


def changes(rows: pl.DataFrame, false: float = FALSE, shared: Collection[str] = ()) -> Changes:
    """Rigs that differ from their siblings, or from themselves in earlier sessions.

    Args:
        rows: Results of a fleet (`rwjax.fleet.store.schema`), all of one design.
        false: Share of the alarms that may be false, on average [1].
        shared: Names of numbers that are one and the same in all sound rigs; from session to session they may change.

    Returns:
        What changed.
    """
    sessions = sessions_of(rows)
    names = common(sessions)
    now, since = latest(sessions, names), since_before(sessions, names)
    rigs, earlier = (one.rigs if len(one.rigs) >= FEWEST else () for one in (now, since))
    return Changes(alarms(now, since, false, shared), rigs, earlier, lacking(sessions, now.names))


def alarms(now: Estimates, since: Estimates, false: float = FALSE, shared: Collection[str] = ()) -> pl.DataFrame:
    """Numbers of rigs that differ from those of their siblings, or from their own in earlier sessions.

    Args:
        now: Estimates of the latest session of each rig.
        since: What each rig has changed by since the sessions before.
        false: Share of the alarms that may be false, on average [1].
        shared: Names of numbers that are one and the same in all sound rigs; from session to session they may change.

    Returns:
        The alarms, as `Changes` has them; none of fewer than `rwjax.fleet.sessions.FEWEST` rigs.
    """
    both = ((now, "siblings", shared), (since, "itself", ()))
    judged = [_judged(one, which, of) for one, which, of in both if len(one.rigs) >= FEWEST]
    through = let_through(np.concatenate([np.zeros(0), *(one.p for one in judged)]), false)
    ends = np.cumsum([len(one.p) for one in judged])
    found = [_alarms(one, which) for one, which in zip(judged, np.split(through, ends[:-1]), strict=False)]
    return pl.concat([pl.DataFrame(schema=ALARM), *found]).sort("p", "rig", "when", maintain_order=True)


def compared(of: Estimates, shared: Collection[str] = ()) -> Compared:
    """Every rig against all of them.

    Args:
        of: Estimates of the rigs.
        shared: Names of numbers that are one and the same in all rigs, which have no spread.

    Returns:
        What differs.
    """
    variance = np.diagonal(of.covariance, axis1=1, axis2=2)
    same = np.array([name in shared for name in of.names], bool)
    expected, spread, share = _centre_and_spread(of.value, variance, of.sessions, same)
    # in units of each number's own deviation, since numbers differ by powers of ten
    unit = np.sqrt(np.median(variance, axis=0) + spread**2)
    unit = np.where(unit > 0.0, unit, 1.0)
    told = np.isfinite(of.value)
    V = np.where(told[:, :, None] & told[:, None, :], of.covariance / np.outer(unit, unit), 0.0)
    V += of.sessions[:, :, None] * np.diag((spread / unit) ** 2)
    V += (
        told[:, :, None] * told[:, None, :] * np.einsum("rj,rjk,rk->jk", share, V, share)
    )  # the centre has an error, too
    information = np.linalg.pinv(V, hermitian=True)
    pull = np.einsum("rjk,rk->rj", information, np.where(told, (of.value - expected) / unit, 0.0))
    freedom = EFFICIENCY * (told.sum(axis=0) - 1)
    return Compared(information, np.where(told, pull, 0.0), unit, expected, spread, freedom)


def _centre_and_spread(
    value: np.ndarray, variance: np.ndarray, sessions: np.ndarray, same: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centre and spread of each number (numbers,), no spread where it is the same in all rigs, and the rigs' shares in the centre."""

    def sizes(centre: np.ndarray, spread: np.ndarray) -> np.ndarray:
        off = np.where(told, np.abs(value - centre), 0.0)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.where(off == 0.0, 0.0, off / np.sqrt(variance + sessions * spread**2))

    def shares(counts: np.ndarray, spread: np.ndarray) -> np.ndarray:
        weight = counts / np.maximum(variance + sessions * spread**2, TINY)
        weight = np.where(weight.max(axis=0) >= 1.0 / TINY, counts, weight)
        return weight / weight.sum(axis=0)

    def spread_of(squares: Callable[[np.ndarray], np.ndarray], count: np.ndarray, usual: float) -> np.ndarray:
        return np.where(same, 0.0, _spread(lambda s: squares(s).sum(axis=0) > usual * (count - 1.0), highest))

    def moved_on(centre: np.ndarray, share: np.ndarray) -> np.ndarray:
        return centre + np.where(told, share * (value - centre), 0.0).sum(axis=0)

    told = np.isfinite(value)
    count, centre = told.sum(axis=0), np.nanmedian(value, axis=0)
    highest = 4.0 * np.nanmax(np.abs(value - centre), axis=0) + TINY
    for _ in range(ROUNDS):
        spread = spread_of(lambda s, c=centre: np.minimum(sizes(c, s), BOUND) ** 2, count, OF_BOUNDED)
        beyond = np.maximum(sizes(centre, spread), BOUND)
        centre = moved_on(centre, shares(np.where(told, BOUND / beyond, 0.0), spread))
    for _ in range(ROUNDS):
        limit = stdtrit(np.maximum(count - 2.0, 1.0), ndtr(WITHIN)) * np.sqrt(1.0 + 1.0 / count)
        kept = told & (sizes(centre, spread) < limit)
        count, share = kept.sum(axis=0), shares(kept, spread)
        centre = moved_on(centre, share)
        spread = spread_of(lambda s, c=centre, k=kept: np.where(k, sizes(c, s) ** 2, 0.0), count, OF_VARIANCE)
    return centre, spread, share


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


def _judged(of: Estimates, against: str, shared: Collection[str]) -> _Judged:
    """Rigs against what is expected of them."""
    found = compared(of, shared)
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
    return false_discovery_control(p) <= false if len(p) else np.zeros(0, bool)
