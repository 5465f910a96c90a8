"""Least squares from wrong starts, and agreement with another optimiser."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest

from rwjax import Log
from rwjax.fitting import multiple_shooting
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.fit import fit
from rwjax.fitting.multiple_shooting import ARRIVED, Fit, carried_on, least_squares, reaches_noise
from rwjax.fitting.problem import pose
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.fitting.uncertainty import uncertainty
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from tests.fitting.logs import FREE, log_of
from tests.systems import platform, reaction, record, run, wheel

SHORT = np.arange(401) * 0.01


DRIVE = np.where(SHORT > 0.6, 3.0 * np.sign(np.sin(4.0 * SHORT + 0.1)) + np.sin(9.0 * SHORT), 0.0)


MOTOR_FREE = ("motor.torque_constant", "motor.resistance", "wheel.inertia")  # the current tells them apart


KINDS = {
    "wheel": (replace(wheel(0.83 * 4e-3), free=MOTOR_FREE), ("wheel_rad_s", "current_A")),
    "platform": (platform(free=FREE), ("yaw_rad",)),
    "reaction": (
        replace(reaction(), free=("axis.inertia", "axis.friction.viscous", "wheel.inertia")),
        ("yaw_rad", "wheel_rad"),
    ),
}


def _simulated(kind: str, noise: dict[str, float] | None = None) -> tuple[Rig, Log]:
    rig, outputs = KINDS[kind]
    y = run(rig, record(SHORT, DRIVE, {name: np.zeros_like(SHORT) for name in outputs}), {})
    rng = np.random.default_rng(1)
    return rig, record(
        SHORT,
        DRIVE,
        {name: y[name] + (noise or {}).get(name, 0.0) * rng.normal(size=401) for name in outputs},
    )


def _from(rig: Rig, log: Log, factors: np.ndarray | float, *, windows: bool = True) -> Fit:
    """One fit from one start, off the rig's free numbers by `factors`: `fit` would try 0.5, 1 and 2 times that."""
    structure = structure_of(rig)
    theta, problem = theta_of(rig, structure), pose(structure, (log,))
    free = np.array([name in rig.free for name in structure.names])
    begin = theta.copy()
    begin[free] *= factors
    moves = coordinates(begin, free, bounds_of(rig, structure), np.ones_like(theta))
    return least_squares(
        problem, moves, begin, nodes=measured_nodes(problem, begin) if windows else None, tolerance=1e-12
    )


@pytest.mark.slow
def test_optimistix_ends_at_the_same_optimum() -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    log = log_of(rig, noise=1e-3)
    ours = fit(rig.with_values({"axis.inertia": 0.15}), [log])
    structure = structure_of(rig)
    problem = pose(structure, (log,), ours.fit.problem.noise)
    theta = theta_of(rig, structure)

    def residual(z, _):
        start = jnp.stack([z[3], jnp.zeros(())])[None]  # the run starts at rest
        y, _ = free_run(problem.structure, z[:3] * theta, start, problem.batch)
        misfit = ((y - problem.batch.reading) * problem.batch.weight).ravel()
        return jnp.concatenate([misfit, 1e6 * (z[:1] - 1.0)])  # the gain is held by a stiff pull to its own value

    z0 = jnp.asarray([1.0, 1.2, 0.8, 0.0])
    solver = optx.LevenbergMarquardt(rtol=1e-10, atol=1e-10)
    other = optx.least_squares(residual, solver, z0, options={"jac": "fwd"}, max_steps=200).value
    values = np.asarray(other[:3]) * theta
    assert ours.rig.values["axis.inertia"] == pytest.approx(values[structure.names.index("axis.inertia")], rel=1e-5)
    assert ours.rig.values["axis.friction.viscous"] == pytest.approx(values[2], rel=1e-4)


@pytest.mark.parametrize("windows", [True, False], ids=["windows", "free run only"])
@pytest.mark.parametrize("factors", [0.5, 2.0, np.array([0.6, 1.7, 0.8])], ids=["halves", "doubles", "mixed"])
@pytest.mark.parametrize("kind", KINDS)
def test_one_wrong_start_is_enough_without_noise(kind: str, factors: np.ndarray | float, windows: bool) -> None:
    rig, log = _simulated(kind)
    found = _from(rig, log, factors, windows=windows)
    assert found.converged and found.steps > 1
    for name in rig.free:
        assert found.numbers()[name] == pytest.approx(rig.values[name], rel=1e-8), (
            name
        )  # 1e-10, the noise floor of 1e-9


@pytest.mark.slow
def test_another_optimiser_finds_the_same_numbers_in_a_motor() -> None:
    rig, log = _simulated("wheel", {"wheel_rad_s": 0.3, "current_A": 0.02})
    ours = _from(rig, log, np.array([0.6, 1.7, 0.8]))
    problem, structure = ours.problem, ours.problem.structure
    theta = theta_of(rig, structure)
    index = np.array([structure.names.index(name) for name in ours.free])

    def residual(z, _):
        y, _ = free_run(
            structure,
            jnp.asarray(theta).at[index].set(theta[index] * jnp.exp(z)),
            problem.start,
            problem.batch,
        )
        return ((y - problem.batch.reading) * problem.batch.weight).ravel()

    assert not problem.start_free[:, 1].any()  # it starts at rest, and no angle is read
    solver = optx.LevenbergMarquardt(rtol=1e-12, atol=1e-12)
    z = optx.least_squares(residual, solver, jnp.asarray([0.3, -0.2, 0.2]), options={"jac": "fwd"}, max_steps=100).value
    for name, value in zip(ours.free, theta[index] * np.exp(np.asarray(z)), strict=True):
        assert ours.numbers()[name] == pytest.approx(value, rel=1e-6), name
        assert ours.numbers()[name] != pytest.approx(rig.values[name], rel=1e-6), name  # noise has moved the optimum


def test_what_is_asked_before_every_step_may_end_the_fit() -> None:
    class Ended(Exception):
        pass

    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    structure = structure_of(rig)
    problem, theta = pose(structure, (log_of(rig, noise=1e-3),)), theta_of(rig, structure)
    free = np.array([name in rig.free for name in structure.names])
    moves = coordinates(1.5 * theta, free, bounds_of(rig, structure), np.ones_like(theta))
    asked: list[int] = []
    found = least_squares(problem, moves, 1.5 * theta, check=lambda: asked.append(0))
    assert len(asked) == found.steps + 1  # once before the first run, too

    def end() -> None:
        asked.append(1)
        if sum(asked) == 2:
            raise Ended

    with pytest.raises(Ended):
        least_squares(problem, moves, 1.5 * theta, check=end)
    assert sum(asked) == 2


def _noisy(factor: float, monkeypatch: pytest.MonkeyPatch, **choices) -> tuple[Fit, list[np.ndarray]]:
    """A fit with noise from numbers that are off by a factor, and the numbers of every free run that was made."""
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    structure = structure_of(rig)
    problem, theta = pose(structure, (log_of(rig, noise=1e-3),)), theta_of(rig, structure)
    free = np.array([name in rig.free for name in structure.names])
    begin = np.where(free, factor * theta, theta)
    moves = coordinates(begin, free, bounds_of(rig, structure), np.ones_like(theta))
    made, run = [], multiple_shooting.run_costs
    monkeypatch.setattr(
        multiple_shooting, "run_costs", lambda p, theta, start: made.append(theta) or run(p, theta, start)
    )
    return least_squares(problem, moves, begin, **choices, nodes=measured_nodes(problem, begin)), made


def test_a_fit_that_has_settled_is_carried_on_without_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    found, made = _noisy(1.5, monkeypatch)
    made.clear()
    on = carried_on(found)
    assert on.converged and not made and np.array_equal(on.theta, found.theta) and on.evaluation is found.evaluation
    assert on.steps == found.steps > 0


def test_a_fit_ends_within_a_thousandth_of_a_standard_error_and_goes_on_from_further_away(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found, _ = _noisy(1.5, monkeypatch)
    error = np.array(list(uncertainty(found).standard_error.values()))
    index = found.coordinates.index
    off = found.theta.copy()
    off[index] += (0.5, 0.3) * error
    again = carried_on(least_squares(found.problem, found.coordinates, off, start=found.start, most_steps=0))
    assert np.max(np.abs(again.theta - found.theta)[index] / error) < ARRIVED
    assert again.cost == pytest.approx(found.cost, rel=1e-9)


def test_where_the_windows_lead_to_the_noise_no_run_is_made_from_the_beginning(monkeypatch: pytest.MonkeyPatch) -> None:
    found, made = _noisy(1.5, monkeypatch)
    assert reaches_noise(found.cost, found.theta, found.problem)
    index = found.coordinates.index
    assert all(theta[index] == pytest.approx(found.theta[index], rel=0.1) for theta in made)
    nodes = measured_nodes(found.problem, found.theta) + 1e3  # from there a single step leads astray
    monkeypatch.setattr(multiple_shooting, "WINDOW_STEPS", 1)
    made.clear()
    off = np.where(np.isin(np.arange(len(found.theta)), index), 1.2 * found.theta, found.theta)
    begun = least_squares(found.problem, found.coordinates, off, nodes=nodes, most_steps=0)
    assert len(made) == 2 and np.array_equal(begun.theta, off) and np.array_equal(begun.start, found.problem.start)


def test_a_step_that_one_number_shortens_is_no_arrival(monkeypatch: pytest.MonkeyPatch) -> None:
    found, made = _noisy(1.5, monkeypatch)
    off = replace(
        found, theta=np.where(np.arange(len(found.theta)) == found.coordinates.index[0], 1.001, 1.0) * found.theta
    )
    monkeypatch.setattr(type(found.coordinates), "shorten", lambda self, dz: 1e-9)
    made.clear()
    carried_on(off)
    assert made  # however short it is, the step is taken
