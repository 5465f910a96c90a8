"""The region of stabilising gains as a table, a figure and a sentence."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from rwjax.control.boundary import boundary, real_boundary
from rwjax.control.region import Region
from rwjax.report.plots import AFTER, BEFORE

OMEGA = np.geomspace(1e-3, 1e4, 4000)  # rad/s, along the boundary


def columns(region: Region, beside: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """`kp`, `kd`, `stable`, one entry for each pair, and what stands beside it."""
    kp, kd = np.meshgrid(region.kp, region.kd, indexing="ij")
    more = {name.replace(" ", "_"): value.ravel() for name, value in beside.items()}
    return {"kp": kp.ravel(), "kd": kd.ravel(), "stable": region.stable.ravel().astype(int), **more}


def draw_region(region: Region, beside: Mapping[str, np.ndarray]) -> Figure:
    """The region over both gains, the D-partition's curves of a continuous loop on top, the edge of what stands beside it dotted."""
    fig, ax = plt.subplots(figsize=(5.5, 4.5), layout="constrained")
    shade = np.where(region.stable.T, 1.0, np.nan)
    if min(region.stable.shape) > 1:
        ax.pcolormesh(region.kp, region.kd, shade, cmap="Blues", vmin=0.0, vmax=2.5, shading="nearest", rasterized=True)
        for (name, value), color in zip(beside.items(), ("#222222", "#1b7837"), strict=False):
            if value.min() < 1.0 == value.max():
                ax.contour(region.kp, region.kd, value.T, [0.999], colors=[color], linestyles=":")
                ax.plot([], [], ":", color=color, label=name if name != "share of plants" else "all plants drawn")
    else:
        kp, kd = np.meshgrid(region.kp, region.kd, indexing="ij")
        ax.plot(kp[region.stable], kd[region.stable], ".", color=AFTER)
    if region.period == 0.0:
        edge = f"{0.0 - region.sigma:g}".replace("-", "−")
        pair = boundary(region.plant, OMEGA, region.sigma)
        ax.plot(*pair, color=AFTER, lw=1.4, label=f"a pair of poles at {edge} ± jω")
        ends = np.array([region.kd.min(), region.kd.max()])
        line = real_boundary(region.plant, ends, region.sigma)
        ax.plot(line, ends, color=BEFORE, lw=1.4, label=f"a real pole at {edge}")
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
    return fig
