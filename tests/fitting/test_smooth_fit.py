"""Fits through the smooth solver: numbers that are known, starts that are off, runs that fail."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, Rig, Smooth, fit, simulate
from rwjax.fitting.coordinates import coordinates
from rwjax.fitting.problem import pose
from rwjax.fitting.smooth_fit import fit_smooth
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from tests.systems import platform, record

WIDTH = 2e-3  # rad/s
T = np.arange(401) * 0.01  # s
SQUARE = np.where(np.sin(2.0 * T) > 0.0, 0.6, -0.5) * (T > 0.3)  # V
SWEEP = 0.7 * np.sin(T**2) * (T > 0.3)
FREE = '"axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'
NOISE = 3e-4  # rad
SMOOTH = Smooth(WIDTH)


def rig() -> Rig:
    return platform(free=FREE)


def log_of(rig: Rig, u: np.ndarray, seed: int, start: dict[str, float] | None = None) -> Log:
    """A run of a rig whose friction is smooth, with noise."""
    y = simulate(rig, T, u, start=start or {}, solver=SMOOTH)["yaw_rad"]
    noise = np.random.default_rng(seed).normal(0.0, NOISE, len(T))
    return replace(record(T, u, {"yaw_rad": y + noise}), name=f"{seed}.csv")


@pytest.fixture(scope="module")
def logs() -> list[Log]:
    return [log_of(rig(), SQUARE, 1), log_of(rig(), SWEEP, 2)]


def off_by(found, truth: Rig) -> dict[str, float]:
    """Errors of the estimates in their standard errors."""
    return {name: (found.rig.values[name] - truth.values[name]) / found.rig.standard_error[name] for name in truth.free}


@pytest.mark.slow
def test_it_finds_the_numbers_of_a_smooth_rig_from_a_start_that_is_off(logs: list[Log]) -> None:
    begin = rig().with_values({"axis.inertia": 0.16, "axis.friction.viscous": 0.03, "axis.friction.coulomb": 0.03})
    found = fit(begin, logs, solver=SMOOTH)
    assert found.fit.converged
    assert found.rms["yaw_rad"] == pytest.approx(NOISE, rel=0.1)
    assert all(abs(z) < 4.0 for z in off_by(found, rig()).values()), off_by(found, rig())
    assert found.rig.standard_error["axis.friction.coulomb"] < 1e-3 * 0.05
    assert found.notes[0] == "dry friction acts by a smooth sign 0.002 rad/s wide, solved by Tsit5"
    assert any(
        "a fit by the exact solver does; their own free run takes --smooth 0.002," in note for note in found.notes
    )
    assert (found.json()["solver"], found.json()["smooth"]) == ("diffrax", WIDTH)


@pytest.mark.slow
def test_the_width_is_chosen_where_the_user_leaves_it_open(logs: list[Log]) -> None:
    fastest = max(np.max(np.abs(np.gradient(log.outputs["yaw_rad"], 0.1))) for log in logs)
    chosen = fit(rig(), logs, solver=Smooth()).fit.problem.solver.width
    assert 0.0 < chosen < 1e-2 * fastest
    assert len(Smooth(2.0 * chosen).notes(rig(), logs)) == 1
    assert Smooth(0.5).notes(platform("viscous = 0.02"), logs)[0].startswith("the rig has no dry friction")
    assert "times as wide as what these readings leave unseen" in Smooth(0.5).notes(rig(), logs)[1]


@pytest.mark.slow
def test_no_profiles_are_made_through_it(logs: list[Log]) -> None:
    near = replace(rig(), bounds={"axis.friction.viscous": (0.0199, 1.0)})  # half a percent below the truth
    found = fit(near, [replace(logs[0], outputs={"yaw_rad": logs[0].outputs["yaw_rad"] * 1.02})], solver=SMOOTH)
    error, (low, high) = found.rig.standard_error, found.interval["axis.friction.viscous"]
    if "axis.friction.viscous" in error:
        assert high - low == pytest.approx(3.92 * error["axis.friction.viscous"], rel=1e-6)
    assert any("a fit by the exact solver gives its profile" in note for note in found.notes)
    assert not any("by its profile" in note for note in found.notes)


@pytest.mark.slow
def test_numbers_of_every_run_priors_and_a_bootstrap_go_through_it(logs: list[Log]) -> None:
    known = replace(rig(), prior={"axis.inertia": (0.1, 1e-7)})
    assert fit(known, logs, solver=SMOOTH).rig.values["axis.inertia"] == pytest.approx(0.1, abs=5e-7)
    drawn = fit(rig(), logs, solver=SMOOTH, bootstrap=40)
    for name, (low, high) in drawn.interval.items():
        assert low < rig().values[name] + 4.0 * drawn.rig.standard_error[name]
        assert 0.3 < (high - low) / (3.92 * drawn.rig.standard_error[name]) < 3.0, name
    own = replace(rig(), per_run=("axis.friction.coulomb",))
    found = fit(own, logs, solver=SMOOTH).fit.numbers()
    assert found["axis.friction.coulomb in 1.csv"] == pytest.approx(0.05, rel=1e-2)


@pytest.mark.slow
def test_a_run_that_begins_in_motion_gets_its_initial_state(logs: list[Log]) -> None:
    moving = log_of(rig(), SQUARE + 0.3, 3, {"psi": 0.4, "w": 2.0})
    found = fit(rig(), [moving, logs[1]], solver=SMOOTH)
    psi, w = found.fit.start[0]
    assert psi == pytest.approx(0.4, abs=5.0 * NOISE) and w == pytest.approx(2.0, abs=0.02)
    assert all(abs(z) < 4.0 for z in off_by(found, rig()).values())


@pytest.mark.slow
def test_initial_states_come_from_the_start_where_the_model_lacks_something(logs: list[Log]) -> None:
    heavier = [replace(log, outputs={"yaw_rad": 1.05 * log.outputs["yaw_rad"] + 0.01 * T**2}) for log in logs]
    found = fit(rig(), heavier, solver=SMOOTH)
    assert found.fit.problem.initial_state_from_start.all()
    assert any("the model lacks something or the smooth sign" in note for note in found.notes)


@pytest.mark.slow
def test_a_start_from_which_runs_fail_is_left_for_another(logs: list[Log]) -> None:
    structure = structure_of(rig())
    problem = pose(structure, logs, solver=SMOOTH.suited(rig(), logs))
    theta = theta_of(rig(), structure)
    free = np.array([name in rig().free for name in structure.names])
    bounds = np.where(free[:, None], (-np.inf, np.inf), bounds_of(rig(), structure))
    moves = coordinates(theta, free, bounds, np.abs(theta))
    wild = np.where(np.array(structure.names) == "axis.friction.viscous", -40.0, theta)  # grows by e every 2.5 ms
    alone = fit_smooth(problem, moves, [wild])
    assert alone.cost == np.inf and not alone.converged and np.array_equal(alone.theta, wild)
    told: list[str] = []
    found = fit_smooth(problem, moves, [wild, wild, np.where(free, 1.3 * theta, theta)], told.append)
    assert [text.partition(": ")[0][-12:] for text in told[:4]] == [f"stage {k} of 3" for k in (1, 1, 2, 3)]
    assert "from 2 further starts" in told[1] and "search 1 of 6 at most" in told[3]
    assert found.converged and found.theta == pytest.approx(theta, rel=1e-2)


@pytest.mark.slow
def test_a_number_that_would_leave_through_its_bound_is_held_and_the_others_are_as_by_the_exact_fit(
    logs: list[Log],
) -> None:
    structure = structure_of(rig())
    problem = pose(structure, logs, solver=SMOOTH.suited(rig(), logs))
    theta = theta_of(rig(), structure)
    free = np.array([name in rig().free for name in structure.names])
    viscous = np.array(structure.names) == "axis.friction.viscous"
    bounds = np.where(viscous[:, None], (0.021, np.inf), bounds_of(rig(), structure))
    moves = coordinates(theta, free, bounds, np.abs(theta))
    both = [fit_smooth(problem, moves, [np.where(viscous, value, theta)]) for value in (0.021, 0.03)]
    assert both[0].numbers()["axis.friction.viscous"] == both[1].numbers()["axis.friction.viscous"] == 0.021
    assert both[0].cost == pytest.approx(both[1].cost, rel=1e-4)
    assert both[0].theta == pytest.approx(both[1].theta, rel=1e-4)
    held = moves.without(int(np.flatnonzero(viscous)[0]))
    alone = fit_smooth(problem, held, [np.where(viscous, 0.021, theta)])
    assert alone.cost == pytest.approx(both[0].cost, rel=1e-4)  # holding it from the beginning leaves no less
