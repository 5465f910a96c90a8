"""The effects of a rig file: which are known, what they need, what they may leave out."""

import pytest

from rwjax.rig.effect_section import effect_parameters, effects
from tests.rig.texts import PLATFORM, STRIBECK, is_refused

MALFORMED = [
    (
        PLATFORM + "[effects.'axis.stribeck']\nM_c = 0.1\nM_e = 0.1\nv_s = 0",
        '`effects."axis.stribeck".v_s` is 0.0; it has to be positive',
    ),
    (
        PLATFORM + "[effects.'axis.stribek']\na = 1",
        "no effect `axis.stribek` for a `platform` rig; the nearest is [eff",
    ),
    (PLATFORM + "[effects.'wheel.coulomb']", "no effect `wheel.coulomb` for a `platform` rig"),
    (
        PLATFORM + "[effects.'axis.stribeck']\nspeed = 1",
        "the effect `axis.stribeck` has no parameter `speed`; it has `",
    ),
    (PLATFORM + "[effects.'axis.stribeck']", "for `axis.stribeck`; write "),
    (
        PLATFORM + "[effects.'drive.delay']\ntau = 7",
        '`effects."drive.delay".tau` is 7.0; it lies between 0 and 0.5 s',
    ),
    (
        PLATFORM + "[effects.'axis.friction_drift']\nd = -2",
        '`effects."axis.friction_drift".d` is -2.0; it is -1 at least',
    ),
    (
        PLATFORM + "[effects.'axis.coulomb']\nM_c = 1e300",
        '`effects."axis.coulomb".M_c` is 1e+300; a torque lies between 0 and 1e+12 N m',
    ),
    (PLATFORM + f"[effects.'axis.coulomb']\nM_c = 1{400 * '0'}", '`effects."axis.coulomb".M_c` is inf; it has to be a'),
    (PLATFORM + "[effects]\naxis = 1", "no effect `axis` for a `platform` rig"),
]


@pytest.mark.parametrize(("text", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_an_effect_that_cannot_be_is_refused_in_one_line(text: str, message: str) -> None:
    is_refused(text, message)


def test_the_effects_of_a_kind_are_some_of_all() -> None:
    every, platform = effect_parameters(), effect_parameters("platform")
    assert {*platform} < {*every} and "wheel.coulomb" not in platform
    assert [*every["axis.stribeck"]] == [*STRIBECK] and every["axis.stribeck"]["v_s"].unit == "rad/s"


def test_an_effect_has_all_its_parameters() -> None:
    given = {f"axis.stribeck.{name}": value for name, value in zip(STRIBECK, (0.1, 0.2, 0.3, 1.0), strict=True)}
    assert effects(given, "platform") == {"axis.stribeck": {"M_c": 0.1, "M_e": 0.2, "v_s": 0.3, "n": 1.0}}
    assert effects({}, "platform") == {}


def test_a_parameter_of_the_form_may_be_left_out_and_is_null_then() -> None:
    given = {"axis.stribeck.M_c": 0.1, "axis.stribeck.M_e": 0.2, "axis.stribeck.v_s": 0.3}
    null = effect_parameters("platform")["axis.stribeck"]["n"].null
    assert effects(given, "platform") == {"axis.stribeck": {"M_c": 0.1, "M_e": 0.2, "v_s": 0.3, "n": null}}


def test_an_effect_of_two_axes_is_none_of_one() -> None:
    is_refused(PLATFORM + '[effects."yaw.viscous"]\nb = 0.1\n', "no effect `yaw.viscous` for a `platform` rig")
