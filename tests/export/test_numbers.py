"""A rig as JSON."""

import json
from dataclasses import replace
from math import inf

from rwjax.export.numbers import numbers
from tests.systems import platform


def test_every_number_stands_there_with_its_unit_and_its_standard_error() -> None:
    rig = replace(
        platform("viscous = 0.02"),
        effects={"axis.coulomb": {"M_c": 0.03}},
        standard_error={"axis.inertia": 0.001, "axis.coulomb.M_c": inf},
    )
    found = json.loads(numbers(rig).text)
    assert found["numbers"]["axis.inertia"] == {"value": 0.1, "unit": "kg m2", "standard_error": 0.001}
    assert found["numbers"]["drive.gain"] == {"value": 0.4, "unit": "N m/V"}
    assert found["effects"]["axis.coulomb"]["numbers"]["M_c"] == {"value": 0.03, "unit": "N m", "standard_error": None}
    assert found["effects"]["axis.coulomb"]["equation"] == "M_c sgn w" and found["kind"] == "platform"
