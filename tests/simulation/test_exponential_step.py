"""The time step: exact where the plant is linear, exact stick, second order in between."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import expm

from rwjax.lowering.program_files import DIGEST
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.exponential_step import EXPONENTIAL_STEP
from tests.systems import platform, reaction, record, run, wheel

TIME = np.arange(3001) * 0.01


def test_coast_down_stops_where_the_closed_form_says_and_stays() -> None:
    I, b, M_c, w0 = 0.1, 0.02, 0.05, 2.0
    y = run(platform(), record(TIME, np.zeros_like(TIME)), {"w": w0})
    stop = I / b * np.log1p(b * w0 / M_c)
    exact = np.where(stop > TIME, (w0 + M_c / b) * np.exp(-b / I * TIME) - M_c / b, 0.0)
    assert np.max(np.abs(y["yaw_rad_s"] - exact)) < 1e-5  # the step that holds the stop is of second order
    after = stop + 0.01 < TIME
    assert np.all(y["yaw_rad_s"][after] == 0.0)
    assert np.ptp(y["yaw_rad"][after]) == 0.0


@pytest.mark.parametrize(("share", "moves"), [(0.9, False), (1.01, True)])
def test_an_axis_below_breakaway_does_not_creep(share: float, moves: bool) -> None:
    u = np.full_like(TIME, share * 0.05 / 0.4)
    y = run(platform(), record(TIME, u), {})
    assert (np.ptp(y["yaw_rad"]) > 0.01) if moves else (np.ptp(y["yaw_rad"]) == 0.0)


def test_a_level_that_falls_lets_a_held_axis_go() -> None:
    y = run(
        platform(), record(TIME, np.full_like(TIME, 0.25)), {}, effects={"axis.friction_drift": {"d": 2.0, "tau": 3.0}}
    )
    away = 3.0 * np.log(0.1 / (0.25 * 0.4 - 0.05))  # 0.05 (1 + 2 exp(-t/3)) falls to 0.1 N m
    assert np.all(y["yaw_rad_s"][away > TIME] == 0.0) and np.all(y["yaw_rad_s"][away + 0.01 < TIME] > 0.0)


@pytest.mark.parametrize("inductance", [0.0641, 0.83 * 0.2e-3], ids=["L/R 77 ms", "L/R 0.2 ms"])
def test_a_linear_motor_is_exact_under_held_voltage(inductance: float) -> None:
    K, R, L, b, J = 0.0182, 0.83, inductance, 4.07e-6, 1.24e-4
    t = TIME[:301]
    u = 3.0 * np.sign(np.sin(7.0 * t + 0.1))
    A = np.array([[-b / J, K / J, 0.0], [-K / L, -R / L, 1.0 / L], [0.0, 0.0, 0.0]])
    step = expm(A * 0.01)
    x, exact = np.zeros(3), []
    for u_k in u:
        x[2] = u_k
        exact.append(x[:2].copy())
        x = step @ x
    y = run(wheel(inductance), record(t, u, {"wheel_rad_s": np.zeros_like(t)}), {})
    scale = np.max(np.abs(np.array(exact)), axis=0)
    assert np.max(np.abs(y["wheel_rad_s"] - np.array(exact)[:, 0])) < 1e-9 * scale[0]
    assert np.max(np.abs(y["current_A"] - np.array(exact)[:, 1])) < 1e-9 * scale[1]


def test_without_inductance_the_current_follows_the_voltage() -> None:
    K, R, b, J = 0.0182, 0.83, 4.07e-6, 1.24e-4
    t = TIME[:301]
    u = 3.0 * np.sign(np.sin(7.0 * t + 0.1))
    y = run(wheel(0.0), record(t, u, {"wheel_rad_s": np.zeros_like(t)}), {})
    rate = (b + K**2 / R) / J
    decay, gain = np.exp(-rate * 0.01), K / R / J / rate
    Omega, exact = 0.0, []
    for u_k in u:
        exact.append(Omega)
        Omega = decay * Omega + (1.0 - decay) * gain * u_k
    assert np.max(np.abs(y["wheel_rad_s"] - exact)) < 1e-9 * np.max(np.abs(exact))
    assert np.max(np.abs(y["current_A"] - (u - K * np.array(exact)) / R)) < 1e-9 * 3.0 / R


def test_a_torque_that_changes_within_a_step_is_of_second_order() -> None:
    s, c, omega = 0.02, 0.05, 7.0
    exact = (s * (1.0 - np.cos(omega * TIME)) + c * np.sin(omega * TIME)) / (omega * 0.1)
    log = record(TIME, np.zeros_like(TIME), {"yaw_rad_s": np.zeros_like(TIME)})
    effect = {"axis.periodic_torque": {"s": s, "c": c, "omega": omega, "p": 0.0, "q": 0.0}}
    for refine in (1, 4):
        w = run(platform("viscous = 0.0"), log, {}, effects=effect, refine=refine)["yaw_rad_s"]
        h = 0.005 / refine  # the trapezoidal rule: h^2 / 12 times the change of the slope of the torque
        assert np.max(np.abs(w - exact)) < 1.1 * h**2 / 12.0 * omega * 2.0 * np.hypot(s, c) / 0.1


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("w0", [0.003, -0.003, 0.0])
def test_an_axis_that_is_to_slide_one_way_slides_whatever_its_rate(direction: float, w0: float) -> None:
    """Its friction is then a constant torque: the linear plant with one more input, solved exactly."""
    rig, u, h = reaction("viscous = 0.0026\ncoulomb = 0.004"), 2.0, 0.01
    plant, states = plant_of_rig(rig)
    x = dict.fromkeys(states, 0.0) | {"psi": 0.4, "w": w0, "Omega": 30.0, "i": 0.2}
    A = np.zeros((len(states) + 1,) * 2)  # the last entry is 1
    K, R, L, b, J, I, b_I = 0.0182, 0.83, 0.0641, 4.07e-6, 1.24e-4, 0.0495, 0.0026
    for rate, terms in {
        "psi": {"w": 1.0},
        "w": {"i": -K / I, "Omega": b / I, "w": -b_I / I, "": -0.004 * direction / I},
        "theta": {"Omega": 1.0},
        "Omega": {"i": K / J, "Omega": -b / J},
        "i": {"Omega": -K / L, "i": -R / L, "": u / L},
    }.items():
        for name, factor in terms.items():
            if rate in states and (not name or name in states):
                A[states.index(rate), states.index(name) if name else -1] = factor
    exact = (expm(A * h) @ [*x.values(), 1.0])[:-1]
    zero, prepared = jnp.zeros(()), EXPONENTIAL_STEP.prepare(plant, jnp.asarray(h))
    start = tuple(jnp.asarray(v) for v in x.values())
    found = EXPONENTIAL_STEP.slide(plant, prepared, zero, start, jnp.asarray(u), jnp.asarray(h), jnp.asarray(direction))
    assert np.array(found) == pytest.approx(exact, rel=1e-11, abs=1e-14)


def test_programs_of_the_step_are_kept_on_disk(tmp_path: Path) -> None:
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        run(platform("viscous = 0.02"), record(TIME[:7], np.zeros(7)), {})  # a length that no other test has
        assert [*tmp_path.glob("lowered-*")]
    finally:
        jax.config.update("jax_compilation_cache_dir", before)


def plant_of_rig(rig: Rig):
    """A rig's plant and the names of its states."""
    structure = structure_of(rig)
    return plant_of(structure, jnp.asarray(theta_of(rig, structure))), structure.states


def test_stick_slip_converges_with_second_order() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05\nstatic = 0.09\nstribeck_velocity = 0.2")
    t = TIME[:801]
    steps, slopes, coarse = (1, 2, 4, 8), [], []
    for amplitude, rate, phase in ((0.45, 1.9, 0.2), (0.45, 2.3, 0.2), (0.6, 3.1, 0.5)):
        s = np.sin(rate * t + phase)
        for u in (amplitude * np.sign(s), amplitude * np.round(s, 2)):
            runs = {r: run(rig, record(t, u), {}, refine=r)["yaw_rad"] for r in (*steps, 64)}
            error = [np.max(np.abs(runs[r] - runs[64])) for r in steps]
            slopes.append(-np.polyfit(np.log(steps), np.log(error), 1)[0])
            coarse.append(error[0])
    # where in a step its stops fall scatters the slope of one run (1.4 to 2.7 here), so several runs are asked
    assert np.mean(slopes) > 1.7
    assert max(coarse) < 2 * np.pi / 8192  # and a plain step is finer than any encoder here


def test_dry_friction_of_the_wheel_keeps_angular_momentum() -> None:
    t = TIME[:1001]
    log = record(t, 3.0 * np.sign(np.sin(2.0 * t)), {"yaw_rad_s": np.zeros_like(t), "wheel_rad_s": np.zeros_like(t)})
    y = run(reaction("viscous = 0.0"), log, {}, effects={"wheel.coulomb": {"M_c": 0.01}})
    momentum = 0.0495 * y["yaw_rad_s"] + 1.24e-4 * y["wheel_rad_s"]
    assert np.max(np.abs(y["wheel_rad_s"])) > 50.0
    assert np.any((y["wheel_rad_s"] == 0.0)[1:])  # it sticks at reversals
    assert np.max(np.abs(momentum)) < 1e-12


@pytest.mark.parametrize("h", [1e-4, 0.01], ids=["1e-4 s", "1e-2 s"])
@pytest.mark.parametrize("inductance", [0.0641, 0.83 * 20e-6], ids=["L/R 77 ms", "L/R 20 us"])
def test_the_exponential_functions_are_those_of_scipy(inductance: float, h: float) -> None:
    plant, _ = plant_of_rig(wheel(inductance))
    p = EXPONENTIAL_STEP.prepare(plant, jnp.asarray(h))
    A, n = np.asarray(p.A), len(p.A)
    augmented = np.zeros((3 * n, 3 * n))  # exp of [[A, 1, 0], [0, 0, 1], [0, 0, 0]] h holds E, h phi1, h^2 phi2
    augmented[:n, :n], augmented[:n, n : 2 * n], augmented[n : 2 * n, 2 * n :] = A, np.eye(n), np.eye(n)
    exact = expm(h * augmented)[:n]
    found = np.concatenate([p.E, p.phi1, h * np.asarray(p.phi2)], axis=1)
    for block in range(3):
        columns = slice(block * n, (block + 1) * n)
        assert np.max(np.abs(found[:, columns] - exact[:, columns])) < 1e-9 * np.max(np.abs(exact[:, columns]))


def test_which_entries_are_worked_out_is_kept_on_disk(tmp_path: Path) -> None:
    structure = structure_of(platform()).with_effects("axis.spring", "axis.imbalance", "drive.bias", "sensor.scale")
    theta = jnp.asarray(0.3 + 0.01 * np.arange(len(structure.names)))
    before = jax.config.values["jax_compilation_cache_dir"]
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        prepared = EXPONENTIAL_STEP.prepare(plant_of(structure, theta), jnp.asarray(0.005))
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    (kept,) = tmp_path.glob("kept-couplings-*")
    n = len(structure.states)
    pattern = np.frombuffer(kept.read_bytes()[DIGEST:], bool).reshape(n, n)
    assert np.array_equal(np.asarray(prepared.A) != 0.0, pattern)
    assert np.array_equal(pattern, [[False, True], [True, True]])  # psi' = w; what turns with psi and w acts on w
