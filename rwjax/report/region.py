"""The region of stabilising gains as a table and a figure."""

import io
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from rwjax.control.region import Region, boundary, real_boundary
from rwjax.report.plots import AFTER, BEFORE

OMEGA = np.geomspace(1e-3, 1e4, 4000)  # rad/s, along the boundary


def table(region: Region) -> str:
    """CSV `kp,kd,stable`, one line for each pair."""
    lines = [
        f"{kp:.10g},{kd:.10g},{int(ok)}"
        for kp, row in zip(region.kp, region.stable, strict=True)
        for kd, ok in zip(region.kd, row, strict=True)
    ]
    return "\n".join(["kp,kd,stable", *lines, ""])


def write_figure(region: Region, path: Path) -> Path:
    """The region over both gains, the D-partition's curves on top."""
    fig, ax = plt.subplots(figsize=(5.5, 4.5), layout="constrained")
    shade = np.where(region.stable.T, 1.0, np.nan)
    if min(region.stable.shape) > 1:
        ax.pcolormesh(region.kp, region.kd, shade, cmap="Blues", vmin=0.0, vmax=2.5, shading="nearest", rasterized=True)
    else:
        kp, kd = np.meshgrid(region.kp, region.kd, indexing="ij")
        ax.plot(kp[region.stable], kd[region.stable], ".", color=AFTER)
    pair = boundary(region.plant, OMEGA, region.sigma)
    ax.plot(*pair, color=AFTER, lw=1.4, label=f"a pair of poles at −{region.sigma:g} ± jω")
    edge = np.array([region.kd.min(), region.kd.max()])
    ax.plot(
        real_boundary(region.plant, edge, region.sigma),
        edge,
        color=BEFORE,
        lw=1.4,
        label=f"a real pole at −{region.sigma:g}",
    )
    for low, high, bound in (
        (region.kp.min(), region.kp.max(), ax.set_xlim),
        (region.kd.min(), region.kd.max(), ax.set_ylim),
    ):
        bound(low, high if high > low else low + 1.0)
    ax.set_xlabel("proportional gain $K_p$ [V/rad]")
    ax.set_ylabel("derivative gain $K_d$ [V s/rad]")
    ax.set_title(
        f"{100.0 * region.share:.1f} % of these gains put every pole left of −{region.sigma:g} 1/s", fontsize=9
    )
    ax.legend(loc="best", fontsize=8, frameon=False)
    buffer = io.BytesIO()
    fig.savefig(buffer, format="png", dpi=130)
    plt.close(fig)
    path.write_bytes(buffer.getvalue())
    return path
