"""Pairs of names that explain together what neither of them explains alone, by the gain that they are predicted to bring.

Another payload changes an axis's inertia and the torque of its weight. With one of the two alone the rig comes no closer, and a search
that adds one name after the other never looks at both. So every name is probed around the rig as it is, and linear least squares says
what any two of them leave together. The probes of single names serve for all of their pairs.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis, chosen_names, free_names
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.score_screen import Probe, ScoreScreen
from rwjax.diagnosis.search.neighbours import extensions
from rwjax.diagnosis.settings import PairSettings
from rwjax.diagnosis.starting_points import candidate_of
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.secant import search_point


@dataclass(frozen=True)
class Joint:
    """What two probes explain together.

    Attributes:
        names: the two names.
        predicted: half the sum of squares [1] that their best sum is predicted to leave.
        probes: the two probes.
        shares: the share of each in that sum [1].
    """

    names: Hypothesis
    predicted: float
    probes: tuple[Probe, Probe]
    shares: tuple[float, float]


def promising_pairs(fits: ModelFits, candidates: Sequence[str]) -> dict[Hypothesis, list[Fit]]:
    """The pairs that are predicted to leave least.

    Args:
        fits: the rig's fits, that of the rig as it is at its end.
        candidates: names that might be missing.

    Returns:
        Points without a step from which the fit of each pair may begin, the most promising pair first.
    """
    limits = fits.settings.pairs
    run = partial(fits.together, work=fits.settings.headway.screened * len(candidates))
    screen = ScoreScreen(fits(NOTHING), fits.settings.screening, run)
    singles = extensions(candidates, NOTHING)
    probes = screen.probes({e: candidate_of(fits, e, NOTHING) for e in singles})
    possible = {both for e in singles for both in extensions(candidates, e) if len(both.names) > 1}
    chosen = foremost((p for p in joint_gains(screen.left, probes, limits) if p.names in possible), limits)
    return {e: _places(fits, screen, pair, limits.begun_at) for e, pair in chosen.items()}


def foremost(pairs: Iterable[Joint], limits: PairSettings) -> dict[Hypothesis, Joint]:
    """The first pairs of different names, among which no name stands too often.

    Args:
        pairs: pairs of probes, the one that leaves least first; several may be of the same names.
        limits: how many pairs are taken, and how many of one name.

    Returns:
        The first probes of each pair of names.
    """
    chosen: dict[Hypothesis, Joint] = {}
    count: Counter[str] = Counter()
    for pair in pairs:
        if len(chosen) == limits.fitted:
            break
        if pair.names not in chosen and all(count[name] < limits.of_a_name for name in pair.names.names):
            chosen[pair.names] = pair
            count.update(pair.names.names)
    return chosen


def joint_gains(left: np.ndarray, probes: Sequence[Probe], limits: PairSettings) -> Iterator[Joint]:
    """The best sum of every two probes of different names.

    With the changes c and d of two probes and their shares s and t, it is where ``|left + s c + t d|² / 2`` is least within the bounds
    of the shares.

    Args:
        left: what is to be explained (m,), in units of the noise [1].
        probes: the probes.
        limits: limits of the shares, and from where on two changes are alike.

    Yields:
        The pairs, the one that leaves least first.
    """
    known = [p for p in probes if np.any(p.change)]
    if len(known) < 2:
        return
    changes = np.stack([p.change for p in known])
    size = np.sqrt(np.sum(changes**2, axis=1))
    changes /= size[:, None]
    alike, towards = changes @ changes.T, -changes @ left
    most = limits.largest * size
    least = np.where([p.one_sided for p in known], 0.0, -most)
    i, j = np.triu_indices(len(known), 1)
    kept = np.abs(alike[i, j]) <= limits.alike
    i, j = i[kept], j[kept]
    c, a, b = alike[i, j], towards[i], towards[j]
    inner = (a - c * b) / (1.0 - c**2), (b - c * a) / (1.0 - c**2)
    sums = [tuple(np.clip(x, least[k], most[k]) for x, k in zip(inner, (i, j), strict=True))]
    sums += [(edge[i], np.clip(b - c * edge[i], least[j], most[j])) for edge in (least, most)]
    sums += [(np.clip(a - c * edge[j], least[i], most[i]), edge[j]) for edge in (least, most)]
    gains = np.array([2.0 * (a * s + b * t) - s**2 - t**2 - 2.0 * c * s * t for s, t in sums])
    best = np.argmax(gains, axis=0)
    predicted = 0.5 * (float(left @ left) - np.max(gains, axis=0))
    for k in np.argsort(predicted, kind="stable"):
        one, other = known[i[k]], known[j[k]]
        if one.hypothesis != other.hypothesis:
            s, t = (float(x[k]) for x in sums[best[k]])
            names = one.hypothesis.plus(*other.hypothesis.names)
            yield Joint(names, float(predicted[k]), (one, other), (s / size[i[k]], t / size[j[k]]))


def _places(fits: ModelFits, screen: ScoreScreen, pair: Joint, shares: Sequence[float]) -> list[Fit]:
    """Points from which the fit of a pair may begin: shares of what it is predicted to need, the free numbers moved to suit them."""
    whole = candidate_of(fits, pair.names, NOTHING)
    names, (moves, _) = whole.problem.structure.names, fits.space(pair.names)
    own = {*free_names(fits.rig, pair.names, fits.outputs), *chosen_names(pair.names)}
    found = []
    for share in shares:
        theta, residual = whole.off.copy(), screen.residual
        for probe, amount in zip(pair.probes, pair.shares, strict=True):
            for name, value in probe.numbers(share * amount).items():
                if name in own:  # of two effects that include the same one, the first brings its numbers
                    theta[names.index(name)] = value
            residual = residual + share * amount * probe.whole
        theta = np.clip(screen.with_free_numbers(whole, theta, residual), *whole.bounds.T)
        found.append(search_point(whole.problem, moves, theta, whole.first))
    return found
