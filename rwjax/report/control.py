"""Maps over gains, manoeuvres and wheel sizes, as columns of a table and as figures."""

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure

from rwjax.control.open_loop import Trajectory
from rwjax.control.response import Response
from rwjax.control.ring import Ring
from rwjax.control.sizing import LIMITS, WheelBudget
from rwjax.report.style import AFTER, BEFORE

MAPS: dict[str, tuple[str, str, float]] = {
    "overshoot": ("overshoot", "overshoot [%]", 100.0),
    "settling_s": ("settling", "settling time [s]; grey: never", 1.0),
    "error_rad": ("error", "error that stays [°]", 180.0 / np.pi),
    "cycle_rad": ("cycle", "limit cycle [°]", 180.0 / np.pi),
    "saturated": ("saturated", "time at the limit [%]", 100.0),
}
"""Columns of a table of responses: field of `Response`, label and factor of the map."""
NEVER = "#cccccc"
"""Colour where a map has no finite value."""


def _map(ax: Axes, x: np.ndarray, y: np.ndarray, value: np.ndarray, **style: Any) -> ScalarMappable:
    """Values `(y, x)` as colours; as points where there is one row or column only, which a mesh cannot show."""
    if min(value.shape) > 1:
        return ax.pcolormesh(x, y, value, shading="nearest", rasterized=True, **style)
    return ax.scatter(*np.meshgrid(x, y), c=value.ravel(), s=12, **style)


def response_columns(
    kp: Float[np.ndarray, " p"], kd: Float[np.ndarray, " d"], found: Response
) -> dict[str, np.ndarray]:
    """Columns of a sweep over PD gains, one entry for each pair.

    Args:
        kp: proportional gains [V/rad], shape `(p,)`.
        kd: derivative gains [V s/rad], shape `(d,)`.
        found: responses, fields of shape `(p, d)`.

    Returns:
        `kp`, `kd` and the columns of `MAPS`, each of shape `(p d,)`.
    """
    gains = np.meshgrid(kp, kd, indexing="ij")
    values = {name: np.asarray(getattr(found, field)).ravel() for name, (field, _, _) in MAPS.items()}
    return {"kp": gains[0].ravel(), "kd": gains[1].ravel(), **values}


def draw_maps(kp: Float[np.ndarray, " p"], kd: Float[np.ndarray, " d"], found: Response, title: str) -> Figure:
    """Maps of a sweep over both gains; grey where the value is infinite (never settled).

    Args:
        kp: proportional gains [V/rad], shape `(p,)`.
        kd: derivative gains [V s/rad], shape `(d,)`.
        found: responses, fields of shape `(p, d)`.
        title: what stands above the figure.

    Returns:
        A figure with one panel for each entry of `MAPS`.
    """
    figure = Figure(figsize=(3.1 * len(MAPS), 3.2), layout="constrained")
    axes = figure.subplots(1, len(MAPS), sharey=True)
    for ax, (field, label, factor) in zip(axes, MAPS.values(), strict=True):
        value = factor * np.asarray(getattr(found, field))
        value = np.abs(value) if field == "error" else value
        ax.set_facecolor(NEVER)
        shown = np.where(np.isfinite(value), value, np.nan).T
        if np.isfinite(shown).any():
            top = float(np.nanmax(shown)) or 1.0
            figure.colorbar(_map(ax, kp, kd, shown, cmap="viridis", vmin=0.0, vmax=top), ax=ax)
        else:
            ax.text(0.5, 0.5, "never", transform=ax.transAxes, ha="center", va="center")
            ax.plot(kp[[0, -1]], kd[[0, -1]], alpha=0.0)
        ax.set(xlabel="$K_p$ [V/rad]", title=label)
        ax.title.set_fontsize(9)
    axes[0].set_ylabel("$K_d$ [V s/rad]")
    figure.suptitle(title, fontsize=10)
    return figure


def course_columns(found: Trajectory) -> dict[str, np.ndarray]:
    """Columns of a manoeuvre in SI units.

    Args:
        found: the manoeuvre at its times `(t,)`.

    Returns:
        Time, command, angle, rates and current by the columns' names in a log, each of shape `(t,)`.
    """
    names = ("time_s", "voltage_V", "yaw_rad", "yaw_rad_s", "wheel_rad_s", "current_A")
    values = (found.time, found.command, found.angle, found.rate, found.wheel, found.current)
    return dict(zip(names, (np.asarray(v) for v in values), strict=True))


def draw_courses(courses: Mapping[str, Trajectory], title: str) -> Figure:
    """Up to three manoeuvres over time, one line each.

    Args:
        courses: manoeuvres by what the legend calls them.
        title: what stands above the figure.

    Returns:
        A figure with angle, wheel rate, current and voltage below each other.
    """
    figure = Figure(figsize=(6.5, 7.0), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True)
    shown = (
        ("angle", "yaw ψ [°]", 180.0 / np.pi),
        ("wheel", "wheel rate Ω [rad/s]", 1.0),
        ("current", "current i [A]", 1.0),
        ("command", "voltage V [V]", 1.0),
    )
    for (name, found), color in zip(courses.items(), (AFTER, BEFORE, "#444444"), strict=False):
        for ax, (field, _, factor) in zip(axes, shown, strict=True):
            ax.plot(np.asarray(found.time), factor * np.asarray(getattr(found, field)), color=color, label=name)
    for ax, (_, label, _) in zip(axes, shown, strict=True):
        ax.set_ylabel(label)
        ax.axhline(0.0, color=NEVER, lw=0.7, zorder=0)
    axes[0].legend(frameon=False, fontsize=8)
    axes[0].set_title(title, fontsize=10)
    axes[-1].set_xlabel("time [s]")
    return figure


def size_columns(ring: Ring, found: WheelBudget) -> dict[str, np.ndarray]:
    """Columns of wheels and what they can do, one entry for each wheel.

    Args:
        ring: wheels over outer radius and thickness, shape `(r, d)` when broadcast.
        found: what these wheels can do.

    Returns:
        Sizes, mass, inertia, momentum, time of the slew [SI] and the name of the limit that binds, each of shape `(r d,)`.
    """
    shape = np.shape(found.time)
    columns = {
        "radius_m": ring.outer,
        "thickness_m": ring.thickness,
        "mass_kg": ring.mass,
        "inertia_kg_m2": ring.inertia,
        "momentum_N_m_s": found.momentum,
        "time_s": found.time,
    }
    values = {name: np.broadcast_to(value, shape).ravel() for name, value in columns.items()}
    return values | {"limit": np.array([LIMITS[k] for k in found.limit.ravel()])}


def draw_sizes(ring: Ring, found: WheelBudget, seconds: float, title: str) -> Figure:
    """Time of the fastest slew, and the limit that binds, over radius and thickness.

    Args:
        ring: wheels over outer radius and thickness, shape `(r, d)` when broadcast.
        found: what these wheels can do.
        seconds: wanted time [s], drawn as a line.
        title: what stands above the figure.

    Returns:
        A figure with two panels.
    """
    figure = Figure(figsize=(8.5, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    x, y = 1e3 * np.ravel(ring.outer), 1e3 * np.ravel(ring.thickness)
    time = np.where(np.isfinite(found.time), found.time, np.nan).T
    left.set_facecolor(NEVER)
    figure.colorbar(_map(left, x, y, time, cmap="viridis_r"), ax=left)
    if min(time.shape) > 1 and np.nanmin(time, initial=np.inf) < seconds < np.nanmax(time, initial=0.0):
        left.contour(x, y, time, [seconds], colors=[BEFORE])
    left.set(xlabel="outer radius [mm]", ylabel="thickness [mm]", title="fastest slew [s]; grey: never")
    cmap = matplotlib.colormaps["Set2"].resampled(len(LIMITS))
    shown = _map(right, x, y, found.limit.T, cmap=cmap, vmin=-0.5, vmax=len(LIMITS) - 0.5)
    figure.colorbar(shown, ax=right, ticks=range(len(LIMITS))).ax.set_yticklabels(LIMITS)
    right.set(xlabel="outer radius [mm]", title="limit that binds")
    figure.suptitle(title, fontsize=10)
    return figure
