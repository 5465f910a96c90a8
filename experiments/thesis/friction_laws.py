"""Eq. 3.7 and 3.8, Figs. 3.7 and 3.8: the friction laws that the thesis considers.

Coulomb, viscous and Stribeck friction are the library's effects; Dahl's law stands here, since it is no effect of the library.
"""

from collections.abc import Callable
from pathlib import Path

import rwjax.setup_jax  # noqa: F401  (float64 comes first)

import jax  # isort: skip
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, least_squares

from experiments.thesis.regenerate import FRICTION
from experiments.thesis.table import rms, row, save
from rwjax.effects.axis_friction import Coulomb, Stribeck, Viscous
from rwjax.effects.effect import Effect, Motion
from rwjax.effects.ports import AxisDry

FASTEST = 10.9  # rad/s, where the thesis's coast-down begins
AMPLITUDE = 2.0  # of the displacement in Fig. 3.8, in units of F_c / sigma

Law = Callable[..., tuple[Effect, ...]]
LAWS: dict[str, tuple[Law, list[float]]] = {  # effects of numbers, and where a search for the numbers begins
    "Coulomb, eq. 3.7": (lambda M_c: (Coulomb(M_c),), [0.5]),
    "Coulomb and viscous": (lambda M_c, b: (Coulomb(M_c), Viscous(b)), [0.3, 0.1]),
    "Stribeck and viscous": (
        lambda M_c, M_e, v_s, b: (Stribeck(M_c, M_e, v_s, jnp.asarray(2.0)), Viscous(b)),
        [0.2, 0.2, 2.0, 0.1],
    ),
}


def friction(law: Law, numbers: np.ndarray | list[float], w: np.ndarray) -> np.ndarray:
    """Friction of a law of the library at the rates `w`, odd in them; 0 at 0."""
    effects = law(*(jnp.asarray(float(x)) for x in numbers))
    zero = jnp.zeros(())

    def forward(rate: jax.Array) -> jax.Array:
        motion = Motion(zero, zero, zero, rate, zero, zero, zero, drawn=zero, load=zero, sensed=rate, own={})
        return sum((e.level(motion, 1.0) if isinstance(e, AxisDry) else -e.torque(motion) for e in effects), zero)

    return np.sign(w) * np.asarray(jax.vmap(forward)(jnp.abs(jnp.asarray(w))))


def closest(name: str, w: np.ndarray) -> np.ndarray:
    """The numbers with which a law comes closest to eq. 3.14 at the rates `w`, by least squares."""
    law, start = LAWS[name]
    return least_squares(lambda x: friction(law, x, w) - FRICTION(w), start, bounds=(1e-3, np.inf)).x


def falling(numbers: list[float]) -> tuple[float, float]:
    """Between which rates Stribeck's law with viscous friction falls: boundary lubrication below, a full film above."""
    _, M_e, v_s, b = numbers
    steepest = v_s / np.sqrt(2.0)

    def slope(w: float) -> float:
        return b - 2.0 * M_e * w / v_s**2 * np.exp(-((w / v_s) ** 2))

    return brentq(slope, 0.0, steepest), brentq(slope, steepest, 10.0 * v_s)


def dahl(t: np.ndarray, rate: Callable[[float], float], sigma: float, F_c: float, n: float) -> np.ndarray:
    """Dahl's friction (eq. 3.8) at the times `t` from 0 force, for a motion of this rate: F' = x' dF/dx."""

    def slope(s: float, F: np.ndarray) -> np.ndarray:
        v = rate(s)
        left = 1.0 - F / F_c * np.sign(v)
        return sigma * np.abs(left) ** n * np.sign(left) * v

    longest = (t[-1] - t[0]) / 1000.0  # so that no turn of the motion is stepped over
    return solve_ivp(slope, (t[0], t[-1]), [0.0], t_eval=t, rtol=1e-8, atol=1e-10 * F_c, max_step=longest).y[0]


def dahl_loop(n: float, omega: float, samples: int = 1000) -> tuple[np.ndarray, np.ndarray]:
    """Displacement [F_c/sigma] and force [F_c] over the third period of a sine of `omega` [rad/s]."""
    t = np.linspace(0.0, 3.0 * 2.0 * np.pi / omega, 3 * samples + 1)
    force = dahl(t, lambda s: AMPLITUDE * omega * np.cos(omega * s), 1.0, 1.0, n)
    return AMPLITUDE * np.sin(omega * t[-samples - 1 :]), force[-samples - 1 :]


def friction_laws(folder: Path) -> None:
    """Eq. 3.7 and 3.8, Figs. 3.7 and 3.8: friction laws, and how near each can come to eq. 3.14."""
    w = np.linspace(0.01, FASTEST, 300)
    found = {name: closest(name, w) for name in LAWS}
    for name, numbers in found.items():
        left = rms(friction(LAWS[name][0], numbers, w) - FRICTION(w))
        row(f"{name}: closest to eq. 3.14 up to {FASTEST} rad/s, RMS [rad/s^2]", "", f"{left:.3f}")
    x = np.linspace(0.0, 5.0, 501)
    error = np.max(np.abs(dahl(x, lambda s: 1.0, 1.0, 1.0, 1.0) - (1.0 - np.exp(-x))))
    row("Dahl, n = 1: against F_c (1 - exp(-sigma x/F_c)), largest error [F_c]", "", f"{error:.0e}")
    loops = {n: dahl_loop(n, 0.1) for n in (0.5, 1.0, 2.0)}
    for n, (_, force) in loops.items():
        exact = f", closed form tanh(2) = {np.tanh(AMPLITUDE):.4f}" if n == 1.0 else ""
        row(
            f"Dahl, n = {n:g}: force where the sine of amplitude 2 F_c/sigma turns [F_c]",
            "",
            f"{np.max(force):.4f}{exact}",
        )
    apart = np.max(np.abs(dahl_loop(1.0, 10.0)[1] - loops[1.0][1]))
    row("Dahl, n = 1: loops at 0.1 and 10 rad/s, largest difference [F_c]", "", f"{apart:.0e}")
    save(_laws_figure(w, found), folder, "fig_3_7")
    save(_loops_figure(loops), folder, "fig_3_8")


def _laws_figure(w: np.ndarray, found: dict[str, np.ndarray]) -> plt.Figure:
    figure, axes = plt.subplots(2, 2, figsize=(9, 6.5), layout="constrained")
    shapes = {
        "Coulomb, eq. 3.7": [0.6],
        "Coulomb and viscous": [0.6, 0.15],
        "Stribeck and viscous": [0.6, 0.4, 1.0, 0.15],
    }
    speed = np.linspace(-4.0, 4.0, 8001)
    for ax, (name, numbers) in zip(axes.flat, shapes.items(), strict=False):
        if name.startswith("Stribeck"):
            _regions(ax, numbers)
        else:
            ax.plot(speed, friction(LAWS[name][0], numbers, speed))
        ax.set(xlabel="rate over Stribeck rate v/v$_s$", ylabel="friction over breakaway friction", title=name)
    axes[1, 1].plot(w, FRICTION(w), color="black", lw=3, alpha=0.3, label="eq. 3.14, corrected")
    for (name, numbers), style in zip(found.items(), (":", "--", "-"), strict=True):
        axes[1, 1].plot(w, friction(LAWS[name][0], numbers, w), style, label=name)
    axes[1, 1].set(
        xlabel="yaw rate ψ' [rad/s]",
        ylabel="friction over inertia [rad/s²]",
        title="Each law as near to eq. 3.14 as it can be",
    )
    axes[1, 1].legend(frameon=False, fontsize=8)
    figure.suptitle("Fig. 3.7: friction laws (the first three show shapes, not this rig)")
    return figure


def _regions(ax: plt.Axes, numbers: list[float]) -> None:
    """Stribeck's law for rates above 0 with its four regions."""
    speed = np.linspace(1e-3, 3.5, 400)
    ax.plot(speed, friction(LAWS["Stribeck and viscous"][0], numbers, speed))
    ax.plot([0.0, 0.0], [0.0, numbers[0] + numbers[1]], color="tab:red", lw=3)
    edges = (0.0, *falling(numbers), 3.5)
    for k, name in enumerate(("boundary", "partial fluid", "full fluid")):
        ax.axvspan(edges[k], edges[k + 1], color="tab:blue", alpha=0.15 - 0.05 * k, lw=0)
        ax.text(0.5 * (edges[k] + edges[k + 1]), 0.08, name, rotation=90 if k == 0 else 0, ha="center", fontsize=9)
    ax.text(-0.08, 0.08, "stick", rotation=90, ha="right", color="tab:red", fontsize=9)
    ax.set(xlim=(-0.3, 3.5), ylim=(0.0, 1.25))


def _loops_figure(loops: dict[float, tuple[np.ndarray, np.ndarray]]) -> plt.Figure:
    figure, ax = plt.subplots(figsize=(6, 4.5), layout="constrained")
    for (n, (x, force)), style in zip(loops.items(), ("--", "-", "-."), strict=True):
        ax.plot(x, force, style, label=f"n = {n:g}")
    for side in (-1.0, 1.0):
        ax.axhline(side, color="#999999", lw=0.8)
    ax.set(
        xlabel="displacement σ x / F$_c$", ylabel="friction F / F$_c$", title="Fig. 3.8: Dahl's law under a slow sine"
    )
    ax.legend(frameon=False)
    return figure
