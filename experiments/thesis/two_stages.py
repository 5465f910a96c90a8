"""Eq. 3.9 to 3.14, Figs. 3.9 to 3.11: friction from a coast-down, the misprints, and what the printed digits determine."""

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.polynomial import Polynomial

from experiments.thesis.platform_models import INERTIA, PLATFORM, platform_rig, settled
from experiments.thesis.regenerate import FRICTION, GAIN, SPEED
from experiments.thesis.table import rms, row, run, save
from rwjax import Log, Rig, read_log
from rwjax.fitting.fit import fit
from rwjax.fitting.predict import predict
from rwjax.fitting.prediction import errors, predict_logs
from rwjax.fitting.problem import pose
from rwjax.methods.two_stage import POLYNOMIAL, two_stage
from rwjax.plant.from_rig import structure_of, theta_of

COAST_DOWN = Path(__file__).parents[2] / "data" / "thesis" / "coast_down.csv"
TIME = np.arange(1501) * 0.01
SPEED_PRINTED = Polynomial([10.9, -1.3, -9.5e-2, -4.1e-3, 6.7e-5])  # eq. 3.12
ACCELERATION_PRINTED = Polynomial([0.3757, -0.525, 2.05e-2, -6.89e-4])  # right side of eq. 3.14, over rate
HALF_DIGIT = np.array([0.05, 0.05, 0.05e-2, 0.05e-3, 0.05e-5])  # of eq. 3.12's coefficients
WINDOWS = ((0, 8), (0, 10), (0, 12), (2, 15), (0, 15), (0, 20))  # s
INERTIA_A4 = 0.0495  # kg m2, the other rig's, with which listing A.4 uses the coefficients
QUANTUM = 2.0 * np.pi / 2048  # rad, one count
LABELS = ("b3/I", "b2/I", "b1/I", "b0/I")
RIG = platform_rig(
    GAIN,
    "polynomial = [0.1, 0.0, 0.0, 0.0]",
    '[encoder]\ncounts_per_rev = 2048\n[fit]\nfree = ["axis.friction.polynomial"]',
)


def contradiction(speed: Polynomial, acceleration: Polynomial) -> float:
    """How far eq. 3.14 is from the derivative of eq. 3.12 (that is 3.13) over 0 to 15 s [rad/s^2, RMS]."""
    return rms(speed.deriv()(TIME) - acceleration(speed(TIME)))


def stage_two(speed: Polynomial, time: np.ndarray) -> np.ndarray:
    """b3/I to b0/I by least squares of minus the derivative of a speed over time on the powers of that speed."""
    w = speed(time)
    return np.linalg.lstsq(np.stack([w**p for p in range(4)], axis=1), -speed.deriv()(time), rcond=None)[0]


def under_rounding(draws: int = 2000) -> np.ndarray:
    """2.5 and 97.5 % of `stage_two` `(2, 4)` where every coefficient of eq. 3.12 is anything that rounds to its digits."""
    rng = np.random.default_rng(0)
    speeds = [Polynomial(SPEED.coef + rng.uniform(-HALF_DIGIT, HALF_DIGIT)) for _ in range(draws)]
    return np.percentile([stage_two(s, TIME) for s in speeds if np.min(s(TIME)) > 0.0], [2.5, 97.5], axis=0)


def of_rig(rig: Rig) -> Polynomial:
    """Friction over inertia [rad/s^2] of a rig with a polynomial."""
    return Polynomial([rig.values[name] / INERTIA for name in POLYNOMIAL])


def misprints(_: Path) -> None:
    """Eq. 3.12 to 3.14: what cannot be as printed."""
    row(
        "least speed over 0 to 15 s (at 15 s), as printed and with + 9.5e-2 t^2 [rad/s]",
        "",
        f"{np.min(SPEED_PRINTED(TIME)):.1f}, {np.min(SPEED(TIME)):.2f}",
    )
    digit = Polynomial([0.3757, -0.0525, 2.05e-2, -6.89e-4])
    for label, speed, acceleration in (
        ("eq. 3.14 against 3.13, both as printed, RMS [rad/s^2]", SPEED_PRINTED, ACCELERATION_PRINTED),
        ("… with + 9.5e-2 t^2 alone", SPEED, ACCELERATION_PRINTED),
        ("… with + 9.5e-2 t^2 and -5.25e-2", SPEED, digit),
        ("… with + 9.5e-2 t^2 and the right side negated", SPEED, -ACCELERATION_PRINTED),
        ("… with -5.25e-2 and the right side negated, but - 9.5e-2 t^2", SPEED_PRINTED, -digit),
        ("… with all three", SPEED, -digit),
        ("… with all three and the digits of listing A.4", SPEED, -FRICTION),
    ):
        row(label, "", f"{contradiction(speed, acceleration):.3f}")
    row("b3 with the inertia it was identified on, 0.228 kg m2 [N m]", "", f"{FRICTION(0.0) * INERTIA:.4f}")
    row("b3 with listing A.4's 0.0495 kg m2, another rig's [N m]", "", f"{FRICTION(0.0) * INERTIA_A4:.4f}")
    row("speed beyond which eq. 3.14 drives instead of braking (b0 < 0) [rad/s]", "", f"{settled(0.0)[-1]:.1f}")
    pole = -FRICTION.deriv()(0.0)
    row(
        "pole -b2/I of the axis linearised at standstill [1/s], time in which a rate doubles [s]",
        "",
        f"{pole:+.4f}, {np.log(2.0) / pole:.1f}",
    )


def two_stages(folder: Path) -> None:
    """Eq. 3.9 to 3.14, Figs. 3.9 to 3.11: friction from the regenerated coast-down, and what its digits determine."""
    log = read_log(COAST_DOWN, RIG)
    twice = two_stage(RIG, [log], order=4)
    ours = of_rig(twice.rig)
    for k, name in enumerate(POLYNOMIAL):
        spread = twice.rig.standard_error[name] / INERTIA
        row(f"two-stage {LABELS[k]}", f"{FRICTION.coef[k]:.5g}", f"{ours.coef[k]:.4g} ± {spread:.1g}")
    row(
        "two-stage curve against eq. 3.14 over 0 to 15 s, RMS [rad/s^2]",
        "",
        f"{rms((ours - FRICTION)(SPEED(TIME))):.3f}",
    )
    _digits()
    whole = _end_to_end(log, twice.rig)
    row("friction at 10.9 and 16 rad/s, two-stage [rad/s^2]", "", f"{ours(10.9):.2f}, {ours(16.0):.2f}")
    row("the same, end-to-end", "", f"{whole(10.9):.2f}, {whole(16.0):.2f}")
    row("the same, eq. 3.14", "", f"{FRICTION(10.9):.2f}, {FRICTION(16.0):.2f}")
    row(
        "rate at which 6.7 V settles (Fig. 3.11); unstable root above it [rad/s]",
        "",
        ", ".join(f"{w:.2f}" for w in settled(6.7)),
    )
    save(_figure(ours, whole), folder, "fig_3_9_to_3_11")


def _digits() -> None:
    """What the digits of eq. 3.12 and the window leave of the coefficients."""
    low, high = under_rounding()
    for k, label in enumerate(LABELS):
        row(
            f"{label} under the rounding of eq. 3.12 (95 %)",
            f"{FRICTION.coef[k]:.5g}",
            f"{low[k]:.2g} to {high[k]:.2g}",
        )
    windows = [stage_two(SPEED, np.arange(a, b + 0.005, 0.01)) for a, b in WINDOWS]
    names = ", ".join(f"{a}-{b}" for a, b in WINDOWS)
    for k, label in enumerate(LABELS):
        row(
            f"{label} from {names} s of eq. 3.12",
            f"{FRICTION.coef[k]:.5g}",
            ", ".join(f"{c[k]:.2g}" for c in windows),
        )
    apart = [rms(Polynomial(c)(SPEED(TIME)) - FRICTION(SPEED(TIME))) for c in windows]
    row("… the same curves against eq. 3.14 over 0 to 15 s, RMS [rad/s^2]", "", ", ".join(f"{a:.2f}" for a in apart))
    row("slowest rate of the coast-down: friction below it is extrapolated [rad/s]", "", f"{SPEED(TIME[-1]):.2f}")
    row(
        "dead band (b3/I)/0.08911 under the rounding of eq. 3.12 (95 %) [V]",
        '"below 4"',
        f"{low[0] / GAIN:.1f} to {high[0] / GAIN:.1f}",
    )
    row("… and from those windows [V]", '"below 4"', ", ".join(f"{c[0] / GAIN:.1f}" for c in windows))


def _end_to_end(log: Log, twice: Rig) -> Polynomial:
    """The friction that the library's fit finds in the coast-down, and both free runs over it."""
    believed = replace(RIG, numbers=RIG.numbers | dict.fromkeys(POLYNOMIAL, 0.0) | {POLYNOMIAL[0]: 0.1})
    end = fit(believed, [log])
    row("end-to-end: free run over the whole coast-down, RMS [counts]", "", f"{end.rms['yaw_rad'] / QUANTUM:.2f}")
    structure = structure_of(RIG)
    problem = pose(structure, (log,))
    left = errors(problem, predict_logs(problem, theta_of(twice, structure), with_floor=False))[0]["yaw_rad"]
    row("two-stage: the same [counts]", "", f"{rms(left) / QUANTUM:.1f}")
    return of_rig(end.rig)


def _figure(ours: Polynomial, whole: Polynomial) -> plt.Figure:
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
    axes[0].plot(TIME, SPEED(TIME), label="eq. 3.12 with + 9.5e-2 t²")
    axes[0].plot(TIME, SPEED_PRINTED(TIME), "--", label="as printed")
    axes[0].axhline(0.0, color="#999999", lw=0.8)
    axes[0].set(xlabel="time [s]", ylabel="yaw rate ψ' [rad/s]", ylim=(-5, 12), title="Fig. 3.9: coast-down")
    w = np.linspace(0.0, 16.0, 200)
    for curve, label, style in (
        (FRICTION, "eq. 3.14, corrected", "-"),
        (ours, "two-stage", "--"),
        (whole, "end-to-end", ":"),
    ):
        axes[1].plot(w, curve(w), style, label=label)
    for edges in ((0.0, SPEED(15.0)), (SPEED(0.0), 16.0)):
        axes[1].axvspan(*edges, color="#eeeeee", zorder=0)
    axes[1].text(13.4, 0.1, "not measured", ha="center", color="#666666", fontsize=8)
    axes[1].set(
        xlabel="yaw rate ψ' [rad/s]",
        ylabel="friction over inertia [rad/s²]",
        title="Fig. 3.10: friction",
        ylim=(0, 2.8),
    )
    t = np.arange(4001) * 0.01
    driven = predict(PLATFORM, run(t, np.where(t > 0.6, 6.7, 0.0)))
    axes[2].plot(t, driven["yaw_rad_s"])
    axes[2].axhline(settled(6.7)[0], color="#999999", ls=":", label=f"settles at {settled(6.7)[0]:.2f} rad/s")
    axes[2].set(xlabel="time [s]", ylabel="yaw rate ψ' [rad/s]", title="Fig. 3.11: 6.7 V from rest")
    for ax, place in zip(axes, ("upper right", "upper left", "lower right"), strict=True):
        ax.legend(frameon=False, fontsize=8, loc=place)
    return figure
