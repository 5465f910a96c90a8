"""The C header: what its functions give, compiled by gcc, and by the board's compiler where it is there."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax import RigError, parse_rig
from rwjax.export.c_header import c_header
from rwjax.rig.model import Rig
from tests.systems import platform, reaction, wheel

FRICTION = "viscous = 0.02\ncoulomb = 0.05\nstatic = 0.08\nstribeck_velocity = 0.1"
DRIVE = {
    "drive.deadzone": {"u_0": 0.4, "j": 0.2},
    "drive.bias": {"u_b": 0.3},
    "drive.asymmetric_gain": {"a": 0.1},
}
WARNINGS = ("-Wall", "-Wextra", "-Werror", "-Wconversion", "-std=c99")


def header(rig: Rig, folder: Path) -> Path:
    path = folder / "feed_forward.h"
    path.write_text(c_header(replace(rig, name="test rig")).text)
    return path


def values(rig: Rig, folder: Path, call: str, over: np.ndarray) -> np.ndarray:
    """What a function of the header gives, compiled by gcc."""
    header(rig, folder)
    (folder / "main.c").write_text(
        '#include <stdio.h>\n#include "feed_forward.h"\n'
        f'int main(void) {{ float x; while (scanf("%f", &x) == 1) printf("%.9g\\n", (double)test_rig_{call}(x)); }}\n'
    )
    subprocess.run(["gcc", *WARNINGS, "-o", "main", "main.c", "-lm"], cwd=folder, check=True)
    given = "\n".join(map(repr, over.tolist()))
    done = subprocess.run([folder / "main"], input=given, capture_output=True, text=True, check=True)
    return np.array(done.stdout.split(), float)


def test_the_friction_is_that_of_the_rig(tmp_path: Path) -> None:
    rig = replace(platform(FRICTION), effects={"axis.asymmetric_friction": {"M_c": 0.0, "d": 0.01}})
    w = np.array([-2.0, -0.05, 0.0, 0.01, 0.1, 3.0])
    wanted = np.sign(w) * (0.05 + 0.03 * np.exp(-((w / 0.1) ** 2)) + 0.02 * np.abs(w) + 0.01 * np.sign(w))
    assert values(rig, tmp_path, "friction_torque", w) == pytest.approx(wanted, rel=1e-6, abs=1e-9)
    assert values(rig, tmp_path, "friction_command", w) == pytest.approx(wanted / 0.4, rel=1e-6, abs=1e-9)


def test_the_drive_gives_what_its_command_was_worked_out_for(tmp_path: Path) -> None:
    rig = replace(platform(), effects=DRIVE)
    wanted = np.array([-3.0, -0.7, -0.4, 0.33, 0.6, 2.0])  # 0.33 is what the offset alone gives
    near = values(
        replace(rig, effects={"drive.deadzone": DRIVE["drive.deadzone"]}),
        tmp_path,
        "drive_command",
        np.array([0.15, 0.05]),
    )
    assert 0.6 < near[0] < 0.61 and near[1] == 0.0  # the least with which it starts, or nothing
    u = values(rig, tmp_path, "drive_command", wanted)
    over = np.abs(u) > 0.6
    given = np.where(over, u - 0.4 * np.sign(u), 0.0) + 0.3
    given = given + 0.1 * np.abs(given)
    assert given == pytest.approx(wanted, rel=1e-5)


def test_a_reaction_wheel_is_driven_against_the_axis(tmp_path: Path) -> None:
    found = values(reaction(), tmp_path, "friction_command", np.array([1.0]))
    assert found == pytest.approx([-0.83 / 0.0182 * 0.0026], rel=1e-6)


def test_friction_never_drives(tmp_path: Path) -> None:
    rig = replace(platform("coulomb = 0.05"), effects={"axis.asymmetric_friction": {"M_c": 0.0, "d": 0.1}})
    assert values(rig, tmp_path, "friction_torque", np.array([-1.0, 1.0])) == pytest.approx([0.0, 0.15])


@pytest.mark.parametrize(("acts_on", "per_torque"), [("torque", 1.0), ("current", 50.0), ("duty", 100.0 / 12.0)])
def test_the_command_is_what_the_servo_acts_on(acts_on: str, per_torque: float, tmp_path: Path) -> None:
    rig = parse_rig(
        f'kind = "joint"\n[drive]\nsupply = 12.0\n[drive.servo]\nacts_on = "{acts_on}"\nkp = 1.0\n'
        "[motor]\ntorque_constant = 0.02\nresistance = 2.0\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.3\n"
    )
    assert values(rig, tmp_path, "friction_command", np.array([1.0])) == pytest.approx([0.3 * per_torque], rel=1e-6)


@pytest.mark.parametrize(("supply", "more"), [("supply = 12.0\n", 0.5 / 12.0), ("", 0.0)])
def test_a_dead_zone_in_volts_is_undone_in_a_duty(supply: str, more: float, tmp_path: Path) -> None:
    rig = parse_rig(
        f'kind = "joint"\n[drive]\n{supply}[drive.servo]\nacts_on = "duty"\nkp = 1.0\n[motor]\ntorque_constant = 0.02\n'
        'resistance = 2.0\n[axis]\ninertia = 0.1\n[effects."drive.deadzone"]\nu_0 = 0.5\nj = 0.0\n'
    )
    assert values(rig, tmp_path, "drive_command", np.array([0.3])) == pytest.approx([0.3 + more], rel=1e-6)
    left = c_header(rig).left_out
    assert ("drive.deadzone" in left) == (not supply) and (supply or "`drive.supply`" in left["drive.deadzone"])


@pytest.mark.parametrize(
    ("acts_on", "motor", "lacks"),
    [
        ("duty", "resistance = 2.0\ntorque_constant = 0.02", "drive.supply"),
        ("voltage", "torque_constant = 0.02", "motor.resistance"),
        ("current", "", "motor.torque_constant"),
        ("torque", "", ""),
    ],
)
def test_a_function_that_the_header_lacks_is_said_with_the_number_that_is_missing(
    acts_on: str, motor: str, lacks: str
) -> None:
    text = f'kind = "joint"\nname = "elbow"\n[motor]\n{motor}\n[drive.servo]\nacts_on = "{acts_on}"\nkp = 1.0\n'
    found = c_header(parse_rig(f"{text}[axis]\ninertia = 0.1\n"))
    assert ("elbow_friction_command(" in found.text) == (not lacks)
    said = {"elbow_friction_command": f"without `{lacks}` no command is known for a torque"}
    assert found.left_out == (said if lacks else {})


def test_names_of_all_letters_stand_in_the_header(tmp_path: Path) -> None:
    (tmp_path / "a.c").write_text(c_header(replace(platform(), name="a */ b \\ 7")).text)
    subprocess.run(["gcc", "-fsyntax-only", *WARNINGS, "a.c"], cwd=tmp_path, check=True)


def test_what_is_no_function_of_the_rate_is_left_out(tmp_path: Path) -> None:
    rig = replace(platform(), effects={"axis.periodic_torque": {"s": 0.1, "c": 0.0, "omega": 3.0, "p": 0.0, "q": 0.0}})
    found = c_header(rig)
    assert {*found.left_out} == {"axis.periodic_torque"} and "/* Left out is axis.periodic_torque: " in found.text
    assert "back-EMF" not in found.text  # a platform has no motor of its own
    with pytest.raises(RigError, match="wheel"):
        c_header(wheel())


@pytest.mark.skipif(shutil.which("avr-gcc") is None, reason="the board's compiler is not there")
def test_the_board_s_compiler_takes_it(tmp_path: Path) -> None:
    header(replace(platform(FRICTION), effects=DRIVE), tmp_path)
    (tmp_path / "main.c").write_text(
        '#include "feed_forward.h"\nvolatile float x;\nint main(void) { x = test_rig_friction_command(x); return 0; }\n'
    )
    command = ["avr-gcc", "-mmcu=atmega328p", "-Os", *WARNINGS, "-o", "main.elf", "main.c", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
