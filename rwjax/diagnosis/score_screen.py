"""Screen: what each candidate would remove from the residual at best, from a few free runs and no fit.

At a fitted hypothesis every candidate is switched on at values from which a search would begin; what that changes in the
free run, and what the free numbers and first states could change, are columns of a least-squares problem in which the
residual is the right side. Free runs at finite values see what a derivative at the null does not (a dead zone, a delay, an
end stop), and small lasting torques that local residuals miss (Breusch and Pagan's score test, with finite probes).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rwjax.fitting.batched_runs import together
from rwjax.fitting.gauss_newton import initial_state_normal, initial_state_response
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import Problem
from rwjax.fitting.secant import residuals
from rwjax.fitting.sensitivities import residual_jacobian

LARGEST = 3.0
"""Most by which what a start changes is taken to grow in proportion."""
PART = 0.3
"""Change that a probe makes, as a share of what is left: so near the parent a search does not begin much worse than there."""
FURTHEST = 0.5
"""Most by which a free number is moved at once, as a share of its size."""
FEW = 12
"""Starts of a candidate from all of which a search begins; of more, from the predicted and from the nearest one."""
SHAPES = 3
"""Predicted places at most, of starts that differ in more than amplitudes, from which a search begins."""
PROBED = (1e-3, 30.0)
"""Shares of a start's amplitude down and up to which it is probed."""


@dataclass(frozen=True)
class Screened:
    """`left`: half the sum of squares that the best of the starts is predicted to leave; `begin`: numbers at which a search
    should begin; `theta`: those among the parent's and the starts that leave least as they are, and the `residual` there."""

    left: float
    begin: tuple[np.ndarray, ...]
    theta: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True)
class Candidate:
    """An hypothesis to be screened: the problem of its structure, the parent's first states in its order, numbers where it
    adds nothing, and starts (t,).

    `besides`: places to begin that are not probed; `free` (t,): numbers that it may move, `amplitude` (t,) those of them in
    proportion to which it acts; `bounds` (t, 2).
    """

    problem: Problem
    first: np.ndarray
    off: np.ndarray
    starts: Sequence[np.ndarray]
    besides: Sequence[np.ndarray]
    free: np.ndarray
    amplitude: np.ndarray
    bounds: np.ndarray

    def shapes(self) -> list[list[int]]:
        """Numbers of the starts that differ in amplitudes alone, together: they add up."""
        groups: dict[bytes, list[int]] = {}
        for k, start in enumerate(self.starts):
            groups.setdefault(np.where(self.amplitude, 0.0, start).tobytes(), []).append(k)
        return list(groups.values())


class Screen:
    """Predictions around one fit."""

    def __init__(self, fitted: Fit) -> None:
        self.fitted = fitted
        problem, e = fitted.problem, fitted.evaluation
        k = np.arange(len(fitted.coordinates.index))
        p = len(e.local) - problem.start.shape[1]
        blocks = []
        for log in range(len(problem.logs)):
            s = np.flatnonzero(problem.start_free[log])
            through = residual_jacobian(e, log)
            P, _ = initial_state_response(*initial_state_normal(problem, e, log), k, p + s, 0.0)
            blocks.append((through[..., k] + through[..., p + s] @ P).reshape(-1, len(k)))
        self.seen = problem.batch.weight.ravel() > 0.0
        self.columns = np.concatenate(blocks).reshape(-1, len(k))[self.seen]
        self.basis = _orthonormal(self.columns)

    def _with_free_numbers(self, candidate: Candidate, theta: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Numbers with those that the parent and the candidate have free moved to where they leave least of a residual, by no
        more than `FURTHEST`."""
        names = candidate.problem.structure.names
        also = [k for k, name in enumerate(self.fitted.free) if name in names and candidate.free[names.index(name)]]
        columns = self.columns[:, also]
        scale = np.maximum(np.sqrt(np.sum(columns**2, axis=0)), 1e-300)
        change = np.linalg.lstsq(columns / scale, -residual, rcond=1e-6)[0] / scale
        theta = theta.copy()
        for k, d in zip(also, change, strict=True):
            most = FURTHEST * self.fitted.coordinates.size[k]
            theta[names.index(self.fitted.free[k])] += np.clip(d, -most, most)
        return theta

    def _without(self, columns: np.ndarray) -> np.ndarray:
        """Columns with what the free numbers can do taken out."""
        return columns - self.basis @ (self.basis.T @ columns)

    def predict(self, candidates: Sequence[Candidate]) -> list[Screened]:
        """What every candidate leaves at best, and where it should begin: probed at its starts, then at amplitudes that
        change a part of what there is to explain."""
        coarse = self._probed(candidates)
        scaled = [self._scaled(c, r) for c, r in zip(candidates, coarse, strict=True)]
        fine = self._probed(scaled)
        found = []
        for c, far, near, nearby in zip(candidates, coarse, scaled, fine, strict=True):
            own = [*near.starts, *self._moved(near, nearby), *c.starts, *self._moved(c, far)]
            predicted = self._predict(near, nearby)
            begin = (*predicted.begin, *(own if len(c.starts) <= FEW else ()), *c.besides)
            found.append(replace(predicted, begin=_different(begin)))
        return found

    def _moved(self, candidate: Candidate, probed: np.ndarray) -> list[np.ndarray]:
        """The starts of a candidate, each with the free numbers moved to where they leave least of its residual."""
        left = probed.reshape(len(probed), -1)[1:, self.seen]
        known = [(theta, r) for theta, r in zip(candidate.starts, left, strict=True) if np.all(np.isfinite(r))]
        return [np.clip(self._with_free_numbers(candidate, theta, r), *candidate.bounds.T) for theta, r in known]

    def _probed(self, candidates: Sequence[Candidate]) -> list[np.ndarray]:
        """Residuals of every candidate without its effect and at its starts."""
        return together([residuals(c.problem, [c.off, *c.starts], [c.first] * (1 + len(c.starts))) for c in candidates])

    def _scaled(self, candidate: Candidate, probed: np.ndarray) -> Candidate:
        """The candidate with amplitudes of its starts that change a part of what is left."""
        residual, *others = probed.reshape(len(probed), -1)[:, self.seen]
        whole = float(np.linalg.norm(self._without(residual)))
        starts = []
        for start, r in zip(candidate.starts, others, strict=True):
            change = float(np.linalg.norm(self._without(r - residual))) if np.all(np.isfinite(r)) else np.inf
            share = float(np.clip(PART * whole / change, *PROBED)) if change > 0.0 and np.isfinite(whole) else 1.0
            scaled = np.where(candidate.amplitude, candidate.off + share * (start - candidate.off), start)
            starts.append(np.clip(scaled, *candidate.bounds.T))
        return replace(candidate, starts=starts)

    def _predict(self, candidate: Candidate, probed: np.ndarray) -> Screened:
        residual, *others = probed.reshape(len(probed), -1)[:, self.seen]
        with np.errstate(over="ignore", invalid="ignore"):
            cost = np.nan_to_num(np.sum(probed.reshape(len(probed), -1) ** 2, axis=1), nan=np.inf)
        nearest = candidate.starts[int(np.argmin(cost[1:]))]
        free = self._without(residual)
        finite = bool(np.all(np.isfinite(free)))
        least, begin = 0.5 * float(free @ free) if finite else np.inf, []
        for group in candidate.shapes():
            known = [k for k in group if np.all(np.isfinite(others[k]))]
            if not known or not finite:
                continue
            starts = [candidate.starts[k] for k in known]
            C = self._without(np.stack([others[k] - residual for k in known], axis=1))
            share = np.linalg.lstsq(C, -free, rcond=1e-9)[0]
            change = np.stack([np.where(candidate.amplitude, start - candidate.off, 0.0) for start in starts])
            one_sided = ((change != 0.0) & (candidate.bounds[:, 0] >= 0.0)).any(axis=1)
            share = np.clip(share, np.where(one_sided, 0.0, -LARGEST), LARGEST)
            left = 0.5 * float(np.sum((free + C @ share) ** 2))
            if left < least:
                theta = starts[0]
                if change.any():
                    theta = np.where(candidate.amplitude, candidate.off + share @ change, theta)
                whole = residual + np.stack([others[k] - residual for k in known], axis=1) @ share
                theta = self._with_free_numbers(candidate, theta, whole)
                begin.append((left, np.clip(theta, *candidate.bounds.T)))
        begin = sorted(begin, key=lambda b: b[0])[:SHAPES]
        here = int(np.argmin(cost))
        return Screened(
            min((left for left, _ in begin), default=least),
            (*(theta for _, theta in begin), np.clip(nearest, *candidate.bounds.T)),
            (candidate.off, *candidate.starts)[here],
            probed[here],
        )


def _different(several: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
    return tuple({one.tobytes(): one for one in several}.values())


def _orthonormal(columns: np.ndarray) -> np.ndarray:
    scale = np.sqrt(np.sum(columns**2, axis=0))
    columns = columns[:, scale > 0.0] / scale[scale > 0.0]
    if not columns.shape[1]:
        return columns
    u, s, _ = np.linalg.svd(columns, full_matrices=False)
    return u[:, s > 1e-8 * s[0]]
