"""End-to-end fit: free-run least squares over whole logs, through short windows first.

Two phases of one Gauss-Newton iteration with Levenberg-Marquardt damping. First every window starts from a state read
off the log and only linearised continuity ties it to the next (condensed multiple shooting: a wide basin of
attraction). Then the windows' states are those of the free run itself, so that the sum of squares is the free run's and
falls with every accepted step. The loop runs on the host and calls two compiled programs: an optimistix solver would
need the residual of the whole log as one function, whose Jacobian by plain forward mode costs the time of a sequential
run for every number (see docs/design.md for the measurement).
"""

from dataclasses import dataclass, replace

import numpy as np

from rwjax.fitting.coordinates import Coordinates
from rwjax.fitting.gauss_newton import LARGEST_DAMPING, gauss_newton_step
from rwjax.fitting.initial_state import initial_states_by_sensitivities
from rwjax.fitting.nonsmooth import secant_steps
from rwjax.fitting.problem import Problem
from rwjax.fitting.sensitivities import run_costs, sensitivities
from rwjax.simulation.shooting import Evaluation

WINDOW_STEPS = 8
LIGHT = 1e-9
"""Damping below which a fit with a prior may end: a prior is light against readings, and heavy damping hides it."""
MISFIT = 1.5
"""Mean square in units of noise above which creases of the sum of squares may have stopped a fit early."""


@dataclass(frozen=True)
class Fit:
    """Result of a fit. `theta` all numbers in the order of `problem.names`, `start` first state of each log.

    `cost`: half the sum of squared residuals in units of noise. `evaluation`: sensitivities at the optimum, windows
    started from the free run (numpy arrays). `converged`: False where the step limit came first or no
    step could be solved for.
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
        """All numbers by name."""
        return dict(zip(self.problem.names, (float(v) for v in self.theta), strict=True))


def _run(problem: Problem, theta: np.ndarray, start: np.ndarray) -> tuple[float, np.ndarray]:
    """Half the sum of squares of all free runs and of the prior, and the states at the windows' starts."""
    cost, nodes = run_costs(problem, theta, start)
    return float(np.sum(cost)) + problem.prior_cost(theta)[0], nodes


def reaches_noise(cost: float, theta: np.ndarray, problem: Problem) -> bool:
    """Whether a cost, the prior's share left out, is so low that creases of the sum of squares, or a bad start, cannot
    have stopped the fit early."""
    return 2.0 * (cost - problem.prior_cost(theta)[0]) <= MISFIT * problem.batch.readings


def _sticks(problem: Problem, theta: np.ndarray) -> bool:
    """Whether any dry friction acts: without it the sum of squares has no creases."""
    dry = ("friction.coulomb", "friction.static", "friction.b3", ".M_c", ".M_e")
    return any(
        name.partition(" ")[0].endswith(dry) and value > 0.0 for name, value in zip(problem.names, theta, strict=True)
    )


def _project(problem: Problem, theta: np.ndarray, start: np.ndarray) -> np.ndarray:
    """First states with those of logs whose first state follows from their start set by the start rule."""
    if not problem.initial_state_from_start.any():
        return start
    initial_state_from_start = replace(
        problem, start_free=problem.start_free & problem.initial_state_from_start[:, None]
    )
    return np.where(
        problem.initial_state_from_start[:, None],
        initial_states_by_sensitivities(initial_state_from_start, theta, start),
        start,
    )


def _through_windows(
    problem: Problem, c: Coordinates, theta: np.ndarray, nodes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """First phase: a few steps from states read off the log. Returns numbers and first states."""
    damping = 1e-3
    for _ in range(WINDOW_STEPS):
        e = sensitivities(problem, theta, c.index, nodes)
        step = gauss_newton_step(problem, e, c, theta, damping)
        if step is None:
            break
        dz, dx = step
        share = c.shorten(dz)
        theta_new = c.move(theta, share * dz)
        change = np.zeros(e.g.shape)
        change[:, : len(c.index)] = (theta_new - theta)[c.index]
        change[:, -dx.shape[1] :] = share * dx
        nodes_new = nodes + np.einsum("lwna,la->lwn", e.chain, change) + share * e.shift
        if not np.all(np.isfinite(nodes_new)):
            break
        theta, nodes = theta_new, nodes_new
        if np.max(np.abs(dz), initial=0.0) < 1e-3:
            break
    return theta, nodes[:, 0]


def least_squares(
    problem: Problem,
    coordinates: Coordinates,
    theta: np.ndarray,
    *,
    start: np.ndarray | None = None,
    nodes: np.ndarray | None = None,
    damping: float = 1e-3,
    most_steps: int = 60,
    tolerance: float = 1e-7,
    creases: bool = False,
) -> Fit:
    """Least squares of the free run over the free numbers and the logs' first states, those of logs whose first state follows from their start by the
    start rule at every step.

    With `nodes` (l, w, n) given, the short windows come first and the better of both starts is kept. With `creases`, a
    fit that ends well above the noise goes on by steps across the creases of stick and slip.
    """
    theta = coordinates.clip(theta)
    start = _project(problem, theta, problem.start if start is None else start)
    cost, states = _run(problem, theta, start)
    if nodes is not None:
        nodes = nodes.copy()
        nodes[:, 0] = np.where(problem.start_free, nodes[:, 0], start)
        with np.errstate(all="ignore"):
            theta_w, start_w = _through_windows(problem, coordinates, theta, nodes)
        if np.all(np.isfinite(theta_w)) and np.all(np.isfinite(start_w)):
            start_w = _project(problem, theta_w, start_w)
            cost_w, states_w = _run(problem, theta_w, start_w)
            if cost_w < cost:
                theta, start, cost, states = theta_w, start_w, cost_w, states_w
    e = sensitivities(problem, theta, coordinates.index, states)
    converged, taken = most_steps == 0, 0
    while taken < most_steps:
        taken += 1
        solved = gauss_newton_step(problem, e, coordinates, theta, damping)
        if solved is None or not np.isfinite(cost):
            break
        dz, dx = solved
        share = coordinates.shorten(dz)
        theta_new = coordinates.move(theta, share * dz)
        start_new = _project(problem, theta_new, start + share * dx)
        cost_new, states_new = _run(problem, theta_new, start_new)
        gain = cost - cost_new
        if gain >= 0.0:
            theta, start, cost, states = theta_new, start_new, cost_new, states_new
            small = gain <= tolerance * max(cost, 1.0)
            damping = max(damping * (0.1 if share == 1.0 else 1.0), 1e-10)
            e = sensitivities(problem, theta, coordinates.index, states)
            if small and damping < (LIGHT if problem.precision.any() else 1e-2):
                converged = True
                break
        else:
            damping = max(damping, 1e-6) * 8.0
            if damping > LARGEST_DAMPING or (len(dz) and np.max(np.abs(dz)) < 1e-10):
                converged = True
                break
    if (
        creases
        and _sticks(problem, theta)
        and np.isfinite(cost)
        and not reaches_noise(cost, theta, problem)
        and len(coordinates.index)
    ):
        wide = replace(coordinates, size=np.maximum(coordinates.size, np.abs(theta[coordinates.index])))
        free = problem.start_free & ~problem.initial_state_from_start[:, None]
        theta_k, start_k, _ = secant_steps(problem, wide, theta, start, free, cost)
        rest = least_squares(problem, coordinates, theta_k, start=start_k)
        if rest.cost < cost:
            return replace(rest, steps=rest.steps + taken)
    return Fit(problem, coordinates, theta, start, cost, e, converged, taken)
