"""Rig files written: what is written reads back equal."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.errors import RigError
from rwjax.kinds import COEFFICIENTS, ENCODERS, KINDS, NUMBERS, RANGES, SERVO, SERVO_CHOICES, TURNING
from rwjax.rig.effect_section import effect_parameters
from rwjax.rig.model import Pwm, Rig, Servo
from rwjax.rig.read import parse_rig, read_rig
from rwjax.rig.write import write_rig
from tests.rig.texts import PLATFORM

DATA = Path(__file__).parents[2] / "data" / "two_axis"


PARAMETERS = {f"{e}.{p}": known for e, given in effect_parameters().items() for p, known in given.items()}
NAMES = st.text(st.characters(exclude_categories=("C", "Z"), include_characters=" "), max_size=8) | st.sampled_from(
    ['"]', "\\", 3 * '"', 3 * "'", "[/]", "#", "= 1", 255 * "é", r"a b\nc"]
)
COLUMNS = st.fixed_dictionaries({}, optional={"position": st.just("pos1"), "pulse": st.just("pwm_2")})


def sizes(name: str) -> st.SearchStrategy[float]:
    """Positive values that a number of an effect may have."""
    low, high = PARAMETERS[name].bounds
    known = RANGES[PARAMETERS[name].unit]
    return st.floats(max(known.least, low), min(known.most, high))


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    kind = draw(st.sampled_from(KINDS))
    two = kind == "two_axis"
    names = [name for name, n in NUMBERS.items() if kind in n.kinds and not name.startswith("gimbal.")]
    servo = draw(st.none() | st.builds(Servo, **{key: st.sampled_from(words) for key, words in SERVO_CHOICES.items()}))
    servo = None if kind not in TURNING else servo
    names = [name for name in names if servo or not name.startswith(f"{SERVO}.")]
    required = {name for name in names if kind in NUMBERS[name].required or name in (f"{SERVO}.kp", f"{SERVO}.period")}
    absent = {n for n in names if n.endswith((".static", ".stribeck_velocity", ".gravity.angle"))}
    absent |= set(COEFFICIENTS if draw(st.booleans()) else [n for n in names if "friction.v" in n or "coul" in n])
    chosen = [n for n in names if n in required or n in COEFFICIENTS or draw(st.booleans())]
    numbers = {name: draw(st.floats(0.1, 10.0)) for name in chosen if name not in absent}
    known = {e: p for e, p in effect_parameters().items() if e.startswith("drive_1." if two else "drive.") and p}
    effects = draw(st.lists(st.sampled_from(sorted(known)), unique=True, max_size=2))
    encoders = [who for who, kinds in ENCODERS.values() if kind in kinds]
    rig = Rig(
        kind=kind,
        name=draw(NAMES),
        numbers=numbers,
        effects={effect: {p: draw(sizes(f"{effect}.{p}")) for p in known[effect]} for effect in effects},
        counts_per_rev={who: draw(st.floats(1.0, 1e9)) for who in encoders if draw(st.booleans())},
        pwm=None if two else draw(st.none() | st.builds(Pwm, st.floats(1e-3, 1e6), st.floats(-1e6, -1e-9))),
        columns={} if two else draw(COLUMNS),
        servo=servo,
        cautions=draw(st.sampled_from([(), ("not claimed: Unknown: 3 é # [fit]",), ("one", "and another")])),
    )
    spread = draw(st.floats(1e-5, 0.9))
    free = draw(st.lists(st.sampled_from(sorted(rig.values)), unique=True))
    errors = {name: draw(st.floats(0.0)) for name in free}
    keys = [name for name in rig.values if name not in COEFFICIENTS] or [None]
    return replace(
        rig,
        guessed=tuple(filter(None, draw(st.lists(st.sampled_from(keys), unique=True, max_size=3)))),
        free=tuple(free),
        standard_error=errors,
        bounds={name: (-1.0, 1e13) for name in free[:1]},
        per_run=tuple(free[:2]),
        prior={name: (rig.values[name], spread * rig.values[name]) for name in free[1:3] if rig.values[name] > 1.0},
    )


def test_guesses_stay_guesses_until_they_are_estimated() -> None:
    text = (
        PLATFORM.replace("gain = -0.428", "gain = -0.428 # a guess")
        + '[effects."drive.deadzone"]\nu_0 = 0.5 # a guess\n'
    )
    rig = parse_rig(text)
    assert rig.guessed == ("drive.gain", "drive.deadzone.u_0")
    again = parse_rig(write_rig(rig))
    assert again.guessed == rig.guessed and again == rig
    told = rig.with_standard_errors({"drive.gain": 0.1})
    assert told.standard_error == {"drive.gain": 0.1} and parse_rig(write_rig(told)).guessed == ("drive.deadzone.u_0",)
    bent = parse_rig(PLATFORM + "[axis.friction]\npolynomial = [0.0, 0.1, 0.0, 0.0] # a guess\n")
    assert bent.guessed == ("axis.friction.polynomial",) == parse_rig(write_rig(bent)).guessed
    assert bent.with_standard_errors({"axis.friction.b2": 0.1}).guessed == ()


@given(rig=rigs())
def test_what_is_written_reads_back_equal(rig):
    again = parse_rig(write_rig(rig))
    assert again == rig and {*again.guessed} == {*rig.guessed}


def test_polynomial_stands_for_four_numbers():
    rig = parse_rig(
        PLATFORM + 'friction.polynomial = [0.4, -5.2e-2, 2e-2, -7e-4]\n[fit]\nfree = ["axis.friction.polynomial"]'
    )
    assert [rig.numbers[b] for b in COEFFICIENTS] == [0.4, -5.2e-2, 2e-2, -7e-4]
    assert rig.free == COEFFICIENTS
    assert 'free = ["axis.friction.polynomial"]' in write_rig(rig)


def test_the_example_with_two_axes_reads_back_equal() -> None:
    rig = read_rig(DATA / "rig.toml")
    assert parse_rig(write_rig(rig)) == replace(rig, name="two-axis")
    assert rig.counts_per_rev == {"axis": 4096.0, "pitch": 4096.0}


def test_numbers_stand_in_their_sections_with_units() -> None:
    text = write_rig(parse_rig(PLATFORM + "friction.coulomb = 0.01\n[fit]\nfree = ['axis.inertia']\n"))
    assert text.index("[drive]") < text.index("[axis]") < text.index("[axis.friction]") < text.index("[fit]")
    assert "inertia = 0.228 # I, kg m2\n" in text and "coulomb = 0.01 # M_c, N m\n" in text


WRONG = [
    ({"axis.inertia": math.nan}, "`axis.inertia` is nan; it has to be a finite number"),
    ({"axis.inertia": 1e300}, "`axis.inertia` is 1e+300; an inertia lies between 1e-12 and 1e+12 kg m2"),
    ({"drive.gain": 0.0}, "`drive.gain` is 0.0; it has to be different from zero"),
    ({"axis.inertia": 0.5}, "`axis.inertia` is 0.5, outside its `fit.bounds` [0.1, 0.4]; widen them"),
]


@pytest.mark.parametrize(("values", "said"), WRONG, ids=[said for _, said in WRONG])
def test_a_rig_that_the_reader_refuses_is_not_written(values: dict[str, float], said: str) -> None:
    rig = replace(parse_rig(PLATFORM, "mine.toml"), bounds={"axis.inertia": (0.1, 0.4)})
    with pytest.raises(RigError) as error:
        write_rig(rig.with_values(values))
    assert str(error.value) == f"rig `mine` cannot be written, since no rig file may say so: {said}"


def test_the_polynomial_keeps_its_place_among_what_is_free() -> None:
    rig = parse_rig(PLATFORM + "friction.polynomial = [0.4, -5.2e-2, 2e-2, -7e-4]\n")
    for free in (
        ("drive.gain", *COEFFICIENTS, "axis.inertia"),
        (*COEFFICIENTS, "drive.gain"),
        ("axis.inertia", *COEFFICIENTS),
        COEFFICIENTS,
        (*COEFFICIENTS[1:], "drive.gain"),
        COEFFICIENTS[::-1],
    ):
        text = write_rig(replace(rig, free=free, per_run=free[1:]))
        back = parse_rig(text)
        assert (back.free, back.per_run) == (free, free[1:])
        in_a_row = any(free[k : k + 4] == COEFFICIENTS for k in range(len(free)))
        assert ('free = ["' in text and "polynomial" in text.partition("free = ")[2].partition("]")[0]) == in_a_row


def test_whole_counts_are_written_as_whole_numbers() -> None:
    rig = parse_rig(PLATFORM + "[encoder]\ncounts_per_rev = 4096\n")
    assert "counts_per_rev = 4096 #" in write_rig(rig)
    assert "counts_per_rev = 4096.5 #" in write_rig(replace(rig, counts_per_rev={"axis": 4096.5}))
