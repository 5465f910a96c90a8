"""Sensitivities, delays, irregular sampling, and how often something is compiled."""

import numpy as np
import pytest

from rwjax.build import structure_of, theta_of
from rwjax.fit.problem import pose
from rwjax.simulate import evaluate, free_run
from tests.systems import platform, reaction, record, run, wheel

TIME = np.arange(201) * 0.01
COMMAND = 3.0 + np.sin(4.0 * TIME)  # one direction of motion: no kinks, so differences are smooth
CASES = {
    "wheel": (wheel(), "wheel_rad_s", {"wheel.coulomb": {"M_c": 2e-3}, "drive.delay": {"tau": 0.0137}}),
    "platform": (platform(), "yaw_rad", {"axis.stribeck": {"M_e": 0.1, "v_s": 1.0}, "drive.deadzone": {"u_0": 0.3}}),
    "reaction": (reaction(), "yaw_rad", {"axis.bias_torque": {"T": 1e-3}, "drive.bias": {"u_b": 0.2}}),
}


@pytest.mark.parametrize("case", CASES)
def test_sensitivities_match_differences_of_the_free_run(case: str) -> None:
    rig, output, effects = CASES[case]
    structure = structure_of(rig).with_effects(*effects)
    theta = theta_of(rig, structure)
    for effect, given in effects.items():
        for name, value in given.items():
            theta[structure.names.index(f"{effect}.{name}")] = value
    problem = pose(structure, (record(TIME, COMMAND, {output: np.zeros_like(TIME)}),), {output: 1.0})
    start = np.array([[{"w": 1.0, "Omega": 20.0}.get(name, 0.0) for name in structure.states]])

    def cost(theta: np.ndarray, start: np.ndarray) -> float:
        y, _ = free_run(structure, theta, start, problem.batch)
        return 0.5 * float(np.sum((np.asarray(y) * problem.batch.weight) ** 2))

    _, nodes = free_run(structure, theta, start, problem.batch)
    e = evaluate(structure, theta, np.asarray(nodes), problem.batch)
    assert np.max(np.abs(e.defect)) < 1e-9 * np.max(np.abs(nodes))  # windows join up
    gradient = np.asarray(e.g)[0]
    for k, name in enumerate((*structure.names, *structure.states)):
        h = np.zeros(len(theta) + start.shape[1])
        h[k] = 1e-5 * max(abs(np.append(theta, start[0])[k]), 1e-2)
        up, down = np.append(theta, start[0]) + h, np.append(theta, start[0]) - h
        p = len(theta)
        difference = (cost(up[:p], up[None, p:]) - cost(down[:p], down[None, p:])) / (2.0 * h[k])
        # differences of a sum of squares lose half the digits; the sum itself sets the scale
        assert gradient[k] == pytest.approx(difference, rel=2e-4, abs=1e-8 * cost(theta, start) / h[k]), name


def test_a_delay_of_whole_samples_shifts_the_command() -> None:
    t = np.arange(501) * 0.01
    u = np.sign(np.sin(3.0 * t))
    late = np.concatenate([np.full(4, u[0]), u[:-4]])
    delayed = run(platform(), record(t, u), {}, effects={"drive.delay": {"tau": 0.04}})
    assert np.max(np.abs(delayed["yaw_rad"] - run(platform(), record(t, late), {})["yaw_rad"])) < 1e-9


def test_irregular_samples_see_the_motion_of_regular_ones() -> None:
    rng = np.random.default_rng(0)
    fine = np.arange(5001) * 0.002
    u = np.sin(1.3 * fine)
    reference = run(platform("viscous = 0.02"), record(fine, u), {})["yaw_rad"]
    pick = np.sort(rng.choice(np.arange(1, 5000), size=900, replace=False))
    pick = np.concatenate([[0], pick, [5000]])
    # the command is held between the kept samples: compare with the fine run under that same held command
    held = u[pick][np.searchsorted(pick, np.arange(5001), side="right") - 1]
    reference = run(platform("viscous = 0.02"), record(fine, held), {})["yaw_rad"]
    seen = run(platform("viscous = 0.02"), record(fine[pick], u[pick]), {})["yaw_rad"]
    # one grid step of 5 ms averages the command: acceleration 4 rad/s2 per volt, steps below 0.05 V
    assert np.max(np.abs(seen - reference[pick])) < 0.5 * 4.0 * 0.05 * 0.005


def test_new_starts_and_logs_of_one_shape_compile_nothing() -> None:
    rig = platform()
    structure = structure_of(rig)
    theta = theta_of(rig, structure)
    for k in range(3):
        log = record(TIME, COMMAND * (1.0 + k), {"yaw_rad": np.zeros_like(TIME)})
        problem = pose(structure, (log,), {"yaw_rad": 1.0})
        _, nodes = free_run(structure, theta * (1.0 + 0.1 * k), problem.start, problem.batch)
        evaluate(structure, theta, np.asarray(nodes), problem.batch)
        if k == 0:
            compiled = evaluate._cache_size(), free_run._cache_size()
    assert (evaluate._cache_size(), free_run._cache_size()) == compiled
