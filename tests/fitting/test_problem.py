"""First states: which of them the readings must tell."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.effects.effect import Effect
from rwjax.effects.library import EFFECTS
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.multiple_shooting import least_squares
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import sizes_of
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from tests.fitting.moving_runs import several
from tests.systems import platform, reaction, record, run, wheel

TIME = np.arange(501) * 0.01
COMMAND = np.sign(np.sin(2.0 * TIME))
ON_ANGLE = {
    "axis.imbalance": "psi",
    "axis.spring": "psi",
    "axis.angle_friction": "psi",
    "axis.end_stop": "psi",
    "sensor.eccentricity": "psi",
    "wheel.cogging": "theta",
}


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_an_unseen_angle_is_free_where_something_depends_on_it(effect: type[Effect]) -> None:
    structure = structure_of(reaction()).with_effects(effect.name)
    rates = {"yaw_rad_s": COMMAND, "wheel_rad_s": COMMAND}
    free = dict(zip(structure.states, pose(structure, (record(TIME, COMMAND, rates),)).start_free[0], strict=True))
    assert effect.at_angle or effect.name not in ON_ANGLE
    body = ON_ANGLE.get(effect.name, "theta" if effect.name.startswith("wheel.") else "psi")
    wanted = {body} if effect.at_angle else set()
    assert {name for name in ("psi", "theta") if free[name]} == wanted


def test_the_encoder_of_a_wheel_alone_depends_on_its_angle() -> None:
    structure = structure_of(wheel()).with_effects("sensor.eccentricity")
    problem = pose(structure, (record(TIME, COMMAND, {"wheel_rad_s": COMMAND}),))
    assert problem.start_free[0, structure.states.index("theta")]


@pytest.mark.slow
def test_a_free_angle_on_which_nothing_acts_stays_and_harms_nothing() -> None:
    rig = platform(free='"axis.inertia", "axis.friction.viscous"')
    y = run(rig, record(TIME, COMMAND, {"yaw_rad_s": COMMAND}), {"w": 0.3})["yaw_rad_s"]
    log = record(TIME, COMMAND, {"yaw_rad_s": y + np.random.default_rng(1).normal(0.0, 1e-3, len(y))})
    found = []
    for effects in ((), ("axis.spring", "axis.imbalance")):  # at their null
        structure = structure_of(rig).with_effects(*effects)
        theta = 1.3 * theta_of(rig, structure)
        free = np.array([name in rig.free for name in structure.names])
        moves = coordinates(theta, free, bounds_of(rig, structure), sizes_of(rig, structure, theta, [log]))
        found.append(least_squares(pose(structure, (log,)), moves, theta))
    plain, held = found
    assert plain.converged and held.converged
    assert held.cost == pytest.approx(plain.cost, rel=1e-9) and held.start[0, 0] == 0.0
    for name in rig.free:
        assert held.numbers()[name] == pytest.approx(plain.numbers()[name], rel=1e-6), name


def test_an_unseen_angle_is_found_from_the_rate() -> None:
    rig = platform(free='"axis.inertia"')
    spring = {"axis.spring": {"k": 0.4}}
    structure = structure_of(rig).with_effects("axis.spring")
    y = run(rig, record(TIME, COMMAND, {"yaw_rad_s": COMMAND}), {"psi": 0.7, "w": 0.3}, effects=spring)["yaw_rad_s"]
    log = record(TIME, COMMAND, {"yaw_rad_s": y + np.random.default_rng(1).normal(0.0, 1e-3, len(y))})
    theta = theta_of(rig, structure)
    theta[structure.names.index("axis.spring.k")] = 0.4
    free = np.array([name == "axis.inertia" for name in structure.names])
    moves = coordinates(theta, free, bounds_of(rig, structure), sizes_of(rig, structure, theta, [log]))
    found = least_squares(pose(structure, (log,)), moves, theta)
    assert found.start[0, :2] == pytest.approx([0.7, 0.3], abs=5e-3)


@pytest.mark.parametrize("shares_programs", [False, True])
def test_runs_that_go_on_threads_are_those_of_one_after_the_other(
    monkeypatch: pytest.MonkeyPatch, shares_programs: bool
) -> None:
    rig = platform("viscous = 0.02")
    problem = replace(several(rig), shares_programs=shares_programs)
    theta = theta_of(rig, problem.structure)
    assert not problem.log_by_log and not problem.only((0,)).log_by_log
    whole = problem.free_run(theta, problem.start)
    monkeypatch.setattr("rwjax.fitting.problem.LONG", problem.batch.windows * len(problem.batch.step_index))
    assert problem.log_by_log
    for on_threads, one_by_one in zip(problem.free_run(theta, problem.start), whole, strict=True):
        assert np.array_equal(on_threads, one_by_one)
    assert np.max(np.abs(whole[0][0] - whole[0][1])) > 0.1  # runs of their own
