"""Rig files written: what is written reads back equal."""

from dataclasses import replace
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from rwjax.kinds import COEFFICIENTS, ENCODERS, KINDS, NUMBERS
from rwjax.rig.effect_section import effect_parameters
from rwjax.rig.model import Pwm, Rig
from rwjax.rig.read import parse_rig, read_rig
from rwjax.rig.write import write_rig
from tests.rig.texts import PLATFORM

DATA = Path(__file__).parents[2] / "data" / "two_axis"


positive = st.floats(1e-12, 1e12)
COLUMNS = st.fixed_dictionaries({}, optional={"position": st.just("pos1"), "pulse": st.just("pwm_2")})


@st.composite
def rigs(draw: st.DrawFn) -> Rig:
    kind = draw(st.sampled_from(KINDS))
    two = kind == "two_axis"
    names = [name for name, n in NUMBERS.items() if kind in n.kinds and not name.startswith("gimbal.")]
    required = {name for name in names if NUMBERS[name].required}
    absent = {n for n in names if n.endswith((".static", ".stribeck_velocity", ".gravity.angle"))}
    absent |= set(COEFFICIENTS if draw(st.booleans()) else [n for n in names if "friction.v" in n or "coul" in n])
    chosen = [n for n in names if n in required or n in COEFFICIENTS or draw(st.booleans())]
    numbers = {name: draw(positive) for name in chosen if name not in absent}
    known = {e: p for e, p in effect_parameters().items() if e.startswith("drive_1." if two else "drive.") and p}
    effects = draw(st.lists(st.sampled_from(sorted(known)), unique=True, max_size=2))
    encoders = [who for who, kinds in ENCODERS.values() if kind in kinds]
    rig = Rig(
        kind=kind,
        name=draw(st.text(st.characters(exclude_categories=["Cs"]), max_size=8)),
        numbers=numbers,
        effects={effect: {p: draw(positive) for p in known[effect]} for effect in effects},
        counts_per_rev={who: draw(positive) for who in encoders if draw(st.booleans())},
        pwm=None if two else draw(st.none() | st.builds(Pwm, positive, positive)),
        columns={} if two else draw(COLUMNS),
    )
    free = draw(st.lists(st.sampled_from(sorted(rig.values)), unique=True))
    errors = {name: draw(st.floats(0.0)) for name in free}
    return replace(
        rig,
        free=tuple(free),
        standard_error=errors,
        bounds={name: (-1.0, 1e13) for name in free[:1]},
        per_run=tuple(free[:2]),
        prior={name: (draw(positive), draw(positive)) for name in free[1:3]},
    )


@given(rig=rigs())
def test_what_is_written_reads_back_equal(rig):
    assert parse_rig(write_rig(rig)) == rig


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
