"""What may be asked of a loop's poles: a region of the continuous loop, or of the loop as it runs."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from rwjax.control.closed_loop import Clockwork
from rwjax.control.linear import linearised, transfer
from rwjax.control.margins import margins_over, moduli_over
from rwjax.control.region import Region, pd_region, share_of_plants, share_of_sampled, stable_sampled
from rwjax.control.running import running_loops, side_by_side
from rwjax.rig import Rig


class Continuous(NamedTuple):
    """Every pole of the continuous loop left of `-sigma` [1/s] and with a `damping` ratio of at least this; the axis held at an
    `angle` [rad]. Delays are left out."""

    sigma: float
    damping: float = 0.0
    angle: float = 0.0

    def region(self, rig: Rig, kp: np.ndarray, kd: np.ndarray) -> Region:
        """The pairs of PD gains that do it."""
        return pd_region(rig, kp, kd, self.sigma, self.angle, self.damping)

    def share(self, rig: Rig, thetas: Float[np.ndarray, "k p"], kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
        """Share `(p, d)` of plants, one for each row of `thetas`, for which each pair does it."""
        return share_of_plants(transfer(linearised(rig, self.angle, thetas)), kp, kd, self.sigma, self.damping)

    def margins(self, rig: Rig, found: Region) -> dict[str, np.ndarray]:
        """Margins of the pairs of a region of this rig."""
        return margins_over(found.plant, found.kp, found.kd, found.stable)


class Sampled(NamedTuple):
    r"""Every pole of the loop as it runs with $|z| < e^{-\sigma h}$, h the period: sampled, its derivative filtered over `smooth` [s],
    the command held and late, the rig's own delays included."""

    sigma: float
    clockwork: Clockwork
    smooth: float = 0.0
    angle: float = 0.0

    @property
    def radius(self) -> float:
        return float(np.exp(-self.sigma * self.clockwork.period))

    def region(self, rig: Rig, kp: np.ndarray, kd: np.ndarray) -> Region:
        """The pairs of PD gains that do it."""
        (loop,) = running_loops(rig, self.clockwork, self.smooth, angle=self.angle)
        found = stable_sampled(loop, kp[:, None], kd[None, :], radius=self.radius)
        plant = transfer(linearised(rig, self.angle))
        return Region(kp, kd, self.sigma, found, plant, period=self.clockwork.period)

    def share(self, rig: Rig, thetas: Float[np.ndarray, "k p"], kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
        """Share `(p, d)` of plants, one for each row of `thetas`, for which each pair does it."""
        loops = running_loops(rig, self.clockwork, self.smooth, thetas, self.angle)
        return share_of_sampled(side_by_side(loops), kp, kd, self.radius)

    def margins(self, rig: Rig, found: Region) -> dict[str, np.ndarray]:
        """Modulus margins of the pairs of a region of this rig."""
        (loop,) = running_loops(rig, self.clockwork, self.smooth, angle=self.angle)
        return moduli_over(loop, found.kp, found.kd, found.stable)
