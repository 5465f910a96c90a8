"""The region of stabilising gains, as columns of a table and a figure."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rwjax.control.boundary import boundary, real_boundary
from rwjax.control.region import Region
from rwjax.report.style import AFTER, BEFORE

OMEGA = np.geomspace(1e-3, 1e4, 4000)  # rad/s, along the boundary


def region_columns(region: Region, beside: Mapping[str, Float[np.ndarray, "p d"]]) -> dict[str, np.ndarray]:
    """Columns of a region, one entry for each pair of gains.

    Args:
        region: the gains `(p,)` and `(d,)`, and which pairs are stable.
        beside: further columns by name, shape `(p, d)`.

    Returns:
        `kp`, `kd`, `stable` (0 or 1) and the further columns, each of shape `(p d,)`.
    """
    kp, kd = np.meshgrid(region.kp, region.kd, indexing="ij")
    more = {name.replace(" ", "_"): value.ravel() for name, value in beside.items()}
    return {"kp": kp.ravel(), "kd": kd.ravel(), "stable": region.stable.ravel().astype(int), **more}


def draw_region(region: Region, beside: Mapping[str, Float[np.ndarray, "p d"]]) -> Figure:
    """The region over both gains, with the D-partition's curves where the loop is continuous.

    Args:
        region: the gains `(p,)` and `(d,)`, and which pairs are stable.
        beside: shares from 0 to 1 by name, shape `(p, d)`; where they fall below 1 a dotted line is drawn.

    Returns:
        A figure with one panel.
    """
    figure = Figure(figsize=(5.5, 4.5), layout="constrained")
    ax = figure.subplots()
    _shade(ax, region, beside)
    if region.period == 0.0:
        _edges(ax, region)
    for low, high, bound in (
        (region.kp.min(), region.kp.max(), ax.set_xlim),
        (region.kd.min(), region.kd.max(), ax.set_ylim),
    ):
        bound(low, high if high > low else low + 1.0)
    ax.set_xlabel("proportional gain $K_p$ [V/rad]")
    ax.set_ylabel("derivative gain $K_d$ [V s/rad]")
    ax.set_title(
        f"{100.0 * region.share:.1f} % of these gains {region.criterion.condition.replace('-', '−')}", fontsize=9
    )
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="best", fontsize=8, frameon=False)
    return figure


def _shade(ax: Axes, region: Region, beside: Mapping[str, np.ndarray]) -> None:
    """The stable pairs as an area, with dotted lines beside it; as points where one gain has one value only."""
    if min(region.stable.shape) == 1:
        kp, kd = np.meshgrid(region.kp, region.kd, indexing="ij")
        ax.plot(kp[region.stable], kd[region.stable], ".", color=AFTER)
        return
    shade = np.where(region.stable.T, 1.0, np.nan)
    ax.pcolormesh(region.kp, region.kd, shade, cmap="Blues", vmin=0.0, vmax=2.5, shading="nearest", rasterized=True)
    for (name, value), color in zip(beside.items(), ("#222222", "#1b7837"), strict=False):
        if value.min() < 1.0 == value.max():
            ax.contour(region.kp, region.kd, value.T, [0.999], colors=[color], linestyles=":")
            ax.plot([], [], ":", color=color, label=name if name != "share of plants" else "all plants drawn")


def _edges(ax: Axes, region: Region) -> None:
    """Gains for which a pole, or a pair of poles, lies on the edge of the wanted half plane."""
    edge = f"{0.0 - region.sigma:g}".replace("-", "−")
    pair = boundary(region.plant, OMEGA, region.sigma)
    ax.plot(*pair, color=AFTER, lw=1.4, label=f"a pair of poles at {edge} ± jω")
    ends = np.array([region.kd.min(), region.kd.max()])
    line = real_boundary(region.plant, ends, region.sigma)
    ax.plot(line, ends, color=BEFORE, lw=1.4, label=f"a real pole at {edge}")
