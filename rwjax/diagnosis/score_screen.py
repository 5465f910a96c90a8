"""Score screen: what each candidate would leave of the residual at best, from a few free runs and no fit.

This is a score test (Breusch and Pagan, Rev. Econ. Stud. 47 (1980)) with finite probes in place of derivatives. Around a fitted
hypothesis every candidate is switched on at the values from which a search would begin. A least-squares problem has the residual on
its right side. Its columns are what a probe changes in the free run, and what the free numbers and first states could change. Finite
probes see what a derivative at the null does not, such as a dead zone, a delay or an end stop. Free runs also see small lasting
torques that local residuals miss.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.settings import ScreeningSettings
from rwjax.fitting.gauss_newton import initial_state_normal, initial_state_response
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.problem import Problem
from rwjax.fitting.processes import ALONE, Task
from rwjax.fitting.secant import residuals
from rwjax.fitting.sensitivities import residual_jacobian


@dataclass(frozen=True)
class Screened:
    """What the score screen says of one candidate.

    Attributes:
        predicted: half the sum of squares [1] that the best of the starts is predicted to leave.
        begin: parameter vectors (t,) [SI] from which a search should begin.
        theta: the parameter vector (t,) [SI], among the parent's and the starts, that leaves least as it is.
        residual: the residual there (l, w, q, y), in units of the noise [1].
    """

    predicted: float
    begin: tuple[np.ndarray, ...]
    theta: np.ndarray
    residual: np.ndarray


@dataclass(frozen=True)
class Candidate:
    """A hypothesis to be screened.

    Attributes:
        problem: the training logs with the hypothesis's structure.
        first: the parent's first states in its order (l, n) [SI].
        off: numbers (t,) [SI] at which it adds nothing.
        starts: parameter vectors (t,) [SI] at which it is probed.
        unprobed: parameter vectors (t,) [SI] from which a search should begin besides.
        free: numbers that it may move (t,).
        amplitude: those of them in proportion to which it acts (t,).
        bounds: least and largest values (t, 2) [SI].
    """

    problem: Problem
    first: np.ndarray
    off: np.ndarray
    starts: Sequence[np.ndarray]
    unprobed: Sequence[np.ndarray]
    free: np.ndarray
    amplitude: np.ndarray
    bounds: np.ndarray

    def shapes(self) -> list[list[int]]:
        """Groups of starts that differ in amplitudes alone, whose changes therefore add up.

        Returns:
            Positions of the starts of each group.
        """
        groups: dict[bytes, list[int]] = {}
        for k, start in enumerate(self.starts):
            groups.setdefault(np.where(self.amplitude, 0.0, start).tobytes(), []).append(k)
        return list(groups.values())


@dataclass(frozen=True)
class Probe:
    """What one start of a candidate changes in the free run.

    Attributes:
        hypothesis: the candidate's name.
        candidate: the candidate, its starts so scaled that they change a part of what is left.
        start: the start, as a parameter vector (t,) [SI].
        whole: change of the residual (m,), in units of the noise [1].
        change: the same without what the free numbers can do (m,) [1].
    """

    hypothesis: Hypothesis
    candidate: Candidate
    start: np.ndarray
    whole: np.ndarray
    change: np.ndarray

    @property
    def one_sided(self) -> bool:
        """Whether an amplitude that it moves cannot have the other sign."""
        moved = self.candidate.amplitude & (self.start != self.candidate.off)
        return bool(np.any(moved & (self.candidate.off <= self.candidate.bounds[:, 0])))

    def numbers(self, share: float) -> dict[str, float]:
        """Numbers that the start sets, amplitudes at a share of theirs.

        Args:
            share: the share [1].

        Returns:
            Values by name [SI].
        """
        c = self.candidate
        theta = np.where(c.amplitude, c.off + share * (self.start - c.off), self.start)
        names = c.problem.structure.names
        return {names[k]: float(theta[k]) for k in np.flatnonzero(self.start != c.off)}


class ScoreScreen:
    """Predictions around one fit.

    Attributes:
        fitted: the fit, at its end.
        limits: limits of the screen.
        run: how several searches are run.
        residual: what the fit leaves where something was read (m,), in units of the noise [1].
        left: the same without what the free numbers can do (m,) [1].
    """

    def __init__(
        self,
        fitted: Fit,
        limits: ScreeningSettings,
        run: Callable[[list[Task[np.ndarray]]], list[np.ndarray]] = ALONE.together,
    ) -> None:
        self.fitted = fitted
        self.limits = limits
        self.run = run
        problem, e = fitted.problem, fitted.evaluation
        k = np.arange(len(fitted.coordinates.index))
        p = len(e.local) - problem.start.shape[1]
        blocks = []
        for log in range(len(problem.logs)):
            s = np.flatnonzero(problem.start_free[log])
            through = residual_jacobian(e, log)
            P, _ = initial_state_response(*initial_state_normal(problem, e, log), k, p + s, 0.0)
            blocks.append(through[..., k] + through[..., p + s] @ P)
        self._observed = problem.batch.weight.ravel() > 0.0
        self._columns = np.stack(blocks).reshape(len(self._observed), len(k))[self._observed]
        self._basis = _orthonormal(self._columns)
        self.residual = e.residual.ravel()[self._observed]
        self.left = self._without(self.residual)

    def with_free_numbers(self, candidate: Candidate, theta: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """Numbers with those that parent and candidate have free moved to where they leave least of a residual.

        Args:
            candidate: the candidate.
            theta: parameter vector (t,) [SI].
            residual: the residual there where something was read (m,), in units of the noise [1].

        Returns:
            The parameter vector with these numbers moved (t,) [SI].
        """
        names = candidate.problem.structure.names
        also = [k for k, name in enumerate(self.fitted.free) if name in names and candidate.free[names.index(name)]]
        columns = self._columns[:, also]
        with np.errstate(over="ignore", invalid="ignore"):  # a run that leaves the range of numbers
            scale = np.maximum(np.sqrt(np.sum(columns**2, axis=0)), 1e-300)
        change = np.linalg.lstsq(columns / scale, -residual, rcond=1e-6)[0] / scale
        theta = theta.copy()
        for k, d in zip(also, change, strict=True):
            most = self.limits.furthest * self.fitted.coordinates.size[k]
            theta[names.index(self.fitted.free[k])] += np.clip(d, -most, most)
        return theta

    def _without(self, columns: np.ndarray) -> np.ndarray:
        """Columns with what the free numbers can do taken out."""
        return columns - self._basis @ (self._basis.T @ columns)

    def predict(self, candidates: Sequence[Candidate]) -> list[Screened]:
        """What every candidate leaves at best, and where its fit should begin.

        Each is probed at its starts, then at amplitudes that change a part of what there is to explain.

        Args:
            candidates: those to screen.

        Returns:
            The prediction of each.
        """
        coarse = self._probed(candidates)
        scaled = [self._scaled(c, r) for c, r in zip(candidates, coarse, strict=True)]
        fine = self._probed(scaled)
        found = []
        for c, far, near, nearby in zip(candidates, coarse, scaled, fine, strict=True):
            predicted = self._predict(near, nearby)
            few = len(c.starts) <= self.limits.few_starts
            own = [*near.starts, *self.moved(near, nearby), *c.starts, *self.moved(c, far)] if few else []
            found.append(replace(predicted, begin=_different((*predicted.begin, *own, *c.unprobed))))
        return found

    def probes(self, candidates: Mapping[Hypothesis, Candidate]) -> list[Probe]:
        """What the starts of every candidate change, at amplitudes that change a part of what there is to explain.

        Args:
            candidates: candidates by their names.

        Returns:
            A probe for each start with a finite residual.
        """
        every = [*candidates.values()]
        scaled = [self._scaled(c, r) for c, r in zip(every, self._probed(every), strict=True)]
        found = []
        for e, c, probed in zip(candidates, scaled, self._probed(scaled), strict=True):
            residual, *others = probed.reshape(len(probed), -1)[:, self._observed]
            for start, other in zip(c.starts, others, strict=True):
                change = other - residual
                if np.all(np.isfinite(change)):
                    found.append(Probe(e, c, start, change, self._without(change)))
        return found

    def moved(self, candidate: Candidate, probed: np.ndarray) -> list[np.ndarray]:
        """The starts of a candidate, each with the free numbers moved to where they leave least of its residual.

        Args:
            candidate: the candidate.
            probed: its residuals without its effect and at its starts (1 + b, l, w, q, y) [1].

        Returns:
            A parameter vector (t,) [SI] for each start at which the residual is finite.
        """
        left = probed.reshape(len(probed), -1)[1:, self._observed]
        known = [(theta, r) for theta, r in zip(candidate.starts, left, strict=True) if np.all(np.isfinite(r))]
        return [np.clip(self.with_free_numbers(candidate, theta, r), *candidate.bounds.T) for theta, r in known]

    def _probed(self, candidates: Sequence[Candidate]) -> list[np.ndarray]:
        """Residuals of every candidate without its effect and at its starts."""
        return self.run(
            [
                Task(c.problem, partial(residuals, c.problem, [c.off, *c.starts], [c.first] * (1 + len(c.starts))))
                for c in candidates
            ]
        )

    def _scaled(self, candidate: Candidate, probed: np.ndarray) -> Candidate:
        """The candidate with amplitudes of its starts that change a part of what is left."""
        residual, *others = probed.reshape(len(probed), -1)[:, self._observed]
        with np.errstate(over="ignore"):  # a run that nearly leaves the range of numbers
            whole = float(np.linalg.norm(self._without(residual)))
        starts = []
        for start, r in zip(candidate.starts, others, strict=True):
            with np.errstate(over="ignore"):
                change = float(np.linalg.norm(self._without(r - residual))) if np.all(np.isfinite(r)) else np.inf
            share = (
                float(np.clip(self.limits.part * whole / change, *self.limits.probed))
                if change > 0.0 and np.isfinite(whole)
                else 1.0
            )
            scaled = np.where(candidate.amplitude, candidate.off + share * (start - candidate.off), start)
            starts.append(np.clip(scaled, *candidate.bounds.T))
        return replace(candidate, starts=starts)

    def _predict(self, candidate: Candidate, probed: np.ndarray) -> Screened:
        """The prediction for a candidate from its residuals without its effect and at its starts."""
        residual, *others = probed.reshape(len(probed), -1)[:, self._observed]
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
            changes = [others[k] - residual for k in known]
            starts = [candidate.starts[k] for k in known]
            left, share = self._best_sum(candidate, free, changes, starts)
            if left < least:
                begin.append((left, self._numbers_of_sum(candidate, residual, changes, starts, share)))
        begin = sorted(begin, key=lambda b: b[0])[: self.limits.shapes]
        here = int(np.argmin(cost))
        return Screened(
            min((left for left, _ in begin), default=least),
            (*(theta for _, theta in begin), np.clip(nearest, *candidate.bounds.T)),
            (candidate.off, *candidate.starts)[here],
            probed[here],
        )

    def _best_sum(
        self, candidate: Candidate, free: np.ndarray, changes: list[np.ndarray], starts: list[np.ndarray]
    ) -> tuple[float, np.ndarray]:
        """Half the sum of squares that the best sum of some starts leaves, and the share of each start in it."""
        C = self._without(np.stack(changes, axis=1))
        share = np.linalg.lstsq(C, -free, rcond=1e-9)[0]
        one_sided = ((_amplitudes(candidate, starts) != 0.0) & (candidate.bounds[:, 0] >= candidate.off)).any(axis=1)
        share = np.clip(share, np.where(one_sided, 0.0, -self.limits.largest), self.limits.largest)
        return 0.5 * float(np.sum((free + C @ share) ** 2)), share

    def _numbers_of_sum(
        self,
        candidate: Candidate,
        residual: np.ndarray,
        changes: list[np.ndarray],
        starts: list[np.ndarray],
        share: np.ndarray,
    ) -> np.ndarray:
        """Parameter vector of a sum of starts, the free numbers moved to where they leave least of its residual."""
        theta, change = starts[0], _amplitudes(candidate, starts)
        if change.any():
            theta = np.where(candidate.amplitude, candidate.off + share @ change, theta)
        whole = residual + np.stack(changes, axis=1) @ share
        return np.clip(self.with_free_numbers(candidate, theta, whole), *candidate.bounds.T)


def _amplitudes(candidate: Candidate, starts: list[np.ndarray]) -> np.ndarray:
    """Amplitudes of starts beyond those at which the candidate adds nothing (b, t)."""
    return np.stack([np.where(candidate.amplitude, start - candidate.off, 0.0) for start in starts])


def _different(several: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
    return tuple({one.tobytes(): one for one in several}.values())


def _orthonormal(columns: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore", invalid="ignore"):  # a run that leaves the range of numbers
        scale = np.sqrt(np.sum(columns**2, axis=0))
    columns = columns[:, scale > 0.0] / scale[scale > 0.0]
    if not columns.shape[1]:
        return columns
    u, s, _ = np.linalg.svd(columns, full_matrices=False)
    return u[:, s > 1e-8 * s[0]]
