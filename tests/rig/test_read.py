"""Rig files read: a whole file, what is no TOML, and what is not imported on the way."""

import math
import subprocess
import sys

import pytest

from rwjax.errors import InputError, RigError
from rwjax.rig.model import Pwm
from rwjax.rig.read import parse_rig, read_one_axis_rig, read_rig
from rwjax.rig.write import write_rig
from tests.rig.texts import PLATFORM, REACTION, STRIBECK, WHEEL, is_refused
from tests.two_axes import two_axis


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


MALFORMED = [
    ("kind = wheel", "rig.toml:1: not valid TOML: Invalid value"),
    ("a = 1\n[motor\n", "rig.toml:2: not valid TOML"),
    ("[axis]\ninertia = 0,06", "decimals take a point (0.06), thousands nothing (4096)"),
    ("[axis]\ninertia = 0.06 kg m2", "a unit does not stand in the file, all numbers are in SI (0.06 # kg m2)"),
    ("[axis]\ninertia = 6e-2kg", "a unit does not stand in the file"),
    (
        "# " + 4_000 * "x" + "\n",
        "rig.toml:1: not valid TOML: 4002 characters on one line, 4000 at most (at line 1);",
    ),
    (250_001 * "\n", "rig.toml: not valid TOML: 250001 characters, and such a file has 250000 at most;"),
    ("a = " + 3900 * "[", "rig.toml: not valid TOML: tables or lists stand too deep"),
    ("# \x85\u2028\n[axis]\ninertia = 0,06", "decimals take a point (0.06), thousands nothing (4096)"),
    ("[axis]\ninertia = 1e-3 2", "write `key = value` under `[section]` headers"),
    (
        "[axis]\ninertia = 1e-3\ninertia = 1e-3",
        "rig.toml:3: not valid TOML: `inertia` is given twice in this section; keep one",
    ),
    (
        "[axis]\n[fit]\n[axis]",
        "rig.toml:3: not valid TOML: `[axis]` stands twice; put all its keys under one such header",
    ),
    ("[fit]\nfree = []\nfree = [\n]", "rig.toml: not valid TOML: Cannot overwrite a value"),
    ("axis.inertia = 1\n[axis]", "rig.toml:2: not valid TOML: Cannot declare"),
]


@pytest.mark.parametrize(("text", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_what_is_no_toml_is_refused_in_one_line(text: str, message: str) -> None:
    is_refused(text, message)


def test_unreadable_files(tmp_path):
    with pytest.raises(RigError, match="none.toml: cannot be read: No such file or directory; give the path"):
        read_rig(tmp_path / "none.toml")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        read_rig(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b'kind = "wheel"\nname = "Stra\xdfe"')
    with pytest.raises(RigError, match="latin.toml:2: byte 0xdf is not UTF-8; save the file as UTF-8"):
        read_rig(tmp_path / "latin.toml")


def test_a_log_in_the_place_of_the_rig_is_said_to_be_one() -> None:
    with pytest.raises(RigError, match="^log.csv:1: not valid TOML: .*; the rig file comes first, then the logs$"):
        parse_rig("time_s,voltage_V\n0,1\n", "log.csv")


def test_what_a_diagnosis_was_not_sure_of_is_read_from_the_comments_above_the_first_key() -> None:
    text = f"# my bench\n\n# caution: not claimed: a\n# caution: b\n{PLATFORM}\n# caution: c\n"
    assert parse_rig(text).cautions == ("not claimed: a", "b")
    assert parse_rig(PLATFORM).cautions == ()


def test_a_rig_without_a_name_has_that_of_its_file() -> None:
    assert (
        parse_rig(WHEEL, "rigs/flywheel.toml").name == "flywheel"
        and parse_rig('name = "mine"\n' + WHEEL).name == "mine"
    )


def test_a_rig_without_a_name_has_that_of_its_file_with_escapes(tmp_path) -> None:
    path = tmp_path / "a\nb\x1b\udcff.toml"
    path.write_text(WHEEL)
    assert read_rig(path).name == r"a\nb\x1b\udcff"
    with pytest.raises(RigError, match=r"a\\nb\\x1b\\udcff.toml: unknown key `wheel.x`"):
        parse_rig(WHEEL + "x = 1", path)


def test_what_knows_one_axis_refuses_two(tmp_path) -> None:
    (tmp_path / "one.toml").write_text(PLATFORM)
    (tmp_path / "two.toml").write_text(write_rig(two_axis()))
    assert read_one_axis_rig(tmp_path / "one.toml") == read_rig(tmp_path / "one.toml")
    with pytest.raises(
        RigError, match="two.toml: kind `two_axis` has two axes, and this is for one; describe that axis"
    ):
        read_one_axis_rig(tmp_path / "two.toml")


def test_reading_without_effects_is_light() -> None:
    code = f"""
import sys
from rwjax import parse_rig, write_rig
print(parse_rig(write_rig(parse_rig({WHEEL!r}))).kind, "jax" in sys.modules)
"""
    out = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env={"PYTHONPATH": ":".join(sys.path)}
    )
    assert out.stdout == "wheel False\n", out.stderr


def test_a_key_is_guessed_where_the_comment_behind_it_says_so() -> None:
    text = 'kind = "platform"\ndrive.gain = 0.4   # a guess\n[axis]\n# inertia = 0.2   # a guess\ninertia = 0.1   # kg m2: a guess, or a scale\n'
    text += '[axis.friction]\nviscous = 0.0   # no guesswork, and not a guess\n[columns]\nyaw_rad = "a guess"\n'
    assert parse_rig(text).guessed == ("drive.gain", "axis.inertia")


@pytest.mark.parametrize("header", ['[effects."drive.deadzone"]', "[ axis ]"])
def test_a_guess_is_of_the_section_that_it_stands_in_however_that_is_written(header: str) -> None:
    rig = 'kind = "joint"\n[motor]\ntorque_constant = 0.1\nresistance = 1.0\n{}[drive.servo]\nacts_on = "voltage"\nkp = 2.0\n{}'
    if header == "[ axis ]":
        text, key = rig.format("", f"{header}\ninertia = 0.1   # a guess\n"), "axis.inertia"
    else:
        section = f"{header}\nu_0 = 0.5   # a guess\nj = 0.0\n"
        text, key = rig.format("[axis]\ninertia = 0.1\n", section), "drive.deadzone.u_0"
    assert parse_rig(text).guessed == (key,)
