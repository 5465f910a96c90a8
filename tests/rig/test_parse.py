"""The hardware sections of a rig file: what is read, and what is refused in which words."""

import numpy as np
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
    ("name = 'x'", 'no `kind`; write kind = "wheel", "platform", "reaction", "joint" or "two_axis"'),
    ("kind = 'car'", '`kind` is \'car\'; write kind = "wheel", "platform", "reaction", "joint" or "two_axis"'),
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
    (
        PLATFORM + "[encoder]\ncounts_per_rev = 1e300",
        "`encoder.counts_per_rev` is 1e+300; the resolution of an encoder lies between 1 and 1e+09 counts",
    ),
    (PLATFORM + "[encoder]\ncounts_per_rev = 1e-300", "`encoder.counts_per_rev` is 1e-300; the resolution of"),
    (PLATFORM + f"[encoder]\ncounts_per_rev = 1{400 * '0'}", "`encoder.counts_per_rev` is inf; it has to be a finite"),
    (
        PLATFORM.replace("-0.428", "1e300"),
        "`drive.gain` is 1e+300; a drive's gain lies between 1e-12 and 1e+12 N m/V in",
    ),
    (WHEEL.replace("0.83", "1e-200"), "`motor.resistance` is 1e-200; a resistance lies between 1e-12 and 1e+12 ohm"),
    (
        FRICTION + "polynomial = [1, 2, 3, 1e200]",
        "`axis.friction.b0` is 1e+200; a drag with speed cubed lies between -1e+12",
    ),
    (
        WHEEL + "[drive]\npwm = { neutral_us = 1e40, volts_per_us = 1 }",
        "`drive.pwm.neutral_us` is 1e+40; a pulse width",
    ),
    (
        WHEEL + "[drive]\npwm = { neutral_us = 1500, volts_per_us = 1e-40 }",
        "a voltage per pulse width lies between 1e-09",
    ),
    (
        PLATFORM.replace("0.228", "0.05") + "friction.viscous = -5",
        "`axis.friction.viscous` is -5.0: a motion of this axis would grow by a factor of e every 0.01 s; friction that falls "
        "with speed lies above -10 times the inertia, here -0.5",
    ),
    (
        WHEEL.replace("0.83\n", "0.83\ninductance = 1e-300\n"),
        "R/L of `motor` is 8.3e+299 1/s; it lies below 1e+06 1/s on any rig: check both, or leave the inductance out",
    ),
    (
        WHEEL.replace("1.24e-4", "1e-12"),
        "K²/(R J) of `motor` and `wheel` is 3.991e+08 1/s; it lies below 1e+06 1/s on any",
    ),
    (WHEEL.replace("0.83\n", "0.83\nfriction = 1e9\n"), "b/J of `motor` and `wheel` is 8.065e+12 1/s; it lies below"),
    (FRICTION + "viscous = 1e9", "b/I of `axis` is 4.386e+09 1/s; it lies below 1e+06 1/s on any rig: check both"),
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
        (
            "[gimbal]",
            "[pitch.friction]\nviscous = -1\n[gimbal]",
            "`pitch.friction.viscous` is -1.0: a motion of this axis",
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


PRODUCTS = ("product_xy", "product_xz", "product_yz")
TWO = {
    f"{part}_{k}.{key}": 1.0
    for k in (1, 2)
    for part, key in (("wheel", "inertia"), ("motor", "resistance"), ("motor", "torque_constant"))
} | {"yaw.inertia": 4.0, "pitch.inertia": 9.0}
"""The numbers that a rig with two axes has to have."""


@pytest.mark.parametrize("size", [0.98, 1.02])
@pytest.mark.parametrize(
    "gimbal",
    [
        {"product_xy": 6.0},  # I_xy² = I_yaw I_pitch, at a right angle
        {"product_yz": -6.0},  # and at none
        {"product_xy": 3.6, "product_yz": 4.8},  # together as long as their hypotenuse
        {"difference": -4.0},  # nothing is left of the yaw inertia at a right angle
        {"product_xz": 4.0},  # nor at half of one
        {"difference": 2.1, "product_xz": -5.0},  # at some angle: 4 + 1.05 - hypot(1.05, 4.939)
    ],
    ids=lambda gimbal: " ".join(gimbal),
)
def test_the_inertia_of_two_axes_has_to_be_positive_definite(gimbal: dict[str, float], size: float) -> None:
    given = TWO | {f"gimbal.{name}": size * value for name, value in gimbal.items()}
    if size < 1.0:
        assert parse.numbers(given, "two_axis") == given
    else:
        with pytest.raises(RigError, match="deg the rig would have no positive inertia"):
            parse.numbers(given, "two_axis")


@pytest.mark.parametrize("seed", range(12))
def test_the_inertia_is_that_of_the_turned_body(seed: int) -> None:
    """The platform's tensor turned by the pitch about y: yaw sees its zz, pitch its yy, and yz couples them."""
    D, xy, xz, yz = np.random.default_rng(seed).uniform(-1.0, 1.0, 4) * (3.0, 5.0, 3.0, 5.0)
    body = np.array(
        [[4.0 + D, -xy, -xz], [-xy, 9.0, -yz], [-xz, -yz, 4.0]]
    )  # products are integrals of xy dm and so on
    least = np.inf
    for pitch in np.radians(np.arange(360.0)):
        s, c = np.sin(pitch), np.cos(pitch)
        turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        least = min(least, float(np.linalg.eigvalsh((turn @ body @ turn.T)[1:, 1:])[0]))
    given = TWO | dict(zip((f"gimbal.{n}" for n in ("difference", *PRODUCTS)), (D, xy, xz, yz), strict=True))
    if least > 0.0:
        assert parse.numbers(given, "two_axis") == given
    else:
        with pytest.raises(RigError, match="no positive inertia"):
            parse.numbers(given, "two_axis")


@pytest.mark.parametrize("key", ["yaw.friction.viscous", "pitch.friction.viscous"])
def test_friction_may_fall_by_ten_times_the_inertia_a_second(key: str) -> None:
    most = 10.0 * TWO[f"{key.partition('.')[0]}.inertia"]
    assert parse.numbers(TWO | {key: -most}, "two_axis")[key] == -most
    with pytest.raises(RigError, match=f"`{key}` is .* here -{most:g}"):
        parse.numbers(TWO | {key: -1.05 * most}, "two_axis")


@pytest.mark.parametrize("axis", ["yaw", "pitch"])
def test_numbers_of_either_axis_mean_something_together_alone(axis: str) -> None:
    pair = {f"{axis}.friction.static": 0.2, f"{axis}.friction.stribeck_velocity": 0.1}
    assert parse.numbers(TWO | pair, "two_axis") == TWO | pair
    for name in pair:
        with pytest.raises(RigError, match="means nothing without"):
            parse.numbers(TWO | {name: 0.1}, "two_axis")


def test_a_polynomial_stands_beside_other_numbers_of_the_axis() -> None:
    read = parse_rig(PLATFORM + "gravity.torque = 0.1\nfriction.polynomial = [1, 2, 3, 4]").numbers
    assert read["axis.gravity.torque"] == 0.1 and [read[name] for name in COEFFICIENTS] == [1.0, 2.0, 3.0, 4.0]


def test_friction_that_falls_as_on_rigs_is_read() -> None:
    """The thesis's polynomial falls by 0.052 N m s/rad; twice the axis's inertia in 1 s is what Stribeck friction has."""
    for friction in ("viscous = -0.456", "polynomial = [0.1, -5.2e-2, 2e-2, -7e-4]"):
        assert parse_rig(FRICTION + friction).numbers["axis.inertia"] == 0.228


def test_ranges_leave_room_for_the_smallest_and_the_largest_rigs() -> None:
    """A reaction wheel of a nanosatellite, and a ship of 200 000 t that turns by its rudder."""
    small = WHEEL.replace("1.24e-4", "1e-9").replace("0.0182", "1e-4").replace("0.83", "20")
    assert parse_rig(small).numbers["wheel.inertia"] == 1e-9
    ship = PLATFORM.replace("0.228", "5e11").replace("-0.428", "1e8") + "friction.viscous = 1e10"
    assert parse_rig(ship).numbers["drive.gain"] == 1e8
