"""Eq. 3.4 to 3.6, Table 3.2, Figs. 3.5 and 3.6: two linear models of the platform, and a dead band that neither has.

The rig stands in as the platform with the friction of eq. 3.14 (corrected) and the gain of eq. 3.6: regenerated, since the
thesis's logs were never published.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from experiments.thesis.regenerate import FRICTION, GAIN
from experiments.thesis.table import rms, row, run, save
from rwjax import Rig, parse_rig
from rwjax.fitting.predict import predict

INERTIA = 0.228  # kg m2, Table 3.2
DAMPING = 0.09091  # 1/s, eq. 3.6
EXPERIMENTS = {1: (-4.0, 0.4), 2: (-5.0, 1.0)}  # V: mean and amplitude of the square wave
PERIOD = 2.0 * np.pi / 0.02  # s; printed for Experiment 2, taken for both
TICK = 0.05  # s


def platform_rig(gain: float, friction: str, rest: str = "") -> Rig:
    """A platform with this gain over its inertia [1/(V s2)]; `friction` is a line of its `[axis.friction]`."""
    return parse_rig(
        f'kind = "platform"\n[drive]\ngain = {gain * INERTIA}\n[axis]\ninertia = {INERTIA}\n'
        f"[axis.friction]\n{friction}\n{rest}"
    )


MODELS = {
    "eq. 3.5 (Table 3.2)": platform_rig(0.428 / INERTIA, "viscous = 0.082"),
    "eq. 3.6 (identified)": platform_rig(GAIN, f"viscous = {DAMPING * INERTIA}"),
}
PLATFORM = platform_rig(GAIN, f"polynomial = {(INERTIA * FRICTION.coef).tolist()}")


def command(experiment: int, periods: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and voltage of an experiment; the wave begins with its upper half, the weaker push."""
    t = np.arange(round(periods * PERIOD / TICK)) * TICK
    mean, amplitude = EXPERIMENTS[experiment]
    return t, mean + np.where(np.mod(t, PERIOD) < 0.5 * PERIOD, amplitude, -amplitude)


def settled(volts: float) -> list[float]:
    """Rates [rad/s] in the direction of a push at which friction balances it, rising; every second one is stable."""
    roots = (FRICTION - GAIN * abs(volts)).roots()
    return sorted(float(r.real) for r in roots if abs(r.imag) < 1e-9 and r.real > 0.0)


def least_linear_miss(volts: np.ndarray, rates: np.ndarray) -> float:
    """What the best constant ratio of settled rate to voltage leaves [rad/s, RMS]: no linear model that settles leaves less."""
    ratio = volts @ rates / (volts @ volts)
    return rms(rates - ratio * volts)


def platform(folder: Path) -> None:
    """Eq. 3.4 to 3.6, Table 3.2, Figs. 3.5 and 3.6: two linear models, and a dead band that neither has."""
    row("gain over inertia: eq. 3.6 against K_yy/I of Table 3.2 [rad/s^2/V]", "0.08911", f"{0.428 / INERTIA:.2f}")
    row("damping over inertia: eq. 3.6 against b/I of Table 3.2 [1/s]", "0.09091", f"{0.082 / INERTIA:.2f}")
    row("settled rate per volt: eq. 3.6 against Table 3.2 [rad/s/V]", f"{GAIN / DAMPING:.3f}", f"{0.428 / 0.082:.2f}")
    dead_band()
    for number in EXPERIMENTS:
        responses(number, folder)


def dead_band() -> None:
    """What the platform does about 4 V."""
    row("voltage below which the platform stays put, (b3/I)/0.08911 [V]", '"below 4"', f"{FRICTION(0.0) / GAIN:.2f}")
    row("the same with Table 3.2 [V]", "", f"{FRICTION(0.0) / (0.428 / INERTIA):.2f}")
    least = min(r.real for r in FRICTION.deriv().roots())
    row(
        "voltage below which a moving platform stops [V], where its friction is least [rad/s]",
        "",
        f"{FRICTION(least) / GAIN:.2f}, {least:.2f}",
    )
    t = np.arange(2001) * 0.01
    for volts in (4.2, 4.25):
        ends = [
            predict(rig, run(t, np.full_like(t, volts)))["yaw_rad"][-1]
            for rig in (PLATFORM, MODELS["eq. 3.6 (identified)"])
        ]
        row(f"angle after 20 s at {volts} V from rest, platform and eq. 3.6 [rad]", "", f"{ends[0]:.4g}, {ends[1]:.1f}")
    row("rate at 4 V: from rest, and once moving [rad/s]", "", f"0, {settled(4.0)[1]:.2f}")


def responses(number: int, folder: Path) -> None:
    """Both models and the platform in one experiment, in numbers and as a figure."""
    t, volts = command(number)
    rig = predict(PLATFORM, run(t, volts))
    runs = {name: predict(model, run(t, volts)) for name, model in MODELS.items()}
    for name, model in runs.items():
        miss = [rms(model[y] - rig[y]) for y in ("yaw_rad_s", "yaw_rad")]
        row(
            f"Experiment {number}: {name} misses rate [rad/s] and angle [rad] by, RMS",
            '"no overlap"',
            f"{miss[0]:.2f}, {miss[1]:.0f}",
        )
    ends = np.arange(1, 5) * len(t) // 4 - 1  # the last sample of each half wave
    row(
        f"Experiment {number}: rates at the end of half waves of {', '.join(f'{u:g}' for u in volts[ends])} V [rad/s]",
        "",
        ", ".join(f"{w:.2f}" for w in rig["yaw_rad_s"][ends] + 0.0),
    )
    row(
        "… which every linear model that settles misses by at least [rad/s, RMS]",
        "",
        f"{least_linear_miss(volts[ends], rig['yaw_rad_s'][ends]):.2f}",
    )
    save(_figure(number, t, volts, {"platform, regenerated": rig} | runs), folder, f"fig_3_{4 + number}")


def _figure(number: int, t: np.ndarray, volts: np.ndarray, runs: dict[str, dict[str, np.ndarray]]) -> plt.Figure:
    figure, axes = plt.subplots(3, 1, figsize=(7.5, 7), sharex=True, layout="constrained", height_ratios=(1, 2, 2))
    axes[0].plot(t, volts, color="black")
    axes[0].axhline(
        -FRICTION(0.0) / GAIN,
        color="#999999",
        ls=":",
        label=f"breakaway of the platform, −{FRICTION(0.0) / GAIN:.2f} V",
    )
    for (name, outputs), style in zip(runs.items(), ("-", "--", "-."), strict=True):
        axes[1].plot(t, outputs["yaw_rad_s"], style, label=name)
        axes[2].plot(t, outputs["yaw_rad"] / 1000.0, style)
    mean, amplitude = (f"{v:g}".replace("-", "−") for v in EXPERIMENTS[number])
    axes[0].set(
        ylabel="command V [V]",
        ylim=(np.min(volts) - 0.3 * np.ptp(volts), np.max(volts) + 0.6 * np.ptp(volts)),
        title=f"Fig. 3.{4 + number}: Experiment {number}, {mean} V with a square wave of {amplitude} V",
    )
    axes[1].set(ylabel="yaw rate ψ' [rad/s]")
    axes[2].set(xlabel="time [s]", ylabel="yaw ψ [1000 rad]")
    axes[0].legend(frameon=False, fontsize=8, loc="upper right")
    axes[1].legend(frameon=False, fontsize=8)
    return figure
