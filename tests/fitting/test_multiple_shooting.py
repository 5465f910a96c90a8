"""The fit: known numbers from wrong starts, agreement with another optimiser, honest words."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest

from rwjax import Log, parse_rig
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.fit import fit
from rwjax.fitting.multiple_shooting import Fit, least_squares
from rwjax.fitting.problem import pose
from rwjax.fitting.shooting_nodes import measured_nodes
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from tests.systems import MOTOR, platform, reaction, record, run, wheel

TIME = np.arange(1001) * 0.01
FREE = '"axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'


def log_of(rig, command=None, noise: float = 0.0, **more):
    u = np.where(TIME > 0.6, 0.6 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME), 0.0)
    u = u if command is None else command
    y = run(rig, record(TIME, u), {})["yaw_rad"]
    return record(TIME, u, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, noise, len(y))}, **more)


@pytest.mark.parametrize("factor", [0.6, 1.7])  # no start of the fit is the truth
def test_known_numbers_come_back_from_wrong_starts(factor: float) -> None:
    truth = platform(free=FREE)
    believed = truth.with_values({name: factor * truth.values[name] for name in truth.free})
    found = fit(believed, [log_of(truth)]).rig
    for name in truth.free:
        assert found.values[name] == pytest.approx(truth.values[name], rel=1e-5), name


def test_optimistix_ends_at_the_same_optimum() -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    log = log_of(rig, noise=1e-3)
    ours = fit(rig.with_values({"axis.inertia": 0.15}), [log])
    structure = structure_of(rig)
    problem = pose(structure, (log,), ours.fit.problem.noise)
    theta = theta_of(rig, structure)

    def residual(z, _):
        start = jnp.stack([z[3], jnp.zeros(())])[None]  # the run starts at rest
        y, _ = free_run(structure, z[:3] * theta, start, problem.batch)
        misfit = ((y - problem.batch.reading) * problem.batch.weight).ravel()
        return jnp.concatenate([misfit, 1e6 * (z[:1] - 1.0)])  # the gain is held by a stiff pull to its own value

    z0 = jnp.asarray([1.0, 1.2, 0.8, 0.0])
    solver = optx.LevenbergMarquardt(rtol=1e-10, atol=1e-10)
    other = optx.least_squares(residual, solver, z0, options={"jac": "fwd"}, max_steps=200).value
    values = np.asarray(other[:3]) * theta
    assert ours.rig.values["axis.inertia"] == pytest.approx(values[structure.names.index("axis.inertia")], rel=1e-5)
    assert ours.rig.values["axis.friction.viscous"] == pytest.approx(values[2], rel=1e-4)


def test_a_halved_step_moves_no_number_by_a_tenth_of_its_standard_error() -> None:
    rig = platform(
        "viscous = 0.02\ncoulomb = 0.05\nstatic = 0.08\nstribeck_velocity = 0.2",
        free=FREE + ', "axis.friction.static"',
    )
    y = log_of(rig).outputs["yaw_rad"]
    q = 2 * np.pi / 2048
    log = record(TIME, log_of(rig).command, {"yaw_rad": q * np.round(y / q)}, resolution={"yaw_rad": q})
    plain, halved = fit(rig, [log]), fit(rig, [log], refine=2)
    for name, error in plain.uncertainty.standard_error.items():
        assert abs(plain.rig.values[name] - halved.rig.values[name]) < 0.1 * error, name


def test_a_number_on_its_bound_is_named() -> None:
    truth = platform("viscous = 0.0\ncoulomb = 0.05", free=FREE)
    believed = truth.with_values({"axis.friction.viscous": 0.01})
    log = log_of(truth, noise=2e-3)
    bent = record(TIME, log.command, {"yaw_rad": log.outputs["yaw_rad"] * (1.0 + 0.02 * TIME / 10.0)})
    notes = fit(believed, [bent]).notes
    assert "axis.friction.viscous sits on its bound" in notes


def test_numbers_that_only_count_together_are_named() -> None:
    text = f'kind = "wheel"\n{MOTOR}\n[fit]\nfree = ["motor.torque_constant", "motor.resistance", "wheel.inertia", "motor.friction"]'
    rig = parse_rig(text.replace("0.0641", "0.0"))
    u = np.where(TIME > 0.6, 3.0 * np.sign(np.sin(1.7 * TIME)), 0.0)
    y = run(rig, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    y = y + np.random.default_rng(0).normal(0.0, 0.3, len(y))
    found = fit(rig, [record(TIME, u, {"wheel_rad_s": y})]).uncertainty
    # the speed tells K/(R J) and (b + K^2/R)/J: two of four
    notes = [note for note in found.notes if note.startswith("only a combination of")]
    assert len(notes) == len(found.notes) == 2
    assert all(any(name in note for note in notes) for name in rig.free)
    assert all(np.isinf(error) for error in found.standard_error.values())


def test_a_number_that_moves_with_an_undetermined_combination_has_no_standard_error() -> None:
    free = 'free = ["motor.torque_constant", "motor.resistance", "wheel.inertia", "motor.friction"]'
    rig = parse_rig(f'kind = "wheel"\n{MOTOR}\n[fit]\n{free}')  # L is known: one combination is left
    u = np.where(TIME > 0.6, 3.0 * np.sign(np.sin(1.7 * TIME)), 0.0)
    y = run(rig, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    log = record(TIME, u, {"wheel_rad_s": y + np.random.default_rng(0).normal(0.0, 0.3, len(y))})
    plain = fit(rig, [log])
    held = replace(rig.with_values({"motor.friction": 20 * 4.07e-6}), free=rig.free[:3])
    other = fit(held, [log])
    assert other.fit.cost == pytest.approx(plain.fit.cost, rel=1e-9)  # the log cannot tell the two apart,
    moved = abs(other.rig.values["motor.resistance"] - plain.rig.values["motor.resistance"])
    assert moved < 3.0 * plain.uncertainty.standard_error["motor.resistance"]  # 6 % of R, 80 standard errors


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


def test_a_number_without_a_trace_is_named() -> None:
    text = "axis.inertia = 0.1\naxis.friction.viscous = 0.02\naxis.gravity.torque = 0.0\naxis.gravity.angle = 0.3"
    free = 'fit.free = ["axis.inertia", "axis.gravity.angle"]'  # the direction of a load of 0
    rig = parse_rig(f'kind = "platform"\ndrive.gain = 0.4\n{text}\n{free}')
    found = fit(rig, [log_of(rig, noise=1e-3)]).uncertainty
    assert found.notes == ("axis.gravity.angle leaves no trace in these logs",)
    assert np.isinf(found.standard_error["axis.gravity.angle"]) and np.isfinite(found.standard_error["axis.inertia"])


def test_numbers_that_are_hardly_told_apart_are_named_with_their_correlation() -> None:
    truth = platform("viscous = 0.5\ncoulomb = 0.05", free=FREE)
    level = np.where(TIME > 5.0, 0.55, 0.5)  # two speeds that hardly differ
    log = log_of(truth, np.where(TIME > 0.6, level, 0.0), noise=1e-3)
    found = fit(truth, [log])
    notes = [note for note in found.notes if "hardly told apart" in note]
    assert any("axis.friction.viscous" in note and "axis.friction.coulomb" in note for note in notes)
    C = np.array(found.json()["covariance"])
    k = [found.rig.free.index(f"axis.friction.{name}") for name in ("viscous", "coulomb")]
    assert C[k[0], k[1]] / np.sqrt(C[k[0], k[0]] * C[k[1], k[1]]) < -0.99
    other = platform(free=FREE)
    assert not [n for n in fit(other, [log_of(other, noise=1e-3)]).notes if "hardly" in n]


def test_the_interval_is_as_wide_as_the_scatter_of_estimates() -> None:
    truth = platform(free=FREE)
    fits = []
    for seed in range(40):
        log = log_of(truth)
        noise = np.random.default_rng(seed).normal(0.0, 2e-3, len(TIME))
        fits.append(fit(truth, [record(TIME, log.command, {"yaw_rad": log.outputs["yaw_rad"] + noise})]))
    for name in truth.free:
        scatter = np.std([f.rig.values[name] for f in fits], ddof=1)
        claimed = np.median([f.uncertainty.standard_error[name] for f in fits])
        assert 0.65 < claimed / scatter < 1.5, name  # 40 draws know a scatter to 11 %


@pytest.mark.parametrize("factor", [0.4, 2.5])
def test_a_swing_is_not_fitted_a_period_off(factor: float) -> None:
    # twelve periods of a pendulum: with 40 % of its gravity the start is seven periods behind, each a local minimum
    truth = parse_rig(
        'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.01\n'
        '[axis.gravity]\ntorque = 1.5\n[fit]\nfree = ["axis.gravity.torque", "axis.friction.viscous"]'
    )
    time = np.arange(2001) * 0.01
    y = run(truth, record(time, 0.0 * time), {"psi": 1.0})["yaw_rad"]
    log = record(time, 0.0 * time, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, 1e-3, len(y))})
    found = fit(truth.with_values({name: factor * truth.values[name] for name in truth.free}), [log])
    for name, error in found.uncertainty.standard_error.items():
        assert abs(found.rig.values[name] - truth.values[name]) < 4.0 * error < 0.04 * truth.values[name], name


def test_dropouts_cost_precision_and_nothing_else() -> None:
    truth = platform(free=FREE)
    whole = log_of(truth, np.where(TIME > 0.6, 0.6 * np.sign(np.sin(1.7 * TIME)), 0.0), noise=1e-3)
    silent = (TIME > 2.0) & (TIME < 4.5)  # no readings
    kept = ~((TIME > 6.0) & (TIME < 6.5)) | (
        np.arange(len(TIME)) % 37 == 0
    )  # hardly any samples; the command is held there
    y = np.where(silent, np.nan, whole.outputs["yaw_rad"])
    broken = record(TIME[kept], whole.command[kept], {"yaw_rad": y[kept]})
    full, found = fit(truth, [whole]), fit(truth, [broken])
    for name, error in found.uncertainty.standard_error.items():
        assert abs(found.rig.values[name] - truth.values[name]) < 4.0 * error, name
        assert full.uncertainty.standard_error[name] < error < 5.0 * full.uncertainty.standard_error[name], name
