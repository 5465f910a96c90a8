"""Criteria for the poles of a closed loop: those of the continuous loop, or those of the loop as it runs."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from rwjax.control.controller import LoopTiming
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import LoopPolynomial, pd_loop
from rwjax.control.margins import margins_over, moduli_over
from rwjax.control.over_gains import gain_grid, over_gains
from rwjax.control.poles import largest_modulus, slowest_pole
from rwjax.control.sampled_loop import SampledLaw, sampled_loops, stacked_loops
from rwjax.control.stability import share_of_plants, share_of_sampled, stable, stable_sampled
from rwjax.control.transfer import controller_form, transfer
from rwjax.rig.model import Rig


class ContinuousPoles(NamedTuple):
    """Every pole of the continuous loop lies left of `-sigma` and is damped enough; delays are left out.

    Attributes:
        sigma: Distance of the poles from the imaginary axis [1/s].
        damping: Least damping ratio [1].
        angle: Angle at which the axis is held [rad].
    """

    sigma: float
    damping: float = 0.0
    angle: float = 0.0

    @property
    def condition(self) -> str:
        """What gains that meet the criterion do, in words."""
        damped = f", with a damping ratio of {self.damping:g} or more" if self.damping > 0.0 else ""
        return f"put every pole left of {0.0 - self.sigma:g} 1/s{damped}"

    def holds(self, rig: Rig, kp: np.ndarray, kd: np.ndarray) -> Bool[np.ndarray, "p d"]:
        """Which pairs of PD gains meet the criterion.

        Args:
            rig: The rig.
            kp: Proportional gains [V/rad], `(p,)`.
            kd: Derivative gains [V s/rad], `(d,)`.

        Returns:
            Whether each pair does, `(p, d)`.

        Raises:
            InputError: As `linearised` does.
        """
        loop = pd_loop(transfer(linearised(rig, self.angle)))
        return stable(loop, kp[:, None], kd[None, :], sigma=self.sigma, damping=self.damping)

    def share(
        self, rig: Rig, thetas: Float[np.ndarray, "k n"], kp: np.ndarray, kd: np.ndarray
    ) -> Float[np.ndarray, "p d"]:
        """Share of plants [1] with which each pair of PD gains meets the criterion.

        Args:
            rig: The rig whose structure the plants have.
            thetas: Parameter vectors [SI], one plant for each row, `(k, n)`.
            kp: Proportional gains [V/rad], `(p,)`.
            kd: Derivative gains [V s/rad], `(d,)`.

        Returns:
            Share of the plants [1], `(p, d)`.
        """
        return share_of_plants(transfer(linearised(rig, self.angle, thetas)), kp, kd, self.sigma, self.damping)

    def margins(
        self, rig: Rig, kp: np.ndarray, kd: np.ndarray, where: Bool[np.ndarray, "p d"]
    ) -> dict[str, Float[np.ndarray, "p d"]]:
        """Margins of some pairs of PD gains, of those that are stable at all.

        Args:
            rig: The rig.
            kp: Proportional gains [V/rad], `(p,)`.
            kd: Derivative gains [V s/rad], `(d,)`.
            where: Pairs whose margins are wanted, `(p, d)`.

        Returns:
            Maps `(p, d)` by name, as `margins_over` gives them.
        """
        plant = transfer(linearised(rig, self.angle))
        return margins_over(plant, kp, kd, where & stable(pd_loop(plant), kp[:, None], kd[None, :]))

    def slowest(self, rig: Rig, kp: np.ndarray, kd: np.ndarray) -> Float[np.ndarray, "p d"]:
        """Real part of the slowest pole at each pair of PD gains.

        Args:
            rig: The rig.
            kp: Proportional gains [V/rad], `(p,)`.
            kd: Derivative gains [V s/rad], `(d,)`.

        Returns:
            The real parts [1/s], `(p, d)`.
        """
        plant = controller_form(transfer(linearised(rig, self.angle)))
        return np.asarray(over_gains(slowest_pole, gain_grid(kp, kd), plant))


class SampledPoles(NamedTuple):
    r"""Every pole of the loop as it runs has $|z| < e^{-\sigma h}$, h the sampling period.

    The loop is sampled, its derivative filtered, its command held and delayed, the rig's own delays included.

    Attributes:
        sigma: Rate at which every motion of the loop dies away at least [1/s].
        timing: When the controller reads and acts, without the rig's own delays.
        filter_time: Time constant of the derivative's filter [s].
        angle: Angle at which the axis is held [rad].
    """

    sigma: float
    timing: LoopTiming
    filter_time: float = 0.0
    angle: float = 0.0

    @property
    def radius(self) -> float:
        """Radius of the circle in the z plane within which the poles have to lie [1]."""
        return float(np.exp(-self.sigma * self.timing.period))

    @property
    def condition(self) -> str:
        """What gains that meet the criterion do, in words."""
        return f"put every pole of the loop sampled every {self.timing.period:g} s within |z| = exp({0.0 - self.sigma:g} h)"

    def holds(self, rig: Rig, kp: np.ndarray, kd: np.ndarray) -> Bool[np.ndarray, "p d"]:
        """Which pairs of PD gains meet the criterion.

        Args:
            rig: The rig.
            kp: Proportional gains [V/rad], `(p,)`.
            kd: Derivative gains [V s/rad], `(d,)`.

        Returns:
            Whether each pair does, `(p, d)`.

        Raises:
            InputError: As `sampled_loops` does.
        """
        found = np.zeros((len(kp), len(kd)), bool)
        for filter_time, at in self._filters(kd):
            (loop,) = self._loops(rig, filter_time)
            found[:, at] = stable_sampled(loop, kp[:, None], kd[None, at], radius=self.radius)
        return found

    def share(
        self, rig: Rig, thetas: Float[np.ndarray, "k n"], kp: np.ndarray, kd: np.ndarray
    ) -> Float[np.ndarray, "p d"]:
        """Share of plants [1] with which each pair of PD gains meets the criterion.

        Args:
            rig: The rig whose structure the plants have.
            thetas: Parameter vectors [SI], one plant for each row, `(k, n)`.
            kp: Proportional gains [V/rad], `(p,)`.
            kd: Derivative gains [V s/rad], `(d,)`.

        Returns:
            Share of the plants [1], `(p, d)`.
        """
        found = np.zeros((len(kp), len(kd)))
        for filter_time, at in self._filters(kd):
            loops = stacked_loops(self._loops(rig, filter_time, thetas))
            found[:, at] = share_of_sampled(loops, kp, kd[at], self.radius)
        return found

    def margins(
        self, rig: Rig, kp: np.ndarray, kd: np.ndarray, where: Bool[np.ndarray, "p d"]
    ) -> dict[str, Float[np.ndarray, "p d"]]:
        """Modulus margins of some pairs of PD gains, of those that are stable at all.

        Args:
            rig: The rig.
            kp: Proportional gains [V/rad], `(p,)`.
            kd: Derivative gains [V s/rad], `(d,)`.
            where: Pairs whose margins are wanted, `(p, d)`.

        Returns:
            Map `(p, d)` by name, as `moduli_over` gives it.
        """
        (loop,) = self._loops(rig, self.filter_time)
        return moduli_over(loop, kp, kd, where & stable_sampled(loop, kp[:, None], kd[None, :]))

    def slowest(self, rig: Rig, kp: np.ndarray, kd: np.ndarray) -> Float[np.ndarray, "p d"]:
        """Rate at which the slowest motion grows at each pair of PD gains.

        Args:
            rig: The rig.
            kp: Proportional gains [V/rad], `(p,)`.
            kd: Derivative gains [V s/rad], `(d,)`.

        Returns:
            The rates [1/s], `(p, d)`.
        """
        found = np.zeros((len(kp), len(kd)))
        for filter_time, at in self._filters(kd):
            (loop,) = self._loops(rig, filter_time)
            found[:, at] = np.log(over_gains(largest_modulus, gain_grid(kp, kd[at]), loop)) / self.timing.period
        return found

    def _filters(self, kd: np.ndarray) -> list[tuple[float, np.ndarray]]:
        """Filter times [s], and which gains have them: without a derivative the filter's pole is none of the loop."""
        split = [(self.filter_time, kd != 0.0), (0.0, kd == 0.0)]
        return [(filter_time, at) for filter_time, at in split if at.any()]

    def _loops(
        self, rig: Rig, filter_time: float, thetas: Float[np.ndarray, "k p"] | None = None
    ) -> list[LoopPolynomial]:
        """Loops of the rig, or of one plant for each row of `thetas`."""
        return sampled_loops(rig, SampledLaw(self.timing, filter_time), thetas, self.angle)
