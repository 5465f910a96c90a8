"""Plots: each draws one result on given axes and computes nothing."""

import numpy as np
from matplotlib.axes import Axes

from rwjax.diagnosis.result import Diagnosis
from rwjax.diagnosis.words import UNIT, spoken
from rwjax.kinds import half_column

MEASURED, BEFORE, AFTER, FLOOR = "#222222", "#c1440e", "#1b6ca8", "#8a8a8a"
AXIS_LABEL = {
    "yaw_rad": "yaw ψ [rad]",
    "yaw_rad_s": "yaw rate ψ' [rad/s]",
    "wheel_rad": "wheel angle θ [rad]",
    "wheel_rad_s": "wheel rate Ω [rad/s]",
    "current_A": "current i [A]",
    "yaw_rate": "yaw rate ψ' [rad/s]",
    "yaw": "yaw ψ, one turn [rad]",
    "wheel_rate": "wheel rate Ω [rad/s]",
    "wheel_angle": "wheel angle θ, one turn [rad]",
    "current": "current i [A]",
    "voltage": "command u [V]",
    "time": "time t [s]",
}
AXIS_LABEL |= {
    "pitch_rad": "pitch θ [rad]",
    "pitch_rad_s": "pitch rate θ' [rad/s]",
    "pitch": "pitch θ [rad]",
    "pitch_rate": "pitch rate θ' [rad/s]",
    **{
        half_column(y, k): f"{k + 1}: {AXIS_LABEL[y]}"
        for y in ("wheel_rad", "wheel_rad_s", "current_A")
        for k in range(2)
    },
}


def plot_runs(d: Diagnosis, ax: Axes) -> Axes:
    """Held-out error over time of the rig as it is and with the named effects, log after log."""
    begin = 0.0
    for number, by_output in d.before.error.items():
        if d.signal not in by_output:
            continue
        t = d.logs[number].time - d.logs[number].time[0] + begin
        first = begin == 0.0
        ax.plot(t, by_output[d.signal], color=BEFORE, lw=0.9, label="rig as it is" if first else None)
        if d.effects:
            ax.plot(
                t,
                d.after.error[number][d.signal],
                color=AFTER,
                lw=0.9,
                label="with the effects" if first else None,
            )
        ax.axvline(begin, color="#dddddd", lw=0.8, zorder=0)
        ax.text(begin, 1.0, f" {d.logs[number].name}", transform=ax.get_xaxis_transform(), va="bottom", fontsize=7)
        begin = float(t[-1]) + 0.5
    ax.set_xlabel("time of the held-out runs, one after the other [s]")
    ax.set_ylabel(f"measured − predicted {AXIS_LABEL[d.signal]}")
    ax.legend(loc="best", fontsize=8, frameon=False)
    return ax


def plot_waterfall(d: Diagnosis, ax: Axes) -> Axes:
    """Held-out RMS after each effect, and the floor."""
    rungs = d.waterfall
    labels = ["rig as it is", *(f"+ {spoken(r.names[-1])}" for r in rungs[1:])]
    values = [r.rms for r in rungs]
    ax.barh(range(len(values)), values, color=[BEFORE, *[AFTER] * (len(values) - 1)], height=0.6)
    for k, value in enumerate(values):
        ax.text(value, k, f" {value:.3g}", va="center", fontsize=8)
    ax.axvline(d.gaps[d.signal].floor, color=FLOOR, ls="--", lw=1.2)
    ax.text(
        d.gaps[d.signal].floor,
        -0.75,
        f" floor {d.gaps[d.signal].floor:.3g}",
        color=FLOOR,
        fontsize=8,
        va="center",
    )
    ax.set_yticks(range(len(labels)), labels, fontsize=8)
    ax.set_ylim(len(values) - 0.4, -1.0)
    ax.set_xlabel(f"held-out RMS error [{UNIT[d.signal]}]")
    ax.margins(x=0.15)
    return ax


def plot_missing(d: Diagnosis, ax: Axes) -> Axes:
    """Missing torque over the coordinate of which it is a function: samples, and mean with its spread in bins."""
    assert d.where is not None and d.where.drawn is not None
    c = np.concatenate([m.coordinates[d.where.drawn] for m in d.where.missing])
    y = np.concatenate([m.torque for m in d.where.missing])
    sd = np.concatenate([m.deviation for m in d.where.missing])
    keep = np.isfinite(c) & np.isfinite(y) & (sd < 3.0 * np.median(sd))
    c, y, sd = c[keep], y[keep], sd[keep]
    stride = max(1, len(c) // 4000)
    ax.plot(c[::stride], y[::stride], ".", ms=1.5, color="#bbbbbb", label="missing torque, every sample")
    edges = np.unique(np.quantile(c, np.linspace(0.0, 1.0, 25)))
    middle, mean, low, high = [], [], [], []
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        inside = (c >= a) & (c <= b)
        if inside.sum() >= 10:
            middle.append(float(np.median(c[inside])))
            quartiles = np.percentile(y[inside], [16.0, 50.0, 84.0])
            mean.append(quartiles[1])
            low.append(quartiles[0])
            high.append(quartiles[2])
    ax.fill_between(middle, low, high, color=AFTER, alpha=0.2, lw=0)
    ax.plot(middle, mean, color=AFTER, lw=1.6, label="median and middle two thirds of each bin")
    span = np.percentile(y, [0.5, 99.5])
    ax.set_ylim(span[0] - 0.2 * np.ptp(span) - 1e-12, span[1] + 0.2 * np.ptp(span) + 1e-12)
    ax.axhline(0.0, color=MEASURED, lw=0.6)
    ax.set_xlabel(AXIS_LABEL[d.where.drawn])
    ax.set_ylabel("missing torque [N m]")
    ax.legend(loc="best", fontsize=8, frameon=False)
    return ax


def plot_ranking(d: Diagnosis, ax: Axes) -> Axes:
    """Share of the evidence of the first candidates."""
    shown = d.ranking[:8]
    ax.barh(range(len(shown)), [r.probability for r in shown], color=AFTER, height=0.6)
    names = [" + ".join(spoken(n) for n in r.effect.split(" + ")) if r.effect != "none" else "nothing" for r in shown]
    ax.set_yticks(range(len(shown)), names, fontsize=8)
    ax.invert_yaxis()
    ax.set_xlim(0.0, 1.0)
    ax.set_xlabel("share of the evidence")
    return ax


def plot_shares(d: Diagnosis, ax: Axes) -> Axes:
    """Share of the excess error that the best law in each coordinate removes."""
    assert d.where is not None
    shares = sorted(d.where.shares.items(), key=lambda kv: -kv[1])
    colour = [AFTER if name == d.where.coordinate else FLOOR for name, _ in shares]
    ax.barh(range(len(shares)), [s for _, s in shares], color=colour, height=0.6)
    ax.set_yticks(range(len(shares)), [name.replace("_", " ") for name, _ in shares], fontsize=8)
    ax.invert_yaxis()
    ax.set_xlim(0.0, 1.0)
    ax.set_xlabel("share of the excess error that the best law in it removes")
    return ax
