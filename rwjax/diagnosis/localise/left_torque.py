r"""Left torque: what the claimed effects leave, as coloured noise for those who randomise their simulators.

The torque is read off the logs like the missing one, with the named effects in the plant. Its power beyond that of the fitted rig's own
readings is its spectrum. Of a first-order Gauss-Markov process with standard deviation $\sigma$ and correlation time $\tau$, whose
density is $4\sigma^2\tau / (1 + (2\pi f\tau)^2)$, half of the power lies below $f = 1/(2\pi\tau)$. That gives $\tau$.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rwjax.diagnosis.localise.own_noise import above
from rwjax.diagnosis.localise.spectrum import OctavePower
from rwjax.diagnosis.localise.where import Missing, power_of, tells_torque
from rwjax.diagnosis.settings import LocalisationSettings
from rwjax.fitting.multiple_shooting import Fit


class LeftTorque(NamedTuple):
    """Torque that a fitted rig leaves, as coloured noise.

    Attributes:
        rms: its standard deviation [N m].
        correlation_time: its correlation time [s]; None where nothing is left, or where half of it is slower than the runs can tell.
        edges: edges of octaves (o + 1,) [Hz].
        density: its one-sided power spectral density in each of them (o,) [N² m²/Hz].
    """

    rms: float
    correlation_time: float | None
    edges: np.ndarray
    density: np.ndarray

    def json(self) -> dict:
        """What `diagnosis.json` holds.

        Returns:
            Plain objects.
        """
        octaves = zip(self.edges[:-1], self.edges[1:], self.density, strict=True)
        return {
            "rms_Nm": self.rms,
            "correlation_time_s": self.correlation_time,
            "spectrum": [
                {"from_hz": float(low), "to_hz": float(high), "density_N2m2_per_Hz": float(density)}
                for low, high, density in octaves
            ],
        }


def left_torque(fitted: Fit, missing: Sequence[Missing], limits: LocalisationSettings) -> LeftTorque | None:
    """Torque that a fitted rig leaves of some logs.

    Args:
        fitted: the fit with the claimed effects.
        missing: what it misses of the logs, with draws.
        limits: limits of the localisation.

    Returns:
        The torque; None where the motion does not tell it (`tells_torque`).
    """
    if not missing or not tells_torque(fitted.problem.structure):
        return None
    return coloured(power_of(fitted, missing, limits.regimes.window), limits.by_chance)


def coloured(power: OctavePower, by_chance: float) -> LeftTorque:
    """Coloured noise of a power by octave, of which only octaves count that chance would hardly give.

    Args:
        power: the power, with that of draws of the rig's own noise.
        by_chance: probability by chance [1] below which an octave counts.

    Returns:
        The noise.
    """
    told = [above(float(octave[0]), octave[1:]) < by_chance for octave in power.power]
    variance, width = np.where(told, power.beyond, 0.0) / np.maximum(power.duration, 1e-300), np.diff(power.edges)
    whole = float(np.sum(variance))
    if whole == 0.0:
        return LeftTorque(0.0, None, power.edges, variance / width)
    below = np.concatenate([[0.0], np.cumsum(variance)]) / whole
    half = float(np.interp(0.5, below, power.edges))
    slow = half < power.edges[1]
    return LeftTorque(
        float(np.sqrt(whole)), None if slow else 1.0 / (2.0 * np.pi * half), power.edges, variance / width
    )
