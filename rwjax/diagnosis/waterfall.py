"""Waterfall: the held-out error and the fitted numbers as one effect after the other is added."""

from dataclasses import dataclass

import numpy as np

from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.uncertainty import uncertainty
from rwjax.rig.model import Rig


@dataclass(frozen=True)
class Rung:
    """One step of the waterfall.

    Attributes:
        names: what has been added so far.
        rms: RMS error of the headline signal on held-out logs [SI].
        numbers: the rig's free numbers, each with its standard error [SI].
        drift: their shift against the rig as it is, in standard errors [1] and in percent.
        own: the numbers of what has been added, each with its standard error [SI].
    """

    names: tuple[str, ...]
    rms: float
    numbers: dict[str, tuple[float, float]]
    drift: dict[str, tuple[float, float]]
    own: dict[str, tuple[float, float]]


def rung(
    rig: Rig, names: tuple[str, ...], fitted: Fit, rms: float, base: dict[str, tuple[float, float]] | None = None
) -> Rung:
    """One step of the waterfall from its fit.

    Args:
        rig: the rig as it is.
        names: what has been added so far.
        fitted: the fit with these names.
        rms: its RMS error of the headline signal on held-out logs [SI].
        base: the rig's free numbers as fitted without any name, each with its standard error [SI]; those of this fit where none
            are given.

    Returns:
        The step.
    """
    error, value = uncertainty(fitted).standard_error, fitted.numbers()
    numbers = {name: (value[name], error.get(name, np.inf)) for name in rig.free}
    own = {name: (value[name], error[name]) for name in fitted.free if name not in numbers}
    base = numbers if base is None else base
    drift = {}
    for name, (old, old_error) in base.items():
        new, new_error = numbers[name]
        scale = float(np.hypot(old_error, new_error))
        drift[name] = (
            (new - old) / scale if np.isfinite(scale) and scale > 0.0 else np.nan,
            100.0 * (new - old) / abs(old) if old else np.nan,
        )
    return Rung(names, rms, numbers, drift, own)
