"""What may be asked of a loop's poles: a region of the continuous loop, or of the loop as it runs."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from rwjax.control.closed_loop import LoopTiming
from rwjax.control.linear import linearised, transfer
from rwjax.control.margins import margins_over, moduli_over
from rwjax.control.region import (
    Loop,
    Region,
    pd_loop,
    pd_region,
    share_of_plants,
    share_of_sampled,
    stable,
    stable_sampled,
)
from rwjax.control.sampled_loop import running_loops, side_by_side
from rwjax.rig.model import Rig


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
        """Margins of the pairs of a region of this rig that are stable at all, as all are but for a negative `sigma`."""
        where = found.stable & stable(pd_loop(found.plant), found.kp[:, None], found.kd[None, :])
        return margins_over(found.plant, found.kp, found.kd, where)


class Sampled(NamedTuple):
    r"""Every pole of the loop as it runs with $|z| < e^{-\sigma h}$, h the period: sampled, its derivative filtered over `smooth` [s],
    the command held and late, the rig's own delays included."""

    sigma: float
    clockwork: LoopTiming
    smooth: float = 0.0
    angle: float = 0.0

    @property
    def radius(self) -> float:
        return float(np.exp(-self.sigma * self.clockwork.period))

    def region(self, rig: Rig, kp: np.ndarray, kd: np.ndarray) -> Region:
        """The pairs of PD gains that do it."""
        among = np.zeros((len(kp), len(kd)), bool)
        for smooth, at in self._filtered(kd):
            (loop,) = self._loops(rig, smooth)
            among[:, at] = stable_sampled(loop, kp[:, None], kd[None, at], radius=self.radius)
        plant = transfer(linearised(rig, self.angle))
        return Region(kp, kd, self.sigma, among, plant, period=self.clockwork.period)

    def share(self, rig: Rig, thetas: Float[np.ndarray, "k p"], kp: np.ndarray, kd: np.ndarray) -> np.ndarray:
        """Share `(p, d)` of plants, one for each row of `thetas`, for which each pair does it."""
        among = np.zeros((len(kp), len(kd)))
        for smooth, at in self._filtered(kd):
            loops = side_by_side(self._loops(rig, smooth, thetas))
            among[:, at] = share_of_sampled(loops, kp, kd[at], self.radius)
        return among

    def margins(self, rig: Rig, found: Region) -> dict[str, np.ndarray]:
        """Modulus margins of the pairs of a region of this rig that are stable at all."""
        (loop,) = self._loops(rig, self.smooth)
        where = found.stable & stable_sampled(loop, found.kp[:, None], found.kd[None, :])
        return moduli_over(loop, found.kp, found.kd, where)

    def _filtered(self, kd: np.ndarray) -> list[tuple[float, np.ndarray]]:
        """Time constants of the filter, and which of the gains have it: without a derivative its pole is none of the loop."""
        split = [(self.smooth, kd != 0.0), (0.0, kd == 0.0)]
        return [(smooth, at) for smooth, at in split if at.any()]

    def _loops(self, rig: Rig, smooth: float, thetas: Float[np.ndarray, "k p"] | None = None) -> list[Loop]:
        return running_loops(rig, self.clockwork, smooth, thetas, self.angle)
