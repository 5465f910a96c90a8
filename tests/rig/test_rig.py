"""The rig file: what is read, what is refused in which words, and what is written reads back equal."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.errors import InputError, RigError
from rwjax.kinds import COEFFICIENTS, ENCODERS, KINDS, NUMBERS
from rwjax.rig.effect_section import effect_parameters
from rwjax.rig.model import Pwm, Rig
from rwjax.rig.read import parse_rig, read_rig
from rwjax.rig.write import write_rig

MOTOR = "[motor]\ntorque_constant = 0.0182\nresistance = 0.83\n"
WHEEL = 'kind = "wheel"\n' + MOTOR + "[wheel]\ninertia = 1.24e-4\n"
PLATFORM = 'kind = "platform"\n[drive]\ngain = -0.428\n[axis]\ninertia = 0.228\n'
STRIBECK = [*effect_parameters()["axis.stribeck"]]  # the names of its parameters
REACTION = 'kind = "reaction"\n' + MOTOR + "[wheel]\ninertia = 1.24e-4\n[axis]\ninertia = 0.0495\n"


def test_reads_every_section(tmp_path):
    path = tmp_path / "testbed.toml"
    path.write_text(
        REACTION
        + """[axis.friction]
viscous = 0.0026
coulomb = 0.01
static = 0.02
stribeck_velocity = 0.3
[axis.gravity]
torque = -0.1
[drive]
pwm = { neutral_us = 1500, volts_per_us = 0.02 }
[encoder]
counts_per_rev = 2048
[wheel_encoder]
counts_per_rev = 12
[columns]
position = "pos1"
pulse = "pwm_2"
[fit]
free = ["axis.inertia", "axis.stribeck.PARAMETER"]
[fit.bounds]
"axis.inertia" = [0.01, inf]
[fit.standard_error]
"axis.inertia" = 1e-4
[effects."axis.stribeck"]
""".replace("PARAMETER", STRIBECK[0])
        + "".join(f"{name} = {i}\n" for i, name in enumerate(STRIBECK)),
        encoding="utf-8-sig",  # a byte order mark, as some editors write it
    )
    rig = read_rig(path)
    assert (rig.kind, rig.name) == ("reaction", "testbed")
    assert rig.numbers["motor.torque_constant"] == 0.0182 and "motor.inductance" not in rig.numbers
    assert rig.pwm == Pwm(1500.0, 0.02) and rig.counts_per_rev == {"axis": 2048.0, "wheel": 12.0}
    assert rig.columns == {"position": "pos1", "pulse": "pwm_2"}
    assert rig.free == ("axis.inertia", f"axis.stribeck.{STRIBECK[0]}")
    assert rig.bounds == {"axis.inertia": (0.01, math.inf)} and rig.standard_error == {"axis.inertia": 1e-4}
    assert rig.effects == {"axis.stribeck": {name: float(i) for i, name in enumerate(STRIBECK)}}
    assert rig.values[f"axis.stribeck.{STRIBECK[1]}"] == 1.0


def test_polynomial_stands_for_four_numbers():
    rig = parse_rig(
        PLATFORM + 'friction.polynomial = [0.4, -5.2e-2, 2e-2, -7e-4]\n[fit]\nfree = ["axis.friction.polynomial"]'
    )
    assert [rig.numbers[b] for b in COEFFICIENTS] == [0.4, -5.2e-2, 2e-2, -7e-4]
    assert rig.free == COEFFICIENTS
    assert 'free = ["axis.friction.polynomial"]' in write_rig(rig)


def test_estimates_take_their_place():
    rig = parse_rig(PLATFORM).with_values({"axis.inertia": 0.3})
    assert rig.numbers == {"drive.gain": -0.428, "axis.inertia": 0.3}
    with pytest.raises(KeyError, match="axis.friction.coulomb"):
        rig.with_values({"axis.friction.coulomb": 0.1})


FRICTION = PLATFORM + "[axis.friction]\n"
FIT = "[fit]\nfree = ['axis.inertia']\n"
FREE = PLATFORM + "[fit]\nfree = "
MALFORMED = [
    ("kind = wheel", "rig.toml:1: not valid TOML: Invalid value"),
    ("a = 1\n[motor\n", "rig.toml:2: not valid TOML"),
    ("[axis]\ninertia = 0,06", "decimals take a point (0.06), thousands nothing (4096)"),
    ("[axis]\ninertia = 0.06 kg m2", "a unit does not stand in the file, all numbers are in SI (0.06 # kg m2)"),
    ("[axis]\ninertia = 6e-2kg", "a unit does not stand in the file"),
    ("[axis]\ninertia = 1e-3 2", "write `key = value` under `[section]` headers"),
    ("[axis]\ninertia = 1e-3\ninertia = 1e-3", "write `key = value` under `[section]` headers"),
    ("name = 'x'", 'no `kind`; write kind = "wheel", "platform", "reaction" or "two_axis"'),
    ("kind = 'car'", '`kind` is \'car\'; write kind = "wheel", "platform", "reaction" or "two_axis"'),
    ("kind = 'platform'\nname = 3", '`name` is 3; it has to be a text in quotes, "3"'),
    (WHEEL + "[motr]", "unknown key `motr`; the nearest valid one is `motor."),
    (WHEEL + "inerta = 1", "unknown key `wheel.inerta`; the nearest valid one is `wheel.inertia`"),
    (PLATFORM + "friction.viscuos = 1", "the nearest valid one is `axis.friction.viscous`"),
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
    (
        'kind = "wheel"\n' + MOTOR,
        "no `wheel.inertia` (J, kg m2), which a `wheel` rig needs; write inertia = … under",
    ),
    (
        REACTION.replace("resistance = 0.83\n", ""),
        "no `motor.resistance` (R, ohm), which a `reaction` rig needs",
    ),
    (PLATFORM.replace("gain = -0.428\n", ""), "no `drive.gain` (k, N m/V), which a `platform` rig needs"),
    (PLATFORM.replace("0.228", "'0.228'"), "`axis.inertia` is '0.228'; it has to be a number"),
    (PLATFORM.replace("0.228", "true"), "`axis.inertia` is True; it has to be a number"),
    (PLATFORM.replace("0.228", "nan"), "`axis.inertia` is nan; it has to be a finite number"),
    (PLATFORM.replace("0.228", "1" + 400 * "0"), "`axis.inertia` is inf; it has to be a finite number"),
    (PLATFORM.replace("0.228", "-0.228"), "`axis.inertia` is -0.228; it has to be positive"),
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
        PLATFORM + "[effects.'axis.stribeck']\nM_c = 0.1\nM_e = 0.1\nv_s = 0",
        '`effects."axis.stribeck".v_s` is 0.0; it has to be positive',
    ),
    (
        FRICTION + "viscous = 1\npolynomial = [1, 2, 3, 4]",
        "is the whole friction, and `axis.friction.viscous` stands",
    ),
    (FRICTION + "polynomial = [1, 2]", "is [1, 2]; it has to be the four numbers [b3, b2, b1, b0]"),
    (FRICTION + "polynomial = [1, 2, 'x', 4]", "`axis.friction.b1` is 'x'; it has to be a number"),
    (WHEEL + "[drive]\npwm = { neutral_us = 1500 }", "`drive.pwm` has no `volts_per_us`; write pwm = {"),
    (WHEEL + "[columns]\npulse = 'pos1'", '`columns.pulse` is \'pos1\'; it has to be "pwm_1" or "pwm_2"'),
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
    (PLATFORM + "[fit]\nfre = []", "unknown key `fit.fre`; the nearest valid one is `fit.free`"),
    (PLATFORM + "[fit]\nbounds = 3", "`fit.bounds` is not a table; write it as a section `[fit.bounds]`"),
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
    (PLATFORM + FIT + "[fit.prior]\n'drive.gain' = [1, 1]", "is of no use, since `drive.gain` is not estimated"),
    (PLATFORM + FIT + "per_run = ['drive.gain']", "`fit.per_run` names `drive.gain`, which is not estimated"),
    (PLATFORM + FIT + "per_run = 'drive.gain'", "`fit.per_run` is 'drive.gain'; it has to be a list of names"),
    (PLATFORM + "[fit.standard_error]\n'axis.inerta' = 1", "the nearest is `axis.inertia`"),
    (PLATFORM + "[fit.standard_error]\n'axis.inertia' = -1", "it has to be zero or positive"),
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
    (PLATFORM + "[effects]\naxis = 1", "no effect `axis` for a `platform` rig"),
]


@pytest.mark.parametrize(("text", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_malformed_rig_is_refused_in_one_line(text, message):
    with pytest.raises(RigError) as error:
        parse_rig(text)
    said = str(error.value)
    assert said.startswith("rig.toml:") and message in said and len(said.splitlines()) == 1


def test_unreadable_files(tmp_path):
    with pytest.raises(RigError, match="none.toml: cannot be read: No such file or directory; give the path"):
        read_rig(tmp_path / "none.toml")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        read_rig(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b'kind = "wheel"\nname = "Stra\xdfe"')
    with pytest.raises(RigError, match="latin.toml:2: byte 0xdf is not UTF-8; save the file as UTF-8"):
        read_rig(tmp_path / "latin.toml")


def test_line_breaks_in_a_key_stay_on_the_line():
    with pytest.raises(RigError) as error:
        parse_rig(WHEEL + r'"a\nb" = 1')
    assert r"unknown key `wheel.a\nb`" in str(error.value)


def test_reading_without_effects_is_light(monkeypatch):
    monkeypatch.setattr("rwjax.rig.effect_section.effect_parameters", lambda: pytest.fail("imports JAX"))
    assert parse_rig(write_rig(parse_rig(WHEEL))).kind == "wheel"


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
