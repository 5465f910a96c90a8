"""The hardware sections of a rig file: what is read, and what is refused in which words."""

import math

import pytest

from rwjax.errors import RigError
from rwjax.kinds import COEFFICIENTS
from rwjax.rig import parse
from rwjax.rig.model import Pwm
from rwjax.rig.read import parse_rig
from rwjax.rig.write import write_rig
from tests.rig.texts import MOTOR, PLATFORM, REACTION, WHEEL, is_refused
from tests.two_axes import GIMBAL, GRAVITY, TILTING, two_axis

FRICTION = PLATFORM + "[axis.friction]\n"
MALFORMED = [
    ("name = 'x'", 'no `kind`; write kind = "wheel", "platform", "reaction" or "two_axis"'),
    ("kind = 'car'", '`kind` is \'car\'; write kind = "wheel", "platform", "reaction" or "two_axis"'),
    (
        'kind = "wheel"\n' + MOTOR,
        "no `wheel.inertia` (J, kg m2), which a `wheel` rig needs; write inertia = … under",
    ),
    (
        REACTION.replace("resistance = 0.83\n", ""),
        "no `motor.resistance` (R, ohm), which a `reaction` rig needs",
    ),
    (PLATFORM.replace("gain = -0.428\n", ""), "no `drive.gain` (k, N m/V), which a `platform` rig needs"),
    (PLATFORM.replace("-0.428", "0"), "`drive.gain` is 0.0; it has to be different from zero"),
    (WHEEL.replace("0.83", "0"), "`motor.resistance` is 0.0; it has to be positive"),
    (PLATFORM + "[encoder]\ncounts_per_rev = 0", "`encoder.counts_per_rev` is 0.0; it has to be positive"),
    (FRICTION + "coulomb = -1", "`axis.friction.coulomb` is -1.0; it has to be zero or positive"),
    (
        FRICTION + "static = 1",
        "`axis.friction.static` means nothing without `axis.friction.stribeck_velocity`; give",
    ),
    (FRICTION + "stribeck_velocity = 1", "means nothing without `axis.friction.static`"),
    (PLATFORM + "gravity.angle = 1", "`axis.gravity.angle` means nothing without `axis.gravity.torque`"),
    (
        FRICTION + "viscous = 1\npolynomial = [1, 2, 3, 4]",
        "is the whole friction, and `axis.friction.viscous` stands",
    ),
    (FRICTION + "polynomial = [1, 2]", "is [1, 2]; it has to be the four numbers [b3, b2, b1, b0]"),
    (WHEEL + "[drive]\npwm = { neutral_us = 1500 }", "`drive.pwm` has no `volts_per_us`; write pwm = {"),
    (WHEEL + "[columns]\npulse = 'pos1'", '`columns.pulse` is \'pos1\'; it has to be "pwm_1" or "pwm_2"'),
]


@pytest.mark.parametrize(("text", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_a_mistake_is_refused_in_one_line(text: str, message: str) -> None:
    is_refused(text, message)


def test_the_kind_is_taken_out() -> None:
    leaves = {"kind": "wheel", "name": "mine"}
    assert parse.kind(leaves) == "wheel" and leaves == {"name": "mine"}


def test_the_polynomial_stands_for_four_numbers() -> None:
    leaves = {"drive.gain": 1, "axis.inertia": 2, "axis.friction.polynomial": [0.4, -5.2e-2, 2e-2, -7e-4]}
    assert parse.numbers(leaves, "platform") == {
        "drive.gain": 1.0,
        "axis.inertia": 2.0,
        **dict(zip(COEFFICIENTS, (0.4, -5.2e-2, 2e-2, -7e-4), strict=True)),
    }


def test_pulses_counts_and_columns_may_be_absent() -> None:
    assert parse.pwm({}) is None and parse.counts_per_rev({}) == {} == parse.columns({})
    assert parse.pwm({"drive.pwm.neutral_us": 1500, "drive.pwm.volts_per_us": -0.02}) == Pwm(1500.0, -0.02)
    assert parse.counts_per_rev({"encoder.counts_per_rev": 2048, "pitch_encoder.counts_per_rev": 12}) == {
        "axis": 2048.0,
        "pitch": 12.0,
    }
    assert parse.columns({"columns.pulse": "pwm_2"}) == {"pulse": "pwm_2"}


TEXT = write_rig(two_axis(GIMBAL + GRAVITY + TILTING))


@pytest.mark.parametrize(
    "old, new, said",
    [
        (
            "[wheel_2]\ninertia = 0.000124",
            "[wheel_2]",
            "no `wheel_2.inertia` (J_2, kg m2), which a `two_axis` rig needs",
        ),
        (
            "[yaw]",
            "[axis.friction]\nviscous = 1.0\n[yaw]",
            "`axis.friction.viscous` does not belong to a `two_axis` rig",
        ),
        ("product_yz = -0.0015", "product_yz = 0.04", "`[gimbal]` is too large for `yaw.inertia` and `pitch.inertia`"),
        (
            "[gimbal]",
            "[yaw.friction]\nstatic = 1.0\n[gimbal]",
            "means nothing without `yaw.friction.stribeck_velocity`",
        ),
        ("wheel_1.gyroscopic", "wheel_1.gyroscope", 'the nearest is [effects."wheel_1.gyroscopic"]'),
        ("wheel_1.gyroscopic", "axis.stribeck", "no effect `axis.stribeck` for a `two_axis` rig"),
        ("[gimbal]", "[yaw]\ngravity.torque = 1.0\n[gimbal]", "not valid TOML"),
    ],
)
def test_a_mistake_in_a_rig_with_two_axes_is_refused_in_one_line(old: str, new: str, said: str) -> None:
    assert old in TEXT
    with pytest.raises(RigError) as error:
        parse_rig(TEXT.replace(old, new))
    assert said in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("product", [0.9, 1.1])
def test_the_inertia_of_two_axes_has_to_be_positive_definite(product: float) -> None:
    """With I_xy alone, the matrix [[I_yaw, I_xy sin], [I_xy sin, I_pitch]] is singular at I_xy² = I_yaw I_pitch."""
    given = {
        f"{section}.{key}": 1.0
        for section, key in (
            ("wheel_1", "inertia"),
            ("wheel_2", "inertia"),
            ("motor_1", "resistance"),
            ("motor_2", "resistance"),
            ("motor_1", "torque_constant"),
            ("motor_2", "torque_constant"),
        )
    }
    given |= {"yaw.inertia": 4.0, "pitch.inertia": 9.0, "gimbal.product_xy": product * math.sqrt(4.0 * 9.0)}
    if product < 1.0:
        assert parse.numbers(given, "two_axis") == given
    else:
        with pytest.raises(RigError, match="at a pitch of -.* deg the rig would have no positive inertia"):
            parse.numbers(given, "two_axis")
