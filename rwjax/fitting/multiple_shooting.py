"""Fit by multiple shooting: free-run least squares over whole logs, through short windows first.

One Gauss-Newton iteration with Levenberg-Marquardt damping, in two phases:

1. Every window starts from a state read off the log, and linearised continuity ties it to the next one (condensed
   multiple shooting; Bock and Plitt, 1984). The basin of attraction is wide.
2. The windows' states are those of the free run. The sum of squares is then that of the free run, and falls with every
   accepted step.

The loop runs on the host and calls two compiled programs. Optimistix, by which `rwjax.fitting.optimise` fits through the smooth
solver, needs the residual of the whole log as one function. Its derivatives go through the log step after step, where windows
run side by side.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rwjax.fitting.batched_runs import by_itself
from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.gauss_newton import LARGEST_DAMPING, gauss_newton_step
from rwjax.fitting.initial_state import initial_states_by_rule
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import run_costs, sensitivities
from rwjax.rig.tied import completed
from rwjax.simulation.shooting import Evaluation

WINDOW_STEPS = 8
"""Steps at most of the first phase."""
MOST_STEPS, TOLERANCE = 60, 1e-7
"""Steps of a fit at most, and the share of the cost below which a step's gain ends it [1]."""
DAMPING_TO_END = 1e-2
"""Damping below which a fit may end where a step gains little [1]."""
DAMPING_TO_END_WITH_PRIOR = 1e-9
"""The same for a fit with a prior: a prior weighs little against the readings, and heavy damping hides it [1]."""
FIRST_DAMPING = 1e-3
"""Damping of the first step of a fit from afar [1]."""
LIGHT_DAMPING = 1e-6
"""Damping of the first step from where a fit, or its first phase, has settled [1]; and the most at which a short step says that the
fit has arrived."""
ARRIVED = 1e-3
"""Length of a step, in standard errors by noise alone, below which a fit has arrived and the step is not taken [1]."""
MISFIT = 1.5
"""Mean square in units of noise above which a nonsmooth sum of squares may have stopped a fit early [1]."""


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    Attributes:
        problem: Logs and structure.
        coordinates: The free numbers.
        theta: All numbers `(t,)` [SI], in the order of `problem.names`.
        start: Initial state of each log `(l, n)` [SI].
        cost: Half the sum of squared residuals in units of noise, and the prior's share [1].
        evaluation: Derivatives at the optimum, windows started from the free run (numpy arrays).
        converged: False where the step limit came first or no step could be solved for.
        steps: How many steps were taken [1].
    """

    problem: Problem
    coordinates: Coordinates
    theta: np.ndarray
    start: np.ndarray
    cost: float
    evaluation: Evaluation
    converged: bool
    steps: int

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free numbers."""
        return tuple(self.problem.names[k] for k in self.coordinates.index)

    def numbers(self) -> dict[str, float]:
        """All numbers by name.

        Returns:
            Values [SI].
        """
        values = dict(zip(self.problem.names, (float(v) for v in self.theta), strict=True))
        return completed(dict(self.problem.structure.tied), values)


class _Run(NamedTuple):
    """A free run of all logs: numbers, initial states, cost with the prior's share, states at the windows' starts."""

    theta: np.ndarray
    start: np.ndarray
    cost: float
    nodes: np.ndarray


def _run(problem: Problem, theta: np.ndarray, start: np.ndarray) -> _Run:
    """Free run, initial states from the first 0.5 s where the problem says so; `start` is where their search begins."""
    start = by_itself(initial_states_by_rule(problem, theta, start))
    cost, nodes = run_costs(problem, theta, start)
    return _Run(theta, start, float(np.sum(cost)) + problem.prior_cost(theta)[0], nodes)


def reaches_noise(cost: float, theta: np.ndarray, problem: Problem) -> bool:
    """Whether a cost is so low that neither a nonsmooth sum of squares nor a bad start has stopped the fit early.

    Args:
        cost: Half the sum of squared residuals and the prior's share, which does not count here [1].
        theta: Parameter vector `(t,)` [SI].
        problem: Logs and structure.

    Returns:
        True where the mean square is at most `MISFIT`.
    """
    return 2.0 * (cost - problem.prior_cost(theta)[0]) <= MISFIT * problem.batch.readings


def _change(e: Evaluation, c: Coordinates, moved: np.ndarray, dx: np.ndarray) -> np.ndarray:
    """Change of the numbers and of each log's initial state `(l, k+n)` [SI], in the order of the normal equations."""
    change = np.zeros(e.g.shape)
    change[:, : len(c.index)] = moved[c.index]
    change[:, -dx.shape[1] :] = dx
    return change


def _through_windows(
    problem: Problem, c: Coordinates, theta: np.ndarray, nodes: np.ndarray
) -> tuple[np.ndarray, np.ndarray, bool]:
    """First phase: a few steps from states read off the log, to numbers and initial states, and whether they settled."""
    settled = False
    for _ in range(WINDOW_STEPS):
        e = sensitivities(problem, theta, c.index, nodes)
        step = gauss_newton_step(problem, e, c, theta, FIRST_DAMPING)
        if step is None:
            break
        dz, dx = step
        share = c.shorten(dz)
        theta_new = c.move(theta, share * dz)
        change = _change(e, c, theta_new - theta, share * dx)
        nodes_new = nodes + np.einsum("lwna,la->lwn", e.chain, change) + share * e.shift
        if not np.all(np.isfinite(nodes_new)):
            break
        theta, nodes = theta_new, nodes_new
        if settled := bool(np.max(np.abs(dz), initial=0.0) < 1e-3):
            break
    return theta, nodes[:, 0], settled


def _begin(
    problem: Problem, c: Coordinates, theta: np.ndarray, start: np.ndarray, nodes: np.ndarray | None
) -> tuple[_Run, bool]:
    """The run from which the second phase goes on, and whether the first one, which is made with nodes, has settled there.

    It is the run to which the first phase leads, where that reaches the noise; else the better of it and the one that begins.
    """
    found = settled = None
    if nodes is not None:
        nodes = nodes.copy()
        nodes[:, 0] = np.where(problem.start_free, nodes[:, 0], start)
        with np.errstate(all="ignore"):
            *through, settled = _through_windows(problem, c, theta, nodes)
        if all(np.isfinite(a).all() for a in through):
            found = _run(problem, *through)
    if found is None or not reaches_noise(found.cost, found.theta, problem):
        here = _run(problem, theta, start)
        if found is None or not found.cost < here.cost:
            return here, False
    return found, bool(settled)


def least_squares(  # noqa: PLR0913 (one of them may end it between its steps)
    problem: Problem,
    coordinates: Coordinates,
    theta: np.ndarray,
    *,
    start: np.ndarray | None = None,
    nodes: np.ndarray | None = None,
    damping: float = FIRST_DAMPING,
    most_steps: int = MOST_STEPS,
    tolerance: float = TOLERANCE,
    check: Callable[[], None] = lambda: None,
) -> Fit:
    """Least squares of the free run over the free numbers and the logs' initial states.

    Initial states that the problem takes from the first 0.5 s are estimated anew at every step.

    Args:
        problem: Logs and structure.
        coordinates: The free numbers.
        theta: Parameter vector `(t,)` [SI] where the fit begins.
        start: Initial states `(l, n)` [SI] where the fit begins; the problem's own without it.
        nodes: States at the windows' starts `(l, w, n)` [SI]. With them the short windows come first. The fit goes on from
            where they lead if that reaches the noise, else from the better of both runs.
        damping: Levenberg-Marquardt damping of the first step [1].
        most_steps: Steps at most [1].
        tolerance: Share of the cost below which a step's gain ends the fit [1].
        check: Is called before every step; what it raises ends the fit.

    Returns:
        The fit.
    """
    check()
    here, settled = _begin(
        problem, coordinates, coordinates.clip(theta), problem.start if start is None else start, nodes
    )
    damping = min(damping, LIGHT_DAMPING) if settled else damping
    e = sensitivities(problem, here.theta, coordinates.index, here.nodes)
    begun = Fit(problem, coordinates, here.theta, here.start, here.cost, e, most_steps == 0, 0)
    return _descend(begun, damping, most_steps, tolerance, check)


def carried_on(begun: Fit) -> Fit:
    """A fit carried to its end from where an earlier one has ended, whose derivatives serve for the first step.

    Args:
        begun: The earlier fit.

    Returns:
        The fit, with the steps of both.
    """
    settled = begun.converged and begun.steps > 0
    damping = LIGHT_DAMPING if settled else FIRST_DAMPING
    return _descend(begun, damping, MOST_STEPS, TOLERANCE, lambda: None)


def _descend(here: Fit, damping: float, most_steps: int, tolerance: float, check: Callable[[], None]) -> Fit:
    """The steps of `least_squares` from a point with its derivatives."""
    problem, c = here.problem, here.coordinates
    damping_to_end = DAMPING_TO_END_WITH_PRIOR if problem.precision.any() else DAMPING_TO_END
    converged, taken = most_steps == 0, 0
    while taken < most_steps:
        check()
        step = gauss_newton_step(problem, here.evaluation, c, here.theta, damping)
        if step is None or not np.isfinite(here.cost):
            break
        dz, dx = step
        share = c.shorten(dz)
        theta, start = c.move(here.theta, share * dz), here.start + share * dx
        light = share == 1.0 and damping <= min(LIGHT_DAMPING, damping_to_end)
        if light and _length(here, theta, start) <= ARRIVED:
            converged = True
            break
        taken += 1
        trial = _run(problem, theta, start)
        gain = here.cost - trial.cost
        if gain >= 0.0:
            e = sensitivities(problem, trial.theta, c.index, trial.nodes)
            here = replace(here, theta=trial.theta, start=trial.start, cost=trial.cost, evaluation=e)
            damping = max(damping * (0.1 if share == 1.0 else 1.0), 1e-10)
            if gain <= tolerance * max(here.cost, 1.0) and damping < damping_to_end:
                converged = True
                break
        else:
            damping = max(damping, 1e-6) * 8.0
            if damping > LARGEST_DAMPING or (len(dz) and np.max(np.abs(dz)) < 1e-10):
                converged = True
                break
    return replace(here, converged=converged, steps=here.steps + taken)


def _length(here: Fit, theta: np.ndarray, start: np.ndarray) -> float:
    """Length of a step in standard errors by noise alone [1]."""
    e, moved = here.evaluation, theta - here.theta
    change = _change(e, here.coordinates, moved, start - here.start)
    return float(np.sqrt(np.einsum("la,lab,lb", change, e.H, change) + here.problem.precision @ moved**2))
