"""Sensitivities and normal equations of multiple shooting."""

import numpy as np
import pytest

from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.free_run import free_run
from rwjax.simulation.shooting import evaluate
from tests.systems import platform, reaction, record, wheel

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


@pytest.mark.parametrize(
    "case", [pytest.param(c, marks=pytest.mark.slow) if c in ("wheel", "reaction") else c for c in CASES]
)
def test_sensitivities_match_differences_of_the_free_run(case: str) -> None:
    rig, output, effects = CASES[case]
    structure = structure_of(rig).with_effects(*effects)
    theta = theta_of(rig, structure)
    for effect, given in effects.items():
        for name, value in given.items():
            theta[structure.names.index(f"{effect}.{name}")] = value
    problem = pose(structure, (record(TIME, COMMAND, {output: np.zeros_like(TIME)}),), {output: 1.0})
    structure = problem.structure
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
    structure = problem.structure
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
    structure = problem.structure
    start = np.array([[0.3, 1.0]])
    _, nodes = (np.asarray(a) for a in free_run(structure, theta, start, problem.batch))
    off = nodes + np.where(np.arange(nodes.shape[1])[:, None] > 0, 0.1, 0.0)
    e = evaluate(structure, theta, np.arange(len(theta)), off, problem.batch)
    assert np.max(np.abs(e.defect)) > 0.01
    assert np.max(np.abs(off + np.asarray(e.shift) - nodes)) < 1e-10 * np.max(np.abs(nodes))
