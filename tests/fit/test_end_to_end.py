"""The fit: known numbers from wrong starts, agreement with another optimiser, honest words."""

import jax.numpy as jnp
import numpy as np
import optimistix as optx
import pytest

from rwjax import parse_rig
from rwjax.build import structure_of, theta_of
from rwjax.fit.problem import pose
from rwjax.fit.rig_fit import fit_rig
from rwjax.simulate import free_run
from tests.systems import MOTOR, platform, record, run

TIME = np.arange(1001) * 0.01
FREE = '"axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'


def _log(rig, command=None, noise: float = 0.0, **more):
    u = np.where(TIME > 0.6, 0.6 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME), 0.0)
    u = u if command is None else command
    y = run(rig, record(TIME, u), {})["yaw_rad"]
    return record(TIME, u, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, noise, len(y))}, **more)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_known_numbers_come_back_from_wrong_starts(factor: float) -> None:
    truth = platform(free=FREE)
    believed = truth.with_values({name: factor * truth.values[name] for name in truth.free})
    found = fit_rig(believed, [_log(truth)]).rig
    for name in truth.free:
        assert found.values[name] == pytest.approx(truth.values[name], rel=1e-5), name


def test_optimistix_ends_at_the_same_optimum() -> None:
    rig = platform("viscous = 0.02", free='"axis.inertia", "axis.friction.viscous"')
    log = _log(rig, noise=1e-3)
    ours = fit_rig(rig.with_values({"axis.inertia": 0.15}), [log])
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
    rig = platform("viscous = 0.02\ncoulomb = 0.05\nstatic = 0.08\nstribeck_velocity = 0.2", free=FREE + ', "axis.friction.static"')
    y = _log(rig).outputs["yaw_rad"]
    q = 2 * np.pi / 2048
    log = record(TIME, _log(rig).command, {"yaw_rad": q * np.round(y / q)}, resolution={"yaw_rad": q})
    plain, halved = fit_rig(rig, [log]), fit_rig(rig, [log], refine=2)
    for name, error in plain.uncertainty.standard_error.items():
        assert abs(plain.rig.values[name] - halved.rig.values[name]) < 0.1 * error, name


def test_a_number_on_its_bound_is_named() -> None:
    truth = platform("viscous = 0.0\ncoulomb = 0.05", free=FREE)
    believed = truth.with_values({"axis.friction.viscous": 0.01})
    log = _log(truth, noise=2e-3)
    bent = record(TIME, log.command, {"yaw_rad": log.outputs["yaw_rad"] * (1.0 + 0.02 * TIME / 10.0)})
    notes = fit_rig(believed, [bent]).uncertainty.notes
    assert "axis.friction.viscous sits on its bound" in notes


def test_numbers_that_only_count_together_are_named() -> None:
    text = f'kind = "wheel"\n{MOTOR}\n[fit]\nfree = ["motor.torque_constant", "motor.resistance", "wheel.inertia", "motor.friction"]'
    rig = parse_rig(text.replace("0.0641", "0.0"))
    u = np.where(TIME > 0.6, 3.0 * np.sign(np.sin(1.7 * TIME)), 0.0)
    y = run(rig, record(TIME, u, {"wheel_rad_s": np.zeros_like(TIME)}), {})["wheel_rad_s"]
    y = y + np.random.default_rng(0).normal(0.0, 0.3, len(y))
    found = fit_rig(rig, [record(TIME, u, {"wheel_rad_s": y})]).uncertainty
    assert any(note.startswith("only a combination of") for note in found.notes)
    assert np.isinf(found.standard_error["motor.resistance"])
