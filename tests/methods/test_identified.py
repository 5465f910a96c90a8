"""What a method returns, and what it says of a rig file that it does not use."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.errors import RigError
from rwjax.methods.identified import Identified, estimated, left_out, undelayed
from tests.systems import platform

RIG = platform(free='"axis.inertia", "axis.friction.viscous"')


def test_estimates_stand_in_the_rig_with_the_standard_errors_that_are_finite() -> None:
    names = ("axis.inertia", "axis.friction.viscous")
    found = Identified(estimated(RIG, names, np.array([0.2, 0.03]), np.array([0.01, np.inf])), ("so",))
    assert found.rig.values["axis.inertia"] == 0.2 and found.rig.values["axis.friction.viscous"] == 0.03
    assert found.rig.standard_error == {"axis.inertia": 0.01}
    assert found.interval == {"axis.inertia": pytest.approx((0.2 - 0.0196, 0.2 + 0.0196))}
    numbers = found.json()["numbers"]
    assert numbers["axis.friction.viscous"] == {"value": 0.03, "standard_error": None}
    assert found.json()["notes"] == ["so"] and found.of_runs() == []


def test_a_note_names_the_keys_that_a_method_does_not_use() -> None:
    rig = replace(RIG, prior={"axis.inertia": (0.1, 0.01)}, per_run=("axis.inertia",))
    assert left_out(rig, prior=False) == ("does not know fit.prior and fit.per_run of the rig file",)
    assert left_out(rig, prior=True) == ("does not know fit.per_run of the rig file",)
    assert left_out(RIG, prior=False) == ()


def test_late_readings_are_refused() -> None:
    undelayed(RIG, "method")
    with pytest.raises(RigError, match="has sensor.delay; the method takes readings to be at once"):
        undelayed(replace(RIG, effects={"sensor.delay": {"tau": 0.05}}), "method")
