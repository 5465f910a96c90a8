"""Estimates: those that the logs tell, as the corrected rig holds them."""

from dataclasses import replace

import numpy as np

from rwjax.diagnosis.estimates import estimates
from rwjax.fitting.multiple_shooting import Fit
from rwjax.fitting.uncertainty import Uncertainty
from tests.systems import platform


class Fitted(Fit):
    """A fit of which the numbers alone are read."""

    def numbers(self) -> dict[str, float]:
        return {"axis.inertia": 0.09, "axis.coulomb.M_c": 0.03, "axis.spring.k": 1e9, "supply in a.csv": 11.9}


NAMES = ("axis.inertia", "axis.coulomb.M_c", "axis.spring.k", "supply in a.csv")
SPREAD = Uncertainty(NAMES, np.diag([np.inf, 1e-6, 4.0, 1e-2]) + 1e-7 * (1.0 - np.eye(4)), np.ones(4), ())
CORRECTED = replace(
    platform(),
    effects={"axis.coulomb": {"M_c": 0.03}},
    standard_error={"axis.coulomb.M_c": 1e-3, "axis.inertia": np.inf},
)


def test_what_the_logs_do_not_tell_and_what_ran_away_is_left_out() -> None:
    found = estimates(object.__new__(Fitted), SPREAD, CORRECTED)
    assert found.numbers == {"axis.coulomb.M_c": (0.03, 1e-3), "supply in a.csv": (11.9, 0.1)}
    assert np.array_equal(found.covariance, [[1e-6, 1e-7], [1e-7, 1e-2]])


def test_the_json_has_the_keys_of_a_fit() -> None:
    said = estimates(object.__new__(Fitted), SPREAD, CORRECTED).json()
    assert said["numbers"]["axis.coulomb.M_c"] == {"value": 0.03, "standard_error": 1e-3}
    assert said["covariance_of"] == ["axis.coulomb.M_c", "supply in a.csv"] and said["covariance"][1][1] == 1e-2
