"""What a rig file says about estimation: names, bounds, priors and standard errors that fit its numbers."""

import math

import pytest

from rwjax.errors import RigError
from rwjax.kinds import COEFFICIENTS
from rwjax.rig.fit_section import FitTables, fit_section
from tests.rig.texts import PLATFORM, STRIBECK, is_refused

FIT = "[fit]\nfree = ['axis.inertia']\n"
FREE = PLATFORM + "[fit]\nfree = "
MALFORMED = [
    (
        FREE + "'axis.inertia'",
        "`fit.free` is 'axis.inertia'; it has to be a list of names, such as [\"axis.inertia\"]",
    ),
    (
        FREE + "['axis.inertai']",
        "`fit.free` names `axis.inertai`, no number of this file; the nearest is `axis.inertia`",
    ),
    (FREE + "['axis.friction.viscous']", "which has no value in this file; give it a starting value"),
    (FREE + "['axis.friction.polynomial']", "which has no value in this file; give it a starting value"),
    (FREE + f"['axis.stribeck.{STRIBECK[0]}']", "which has no value in this file; give it a starting value"),
    (FREE + "['motor.resistance']", "`motor.resistance`, no number of this file; the nearest is"),
    (FREE + "['axis.inertia', 'axis.inertia']", "`fit.free` names `axis.inertia` twice; name it once"),
    (
        PLATFORM + "[fit.bounds]\naxis.inertia = 3",
        "`fit.bounds.axis.inertia` is 3; it has to be [lowest, highest]",
    ),
    (PLATFORM + "[fit.bounds]\n'axis.inertia' = [2, 1]", "the first has to be below the second"),
    (
        PLATFORM + "[fit.bounds]\n'axis.inertia' = [1, 2]",
        "`axis.inertia` is 0.228, outside its `fit.bounds` [1.0, 2.0]",
    ),
    (PLATFORM + FIT + "[fit.prior]\n'axis.inertia' = 3", "`fit.prior.axis.inertia` is 3; it has to be [mean, stand"),
    (PLATFORM + FIT + "[fit.prior]\n'axis.inertia' = [1, 0]", "`fit.prior.axis.inertia` is 0.0; it has to be positive"),
    (
        PLATFORM + FIT + "[fit.prior]\n'axis.inertia' = [1, 1e-308]",
        "`fit.prior.axis.inertia` has the standard deviation 1e-308; it lies between 1e-06 and 1e+12 (SI); a number that is "
        "known better is not estimated: take it out of `fit.free`",
    ),
    (PLATFORM + FIT + "[fit.prior]\n'axis.inertia' = [1, 1e300]", "has the standard deviation 1e+300; it lies between"),
    (
        PLATFORM + FIT + "[fit.prior]\n'axis.inertia' = [1e300, 1]",
        "`fit.prior.axis.inertia` is 1e+300; an inertia lies",
    ),
    (PLATFORM + FIT + f"[fit.prior]\n'axis.inertia' = [1, 1{400 * '0'}]", "`fit.prior.axis.inertia` is inf; it has to"),
    (
        PLATFORM + "[effects.'drive.delay']\ntau = 0.1\n[fit]\nfree = ['drive.delay.tau']\n"
        "[fit.prior]\n'drive.delay.tau' = [-1, 0.1]",
        "`fit.prior.drive.delay.tau` is -1.0; it has to be zero or positive",
    ),
    (PLATFORM + FIT + "[fit.prior]\n'drive.gain' = [1, 1]", "is of no use, since `drive.gain` is not estimated"),
    (PLATFORM + FIT + "per_run = ['drive.gain']", "`fit.per_run` names `drive.gain`, which is not estimated"),
    (PLATFORM + FIT + "per_run = 'drive.gain'", "`fit.per_run` is 'drive.gain'; it has to be a list of names"),
    (PLATFORM + "[fit.standard_error]\n'axis.inerta' = 1", "the nearest is `axis.inertia`"),
    (PLATFORM + "[fit.standard_error]\n'axis.inertia' = -1", "it has to be zero or positive"),
]


@pytest.mark.parametrize(("text", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_what_does_not_fit_the_numbers_is_refused_in_one_line(text: str, message: str) -> None:
    is_refused(text, message)


VALUES = {"axis.inertia": 0.2, "drive.gain": -0.4, "motor.inductance": 0.0}


def test_nothing_is_estimated_without_the_section() -> None:
    assert fit_section({}, FitTables({}, {}, {}, {}), VALUES, "platform") == ((), (), {}, {}, {})


def test_the_section_is_read_whole() -> None:
    tables = FitTables({"drive.gain": math.inf}, {"axis.inertia": [0.1, math.inf]}, {"axis.inertia": [0.3, 0.1]}, {})
    leaves = {"fit.free": ["axis.inertia", "drive.gain"], "fit.per_run": ["drive.gain"]}
    found = fit_section(leaves, tables, VALUES, "platform")
    assert found.free == ("axis.inertia", "drive.gain") and found.per_run == ("drive.gain",)
    assert found.bounds == {"axis.inertia": (0.1, math.inf)} and found.prior == {"axis.inertia": (0.3, 0.1)}
    assert found.standard_error == {"drive.gain": math.inf}


def test_the_polynomial_is_four_free_numbers() -> None:
    values = dict.fromkeys(COEFFICIENTS, 1.0)
    assert fit_section(
        {"fit.free": ["axis.friction.polynomial"]}, FitTables({}, {}, {}, {}), values, "platform"
    ).free == (COEFFICIENTS)


def test_a_prior_lies_within_the_bounds() -> None:
    text = PLATFORM + FIT + "bounds = { 'axis.inertia' = [0.1, 1] }\nprior = { 'axis.inertia' = [2, 1] }\n"
    is_refused(text, "`fit.prior.axis.inertia` has the mean 2.0, outside the number's `fit.bounds` [0.1, 1.0]")


def test_an_inductance_that_is_left_out_has_no_value_for_each_log() -> None:
    text = (
        'kind = "wheel"\nmotor = { torque_constant = 1, resistance = 1, inductance = 0 }\nwheel.inertia = 1\n'
        'fit = { free = ["motor.inductance"], per_run = ["motor.inductance"] }'
    )
    is_refused(text, "`fit.per_run` names `motor.inductance`, which is 0 and left out; give it a starting value")


@pytest.mark.parametrize("bounds", [[0.2, math.inf], [-math.inf, 0.2], [0.1, 0.3]])
def test_a_number_and_the_mean_of_its_prior_may_lie_on_a_bound(bounds: list[float]) -> None:
    for mean in (value for value in bounds if math.isfinite(value)):
        tables = FitTables({}, {"axis.inertia": bounds}, {"axis.inertia": [mean, 0.1]}, {})
        found = fit_section({"fit.free": ["axis.inertia"]}, tables, VALUES, "platform")
        assert found.bounds == {"axis.inertia": tuple(bounds)} and found.prior == {"axis.inertia": (mean, 0.1)}


@pytest.mark.parametrize("bounds", [[0.2, 0.2], [0.3, 0.4], [0.1, 0.15], [0.1], [0.1, 0.2, 0.3]])
def test_bounds_that_hold_no_range_with_the_number_are_refused(bounds: list[float]) -> None:
    with pytest.raises(RigError, match=r"fit\.bounds"):
        fit_section({}, FitTables({}, {"axis.inertia": bounds}, {}, {}), VALUES, "platform")


@pytest.mark.parametrize("mean", [0.05, 0.35])
def test_a_prior_beside_its_bounds_is_refused(mean: float) -> None:
    tables = FitTables({}, {"axis.inertia": [0.1, 0.3]}, {"axis.inertia": [mean, 0.1]}, {})
    with pytest.raises(RigError, match="outside the number's"):
        fit_section({"fit.free": ["axis.inertia"]}, tables, VALUES, "platform")


@pytest.mark.parametrize(
    ("mean", "deviation", "read"),
    [
        (0.2, 0.2e-6, True),  # a millionth of the number
        (0.2, 0.19e-6, False),
        (5.0, 5e-6, True),  # of the mean, where that is larger
        (5.0, 4.9e-6, False),
        (0.2, 1e12, True),
        (0.2, 1.05e12, False),
    ],
)
def test_what_is_known_lies_between_nothing_and_all(mean: float, deviation: float, read: bool) -> None:
    tables, leaves = FitTables({}, {}, {"axis.inertia": [mean, deviation]}, {}), {"fit.free": ["axis.inertia"]}
    if read:
        assert fit_section(leaves, tables, VALUES, "platform").prior == {"axis.inertia": (mean, deviation)}
    else:
        with pytest.raises(RigError, match="has the standard deviation"):
            fit_section(leaves, tables, VALUES, "platform")


@pytest.mark.parametrize("prior", [[0.2], [0.2, 0.1, 0.1], 0.2])
def test_a_prior_is_a_mean_and_a_deviation(prior: object) -> None:
    tables = FitTables({}, {}, {"axis.inertia": prior}, {})
    with pytest.raises(RigError, match="it has to be .mean, standard deviation"):
        fit_section({"fit.free": ["axis.inertia"]}, tables, VALUES, "platform")


def test_the_polynomial_stands_among_other_names_and_is_named_once() -> None:
    values = {"axis.inertia": 0.2, "drive.gain": 1.0} | dict.fromkeys(COEFFICIENTS, 1.0)
    listed = ["drive.gain", "axis.friction.polynomial", "axis.inertia"]
    found = fit_section({"fit.free": listed, "fit.per_run": listed[1:]}, FitTables({}, {}, {}, {}), values, "platform")
    assert found.free == ("drive.gain", *COEFFICIENTS, "axis.inertia")
    assert found.per_run == (*COEFFICIENTS, "axis.inertia")
    with pytest.raises(RigError, match=f"names `{COEFFICIENTS[1]}` twice"):
        leaves = {"fit.free": ["axis.friction.polynomial", COEFFICIENTS[1]]}
        fit_section(leaves, FitTables({}, {}, {}, {}), values, "platform")


def test_a_number_of_which_every_log_has_its_own_may_be_0_unless_it_is_left_out_then() -> None:
    values = VALUES | {"axis.friction.viscous": 0.0, "motor.inductance": 1e-3}
    for name in ("axis.friction.viscous", "motor.inductance"):
        leaves = {"fit.free": [name], "fit.per_run": [name]}
        assert fit_section(leaves, FitTables({}, {}, {}, {}), values, "reaction").per_run == (name,)
