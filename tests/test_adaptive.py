"""Two independent routes: an adaptive diffrax solve of the smooth field, and scipy's events for stick and slip."""

import diffrax
import jax.numpy as jnp
import numpy as np
from scipy.integrate import solve_ivp

from rwjax.build import structure_of, theta_of
from rwjax.simulate import plant_of
from tests.systems import platform, reaction, record, run


def test_a_smooth_rig_agrees_with_an_adaptive_solve() -> None:
    rig = reaction("viscous = 0.0026")
    rig = type(rig)(**{**rig.__dict__, "numbers": rig.numbers | {"axis.gravity.torque": 0.02, "axis.gravity.angle": 0.3}})
    t = np.arange(301) * 0.01
    u = 4.0 * np.sin(3.0 * t)
    structure = structure_of(rig)
    plant = plant_of(structure, jnp.asarray(theta_of(rig, structure)))

    def field(t: float, x: jnp.ndarray, command: jnp.ndarray) -> jnp.ndarray:
        k = jnp.clip((t / 0.01).astype(int), 0, len(command) - 1)
        return jnp.stack(plant.field(t, tuple(x[j] for j in range(5)), command[k]))

    solution = diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Dopri8(),
        0.0,
        3.0,
        1e-3,
        jnp.zeros(5).at[0].set(0.5),
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
        for r in (1, 4)
    ]
    assert error[1] < 1e-6
    assert error[0] / error[1] > 10.0  # second order: 16


def test_stick_and_slip_agree_with_located_events() -> None:
    I, b, M_c, M_s, v_s, gain = 0.1, 0.02, 0.05, 0.09, 0.2, 0.4  # noqa: E741
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
