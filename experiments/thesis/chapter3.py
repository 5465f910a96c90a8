"""Chapter 3 of the thesis: every number again, what was printed beside it, and what one command finds.

`python -m experiments.thesis.chapter3 [FOLDER]` prints the tables and draws the figures into `build/thesis` by default.
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.polynomial import Polynomial

from experiments.thesis.regenerate import FRICTION, GAIN, SPEED
from rwjax import Log, parse_rig, read_log, read_logs, read_rig
from rwjax.build import structure_of, theta_of
from rwjax.diagnose.diagnosis import diagnose
from rwjax.fit.problem import pose
from rwjax.fit.rig_fit import fit_rig
from rwjax.methods.two_stage import POLYNOMIAL, two_stage
from rwjax.predict import errors, predict, predict_log
from rwjax.report.words import text

DATA = Path(__file__).parents[2] / "data" / "thesis"
TIME = np.arange(1501) * 0.01
INERTIA = 0.228  # kg m2, of the platform on which the friction was identified


def row(what: str, printed: str, ours: str) -> None:
    """One line of the table."""
    print(f"  {what:66s} {printed:>16s} {ours:>22s}")


def motor() -> None:
    """Eq. 3.1 to 3.3 and Table 3.1."""
    K, R, J = 0.0182, 0.83, 1.24e-4
    b = (K / 54.39 - K**2) / R
    p, q, r = b**2, -(2.0 * b * R * J + 4.0 * K**2 * J), (R * J) ** 2
    low, high = sorted(np.roots([p, q, r]).real)
    row("motor friction from limit speeds, b = (K/54.39 - K^2)/R [N m s/rad]", "4.07e-6", f"{b:.3g}")
    row("inductance that makes the motor's poles equal, smaller root [H]", "0.0641", f"{low:.4f} (other {high:.0f})")
    rig = parse_rig(
        f'kind = "wheel"\n[motor]\ntorque_constant = {K}\nresistance = {R}\ninductance = {low}\nfriction = {b}\n'
        f"[wheel]\ninertia = {J}"
    )
    row("limit speed per volt K/(R b + K^2) [rad/s/V]", "54.39", f"{K / (R * b + K**2):.2f}")
    t = np.arange(1001) * 0.01
    run = predict_log(rig, _silent(t, np.where(t < 5.0, 8.0, 0.0)))
    fig, axes = plt.subplots(2, 1, figsize=(7, 5), sharex=True)
    axes[0].plot(t, run["wheel_rad_s"])
    axes[0].set_ylabel("wheel rate Ω [rad/s]")
    axes[1].plot(t, run["current_A"])
    axes[1].axhspan(-3.0, 3.0, color="#eeeeee", zorder=0, label="±3 A, where listing A.3 clips and the text does not")
    axes[1].set(xlabel="time [s]", ylabel="current i [A]")
    axes[1].legend(frameon=False, fontsize=8)
    _save(fig, "fig_3_2")
    row("largest current at 8 V (listing A.3 clips at 3 A) [A]", "3", f"{np.max(run['current_A']):.2f}")


def platform() -> None:
    """Eq. 3.4 to 3.6: two models that do not agree, and a dead band that neither has."""
    row("gain over inertia from Table 3.2, K_yy/I, and from eq. 3.6", "0.08911", f"{0.428 / INERTIA:.2f}")
    row("damping over inertia from Table 3.2, b/I, and from eq. 3.6", "0.09091", f"{0.082 / INERTIA:.2f}")
    row("voltage below which the platform stays put, (b3/I)/0.08911 [V]", '"below 4"', f"{FRICTION(0.0) / GAIN:.2f}")
    row("the same with Table 3.2 [V]", "", f"{FRICTION(0.0) / (0.428 / INERTIA):.2f}")
    settled = [w.real for w in (FRICTION - GAIN * 6.7).roots() if abs(w.imag) < 1e-9 and w.real > 0.0]
    row("speed at which 6.7 V settles (Fig. 3.11) [rad/s]", "", ", ".join(f"{w:.2f}" for w in sorted(settled)))


def friction() -> None:
    """Eq. 3.12 to 3.14: the two stages, the misprints, and what the printed digits determine."""
    printed = Polynomial([10.9, -1.3, -9.5e-2, -4.1e-3, 6.7e-5])
    row("speed at 15 s from eq. 3.12 as printed [rad/s]", "", f"{printed(15.0):.1f}")
    row("the same with + 9.5e-2 t^2 [rad/s]", "", f"{SPEED(15.0):.2f}")
    w = SPEED(TIME)
    misprint = -Polynomial([0.3757, -0.525, 2.05e-2, -6.89e-4])
    both = ((printed, misprint), (SPEED, FRICTION))
    rms = [np.sqrt(np.mean((-speed.deriv()(TIME) - m(speed(TIME))) ** 2)) for speed, m in both]
    row("eq. 3.14 against eq. 3.13, both as printed, RMS [rad/s^2]", "", f"{rms[0]:.1f}")
    row("the same with + 9.5e-2 t^2, -5.25e-2 and the sign of a friction", "", f"{rms[1]:.3f}")

    log = read_log(DATA / "coast_down.csv", RIG)
    twice = two_stage(RIG, [log], order=4)
    ours = Polynomial([twice.rig.values[name] / INERTIA for name in POLYNOMIAL])
    spread = [twice.rig.standard_error[name] / INERTIA for name in POLYNOMIAL]
    for k, name in enumerate(("b3/I", "b2/I", "b1/I", "b0/I")):
        row(f"two-stage {name}", f"{FRICTION.coef[k]:.5g}", f"{ours.coef[k]:.4g} ± {spread[k]:.1g}")
    row(
        "two-stage curve against eq. 3.14 over 0 to 15 s, RMS [rad/s^2]",
        "",
        f"{np.sqrt(np.mean((ours(w) - FRICTION(w)) ** 2)):.3f}",
    )
    rng = np.random.default_rng(0)
    half = np.array([0.05, 0.05, 0.05e-2, 0.05e-3, 0.05e-5])
    drawn = []
    for _ in range(2000):
        speed = Polynomial(SPEED.coef + rng.uniform(-half, half))
        v = speed(TIME)
        if np.min(v) > 0.0:
            drawn.append(np.linalg.lstsq(np.stack([v**p for p in range(4)], 1), -speed.deriv()(TIME), rcond=None)[0])
    low, high = np.percentile(drawn, [2.5, 97.5], axis=0)
    for k, name in enumerate(("b3/I", "b2/I", "b1/I", "b0/I")):
        row(f"{name} under the rounding of eq. 3.12", f"{FRICTION.coef[k]:.5g}", f"{low[k]:.2g} to {high[k]:.2g}")

    believed = replace(RIG, numbers=RIG.numbers | dict.fromkeys(POLYNOMIAL, 0.0) | {POLYNOMIAL[0]: 0.1})
    end = fit_rig(believed, [log])
    quantum = 2.0 * np.pi / 2048
    row("end-to-end: free run over the whole coast-down, RMS [counts]", "", f"{end.rms['yaw_rad'] / quantum:.2f}")
    structure = structure_of(RIG)
    problem = pose(structure, (log,))
    left = errors(problem, predict(problem, theta_of(twice.rig, structure), with_floor=False))[0]["yaw_rad"]
    row("two-stage: the same [counts]", "", f"{np.sqrt(np.mean(left**2)) / quantum:.1f}")
    whole = Polynomial([end.rig.values[name] / INERTIA for name in POLYNOMIAL])
    row("friction at 10.9 and 16 rad/s, two-stage [rad/s^2]", "", f"{ours(10.9):.2f}, {ours(16.0):.2f}")
    row("the same, end-to-end", "", f"{whole(10.9):.2f}, {whole(16.0):.2f}")
    row("the same, eq. 3.14 (negative b0: it must turn down)", "", f"{FRICTION(10.9):.2f}, {FRICTION(16.0):.2f}")
    row(
        "speed beyond which eq. 3.14 drives instead of braking [rad/s]",
        "",
        f"{max(r.real for r in FRICTION.roots() if abs(r.imag) < 1e-9):.1f}",
    )
    row(
        "slope of the friction at standstill, b2/I (negative: unstable) [1/s]",
        "-5.2491e-2",
        f"{FRICTION.deriv()(0.0):.4g}",
    )

    fig, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
    axes[0].plot(TIME, w, label="eq. 3.12, sign corrected")
    axes[0].plot(TIME, printed(TIME), "--", label="as printed")
    axes[0].set(xlabel="time [s]", ylabel="yaw rate ψ' [rad/s]", ylim=(-5, 12), title="Fig. 3.9")
    s = np.linspace(0.0, 16.0, 200)
    for curve, label in ((FRICTION, "eq. 3.14, corrected"), (ours, "two-stage"), (whole, "end-to-end")):
        axes[1].plot(s, curve(s), label=label)
    axes[1].axvline(10.9, color="#999999", lw=0.8)
    axes[1].set(xlabel="yaw rate ψ' [rad/s]", ylabel="friction over inertia [rad/s²]", title="Fig. 3.10", ylim=(-1, 4))
    t = np.arange(4001) * 0.01
    driven = predict_log(
        replace(RIG, numbers=RIG.numbers | dict(zip(POLYNOMIAL, INERTIA * FRICTION.coef, strict=True))),
        _silent(t, np.where(t > 0.6, 6.7, 0.0)),
    )
    axes[2].plot(t, driven["yaw_rad_s"])
    axes[2].set(xlabel="time [s]", ylabel="yaw rate ψ' [rad/s]", title="Fig. 3.11, 6.7 V")
    for ax in axes[:2]:
        ax.legend(frameon=False, fontsize=8)
    _save(fig, "fig_3_9_to_3_11")


def diagnosis() -> None:
    """What took a chapter: from the viscous model of eq. 3.6 to the friction that it lacks."""
    rig = read_rig(DATA / "platform.toml")
    found = diagnose(rig, read_logs([DATA / f"{name}.csv" for name in ("square", "stairs", "triangle")], rig))
    print("\n".join(text(found)))


RIG = parse_rig(
    f'kind = "platform"\n[drive]\ngain = {GAIN * INERTIA}\n[axis]\ninertia = {INERTIA}\n[axis.friction]\n'
    "polynomial = [0.1, 0.0, 0.0, 0.0]\n[encoder]\ncounts_per_rev = 2048\n"
    '[fit]\nfree = ["axis.friction.polynomial"]'
)
FOLDER = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/thesis")


def _silent(t: np.ndarray, command: np.ndarray) -> Log:
    return Log("run", t, command, {}, {}, {}, False, None, float(t[0]))


def _save(fig, name: str) -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    fig.savefig(FOLDER / f"{name}.png", dpi=130)
    plt.close(fig)


def main() -> None:
    """Prints everything."""
    row("", "printed", "here")
    for part in (motor, platform, friction):
        print(f"{part.__doc__.splitlines()[0]}")
        part()
    print(diagnosis.__doc__)
    diagnosis()
    print(f"figures: {FOLDER}")


if __name__ == "__main__":
    main()
