"""The estimates of a corrected rig, with their covariance, as programs read them."""

from typing import NamedTuple

import numpy as np

from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.uncertainty import Uncertainty
from rwjax.rig.model import Rig


class Estimates(NamedTuple):
    """Estimates that the logs tell.

    Attributes:
        numbers: each with its standard error [SI], by name.
        covariance: of the same numbers in the same order (numbers, numbers) [SI²].
    """

    numbers: dict[str, tuple[float, float]]
    covariance: np.ndarray

    def json(self) -> dict:
        """The estimates under the keys of `rwjax fit --json`.

        Returns:
            Plain objects.
        """
        return {
            "numbers": {
                name: {"value": value, "standard_error": error} for name, (value, error) in self.numbers.items()
            },
            "covariance_of": list(self.numbers),
            "covariance": self.covariance.tolist(),
        }


def estimates(found: Fit, spread: Uncertainty, corrected: Rig) -> Estimates:
    """What a fit tells of a corrected rig, as that holds it.

    Args:
        found: the fit of the named hypothesis.
        spread: its uncertainty.
        corrected: the rig with what is named; a number that ran away has no standard error there, and is left out.

    Returns:
        The estimates.
    """
    fitted, error = found.numbers(), spread.standard_error
    told = [
        name
        for name in spread.names
        if np.isfinite(error[name]) and (name in corrected.standard_error or " in " in name)
    ]
    return Estimates({name: (corrected.values.get(name, fitted[name]), error[name]) for name in told}, spread.of(told))
