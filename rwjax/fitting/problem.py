"""Logs and a structure made ready for a fit: layout, noise, which runs start at rest."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rwjax.kinds import is_angle
from rwjax.logs import noise as noise_of
from rwjax.logs.log import Log
from rwjax.plant.one_axis import Structure
from rwjax.simulation.batch import Batch, lay_out

START_S = 0.5
"""Length of the stretch from which a run's initial state is estimated [s]."""
NO_COMMAND = 1e-3
"""Voltage that cannot be told from none [V]."""


SWING = 3.0
"""Scatter of a rate over the first 0.5 s, in units of its noise, above which it moves."""


@dataclass(frozen=True)
class Problem:
    """`start`: first state of each log; `start_free`: which of its entries the readings must tell, `(l, n)`; `initial_state_from_start`:
    logs `(l,)` that tell them by their first 0.5 s alone (the start rule), not by the whole run. `per_run`: numbers of
    which every run has a value of its own; `prior` (t, 2): mean and inverse variance of what is known of each number
    besides the logs, 0 where nothing is; `prior_weight`: as how many readings one counts that has the prior's standard
    deviation, above 1 where residuals are correlated and many readings say what one would.
    """

    structure: Structure
    logs: tuple[Log, ...]
    noise: dict[str, float]
    batch: Batch
    start: np.ndarray
    start_free: np.ndarray
    initial_state_from_start: np.ndarray
    per_run: tuple[str, ...]
    prior: np.ndarray
    prior_weight: float = 1.0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all entries of `theta`: the structure's, then those that every run has of its own, log by log."""
        return self.structure.names + tuple(f"{name} in {log.name}" for log in self.logs for name in self.per_run)

    def spread_out(self, values: np.ndarray) -> np.ndarray:
        """Values of the structure's numbers (p, …) as values of all entries of `theta`."""
        own = [self.structure.names.index(name) for name in self.per_run]
        return np.concatenate([values, *(values[own] for _ in self.logs)])

    @property
    def precision(self) -> np.ndarray:
        """Inverse variance of the prior `(t,)` times its weight."""
        return self.prior_weight * self.prior[:, 1]

    def against_prior(self, theta: np.ndarray) -> tuple[float, np.ndarray]:
        """The prior's part of the cost, half the squared distance in its standard deviations, and its slope `(t,)`."""
        away = np.where(self.precision > 0.0, theta - self.prior[:, 0], 0.0)
        return 0.5 * float(self.precision @ away**2), self.precision * away

    @property
    def told(self) -> np.ndarray:
        """Logs with any reading in the residual."""
        return np.flatnonzero(self.batch.weight.any(axis=(1, 2, 3)))

    @cached_property
    def by_rule(self) -> "Problem":
        """The same with every log's first state by the start rule."""
        return replace(self, initial_state_from_start=self.start_free.any(axis=1))

    @cached_property
    def early(self) -> "Problem":
        """The problem of the first 0.5 s of each log, its readings weighed by their noise there: nothing later counts."""
        batch = self.batch.until(START_S)
        weight = batch.weight.copy()
        for k, log in enumerate(self.logs):
            early = _early(log)
            noise = noise_of.noise_by_output(log.cut(0, int(early.sum())))
            unit = np.array([self.noise[y] / noise[y] if y in noise else 1.0 for y in self.structure.outputs])
            late = np.append(~early, False)  # empty slots point at the last entry
            weight[k] = np.where(late[batch.slot_sample[k]][..., None], 0.0, weight[k] * unit)
        return replace(
            self, batch=batch._replace(weight=weight), initial_state_from_start=np.zeros(len(self.logs), bool)
        )

    def only(self, logs: Collection[int]) -> "Problem":
        """The same arrays with all other logs left out of the residual: nothing has to be compiled anew."""
        kept = np.isin(np.arange(len(self.logs)), list(logs))
        weight = self.batch.weight * kept[:, None, None, None]
        return replace(self, batch=self.batch._replace(weight=weight), start_free=self.start_free & kept[:, None])


def _early(log: Log) -> np.ndarray:
    return log.time - log.time[0] <= START_S


def _line(log: Log, name: str) -> tuple[float, float, float]:
    """Value at the first sample, slope, and the slope's standard error of a line through the first 0.5 s."""
    early = _early(log) & np.isfinite(log.outputs[name])
    t, y = log.time[early] - log.time[0], log.outputs[name][early]
    if len(t) < 3:
        return (float(y[0]) if len(y) else 0.0), 0.0, np.inf
    A = np.stack([np.ones_like(t), t], axis=1)
    (value, slope), *_ = np.linalg.lstsq(A, y, rcond=None)
    spread = max(np.std(y - A @ (value, slope)), noise_of.quantisation(log, name))
    return float(value), float(slope), float(spread / np.sqrt(np.sum((t - t.mean()) ** 2)))


def starts_at_rest(log: Log) -> bool:
    """Whether input and rates are indistinguishable from zero over the first 0.5 s; a current's offset says nothing."""
    early = _early(log)
    if np.max(np.abs(log.command[early])) > NO_COMMAND:
        return False
    for name, value in log.outputs.items():
        if name.startswith("current"):
            continue
        y = value[early & np.isfinite(value)]
        if len(y) < 3:
            continue
        if is_angle(name):
            _, slope, error = _line(log, name)
            moved = float(np.ptp(y)) > 1.5 * log.resolution.get(name, 0.0)
            if moved and abs(slope) > 3.5 * error:
                return False
        else:
            noise = max(noise_of.noise_level(y), noise_of.quantisation(log, name))
            spread = max(float(np.std(y)), noise) / np.sqrt(len(y))
            swings = noise > 0.0 and float(np.std(y)) > SWING * noise  # through 0 and back
            if swings or abs(float(np.mean(y))) > 3.5 * spread + 1e-12:
                return False
    return True


def _first_state(structure: Structure, log: Log, rest: bool) -> tuple[np.ndarray, np.ndarray]:
    """First state as the readings suggest it, and which entries stay unknown."""
    guess, free = dict.fromkeys(structure.states, 0.0), dict.fromkeys(structure.states, False)
    for angle, rate, angle_name, rate_name in structure.turning:
        early = _early(log)
        if angle_name in log.outputs:
            value, slope, _ = _line(log, angle_name)
            seen = log.outputs[angle_name][early & np.isfinite(log.outputs[angle_name])]
            guess[angle], guess[rate] = (float(np.mean(seen)) if rest and len(seen) else value), slope
            free[angle] = True
        elif log.outputs and angle in structure.angles:
            free[angle] = True  # unseen, but something depends on it
        if rate_name in log.outputs:
            guess[rate] = _line(log, rate_name)[0]
        free[rate] = not rest
        guess[rate] = 0.0 if rest else guess[rate]
    for i, name in structure.currents:
        if not rest:
            guess[i] = _line(log, name)[0] if name in log.outputs else 0.0
            free[i] = True
    return np.array(list(guess.values())), np.array(list(free.values()))


def pose(
    structure: Structure,
    logs: Sequence[Log],
    noise: dict[str, float] | None = None,
    *,
    per_run: Sequence[str] = (),
    prior: Mapping[str, tuple[float, float]] | None = None,
    refine: int = 1,
) -> Problem:
    """Problem of fitting a structure to logs; `noise` (SI) from the readings unless it is given. `prior`: mean and
    standard deviation by name."""
    logs = tuple(logs)
    known = [(prior or {}).get(name, (0.0, np.inf)) for name in structure.names]
    noise = noise_of.pooled_noise(logs) if noise is None else noise
    first = [_first_state(structure, log, starts_at_rest(log)) for log in logs]
    problem = Problem(
        structure=structure,
        logs=logs,
        noise=noise,
        batch=lay_out(structure, logs, [noise] * len(logs), per_run=per_run, refine=refine),
        start=np.stack([guess for guess, _ in first]),
        start_free=np.stack([free for _, free in first]),
        initial_state_from_start=np.zeros(len(logs), bool),
        per_run=tuple(per_run),
        prior=np.array([(mean, spread**-2.0) for mean, spread in known]),
    )
    spread = problem.spread_out(problem.prior)
    spread[[structure.names.index(name) for name in per_run]] = 0.0  # no run has the shared value
    return replace(problem, prior=spread)
