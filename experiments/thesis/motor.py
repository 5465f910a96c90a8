"""Eq. 3.1 to 3.3, Table 3.1, Fig. 3.2: motor and wheel."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import expm

from experiments.methods.limit_speeds import thesis as limit_speeds
from experiments.thesis.table import row, run, save
from experiments.thesis.testbed import L_CHAPTER_4, J, K, R
from rwjax import parse_rig
from rwjax.fitting.predict import predict

SLOPE = 54.39  # rad/s per volt, measured limit speed over voltage (listing A.3)
CLIP = 3.0  # A, listing A.3


def friction_from_limit_speed(slope: float) -> float:
    """Eq. 3.3 solved for the motor's friction b [N m s/rad]."""
    return (K / slope - K**2) / R


def critical_inductances(b: float) -> tuple[float, float]:
    """The two inductances [H] at which both poles of eq. 3.1 are equal, the smaller first."""
    roots = np.roots([b**2, -(2.0 * b * R * J + 4.0 * K**2 * J), (R * J) ** 2])
    low, high = sorted(roots.real)
    return float(low), float(high)


def damping_ratio(b: float, L: float) -> float:
    """Damping ratio of eq. 3.1; 1 where the poles are equal."""
    return 0.5 * (R / L + b / J) / np.sqrt((K**2 + R * b) / (J * L))


def clipped(volts: np.ndarray, tick: float, b: float, L: float, limit: float) -> np.ndarray:
    """Wheel rate and current `(time, 2)` from rest, the current held within the limit after every exact step."""
    A = np.array([[-b / J, K / J], [-K / L, -R / L]])
    step = expm(tick * A)
    push = np.linalg.solve(A, (step - np.eye(2)) @ [0.0, 1.0 / L])
    x = np.zeros((len(volts), 2))
    for k, u in enumerate(volts[:-1]):
        x[k + 1] = step @ x[k] + push * u
        x[k + 1, 1] = np.clip(x[k + 1, 1], -limit, limit)
    return x


def motor(folder: Path) -> None:
    """Eq. 3.1 to 3.3, Table 3.1, Fig. 3.2: motor and wheel."""
    b = friction_from_limit_speed(SLOPE)
    low, high = critical_inductances(b)
    row("motor friction from limit speeds, b = (K/54.39 - K^2)/R [N m s/rad]", "4.07e-6", f"{b:.3g}")
    again = limit_speeds().rig.values["motor.friction"]
    row("… by `rwjax fit --method limit-speeds` from regenerated staircases [N m s/rad]", "4.07e-6", f"{again:.3g}")
    row("… with a torque constant 1 % larger [N m s/rad]", "", f"{(1.01 * K / SLOPE - (1.01 * K) ** 2) / R:.2g}")
    row("inductance that makes the motor's poles equal, smaller root [H]", "0.0641", f"{low:.4f} (other {high:.0f})")
    row("limit speed per volt K/(R b + K^2) [rad/s/V]", f"{SLOPE}", f"{K / (R * b + K**2):.2f}")
    zeta = damping_ratio(b, L_CHAPTER_4)
    over = np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2))
    row(
        "inductance: Table 3.1 (damping ratio 1) against listing A.4 [H]",
        "0.0641, 0.1",
        f"0.1 gives damping ratio {zeta:.2f}, {100.0 * over:.1f} % overshoot",
    )
    rig = parse_rig(
        f'kind = "wheel"\n[motor]\ntorque_constant = {K}\nresistance = {R}\ninductance = {low}\nfriction = {b}\n'
        f"[wheel]\ninertia = {J}"
    )
    t = np.arange(10001) * 0.001
    volts = np.where(t < 5.0, 8.0, 0.0)
    free = predict(rig, run(t, volts))
    held = clipped(volts, 0.001, b, low, CLIP)
    row(
        "largest current at 8 V (listing A.3 clips at 3 A, the text does not say so) [A]",
        "3",
        f"{np.max(free['current_A']):.2f}",
    )
    reached = [t[np.argmax(speed > 0.95 * 8.0 * SLOPE)] for speed in (free["wheel_rad_s"], held[:, 0])]
    row(
        "time to 95 % of the limit speed at 8 V, without and with the clip [s]",
        "",
        f"{reached[0]:.2f}, {reached[1]:.2f}",
    )
    save(_figure(t, free, held), folder, "fig_3_2")


def _figure(t: np.ndarray, free: dict[str, np.ndarray], held: np.ndarray) -> plt.Figure:
    figure, axes = plt.subplots(2, 1, figsize=(7, 5), sharex=True, layout="constrained")
    for k, name in enumerate(("wheel_rad_s", "current_A")):
        axes[k].plot(t, held[:, k], label="current clipped at ±3 A (listing A.3)")
        axes[k].plot(t, free[name], "--", label="eq. 3.1 alone")
    axes[0].set(ylabel="wheel rate Ω [rad/s]", title="Fig. 3.2: 8 V for 5 s, then 0 V")
    axes[1].set(xlabel="time [s]", ylabel="current i [A]")
    axes[0].legend(frameon=False)
    return figure
