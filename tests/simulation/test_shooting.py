"""Sensitivities, delays, irregular sampling, and how often something is compiled."""

import numpy as np
import pytest

from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.shooting import evaluate, free_run
from tests.systems import platform, reaction, record, run, wheel

TIME = np.arange(201) * 0.01
COMMAND = 3.0 + np.sin(4.0 * TIME)  # one direction of motion: no kinks, so differences are smooth
CASES = {
    "wheel": (wheel(), "wheel_rad_s", {"wheel.coulomb": {"M_c": 2e-3}, "drive.delay": {"tau": 0.0137}}),
    "platform": (
        platform(),
        "yaw_rad",
        {"axis.stribeck": {"M_e": 0.1, "v_s": 1.0}, "drive.deadzone": {"u_0": 0.3}},
    ),
    "late platform": (platform(), "yaw_rad", {"sensor.delay": {"tau": 0.0372}}),
    "late wheel": (
        wheel(),
        "wheel_rad",
        {"sensor.delay": {"tau": 0.0372}, "sensor.missed_counts": {"s": 0.3, "w_m": 9.0}},
    ),
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
    e = evaluate(structure, theta, np.arange(len(theta)), np.asarray(nodes), problem.batch)
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
    pick = np.sort(rng.choice(np.arange(1, 5000), size=900, replace=False))
    pick = np.concatenate([[0], pick, [5000]])
    # the command is held between the kept samples: compare with the fine run under that same held command
    held = u[pick][np.searchsorted(pick, np.arange(5001), side="right") - 1]
    reference = run(platform("viscous = 0.02"), record(fine, held), {})["yaw_rad"]
    seen = run(platform("viscous = 0.02"), record(fine[pick], u[pick]), {})["yaw_rad"]
    # one grid step of 5 ms averages the command: acceleration 4 rad/s2 per volt, steps below 0.05 V
    assert np.max(np.abs(seen - reference[pick])) < 0.5 * 4.0 * 0.05 * 0.005


def test_without_inductance_an_irregular_sample_sees_the_current_of_its_own_command() -> None:
    t = np.array([0.0, 0.01, 0.02, 0.03, 0.0427, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1])
    u = np.where(t > 0.0426, -2.0, 2.0)
    y = run(wheel(0.0), record(t, u, {"current_A": np.zeros_like(t)}), {})
    exact = (u - 0.0182 * y["wheel_rad_s"]) / 0.83
    assert np.max(np.abs(y["current_A"] - exact)) < 0.01 * np.ptp(exact)


@pytest.mark.parametrize("case", CASES)
def test_every_sensitivity_matches_a_difference(case: str) -> None:
    """`local`, `chain`, `H` and `g`, against central differences of readings and states of the free run."""
    rig, output, effects = CASES[case]
    structure = structure_of(rig).with_effects(*effects)
    theta = theta_of(rig, structure)
    for effect, given in effects.items():
        for name, value in given.items():
            theta[structure.names.index(f"{effect}.{name}")] = value
    problem = pose(structure, (record(TIME, COMMAND, {output: np.zeros_like(TIME)}),), {output: 1.0})
    z = np.append(theta, [{"w": 1.0, "Omega": 20.0}.get(name, 0.0) for name in structure.states])
    p = len(theta)

    def free(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        y, nodes = free_run(structure, z[:p], z[None, p:], problem.batch)
        return np.asarray(y) * problem.batch.weight, np.asarray(nodes)

    r, nodes = free(z)
    e = evaluate(structure, theta, np.arange(len(theta)), nodes, problem.batch)
    assert np.array_equal(e.residual != 0.0, r != 0.0)
    assert np.max(np.abs(np.asarray(e.residual) - r)) < 1e-12 * np.max(np.abs(r))  # windows as in the free run
    seen = problem.batch.weight > 0.0
    jacobian = np.einsum("nlwqy,lwna->alwqy", np.asarray(e.local)[p:], np.asarray(e.chain))
    jacobian[:p] += np.asarray(e.local)[:p]
    differences = np.zeros_like(jacobian)
    for k, name in enumerate((*structure.names, *structure.states)):
        h = np.zeros(len(z))
        h[k] = 1e-4 * (abs(z[k]) if z[k] != 0.0 else 1.0)  # truncation 1e-8, rounding 1e-12
        (r_up, x_up), (r_down, x_down) = free(z + h), free(z - h)
        differences[k] = (r_up - r_down) / (2.0 * h[k])
        by_node = (x_up - x_down) / (2.0 * h[k])
        chain = np.asarray(e.chain)[..., k]
        for j, state in enumerate(structure.states):
            size = max(np.max(np.abs(by_node[..., j])), 1e-9 * np.max(np.abs(nodes[..., j])) / h[k])
            assert np.max(np.abs(chain[..., j] - by_node[..., j])) < 1e-5 * size, (name, state)
        size = max(np.max(np.abs(differences[k])), 1e-9 * np.max(np.abs(r)) / h[k])
        assert np.max(np.abs(jacobian[k] - differences[k])[seen]) < 1e-5 * size, name
    H = np.einsum("alwqy,blwqy->ab", differences, differences)
    size = np.sqrt(np.outer(np.diag(H), np.diag(H)))
    assert np.max(np.abs(np.asarray(e.H)[0] - H)[size > 0.0] / size[size > 0.0]) < 2e-5
    g = np.einsum("alwqy,lwqy->a", differences, r)
    assert np.max(np.abs(np.asarray(e.g)[0] - g) / np.maximum(np.sqrt(np.diag(H) * np.sum(r**2)), 1e-300)) < 1e-5


def test_windows_that_do_not_join_are_mended_to_first_order() -> None:
    """Linearised continuity: states moved off the free run come back to it, the plant being linear while it slides."""
    structure = structure_of(platform())
    theta = theta_of(platform(), structure)
    problem = pose(structure, (record(TIME, COMMAND, {"yaw_rad": np.zeros_like(TIME)}),), {"yaw_rad": 1.0})
    start = np.array([[0.3, 1.0]])
    _, nodes = (np.asarray(a) for a in free_run(structure, theta, start, problem.batch))
    off = nodes + np.where(np.arange(nodes.shape[1])[:, None] > 0, 0.1, 0.0)
    e = evaluate(structure, theta, np.arange(len(theta)), off, problem.batch)
    assert np.max(np.abs(e.defect)) > 0.01
    assert np.max(np.abs(off + np.asarray(e.shift) - nodes)) < 1e-10 * np.max(np.abs(nodes))


def test_a_small_change_of_delay_moves_the_motion_continuously() -> None:
    u = np.sign(np.sin(3.0 * TIME + 0.1))
    runs = [
        run(platform("viscous = 0.02"), record(TIME, u), {}, effects={"drive.delay": {"tau": tau}})["yaw_rad"]
        for tau in (0.0149, 0.015, 0.0151)  # across a grid point
    ]
    steps = [np.max(np.abs(b - a)) for a, b in zip(runs[:-1], runs[1:], strict=True)]
    # moving jumps of 0.8 N m by 0.1 ms changes w by 0.8 mrad/s; the angle by at most that times 2 s and the jumps
    assert steps[0] == pytest.approx(steps[1], rel=0.02) and 1e-5 < steps[0] < 5e-3


def test_the_last_current_is_that_of_the_last_command() -> None:
    # without inductance the current follows the voltage at once, at the last sample as at any other
    t = TIME[:51]
    u = np.append(np.full(50, 2.0), -2.0)
    log = record(t, u, {"wheel_rad_s": np.zeros_like(t), "current_A": np.zeros_like(t)})
    y = run(wheel(0.0), log, {})
    assert np.allclose(y["current_A"], (u - 0.0182 * y["wheel_rad_s"]) / 0.83, rtol=1e-12)


def test_before_the_log_the_first_command_counts_as_held() -> None:
    late = run(platform(), record(TIME, np.full_like(TIME, 0.7)), {}, effects={"drive.delay": {"tau": 0.0437}})
    plain = run(platform(), record(TIME, np.full_like(TIME, 0.7)), {})
    assert np.max(np.abs(late["yaw_rad"] - plain["yaw_rad"])) < 1e-12 * np.ptp(plain["yaw_rad"]) * len(TIME)


def test_a_delayed_command_from_before_a_cut_still_arrives() -> None:
    rig = platform()
    t = np.arange(1001) * 0.01
    u = np.where(t < 5.0, 0.5, -0.8)
    effects = {"drive.delay": {"tau": 0.3}}
    whole = record(t, u)
    y = run(rig, whole, {}, effects=effects)
    cut = 510  # 0.1 s after the command changed, 0.2 s before it acts
    part = whole.cut(cut, len(t))
    start = {"psi": float(y["yaw_rad"][cut]), "w": float(y["yaw_rad_s"][cut])}
    assert run(rig, part, start, effects=effects)["yaw_rad"] == pytest.approx(y["yaw_rad"][cut:], abs=1e-9)
