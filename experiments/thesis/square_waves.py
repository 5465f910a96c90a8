"""Figs. 4.5 to 4.11: square waves on the nonlinear closed loop, and the thesis's findings as statements.

The thesis prints neither the waves' period nor whether they go between 0 and their height or to both sides; here they go between
0 and their height, 10 s each way. The derivative is filtered over 20 ms; sampling at 10 ms, as its firmware does.
"""

from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np

from experiments.thesis.table import row, save
from experiments.thesis.testbed import TOP, VOLTS, yaw_testbed
from rwjax.control.closed_loop import ClosedLoopRun, run_rig
from rwjax.control.controller import Controller, LoopTiming, wheel_holding_voltage
from rwjax.control.response import Response, step_response
from rwjax.control.sweep import step_responses
from rwjax.report.control import draw_maps

HEIGHTS = (10.0, 20.0, 30.0, 45.0)  # degrees
SOFT, STIFF = (40.0, 10.0), (100.0, 10.0)  # V/rad, V s/rad
CLOCK = LoopTiming(period=0.01, steps=4, counts=2048)
HALF = 1000  # samples each way
SMOOTH = 0.02  # s


class Wave(NamedTuple):
    """A `run` along its `reference` [rad], what the steps out and back show, two each, and the largest angle beyond the reference
    on the first of each, `over` [°]."""

    reference: np.ndarray
    run: ClosedLoopRun
    out: list[Response]
    back: list[Response]
    over: tuple[float, float]


def controller(kp: float, kd: float, **more: float) -> Controller:
    """The thesis's PD law with its voltage limit."""
    return Controller(kp, kd=kd, filter_time=SMOOTH, voltage_limit=VOLTS, **more)


def wave(height: float, law: Controller) -> Wave:
    """Two periods of a square wave of a height [°]."""
    angle = np.radians(height)
    reference = np.tile(np.repeat([angle, 0.0], HALF), 2)
    run = run_rig(yaw_testbed(), law, reference, CLOCK)
    parts = [ClosedLoopRun(*(x[k * HALF : (k + 1) * HALF] for x in run)) for k in range(4)]
    seen = [step_response(p, reference[k * HALF], CLOCK.period, VOLTS) for k, p in enumerate(parts)]
    angles = np.degrees(np.asarray(run.angle)).reshape(4, HALF)
    over = max(angles[0].max() - height, 0.0), max(-angles[1].min(), 0.0)
    return Wave(reference, run, seen[::2], seen[1::2], over)


class Findings(NamedTuple):
    """What the thesis says of its tests, each a statement about the simulation."""

    stiffer_tracks_better: bool
    stiffer_saturates_more: bool
    overshoot_is_larger_at_20_degrees_than_at_10: bool
    overshoot_grows_on_to_45_degrees: bool
    an_error_stays: bool


def findings(soft: list[Wave], stiff: list[Wave]) -> Findings:
    """The thesis's findings on waves of all heights."""

    def error(w: Wave) -> float:
        return float(np.mean([abs(float(r.error)) for r in (*w.out, *w.back)]))

    def limit(w: Wave) -> float:
        return float(np.mean([float(r.saturated) for r in (*w.out, *w.back)]))

    ways = np.array([w.over for w in stiff])
    return Findings(
        stiffer_tracks_better=all(error(b) < error(a) for a, b in zip(soft, stiff, strict=True)),
        stiffer_saturates_more=all(limit(b) > limit(a) for a, b in zip(soft, stiff, strict=True)),
        overshoot_is_larger_at_20_degrees_than_at_10=bool(np.all(ways[1] > ways[0])),
        overshoot_grows_on_to_45_degrees=bool(np.all(np.diff(ways[1:], axis=0) > 0.0)),
        an_error_stays=all(abs(float(w.out[0].error)) > np.radians(0.2) for w in (*soft, *stiff)),
    )


def square_waves(folder: Path) -> None:
    """Figs. 4.5 to 4.11: square waves at (40, 10) and (100, 10), the voltage limited to 10 V."""
    soft, stiff = ([wave(h, controller(*gains)) for h in HEIGHTS] for gains in (SOFT, STIFF))
    for gains, waves in ((SOFT, soft), (STIFF, stiff)):
        for height, w in zip(HEIGHTS, waves, strict=True):
            row(
                f"{height:g} deg at {gains}: overshoot out, back; error that stays out, back [deg]; at 10 V [%]",
                "",
                f"{w.over[0]:.2f}, {w.over[1]:.2f}; "
                f"{np.degrees(float(w.out[0].error)):.2f}, {np.degrees(float(w.back[0].error)):.2f}; "
                f"{100.0 * np.mean([float(r.saturated) for r in (*w.out, *w.back)]):.1f}",
            )
    for name, holds in findings(soft, stiff)._asdict().items():
        row(f"finding: {name.replace('_', ' ')}", "yes", "yes" if holds else "no")
    fastest = max(float(r.fastest) for w in stiff for r in (*w.out, *w.back))
    row("fastest wheel at (100, 10), 4000 rpm being its limit [rpm]", "", f"{fastest / TOP * 4000.0:.0f}")
    w = stiff[1]
    stays = STIFF[0] * (w.reference - np.asarray(w.run.angle))[HALF - 1]
    keeps = float(wheel_holding_voltage(yaw_testbed().values) * np.asarray(w.run.wheel)[HALF - 1])
    row(
        "20 deg at (100, 10), last sample out: K_p e, and what keeps the wheel at its rate [V]",
        "",
        f"{stays:.2f}, {-keeps:.2f}",
    )
    save(_figure(soft, stiff), folder, "fig_4_5_to_4_11")
    kp, kd = np.linspace(5.0, 100.0, 39), np.linspace(1.0, 40.0, 40)
    step = np.full((1, HALF), np.radians(10.0))
    found = step_responses(yaw_testbed(), [controller(p, d) for p in kp for d in kd], step, CLOCK)
    maps = Response(*(x.reshape(len(kp), len(kd)) for x in found))
    i, j = np.unravel_index(np.argmin(np.abs(np.asarray(maps.error))), maps.error.shape)
    row(
        "1560 gain pairs, 10 deg: least error that stays [deg], where",
        "",
        f"{np.degrees(abs(float(maps.error[i, j]))):.2f}, ({kp[i]:.4g}, {kd[j]:.4g})",
    )
    row("… of them settled within 2 % after 10 s", "", f"{int(np.isfinite(np.asarray(maps.settling)).sum())}")
    i, j = np.nonzero(np.degrees(np.asarray(maps.cycle)) > 0.1)
    row(
        "… of them that never come to rest: how many, least K_p, largest K_d",
        "",
        f"{len(i)}, {kp[i].min():.4g}, {kd[j].max():.4g}",
    )
    save(draw_maps(kp, kd, maps, "chapter 4 again: 10° steps on the nonlinear loop"), folder, "chapter_4_maps")


def _figure(soft: list[Wave], stiff: list[Wave]) -> plt.Figure:
    figure, axes = plt.subplots(2, len(HEIGHTS), figsize=(13, 5.5), sharex=True, layout="constrained")
    for column, (height, a, b) in enumerate(zip(HEIGHTS, soft, stiff, strict=True)):
        t = CLOCK.period * np.arange(len(a.reference))
        top, low = axes[:, column]
        top.plot(t, np.degrees(a.reference), color="#999999", lw=0.9, label="reference")
        for w, gains, color in ((a, SOFT, "tab:orange"), (b, STIFF, "tab:blue")):
            top.plot(t, np.degrees(np.asarray(w.run.angle)), color=color, label=f"({gains[0]:g}, {gains[1]:g})")
            low.plot(t, np.asarray(w.run.command), color=color, lw=0.8)
        top.set_title(f"{height:g}°")
        low.set(xlabel="time [s]", ylim=(-11, 11))
    axes[0, 0].set_ylabel("yaw ψ [°]")
    axes[1, 0].set_ylabel("command [V]")
    axes[0, 0].legend(frameon=False, fontsize=8)
    figure.suptitle("Figs. 4.5 to 4.11: square waves on the nonlinear loop, 10 V limit")
    return figure
