"""Every effect: a motion known in closed form, from the modules in `tests/effects/motions`."""

from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest

from tests.effects import motions
from tests.effects.known import Known
from tests.effects.rigs import HERE, go

MOTIONS = [
    known
    for module in iter_modules(motions.__path__)
    for known in import_module(f"{motions.__name__}.{module.name}").MOTIONS
]


@pytest.mark.parametrize("known", MOTIONS, ids=lambda known: known.effect)
def test_the_motion_is_that_of_the_closed_form(known: Known) -> None:
    y = go(known.rig, known.u, known.start, {known.effect: known.given})
    error = np.abs(y[known.output] - known.exact(y))[known.when]
    assert np.max(error) < known.within * max(1.0, float(np.max(np.abs(y[known.output]))))


def test_every_effect_has_a_known_motion() -> None:
    assert {known.effect for known in MOTIONS} == {effect.name for effect in HERE}
