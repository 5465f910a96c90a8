"""The names of the rig file."""

import pytest

from rwjax.kinds import (
    COEFFICIENTS,
    ENCODERS,
    HALVES,
    KEYS,
    KINDS,
    MOTORED,
    NUMBERS,
    ONE_AXIS,
    RANGES,
    SETTINGS,
    SIGNS,
    SUBSYSTEMS,
    TURNING,
    TWO_AXIS,
    WHEELED,
    beyond,
    encoder_section,
    half_column,
    is_angle,
    of_half,
    on_half,
)


def test_kinds_are_those_with_one_axis_and_with_two() -> None:
    assert KINDS == (*ONE_AXIS, *TWO_AXIS) and {*MOTORED, *TURNING} == {*ONE_AXIS}
    assert {*MOTORED} & {*TURNING} == {"reaction", "joint"} and {*WHEELED} == {*MOTORED} - {"joint"}


@pytest.mark.parametrize("half", [0, 1])
def test_a_name_on_a_half_comes_back(half: int) -> None:
    for name in ("axis.inertia", "wheel", "drive.delay.tau", "sensor.scale", "motor.resistance"):
        there = on_half(name, half)
        assert there != name and of_half(there) == (half, name)
    assert on_half("axis.friction.coulomb", half).startswith(("yaw.", "pitch.")[half])


@pytest.mark.parametrize("name", ["axis.inertia", "gimbal.difference", "sensor.clock", "yawning.inertia"])
def test_what_lies_on_no_half(name: str) -> None:
    assert of_half(name) is None


def test_columns_of_either_half() -> None:
    assert [half_column("yaw_rad_s", k) for k in (0, 1)] == ["yaw_rad_s", "pitch_rad_s"]
    assert [half_column("current_A", k) for k in (0, 1)] == ["current_1_A", "current_2_A"]
    assert is_angle("pitch_rad") and is_angle("wheel_rad")
    assert not is_angle("yaw_rad_s") and not is_angle("current_A")


def test_every_number_has_a_unit_a_sign_and_a_kind_and_a_part_that_the_kind_has() -> None:
    parts = SUBSYSTEMS | {"gimbal": TWO_AXIS, "gear": ("joint",)}
    for name, number in NUMBERS.items():
        assert number.unit and number.symbol and number.sign in SIGNS, name
        assert number.kinds and {*number.kinds} <= {*parts[name.partition(".")[0]]}, name


def test_each_half_has_the_numbers_of_a_reaction_rig() -> None:
    mine = {name for name, n in NUMBERS.items() if "reaction" in n.kinds and not name.startswith("drive.")} - {
        *COEFFICIENTS
    }
    for k, parts in enumerate(HALVES):
        there = {of_half(name) for name in NUMBERS if name.partition(".")[0] in parts.values()}
        level = {"axis.gravity.torque", "axis.gravity.angle"} if k == 0 else set()  # yaw turns about the vertical
        assert there == {(k, name) for name in mine - level}


def test_keys_are_numbers_and_settings_and_no_coefficients() -> None:
    assert {*KEYS} == ({*NUMBERS} | {*SETTINGS}) - {*COEFFICIENTS}
    assert KEYS["axis.friction.polynomial"] == TURNING and KEYS["fit.free"] == KINDS


def test_an_encoder_has_one_section_in_each_kind() -> None:
    assert encoder_section("axis", "platform") == "encoder" and encoder_section("axis", "two_axis") == "yaw_encoder"
    assert encoder_section("wheel", "reaction") == "wheel_encoder"
    assert encoder_section("wheel_2", "two_axis") == "wheel_2_encoder"
    for on, kinds in ENCODERS.values():
        assert all(encoder_section(on, kind) in ENCODERS for kind in kinds)


@pytest.mark.parametrize(
    ("sign", "allowed"),
    [
        ("any", {-1.0, 0.0, 1.0}),
        ("positive", {1.0}),
        ("zero or positive", {0.0, 1.0}),
        ("different from zero", {-1.0, 1.0}),
    ],
)
def test_signs(sign: str, allowed: set[float]) -> None:
    assert {value for value in (-1.0, 0.0, 1.0) if SIGNS[sign](value)} == allowed


@pytest.mark.parametrize(
    ("value", "unit", "sign", "said"),
    [
        (1e-300, "kg m2", "positive", "an inertia lies between 1e-12 and 1e+12 kg m2"),
        (-1e13, "N m/V", "different from zero", "a drive's gain lies between 1e-12 and 1e+12 N m/V in size"),
        (1e13, "N m", "zero or positive", "a torque lies between 0 and 1e+12 N m"),
        (-1e13, "N m", "any", "a torque lies between -1e+12 and 1e+12 N m"),
        (2e6, "1", "any", "a number without unit lies between -1e+06 and 1e+06"),
        (1e13, "of its own", "any", "a number lies between -1e+12 and 1e+12 of its own"),
        (1e-300, "N m", "any", ""),
        (0.0, "H", "zero or positive", ""),
        (1e-12, "kg m2", "positive", ""),
        (1e12, "kg m2", "positive", ""),
        (-1e-12, "N m/V", "different from zero", ""),
    ],
)
def test_a_number_beyond_the_range_of_its_unit_is_told_the_range(value: float, unit: str, sign: str, said: str) -> None:
    assert beyond(value, unit, sign) == said


def test_every_number_and_every_power_of_its_range_is_finite() -> None:
    """A product of four of the largest by four inverses of the least stays a float."""
    assert {n.unit for n in NUMBERS.values()} <= {*RANGES}
    largest, least = max(r.most for r in RANGES.values()), min(r.least for r in RANGES.values())
    assert 0.0 < least and largest**4 / least**4 < 1e300
