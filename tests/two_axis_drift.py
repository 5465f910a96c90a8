"""Energy and momentum of a rig with two axes that nothing brakes: `python -m tests.two_axis_drift` prints how far they drift."""

import jax
import jax.numpy as jnp
import numpy as np

from rwjax.rig.model import Rig
from tests.two_axes import GIMBAL, GRAVITY, TILTING, motion, two_axis

FREE = 1e12  # ohm: a motor that is not connected
Q_NAMES = ("psi_1", "psi_2", "theta_1", "theta_2")
W_NAMES = ("w_1", "w_2", "Omega_1", "Omega_2")


def lagrangian(values: dict[str, float], q, qd):
    """Kinetic minus potential energy, from turning bodies in space: nothing of the library's formulas."""
    psi, tilt = q[0], q[1]
    turned = jnp.array(
        [[jnp.cos(psi), -jnp.sin(psi), 0.0], [jnp.sin(psi), jnp.cos(psi), 0.0], [0.0, 0.0, 1.0]]
    ) @ jnp.array([[jnp.cos(tilt), 0.0, jnp.sin(tilt)], [0.0, 1.0, 0.0], [-jnp.sin(tilt), 0.0, jnp.cos(tilt)]])
    up = jnp.array([0.0, 0.0, 1.0])
    across = jnp.array([-jnp.sin(psi), jnp.cos(psi), 0.0])
    spin = turned.T @ (up * qd[0] + across * qd[1])
    xy, xz, yz = (values.get(f"gimbal.product_{name}", 0.0) for name in ("xy", "xz", "yz"))
    Izz = 0.4 * values["yaw.inertia"]  # the rest turns with yaw alone
    Ixx = Izz + values.get("gimbal.difference", 0.0)
    tensor = jnp.array([[Ixx, -xy, -xz], [-xy, values["pitch.inertia"], -yz], [-xz, -yz, Izz]])
    lean = values.get("wheel_1.gyroscopic.s", 0.0) * tilt
    along = jnp.cos(lean) * up + jnp.sin(lean) * jnp.array([jnp.cos(psi), jnp.sin(psi), 0.0])
    rates = (qd[2] + along @ (up * qd[0]), qd[3] + qd[1])
    wheels = sum(0.5 * values[f"wheel_{k}.inertia"] * rate**2 for k, rate in zip((1, 2), rates, strict=True))
    angle, mgl = values.get("pitch.gravity.angle", 0.0), values.get("pitch.gravity.torque", 0.0)
    return (
        0.5 * 0.6 * values["yaw.inertia"] * qd[0] ** 2
        + 0.5 * spin @ tensor @ spin
        + wheels
        + mgl * jnp.cos(tilt + angle)
    )


def energy(rig: Rig, found: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Energy and angular momentum about the vertical along a motion."""

    def both(q, qd):
        p = jax.grad(lambda v: lagrangian(rig.values, q, v))(qd)
        return p @ qd - lagrangian(rig.values, q, qd), p[0]

    q, qd = (np.stack([found[n][::10] for n in names], axis=1) for names in (Q_NAMES, W_NAMES))
    E, p = jax.jit(jax.vmap(both))(q, qd)
    return np.asarray(E), np.asarray(p)


START = {"w_1": 1.2, "psi_2": 0.5, "w_2": -0.4, "Omega_1": 300.0, "Omega_2": -150.0}
SECONDS = 20.0
STEPS = (0.02, 0.01, 0.005, 0.0025, 0.00125)  # s


def drift(step: float) -> tuple[float, float]:
    """The largest change within `SECONDS` of energy, as a share of the m g l of pitch (most of it lies in the wheels, whose
    speed hardly changes), and of momentum about the vertical, as a share of itself."""
    rig = two_axis(GIMBAL + GRAVITY + TILTING, ohm=FREE)
    found = motion(rig, START, np.zeros((round(SECONDS / 0.02), 2)), step, round(0.02 / step))
    assert np.ptp(found["psi_2"]) > 0.3 and np.ptp(found["w_1"]) > 0.3  # there is something to keep
    E, p = energy(rig, found)
    return float(np.max(np.abs(E - E[0])) / rig.values["pitch.gravity.torque"]), float(
        np.max(np.abs(p - p[0])) / abs(p[0])
    )


def main() -> None:
    """Prints the table of docs/two_axis.md."""
    jax.config.update("jax_enable_x64", True)
    print("| step [ms] | energy | momentum about the vertical |\n| --- | --- | --- |")
    for step in STEPS:
        E, p = drift(step)
        print(f"| {1000.0 * step:g} | {E:.1e} | {p:.1e} |")


if __name__ == "__main__":
    main()
