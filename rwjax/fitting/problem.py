"""Logs and a structure made ready for a fit: layout in time, noise, initial states, priors."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from rwjax.fitting.initial_guess import START_S, first_half_second, guess_initial_state, starts_at_rest
from rwjax.fitting.threads import on_threads
from rwjax.logs import noise as noise_of
from rwjax.logs.log import Log
from rwjax.logs.segments import runs_of
from rwjax.plant.structure import Structure
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT
from rwjax.simulation.free_run import free_run
from rwjax.simulation.layout import lay_out
from rwjax.simulation.shared_program import batch_within, with_light_effects
from rwjax.simulation.solver import Solver

LONG = 4000
"""Steps of a log from which a call of its own costs less than it saves."""


@dataclass(frozen=True)
class Problem:
    """Least squares of a structure's free run against logs.

    Axes: log `l`, state `n`, entry of the parameter vector `t` (the structure's numbers, then those of every run).

    Attributes:
        structure: The plant's structure.
        logs: The logs.
        noise: Standard deviation of each output's noise [SI].
        batch: The logs laid out for simulation.
        start: Initial state of each log `(l, n)` [SI], as guessed.
        start_free: Which of its entries are unknown `(l, n)`.
        initial_state_from_start: Logs `(l,)` whose initial state is estimated from their first 0.5 s alone, not from
            the whole run.
        per_run: Names of the numbers of which every run has a value of its own.
        prior: Mean [SI] and inverse variance [1/SI²] `(t, 2)` of what is known of a number besides the logs; 0 where
            nothing is.
        prior_weight: How many readings a prior counts as [1]. It is above 1 where residuals are correlated, so that
            many readings carry the information of one.
        solver: What moves the plant through a log.
        shares_programs: Whether its free runs take programs that plants with other light effects take, too
            (`rwjax.simulation.shared_program`): one program takes longer then, and many plants need fewer.
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
    solver: Solver = EXACT
    shares_programs: bool = False

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all entries of `theta`: the structure's, then those of every run, run by run."""
        runs = (self.logs[k].name for k in np.unique(runs_of(self.logs), return_index=True)[1])
        return self.structure.names + tuple(f"{name} in {run}" for run in runs for name in self.per_run)

    def __getstate__(self) -> dict[str, Any]:
        """What another process is given: nothing that follows from the rest, which other threads may be working out."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def expand(self, values: np.ndarray) -> np.ndarray:
        """Values of the structure's numbers, repeated for those of every run.

        Args:
            values: Values `(p, …)` [SI] in the order of `structure.names`.

        Returns:
            Values `(t, …)` [SI] in the order of `names`.
        """
        own = [self.structure.names.index(name) for name in self.per_run]
        return np.concatenate([values, *(values[own] for _ in np.unique(runs_of(self.logs)))])

    @property
    def precision(self) -> np.ndarray:
        """Inverse variance of the prior `(t,)` [1/SI²], times its weight."""
        return self.prior_weight * self.prior[:, 1]

    def prior_cost(self, theta: np.ndarray) -> tuple[float, np.ndarray]:
        """Share of the cost that comes from the prior: half the squared distance, in its standard deviations.

        Args:
            theta: Parameter vector `(t,)` [SI].

        Returns:
            The cost [1] and its derivative by `theta` `(t,)` [1/SI].
        """
        away = np.where(self.precision > 0.0, theta - self.prior[:, 0], 0.0)
        return 0.5 * float(self.precision @ away**2), self.precision * away

    @property
    def log_by_log(self) -> bool:
        """Whether there are several logs, so long that each has a call of its own, at the same time as others."""
        return len(self.logs) > 1 and self.batch.windows * len(self.batch.step_index) >= LONG

    @property
    def program(self) -> Structure:
        """The structure whose programs its free runs take."""
        return with_light_effects(self.structure) if self.shares_programs else self.structure

    def free_run(self, theta: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Free runs of all logs; by the exact solver several long ones run at the same time.

        Args:
            theta: Parameter vector `(t,)` [SI].
            start: Initial states `(l, n)` [SI].

        Returns:
            Readings `(l, w, q, y)` [rad, rad/s or A] and states at the windows' starts `(l, w, n)` [SI].
        """
        numbers, batch = np.asarray(theta), self.batch
        if self.program != self.structure:
            numbers, batch = batch_within(self.program, self.structure, numbers, batch)

        def of(start: np.ndarray, batch: Batch) -> tuple[np.ndarray, np.ndarray]:
            y, nodes = free_run(self.program, numbers, start, batch, solver=self.solver)
            return np.asarray(y), np.asarray(nodes)

        if self.solver.smooth or not self.log_by_log:
            return of(start, batch)
        parts = on_threads(lambda log: of(start[log : log + 1], batch.of(log)), range(len(self.logs)))
        y, nodes = (np.concatenate(part) for part in zip(*parts, strict=True))
        return y, nodes

    @cached_property
    def logs_with_readings(self) -> np.ndarray:
        """Numbers of the logs with any reading in the residual."""
        return np.flatnonzero(self.batch.weight.any(axis=(1, 2, 3)))

    @cached_property
    def windows_with_readings(self) -> int:
        """Windows up to the last one that holds a reading in the residual."""
        return int(np.max(self.batch.windows_of[self.logs_with_readings], initial=0))

    @cached_property
    def from_start(self) -> "Problem":
        """The same problem with every log's initial state from its first 0.5 s."""
        return replace(self, initial_state_from_start=self.start_free.any(axis=1))

    @cached_property
    def start_only(self) -> "Problem":
        """The problem of the first 0.5 s of each log, with the noise of those readings; later readings have weight 0."""
        batch = self.batch.until(START_S)
        weight = batch.weight.copy()
        for k in self.logs_with_readings:
            log = self.logs[k]
            early = first_half_second(log)
            noise = noise_of.noise_by_output(log.cut(0, int(early.sum())))
            unit = np.array([self.noise[y] / noise[y] if y in noise else 1.0 for y in self.structure.outputs])
            late = np.append(~early, False)  # empty slots point at the last entry
            weight[k] = np.where(late[batch.slot_sample[k]][..., None], 0.0, weight[k] * unit)
        return replace(
            self, batch=batch._replace(weight=weight), initial_state_from_start=np.zeros(len(self.logs), bool)
        )

    def only(self, logs: Collection[int]) -> "Problem":
        """The same problem with the readings of some logs alone; the arrays keep their shapes, and programs serve on.

        Args:
            logs: Numbers of the logs that stay in the residual.

        Returns:
            The problem, in which the other logs have weight 0.
        """
        kept = np.isin(np.arange(len(self.logs)), list(logs))
        weight = self.batch.weight * kept[:, None, None, None]
        return replace(self, batch=self.batch._replace(weight=weight), start_free=self.start_free & kept[:, None])


def pose(
    structure: Structure,
    logs: Sequence[Log],
    noise: dict[str, float] | None = None,
    *,
    per_run: Sequence[str] = (),
    prior: Mapping[str, tuple[float, float]] | None = None,
    refine: int = 1,
    solver: Solver = EXACT,
) -> Problem:
    """The problem of fitting a structure to logs.

    Args:
        structure: The plant's structure; of its outputs the problem keeps those that a log holds.
        logs: The logs.
        noise: Standard deviation of each output's noise [SI]; without it, estimated from the readings.
        per_run: Names of the numbers of which every run has a value of its own.
        prior: Mean and standard deviation [SI] of numbers that are known besides the logs, by name.
        refine: Parts into which each time step is divided [1].
        solver: What moves the plant through a log.

    Returns:
        The problem, with initial states guessed from the first readings.
    """
    logs = tuple(logs)
    structure = structure.reading({name for log in logs for name in log.outputs})
    known = [(prior or {}).get(name, (0.0, np.inf)) for name in structure.names]
    noise = noise_of.pooled_noise(logs) if noise is None else noise
    first = [guess_initial_state(structure, log, starts_at_rest(log)) for log in logs]
    problem = Problem(
        structure=structure,
        logs=logs,
        noise=noise,
        batch=lay_out(structure, logs, [noise] * len(logs), per_run=per_run, refine=refine),
        start=np.stack([guess for guess, _ in first]),
        start_free=np.stack([free for _, free in first]),
        initial_state_from_start=np.zeros(len(logs), bool),
        per_run=tuple(per_run),
        solver=solver,
        prior=np.array([(mean, deviation**-2.0) for mean, deviation in known]),
    )
    expanded = problem.expand(problem.prior)
    expanded[[structure.names.index(name) for name in per_run]] = 0.0  # no run has the shared value
    return replace(problem, prior=expanded)
