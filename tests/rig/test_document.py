"""Values of a rig file by their dotted names: found, taken, checked, and refused in which words."""

import math
import time

import pytest

from rwjax.errors import RigError
from rwjax.rig.document import check_keys, leaves, number, take, text
from tests.rig.texts import MOTOR, PLATFORM, WHEEL, is_refused

FRICTION = PLATFORM + "[axis.friction]\n"
MALFORMED = [
    ("kind = 'platform'\nname = 3", '`name` is 3; it has to be a text in quotes, "3"'),
    (WHEEL + "[motr]", "unknown key `motr`; the nearest valid one is `motor."),
    (WHEEL + "inerta = 1", "unknown key `wheel.inerta`; the nearest valid one is `wheel.inertia`"),
    (PLATFORM + "friction.b3 = 1", "unknown key `axis.friction.b3`"),
    (PLATFORM + "'friction.viscous' = 1\nfriction.viscous = 1", "`axis.friction.viscous` is given twice"),
    (
        PLATFORM + MOTOR,
        "`motor.torque_constant` does not belong to a `platform` rig; take it out, or set kind =",
    ),
    (PLATFORM + "[motor]", "`motor` does not belong to a `platform` rig"),
    (
        WHEEL + "[drive]\ngain = 1",
        '`drive.gain` does not belong to a `wheel` rig; take it out, or set kind = "plat',
    ),
    (
        WHEEL + "[encoder]\ncounts_per_rev = 9",
        'a `wheel` rig; take it out, or set kind = "platform" or "reaction"',
    ),
    (PLATFORM.replace("0.228", "'0.228'"), "`axis.inertia` is '0.228'; it has to be a number"),
    (PLATFORM.replace("0.228", "true"), "`axis.inertia` is True; it has to be a number"),
    (PLATFORM.replace("0.228", "nan"), "`axis.inertia` is nan; it has to be a finite number"),
    (PLATFORM.replace("0.228", "1" + 400 * "0"), "`axis.inertia` is inf; it has to be a finite number"),
    (PLATFORM.replace("0.228", "-0.228"), "`axis.inertia` is -0.228; it has to be positive"),
    (FRICTION + "polynomial = [1, 2, 'x', 4]", "`axis.friction.b1` is 'x'; it has to be a number"),
    (PLATFORM.replace("0.228", "1e-300"), "`axis.inertia` is 1e-300; an inertia lies between 1e-12 and 1e+12 kg m2"),
    (PLATFORM.replace("0.228", "0x" + 3900 * "f"), "`axis.inertia` is inf; it has to be a finite number"),
    (PLATFORM.replace("0.228", f"[0x{3900 * 'f'}]"), "`axis.inertia` is a number of thousands of digits; it has to be"),
    (FRICTION + "coulomb = 1e40", "`axis.friction.coulomb` is 1e+40; a torque lies between 0 and 1e+12 N m"),
    (
        r'name = "a\nb"' + "\n" + PLATFORM,
        r"`name` holds `\n`, which is not printed; write it in letters, digits, signs",
    ),
    (r'name = "\u001b[31m"' + "\n" + PLATFORM, r"`name` holds `\x1b`, which is not printed"),
    (f'name = "{256 * "x"}"\n' + PLATFORM, "`name` has 256 characters; 255 at most"),
    (PLATFORM + "[fit]\nfre = []", "unknown key `fit.fre`; the nearest valid one is `fit.free`"),
    (PLATFORM + "[fit]\nbounds = 3", "`fit.bounds` is not a table; write it as a section `[fit.bounds]`"),
    (PLATFORM + "friction.viscuos = 1", "the nearest valid one is `axis.friction.viscous`"),
]


@pytest.mark.parametrize(("text", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_a_mistake_is_refused_in_one_line(text: str, message: str) -> None:
    is_refused(text, message)


def test_values_are_found_by_dotted_name_in_the_order_of_the_file() -> None:
    found = leaves({"kind": "wheel", "axis": {"friction": {"viscous": 1}, "gravity": {}, "list": [1, 2]}})
    assert list(found.items()) == [
        ("kind", "wheel"),
        ("axis.friction.viscous", 1),
        ("axis.gravity", {}),
        ("axis.list", [1, 2]),
    ]


def test_what_is_taken_is_gone() -> None:
    found = {"fit.free": [1], "fit.bounds.axis.inertia": 2, "fit.prior": {}, "axis.inertia": 3}
    assert take(found, "fit.bounds") == {"axis.inertia": 2}
    assert take(found, "fit.prior") == {} == take(found, "effects")
    assert found == {"fit.free": [1], "axis.inertia": 3}


def test_a_section_that_belongs_to_several_kinds_is_none_of_another() -> None:
    check_keys({"axis.inertia": 1, "axis": {}}, "reaction")
    with pytest.raises(
        RigError, match='`axis` does not belong to a `wheel` rig; take it out, or set kind = "platform" or'
    ):
        check_keys({"axis": {}}, "wheel")


@pytest.mark.parametrize(
    ("value", "sign", "found"), [(3, "positive", 3.0), (-0.5, "any", -0.5), (0, "zero or positive", 0.0)]
)
def test_numbers_are_read_as_they_stand(value: float, sign: str, found: float) -> None:
    assert number("x", value, sign) == found


def test_only_some_numbers_may_be_infinite() -> None:
    assert number("x", math.inf, finite=False) == math.inf == number("x", 10**400, finite=False)
    for value in (math.inf, 10**400, math.nan):
        with pytest.raises(RigError, match="`x` is .*; it has to be a finite number"):
            number("x", value)
    with pytest.raises(RigError, match="`x` is nan; it has to be a finite number"):
        number("x", math.nan, finite=False)


def test_a_text_has_a_default() -> None:
    assert text({}, "name", "testbed") == "testbed" and text({"name": "mine"}, "name", "testbed") == "mine"


def test_line_breaks_in_a_key_stay_on_the_line() -> None:
    is_refused(WHEEL + r'"a\nb" = 1', r"unknown key `wheel.a\nb`")


def test_many_keys_take_as_long_for_each_as_few() -> None:
    """50 000 keys took minutes where each was compared with all before it."""
    document = {"axis": {f"k{i}": i for i in range(50_000)}}
    begin = time.process_time()
    assert len(leaves(document)) == 50_000
    assert time.process_time() - begin < 10.0
