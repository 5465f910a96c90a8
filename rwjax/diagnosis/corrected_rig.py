"""Corrected rig: the rig file with what the diagnosis has named, at its estimates."""

from dataclasses import replace

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.effects.library import BY_NAME
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.tied_errors import tied_errors
from rwjax.fitting.uncertainty import Uncertainty
from rwjax.plant.from_rig import rig_with
from rwjax.rig.model import Rig


def corrected_rig(rig: Rig, hypothesis: Hypothesis, fitted: Fit, spread: Uncertainty) -> Rig:
    """The rig with a hypothesis's effects and numbers at their estimates.

    A fit of it estimates the same numbers, but for those of an effect that the logs do not determine.

    Args:
        rig: the rig as it is.
        hypothesis: what the diagnosis has named.
        fitted: its fit.
        spread: the fit's uncertainty.

    Returns:
        The rig, with standard errors where they are finite.
    """
    kept = fitted.problem.structure._replace(
        effects=tuple(e for e in BY_NAME if e in (*rig.effects, *hypothesis.effects))
    )
    values = fitted.numbers()
    theta = np.array([values[name] for name in kept.names])
    errors = {name: error for name, error in spread.standard_error.items() if np.isfinite(error)}
    free = (*rig.free, *(name for name in errors if name in kept.names and name not in rig.free))
    errors |= tied_errors(rig.tied, values, spread.names, spread.covariance)
    return replace(rig_with(rig, kept, theta, errors), free=free)
