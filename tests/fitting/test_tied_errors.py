"""Standard errors of numbers that follow from others."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import fit
from rwjax.fitting.tied_errors import tied_errors
from tests.diagnosis.simulated import COMMAND, TIME
from tests.systems import platform, record, run


def test_they_are_those_of_the_linear_formula() -> None:
    tied, values = (
        {"y": "2 * a - b", "z": "y ** 2", "w": "c"},
        {"a": 3.0, "b": 1.0, "c": 1.0, "y": 5.0, "z": 25.0, "w": 1.0},
    )
    C = np.array([[0.04, 0.01], [0.01, 0.09]])
    found = tied_errors(tied, values, ("a", "b"), C)
    assert found == pytest.approx({"y": np.sqrt(0.21), "z": 10.0 * np.sqrt(0.21)}, rel=1e-8)
    assert tied_errors(tied, values, ("a", "b"), np.diag([np.inf, 0.09])) == {}


@pytest.mark.slow
def test_a_fit_moves_the_number_with_those_that_it_follows_from() -> None:
    truth = platform("viscous = 0.02").with_values({"axis.inertia": 0.08, "axis.friction.viscous": 0.04})
    y = run(truth, record(TIME, COMMAND), {})["yaw_rad"]
    log = record(TIME, COMMAND, {"yaw_rad": y + np.random.default_rng(0).normal(0.0, 2e-4, len(y))})
    rig = replace(platform("viscous = 0.02"), tied={"axis.friction.viscous": "axis.inertia / 2"}).with_values({})
    found = fit(rig, [log])
    I, b = (found.rig.values[name] for name in ("axis.inertia", "axis.friction.viscous"))
    assert I == pytest.approx(0.08, rel=1e-3) and b == I / 2 and not found.notes
    errors = found.rig.standard_error
    assert errors["axis.friction.viscous"] == pytest.approx(errors["axis.inertia"] / 2, rel=1e-6)
    assert found.json()["numbers"]["axis.friction.viscous"]["value"] == b
