"""Regions of gains: the pairs of PD gains that put every pole of a rig's closed loop where it should be."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from rwjax.control.controller import FILTER_TIME, LoopTiming
from rwjax.control.criteria import ContinuousPoles, SampledPoles
from rwjax.control.linear import linearised
from rwjax.control.transfer import Transfer, transfer
from rwjax.errors import InputError, refuses_other_types
from rwjax.rig.model import Rig


@dataclass(frozen=True, eq=False)
class Region:
    """Pairs of PD gains of a rig that meet a criterion.

    Attributes:
        rig: The rig.
        criterion: What every pole has to do.
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.
        stable: Whether each pair meets the criterion, `(p, d)`.
        plant: Transfer function of the rig, delays left out.
    """

    rig: Rig
    criterion: ContinuousPoles | SampledPoles
    kp: Float[np.ndarray, " p"]
    kd: Float[np.ndarray, " d"]
    stable: Bool[np.ndarray, "p d"]
    plant: Transfer

    @property
    def sigma(self) -> float:
        """Distance of the poles from the imaginary axis that was asked for [1/s]."""
        return self.criterion.sigma

    @property
    def damping(self) -> float:
        """Least damping ratio that was asked for [1]; 0 of a sampled loop."""
        return self.criterion.damping if isinstance(self.criterion, ContinuousPoles) else 0.0

    @property
    def period(self) -> float:
        """Sampling period of the loop [s]; 0 of a continuous one."""
        return self.criterion.timing.period if isinstance(self.criterion, SampledPoles) else 0.0

    @property
    def share(self) -> float:
        """Share of the pairs that meet the criterion [1]."""
        return float(np.mean(self.stable))

    def margins(self) -> dict[str, Float[np.ndarray, "p d"]]:
        """Margins of the pairs in the region that are stable at all, as all are but for a negative `sigma`.

        Returns:
            Maps `(p, d)` by name with no number elsewhere: `modulus` [1]; of a continuous loop also `gain_below` and
            `gain_above` [1], `phase_rad` [rad] and `delay_s` [s].
        """
        return self.criterion.margins(self.rig, self.kp, self.kd, self.stable)

    def slowest(self) -> Float[np.ndarray, "p d"]:
        """How fast the loop is: the largest real part of its poles; of a sampled loop the rate at which its slowest motion grows.

        Returns:
            Map over the gains [1/s], `(p, d)`; negative where the loop is stable.
        """
        return self.criterion.slowest(self.rig, self.kp, self.kd)

    def share_of_plants(self, thetas: Float[np.ndarray, "k n"]) -> Float[np.ndarray, "p d"]:
        """Share of many plants with which each pair meets the criterion.

        Args:
            thetas: Parameter vectors of the rig's structure [SI], one plant for each row, `(k, n)` (`fit_estimate.draw_plants`).

        Returns:
            Share of the plants [1], `(p, d)`.
        """
        return self.criterion.share(self.rig, thetas, self.kp, self.kd)

    def __str__(self) -> str:
        lines = [
            f"PD gains kp {self.kp.min():g} to {self.kp.max():g} V/rad, kd {self.kd.min():g} to {self.kd.max():g} V s/rad:",
            f"  {int(self.stable.sum())} of {self.stable.size} pairs ({100.0 * self.share:.1f} %) {self.criterion.condition}",
        ]
        if self.plant.hidden:
            lines.append("  left out: the conserved momentum's pole at 0, which no gain moves")
        return "\n".join(lines)


@refuses_other_types
def region(
    rig: Rig,
    kp: Float[np.ndarray, " p"],
    kd: Float[np.ndarray, " d"],
    sigma: float = 0.5,
    *,
    damping: float = 0.0,
    angle: float = 0.0,
    timing: LoopTiming | None = None,
    filter_time: float = FILTER_TIME,
) -> Region:
    """Pairs of PD gains that put every pole of a rig's closed loop left of `-sigma`.

    Without `timing` the loop is continuous, and delays are left out. With it the loop is judged as it runs: sampled, its
    command held and delayed, the rig's own delays included.

    Args:
        rig: The rig.
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.
        sigma: Distance of the poles from the imaginary axis [1/s].
        damping: Least damping ratio [1], of the continuous loop only.
        angle: Angle at which the axis is held [rad].
        timing: When a sampled controller reads and acts; None for the continuous loop.
        filter_time: Time constant of the derivative's filter [s], of the sampled loop only.

    Returns:
        The region, which prints itself.

    Raises:
        InputError: For a damping ratio below 0, of 1 or more, or beside a timing, and for no rig; as `linearised` and `sampled_loop` do.

    Source:
        Thesis, Fig. 4.3.
    """
    if not 0.0 <= damping < 1.0:
        raise InputError(f"damping {damping:g}: has to lie between 0 and below 1")
    if timing is None:
        return region_of(rig, ContinuousPoles(sigma, damping, angle), kp, kd)
    if damping > 0.0:
        raise InputError(f"damping {damping:g}: is of the continuous loop; leave it or the timing out")
    return region_of(rig, SampledPoles(sigma, timing, filter_time, angle), kp, kd)


def region_of(rig: Rig, criterion: ContinuousPoles | SampledPoles, kp: np.ndarray, kd: np.ndarray) -> Region:
    """Pairs of PD gains of a rig that meet a criterion.

    Args:
        rig: The rig.
        criterion: What every pole has to do.
        kp: Proportional gains [V/rad], `(p,)`.
        kd: Derivative gains [V s/rad], `(d,)`.

    Returns:
        The region.

    Raises:
        InputError: As the criterion's `holds` does.
    """
    kp, kd = np.asarray(kp, float), np.asarray(kd, float)
    found = criterion.holds(rig, kp, kd)
    return Region(rig, criterion, kp, kd, found, transfer(linearised(rig, criterion.angle)))
