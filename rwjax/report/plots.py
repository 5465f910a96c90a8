"""Figures of a diagnosis: each function draws one result on given axes and computes nothing."""

import numpy as np
from matplotlib.axes import Axes

from rwjax.diagnosis.hypothesis import spoken
from rwjax.diagnosis.result import Diagnosis
from rwjax.diagnosis.words import UNIT
from rwjax.logs.segments import runs_of
from rwjax.report.style import AFTER, AXIS_LABEL, BEFORE, FLOOR, MEASURED, drawn_name

MOST_POINTS = 4000  # samples drawn of a missing torque
BINS, FEWEST_IN_A_BIN = 24, 10
MOST_RANKED = 8  # candidates in the figure of the ranking
NAMES_APART = 0.06  # between the two lines on which names of runs stand, of the height of the axes


def held_out_errors(d: Diagnosis) -> dict[int, np.ndarray]:
    """Errors of the rig as it is in the headline signal, the run first that is followed worst.

    Args:
        d: the diagnosis.

    Returns:
        By number of the log, measured less predicted (time,) in the signal's unit [any], of logs in which it was read.
    """
    held = {k: e[d.signal] for k, e in d.before.error.items() if d.signal in e and np.isfinite(e[d.signal]).any()}
    return dict(sorted(held.items(), key=lambda one: -float(np.nanmean(one[1] ** 2))))


def plot_motion(d: Diagnosis, ax: Axes) -> Axes:
    """Draws the measured motion of the held-out run that is followed worst, and the simulated one before and after the named effects.

    Args:
        d: what is drawn.
        ax: axes to draw on.

    Returns:
        The same axes.
    """
    held = held_out_errors(d)
    worst = next(iter(held))
    log = d.logs[worst]
    t, measured = log.time, log.outputs[d.signal]
    ax.plot(t, measured, color=MEASURED, lw=2.4, alpha=0.5, label="measured")
    ax.plot(t, measured - held[worst], color=BEFORE, lw=1.0, label="rig as it is")
    if d.effects:
        ax.plot(t, measured - d.after.error[worst][d.signal], color=AFTER, lw=1.0, ls="--", label="with the effects")
    ax.set_title(drawn_name(log.name), loc="left", fontsize=8)
    ax.set_xlabel("time [s]")
    ax.set_ylabel(AXIS_LABEL[d.signal])
    ax.legend(loc="best", fontsize=8, frameon=False)
    return ax


def plot_runs(d: Diagnosis, ax: Axes) -> Axes:
    """Draws the held-out error over time, before and after the named effects are added, run after run.

    Args:
        d: what is drawn.
        ax: axes to draw on.

    Returns:
        The same axes.
    """
    begin, shift, runs, run_of = 0.0, 0.0, list[int](), runs_of(d.logs).tolist()
    for number, by_output in d.before.error.items():
        if d.signal not in by_output:
            continue
        log, first = d.logs[number], not runs
        if run_of[number] not in runs:
            shift, place = begin - log.time[0], 1.0 + NAMES_APART * (len(runs) % 2)
            runs.append(run_of[number])
            ax.text(
                begin, place, f" {drawn_name(log.name)}", transform=ax.get_xaxis_transform(), va="bottom", fontsize=7
            )
            ax.axvline(begin, color="#dddddd", lw=0.8, zorder=0)
        t = log.time + shift
        ax.plot(t, by_output[d.signal], color=BEFORE, lw=0.9, label="rig as it is" if first else None)
        if d.effects:
            label = "with the effects" if first else None
            ax.plot(t, d.after.error[number][d.signal], color=AFTER, lw=0.9, label=label)
        begin = float(t[-1]) + 0.5
    ax.set_xlabel("time of the held-out runs, one after the other [s]")
    ax.set_ylabel(f"measured − predicted {AXIS_LABEL[d.signal]}")
    ax.legend(loc="best", fontsize=8, frameon=False)
    return ax


def plot_waterfall(d: Diagnosis, ax: Axes) -> Axes:
    """Draws the held-out RMS error after each effect is added, and the noise floor, on an axis that shows both.

    Args:
        d: what is drawn.
        ax: axes to draw on.

    Returns:
        The same axes.
    """
    rungs, floor = d.waterfall, d.gaps[d.signal].floor
    labels = ["rig as it is", *(f"+ {spoken(r.names[-1])}" for r in rungs[1:])]
    values = [r.rms for r in rungs]
    colours = [BEFORE, *[AFTER] * (len(values) - 1)]
    ax.hlines(range(len(values)), floor, values, color=colours, lw=2.0)
    ax.scatter(values, range(len(values)), color=colours, s=36, zorder=3)
    for k, value in enumerate(values):
        ax.annotate(f"{value:.3g}", (value, k), (6.0, 0.0), textcoords="offset points", va="center", fontsize=8)
    ax.set_xscale("log")
    ax.axvline(floor, color=FLOOR, ls="--", lw=1.2)
    at, aside = (floor, -0.75), (6.0, 0.0)
    ax.annotate(f"floor {floor:.3g}", at, aside, textcoords="offset points", color=FLOOR, fontsize=8, va="center")
    ax.set_yticks(range(len(labels)), labels, fontsize=8)
    ax.set_ylim(len(values) - 0.4, -1.0)
    ax.set_xlabel(f"held-out RMS error [{UNIT[d.signal]}], logarithmic")
    ax.margins(x=0.15)
    return ax


def plot_missing(d: Diagnosis, ax: Axes) -> Axes:
    """Draws the missing torque over the coordinate of which it is a function: samples, and median and middle two thirds of bins.

    Args:
        d: what is drawn; `d.where.drawn` names the coordinate.
        ax: axes to draw on.

    Returns:
        The same axes.
    """
    assert d.where is not None and d.where.drawn is not None
    c = np.concatenate([m.coordinates[d.where.drawn] for m in d.where.missing])
    y = np.concatenate([m.torque for m in d.where.missing])
    sd = np.concatenate([m.deviation for m in d.where.missing])
    keep = np.isfinite(c) & np.isfinite(y) & (sd < 3.0 * np.median(sd))
    c, y = c[keep], y[keep]
    stride = max(1, len(c) // MOST_POINTS)
    ax.plot(c[::stride], y[::stride], ".", ms=1.5, color="#bbbbbb", label="missing torque, every sample")
    middle, low, median, high = _binned(c, y)
    ax.fill_between(middle, low, high, color=AFTER, alpha=0.2, lw=0)
    ax.plot(middle, median, color=AFTER, lw=1.6, label="median and middle two thirds of each bin")
    span = np.percentile(y, [0.5, 99.5])
    ax.set_ylim(span[0] - 0.2 * np.ptp(span) - 1e-12, span[1] + 0.2 * np.ptp(span) + 1e-12)
    ax.axhline(0.0, color=MEASURED, lw=0.6)
    ax.set_xlabel(AXIS_LABEL[d.where.drawn])
    ax.set_ylabel("missing torque [N m]")
    ax.legend(loc="best", fontsize=8, frameon=False)
    return ax


def _binned(c: np.ndarray, y: np.ndarray) -> tuple[list[float], list[float], list[float], list[float]]:
    """Median of `c`, and the 16th, 50th and 84th percentile of `y`, in bins that hold equally many samples."""
    edges = np.unique(np.quantile(c, np.linspace(0.0, 1.0, BINS + 1)))
    found: tuple[list[float], ...] = ([], [], [], [])
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        inside = (c >= a) & (c <= b)
        if inside.sum() >= FEWEST_IN_A_BIN:
            for values, value in zip(
                found, (np.median(c[inside]), *np.percentile(y[inside], [16.0, 50.0, 84.0])), strict=True
            ):
                values.append(float(value))
    return found


def plot_ranking(d: Diagnosis, ax: Axes) -> Axes:
    """Draws the share of the evidence of the first candidates.

    Args:
        d: what is drawn.
        ax: axes to draw on.

    Returns:
        The same axes.
    """
    shown = d.ranking[:MOST_RANKED]
    ax.barh(range(len(shown)), [r.probability for r in shown], color=AFTER, height=0.6)
    names = [" + ".join(spoken(n) for n in r.effect.split(" + ")) if r.effect != "none" else "nothing" for r in shown]
    ax.set_yticks(range(len(shown)), names, fontsize=8)
    ax.invert_yaxis()
    ax.set_xlim(0.0, 1.0)
    ax.set_xlabel("share of the evidence")
    return ax


def plot_shares(d: Diagnosis, ax: Axes) -> Axes:
    """Draws the share of the excess error that the best law in each coordinate removes.

    Args:
        d: what is drawn.
        ax: axes to draw on.

    Returns:
        The same axes.
    """
    assert d.where is not None
    shares = sorted(d.where.shares.items(), key=lambda kv: -kv[1])
    colour = [AFTER if name == d.where.coordinate else FLOOR for name, _ in shares]
    ax.barh(range(len(shares)), [s for _, s in shares], color=colour, height=0.6)
    ax.set_yticks(range(len(shares)), [name.replace("_", " ") for name, _ in shares], fontsize=8)
    ax.invert_yaxis()
    ax.set_xlim(0.0, 1.0)
    ax.set_xlabel("share of the excess error that the best law in it removes")
    return ax
