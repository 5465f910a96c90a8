"""Two independent routes: an adaptive diffrax solve of the smooth field, and scipy's events for stick and slip."""

from dataclasses import replace

import diffrax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rwjax import Log
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from rwjax.simulation.reference import simulate_adaptively, solver_for
from tests.systems import platform, reaction, record, run, wheel


@pytest.mark.parametrize(
    "rig",
    [platform("viscous = 0.02"), pytest.param(reaction("viscous = 0.0026"), marks=pytest.mark.slow)],
    ids=lambda rig: rig.kind,
)
def test_a_smooth_rig_agrees_with_an_adaptive_solve(rig: Rig) -> None:
    rig = replace(rig, numbers=rig.numbers | {"axis.gravity.torque": 0.02, "axis.gravity.angle": 0.3})
    t = np.arange(301) * 0.01
    u = 4.0 * np.sin(3.0 * t)
    structure = structure_of(rig)
    n = len(structure.states)
    plant = plant_of(structure, jnp.asarray(theta_of(rig, structure)))

    def field(t: float, x: jnp.ndarray, command: jnp.ndarray) -> jnp.ndarray:
        k = jnp.clip((t / 0.01).astype(int), 0, len(command) - 1)
        return jnp.stack(plant.field(t, tuple(x[j] for j in range(n)), command[k]))

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Dopri8(),
        0.0,
        3.0,
        1e-3,
        jnp.zeros(n).at[0].set(0.5),
        args=jnp.asarray(u),
        saveat=diffrax.SaveAt(ts=jnp.asarray(t)),
        stepsize_controller=diffrax.ClipStepSizeController(
            diffrax.PIDController(rtol=1e-9, atol=1e-11), jump_ts=jnp.asarray(t[1:-1])
        ),
        max_steps=20_000,
    )
    assert solution.ys is not None
    start = {"psi": 0.5}
    error = [
        float(np.max(np.abs(run(rig, record(t, u), start, refine=r)["yaw_rad"] - np.asarray(solution.ys)[:, 0])))
        for r in (1, 8)
    ]
    assert error[1] < 1e-6
    assert error[0] / error[1] > 40.0  # second order: 64


def test_stick_and_slip_agree_with_located_events() -> None:
    I, b, M_c, M_s, v_s, gain = 0.1, 0.02, 0.05, 0.09, 0.2, 0.4
    rig = platform(f"viscous = {b}\ncoulomb = {M_c}\nstatic = {M_s}\nstribeck_velocity = {v_s}")
    t = np.arange(1001) * 0.01
    u = np.round(0.5 * np.sin(1.1 * t), 2)
    psi, w, exact = 0.0, 0.0, [0.0]
    for k in range(len(t) - 1):
        now, end = t[k], t[k + 1]
        while now < end:
            torque = gain * u[k]
            if w == 0.0 and abs(torque) <= M_s:
                break
            s = np.sign(w) if w != 0.0 else np.sign(torque)

            def rate(_: float, x: np.ndarray, s: float = s, torque: float = torque) -> list[float]:
                level = M_c + (M_s - M_c) * np.exp(-((x[1] / v_s) ** 2))
                return [x[1], (torque - s * level - b * x[1]) / I]

            def stop(time: float, x: np.ndarray, s: float = s, begin: float = now) -> float:
                return x[1] * s if time > begin + 1e-9 else 1.0

            stop.terminal, stop.direction = True, -1
            found = solve_ivp(rate, (now, end), [psi, w], rtol=1e-10, atol=1e-12, events=stop)
            now, (psi, w) = found.t[-1], found.y[:, -1]
            if found.t_events[0].size:
                w = 0.0
        exact.append(psi)
    motion = np.array(exact)
    assert np.ptp(motion) > 0.2 and np.sum(np.diff(motion) == 0.0) > 20  # it slides and it sticks
    error = [np.max(np.abs(run(rig, record(t, u), {}, refine=r)["yaw_rad"] - motion)) for r in (1, 8)]
    assert error[0] < 2 * np.pi / 8192
    assert error[1] < error[0] / 8.0


def by_reference(rig: Rig, log: Log, start: dict[str, float], effects: dict | None = None, **options: object) -> dict:
    """As `systems.run`, by `rwjax.simulation.reference`."""
    effects = effects or {}
    structure = structure_of(rig).with_effects(*effects)
    theta = theta_of(rig, structure)
    for effect, given in effects.items():
        for name, value in given.items():
            theta[structure.names.index(f"{effect}.{name}")] = value
    x0 = np.array([start.get(name, 0.0) for name in structure.states])
    return simulate_adaptively(plant_of(structure, jnp.asarray(theta)), log, x0, **options)


STRIBECK = "viscous = 0.02\ncoulomb = 0.05\nstatic = 0.09\nstribeck_velocity = 0.2"
SHORT = np.arange(301) * 0.01


@pytest.mark.slow
def test_the_reference_stops_when_the_closed_form_says_and_stays() -> None:
    I, b, M_c, w0 = 0.1, 0.02, 0.05, 0.9
    y = by_reference(platform(STRIBECK.replace("0.09", "0.05")), record(SHORT, np.zeros_like(SHORT)), {"w": w0})
    stop = I / b * np.log1p(b * w0 / M_c)
    assert 1.0 < stop < 2.0
    exact = np.where(stop > SHORT, (w0 + M_c / b) * np.exp(-b / I * SHORT) - M_c / b, 0.0)
    assert np.max(np.abs(y["yaw_rad_s"] - exact)) < 1e-8  # ten times rtol
    distance = I / b * (w0 - M_c / b * np.log1p(b * w0 / M_c))
    after = stop < SHORT
    assert np.all(y["yaw_rad_s"][after] == 0.0) and np.ptp(y["yaw_rad"][after]) == 0.0
    assert y["yaw_rad"][-1] == pytest.approx(distance, rel=1e-8)


def test_the_step_reaches_second_order_through_stick_and_reversal() -> None:
    log = record(SHORT, np.round(0.35 * np.sin(4.0 * SHORT), 2))
    exact = by_reference(platform(STRIBECK), log, {})
    assert np.sum(exact["yaw_rad_s"][50:] == 0.0) > 10  # it sticks between reversals
    assert exact["yaw_rad_s"].min() < -0.1 < 0.1 < exact["yaw_rad_s"].max()
    refine = np.array([1, 2, 4, 8])
    error = [
        np.max(np.abs(run(platform(STRIBECK), log, {}, refine=int(r))["yaw_rad"] - exact["yaw_rad"])) for r in refine
    ]
    # 2.00; where a stop falls within a step scatters each error a little; a stop at a step's end would give 1
    assert -np.polyfit(np.log(refine), np.log(error), 1)[0] == pytest.approx(2.0, abs=0.2)
    assert error[0] < 1e-5


def test_the_step_has_second_order_while_a_stribeck_axis_slides() -> None:
    log = record(SHORT, 1.0 + 0.5 * np.sin(4.0 * SHORT))
    exact = by_reference(platform(STRIBECK), log, {"w": 0.05})["yaw_rad"]
    error = [
        np.max(np.abs(run(platform(STRIBECK), log, {"w": 0.05}, refine=r)["yaw_rad"] - exact)) for r in (1, 2, 4, 8)
    ]
    assert -np.polyfit(np.log([1, 2, 4, 8]), np.log(error), 1)[0] == pytest.approx(2.0, abs=0.15)  # no kink: no scatter


@pytest.mark.slow
def test_an_axis_breaks_away_within_a_held_command_as_the_current_rises() -> None:
    # samples 0.25 s apart: reaction torque K i grows over L/R = 77 ms and passes breakaway between two of them
    t = np.arange(9) * 0.25
    log = record(t, np.where((t > 0.2) & (t < 1.2), 1.0, -1.5))
    rig = reaction("viscous = 0.0026\ncoulomb = 0.004\nstatic = 0.012\nstribeck_velocity = 0.05")
    effects = {"wheel.coulomb": {"M_c": 0.002}}
    exact = by_reference(rig, log, {}, effects)
    error = {
        name: [np.max(np.abs(run(rig, log, {}, effects=effects, refine=r)[name] - exact[name])) for r in (1, 8)]
        for name in exact
    }
    assert np.ptp(exact["yaw_rad"]) > 0.01
    for name, (coarse, fine) in error.items():
        size = np.ptp(exact[name])
        assert coarse < 1e-2 * size and fine < 5e-4 * size, name  # a factor 8 in step, 64 where no event scatters it


@pytest.mark.slow
def test_dry_friction_of_the_wheel_keeps_angular_momentum_in_the_reference() -> None:
    log = record(SHORT, 3.0 * np.sign(np.sin(4.0 * SHORT + 0.1)))
    y = by_reference(
        reaction("viscous = 0.0"), log, {}, {"wheel.coulomb": {"M_c": 0.008}, "drive.delay": {"tau": 0.0137}}
    )
    momentum = 0.0495 * y["yaw_rad_s"] + 1.24e-4 * y["wheel_rad_s"]
    assert np.ptp(y["wheel_rad_s"]) > 20.0
    assert np.max(np.abs(momentum)) < 1e-9 * 1.24e-4 * np.ptp(
        y["wheel_rad_s"]
    )  # linear: kept to rounding by Runge-Kutta


@pytest.mark.slow
def test_a_stiff_motor_takes_the_implicit_solver_and_agrees() -> None:
    t = np.arange(51) * 0.01
    log = record(t, 3.0 * np.sign(np.sin(17.0 * t + 0.1)), {"wheel_rad_s": np.zeros_like(t)})
    rig = wheel(0.83 * 2e-6)  # L/R = 2 us against samples of 10 ms
    plant = plant_of(structure_of(rig), jnp.asarray(theta_of(rig, structure_of(rig))))
    assert isinstance(solver_for(plant, 0.01), diffrax.Kvaerno5)
    exact, y = by_reference(rig, log, {}), run(rig, log, {})
    for name, value in exact.items():
        assert np.max(np.abs(y[name] - value)) < 1e-7 * np.ptp(value), name
