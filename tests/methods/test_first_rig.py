"""First rig files: the kind by the columns, numbers by the datasheet, and free ones near what made the logs."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rwjax import InputError, LogError, Rig, parse_rig, read_logs, simulate, write_log
from rwjax.fitting.questions.check import check
from rwjax.methods.first_rig import Datasheet, first_rig
from rwjax.methods.known import Known
from rwjax.methods.mujoco_joint import MujocoJoint
from tests.systems import platform, reaction, wheel

NOTHING = Datasheet()


def text_of(*given: Any) -> str:
    """The text of a first rig file."""
    return first_rig(*given).text


def logs_of(rig: Rig, folder: Path, names: tuple[str, ...], volts: float = 3.0) -> list[Path]:
    """A log of a rig under squares of a rising height."""
    t = 0.01 * np.arange(1500)
    u = volts * np.sign(np.sin(1.5 * t)) * (1.0 + 0.2 * t / t[-1]) * (t > 0.6)
    run = simulate(rig, t, u)
    rng = np.random.default_rng(1)
    columns = {name: np.asarray(run[name]) + 1e-4 * rng.standard_normal(len(t)) for name in names}
    write_log(folder / "run.csv", {"time_s": t, "voltage_V": u} | columns, {})
    return [folder / "run.csv"]


@pytest.mark.parametrize(
    ("rig", "names", "kind"),
    [
        (platform("viscous = 0.02"), ("yaw_rad",), "platform"),
        (wheel(), ("wheel_rad_s",), "wheel"),
        (reaction(), ("yaw_rad", "wheel_rad_s"), "reaction"),
    ],
)
def test_the_columns_tell_the_kind_and_the_file_reads_back(
    rig: Rig, names: tuple[str, ...], kind: str, tmp_path: Path
) -> None:
    paths = logs_of(rig, tmp_path, names)
    found = parse_rig(text_of(paths, NOTHING))
    assert found.kind == kind and found.name == tmp_path.name and found.free
    assert len(read_logs(paths, found)) == 1


def test_free_numbers_come_near_those_that_made_the_log(tmp_path: Path) -> None:
    paths = logs_of(platform("viscous = 0.02"), tmp_path, ("yaw_rad",))
    found = parse_rig(text_of(paths, Datasheet(supply=10.0, stall_torque=4.0)))
    assert found.numbers["drive.gain"] == 0.4
    assert found.numbers["axis.inertia"] == pytest.approx(0.1, rel=0.05)
    assert found.numbers["axis.friction.viscous"] == pytest.approx(0.02, rel=0.1)
    scaled = parse_rig(text_of(paths, NOTHING))  # in units of the gain
    assert scaled.numbers["axis.inertia"] == pytest.approx(0.1 / 0.4, rel=0.05)
    weighed = parse_rig(text_of(paths, Datasheet(axis_inertia=0.1)))  # which tells the gain
    assert weighed.numbers["drive.gain"] == pytest.approx(0.4, rel=0.05)


def test_a_datasheet_gives_the_motor_behind_its_gear(tmp_path: Path) -> None:
    t = 0.01 * np.arange(400)
    columns = {"time_s": t, "duty": 0.3 * np.sin(3.0 * t), "position_rad": 0.2 * np.sin(3.0 * t - 1.0)}
    write_log(tmp_path / "run.csv", columns, {})
    datasheet = Datasheet(supply=12.0, stall_torque=2.0, no_load_speed=6.0, mass=0.3, length=0.2)
    found = parse_rig(text_of([tmp_path / "run.csv"], datasheet))
    assert found.kind == "joint" and found.numbers["drive.supply"] == 12.0
    assert found.numbers["motor.torque_constant"] == pytest.approx(2.0)
    assert found.numbers["motor.resistance"] == pytest.approx(12.0)  # 2 N m/A · 12 V / 2 N m
    assert {"axis.gravity.torque", "axis.inertia"} <= {*found.free}
    by_winding = parse_rig(text_of([tmp_path / "run.csv"], Datasheet(supply=12.0, stall_torque=2.0, resistance=6.0)))
    assert by_winding.numbers["motor.torque_constant"] == pytest.approx(1.0)  # 2 N m by 12 V / 6 ohm
    with pytest.raises(LogError, match="no column holds counts, and an angle needs no --counts: leave it out"):
        first_rig([tmp_path / "run.csv"], datasheet._replace(counts=2048.0))


@pytest.mark.parametrize(
    ("header", "given", "kind"),
    [
        ("millis,pwm,count", {}, "platform"),
        ("millis,pwm,count", {"torque_constant": 0.05, "resistance": 2.0}, "wheel"),
        ("millis,pwm,count,mA", {"wheel_inertia": 1e-3}, "wheel"),
        ("millis,pwm,count,mA", {}, "joint"),
        ("millis,pwm,count", {"torque_constant": 0.05, "axis_inertia": 0.02}, "joint"),
        ("millis,pwm,angle_deg,wheel_rpm", {}, "reaction"),
        ("millis,pwm,flywheel_rpm", {}, "wheel"),
        ("millis,pwm,yaw_deg", {"resistance": 2.0}, "joint"),
        ("millis,pwm,yaw_deg", {"wheel_inertia": 1e-3}, "reaction"),
        ("millis,pwm,count", {"wheel_inertia": 1e-3, "axis_inertia": 0.05}, "reaction"),
        ("millis,pwm,yaw_deg", {"supply": 12.0, "stall_torque": 2.0, "no_load_speed": 6.0}, "platform"),
        ("millis,goal_deg,yaw_deg", {"resistance": 2.0}, "joint"),
    ],
)
def test_what_is_known_of_a_motor_tells_the_kind_where_the_columns_do_not(
    header: str, given: dict[str, Any], kind: str, tmp_path: Path
) -> None:
    rows = [f"{10 * k},{100 * (-1) ** (k // 50)},{30 * k},{12 * k % 7}" for k in range(200)]
    columns = header.count(",") + 1
    (tmp_path / "run.csv").write_text("\n".join([header, *(",".join(row.split(",")[:columns]) for row in rows), ""]))
    found = parse_rig(text_of([tmp_path / "run.csv"], Datasheet(**given)))
    assert found.kind == kind
    numbers = {"torque_constant": "motor.torque_constant", "resistance": "motor.resistance"}
    numbers |= {"wheel_inertia": "wheel.inertia", "axis_inertia": "axis.inertia"}
    known = {numbers[name]: value for name, value in given.items() if name in numbers}
    assert known.items() <= found.numbers.items() and not {*known} & {*found.free}
    scale = {"drive.gain", "motor.torque_constant", "axis.inertia", "wheel.inertia"} & {*found.numbers}
    assert scale & {*found.free} or scale <= {*known} | {"drive.gain"}  # what torques and inertias are in proportion to


def test_a_number_that_the_kind_does_not_have_is_refused(tmp_path: Path) -> None:
    paths = logs_of(platform("viscous = 0.02"), tmp_path, ("yaw_rad",))
    with pytest.raises(
        LogError, match="--wheel-inertia is given, and a first rig of kind `platform` has no wheel.inertia"
    ):
        text_of(paths, Datasheet(wheel_inertia=1e-3), "platform")


def test_a_resistance_is_free_where_a_current_is_read_under_a_voltage_alone(tmp_path: Path) -> None:
    t = 0.01 * np.arange(400)
    for command, free in (("voltage_V", True), ("command_A", False)):
        columns = {"time_s": t, command: np.sin(3.0 * t), "current_A": 0.4 * np.sin(3.0 * t), "wheel_rad_s": np.sin(t)}
        write_log(tmp_path / "run.csv", columns, {})
        found = parse_rig(text_of([tmp_path / "run.csv"], NOTHING))
        assert ("motor.resistance" in found.free) == free


def test_columns_of_another_layout_are_proposed_and_guesses_are_said(tmp_path: Path) -> None:
    rows = "\n".join(f"{10 * k},{100 * math.sin(0.05 * k):.0f},{k}" for k in range(300))
    (tmp_path / "run.csv").write_text(f"millis,pwm,encoder_counts\n{rows}\n")
    text = text_of([tmp_path / "run.csv"], Datasheet(counts=4096))
    found = parse_rig(text)
    assert found.kind == "platform" and found.counts_per_rev == {"axis": 4096}
    assert {*found.sources} == {"time_s", "voltage_V", "yaw_counts"} and "right?" in text


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "millis,pwm,encoder\n" + "\n".join(f"{k},{'abc' if k == 5 else k % 7},{k}" for k in range(50)),
            ":7: `pwm` is 'abc'",
        ),
        (
            "millis,foo,encoder\n" + "\n".join(f"{k},{k % 7},{k}" for k in range(50)),
            "a command; found millis, foo, encoder",
        ),
        ("millis,pwm,encoder\n1,2,3\n2,3,4\n", "at least 10"),
        ("time_s,voltage_1_V,voltage_2_V,pitch_rad\n" + "\n".join(f"{k},1,2,3" for k in range(50)), "two axes"),
    ],
)
def test_what_is_wrong_with_a_log_is_said_by_its_own_columns(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(text)
    with pytest.raises(InputError, match=says):
        text_of([tmp_path / "run.csv"], NOTHING)


def test_numbers_of_a_mujoco_hinge_go_with_the_columns_of_its_logs(tmp_path: Path) -> None:
    known = {
        "axis.inertia": Known(0.02, "of the model"),
        "axis.friction.viscous": Known(0.01, "of the model", free=True),
    }
    gains = {"drive.servo.kp": Known(4.0, "kp of the model", free=True)}
    spring = {"axis.spring": {"k": 0.3, "T_0": 0.0, "k_3": 0.0}}
    t = 0.01 * np.arange(200)
    write_log(tmp_path / "run.csv", {"time_s": t, "goal_rad": np.sin(t), "yaw_counts": np.round(100 * np.sin(t))}, {})
    text = text_of([tmp_path / "run.csv"], NOTHING, None, MujocoJoint("elbow", known | gains, True, spring, ("so.",)))
    found = parse_rig(text)
    assert text.startswith("# so.\n") and found.kind == "joint" and found.effects == spring
    assert found.servo is not None and (found.servo.acts_on, found.servo.damping_on) == ("torque", "speed")
    assert {name: found.numbers[name] for name in known | gains} == {n: k.value for n, k in (known | gains).items()}
    assert found.free == ("axis.friction.viscous", "drive.servo.kp")
    with pytest.raises(LogError, match="`elbow` takes command_Nm"):
        text_of([tmp_path / "run.csv"], NOTHING, None, MujocoJoint("elbow", known, False, {}, ()))


def test_an_axis_that_pitches_is_the_one_axis(tmp_path: Path) -> None:
    rows = [f"{k / 100},{(-1) ** (k // 50)},{(k / 100) ** 2},{k / 50}" for k in range(200)]
    text = "\n".join(["time_s,voltage_V,pitch_rad,pitch_rad_s", *rows])
    (tmp_path / "run.csv").write_text(text)
    found = parse_rig(text_of([tmp_path / "run.csv"], NOTHING))
    assert (found.sources["yaw_rad"].column, found.sources["yaw_rad_s"].column) == ("pitch_rad", "pitch_rad_s")
    (tmp_path / "run.csv").write_text(f"# layout: rwjax\n{text}")  # of which every column has its name
    with pytest.raises(LogError, match="which is called yaw: write `yaw_rad` for `pitch_rad`, `yaw_rad_s`"):
        text_of([tmp_path / "run.csv"], NOTHING)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        (
            "time_s,voltage_1_V,voltage_2_V,yaw_rad,pitch_rad,temp",
            "a rig with two axes; `init` writes rigs with one command",
        ),
        ("time_s,voltage_V,pitch_rad,yaw_rad,b,c", "a rig with two axes"),
        (
            "t,pos1,pos2,speed2,pwm_1,pwm_2",
            'the thesis layout; write a rig file by hand with [columns] `position = "pos1"`',
        ),
    ],
)
def test_what_init_does_not_write_is_said(header: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("\n".join([header, *(f"{k / 100},1,1,{k},{k},{k}" for k in range(40))]))
    with pytest.raises(LogError, match=re.escape(message)):
        text_of([tmp_path / "run.csv"], NOTHING)


def test_a_number_in_a_name_makes_no_second_axis(tmp_path: Path) -> None:
    text = logs_of(platform("viscous = 0.02"), tmp_path, ("yaw_rad",))[0].read_text().splitlines()
    head = next(k for k, line in enumerate(text) if line.startswith("time_s"))
    more = [*text[:head], text[head] + ",temp_1_C", *(line + ",20" for line in text[head + 1 :])]
    (tmp_path / "run.csv").write_text("\n".join(["# ignore: temp_1_C", *more]))
    assert parse_rig(text_of([tmp_path / "run.csv"], NOTHING)).kind == "platform"


def test_a_commanded_torque_makes_a_joint_and_is_no_command_of_another_rig(tmp_path: Path) -> None:
    rows = [f"{k / 100},{(-1) ** (k // 50) * 0.1},{0.09},{math.sin(0.05 * k)},{0.1}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["time_s,torque_meas_Nm,torque_cmd_Nm,angle_rad,angle_des_rad", *rows]))
    rig = parse_rig(first_rig([tmp_path / "run.csv"], NOTHING).text)
    (log,) = read_logs([tmp_path / "run.csv"], rig)
    assert rig.kind == "joint" and log.input == "command_Nm" and {*log.outputs} == {"yaw_rad"}
    with pytest.raises(LogError, match="`torque_cmd_Nm` looks like .* give --kind joint$"):
        first_rig([tmp_path / "run.csv"], NOTHING, kind="platform")
    (tmp_path / "driven.csv").write_text(
        "\n".join(["time_s,torque_cmd_Nm,voltage_V,angle_rad", *(row.rpartition(",")[0] for row in rows)])
    )
    rig = parse_rig(first_rig([tmp_path / "driven.csv"], NOTHING, kind="joint").text)
    assert "command_Nm" not in rig.columns  # a voltage drives, whatever torque it follows


@pytest.mark.parametrize(
    ("names", "command"),
    [
        ("Zeit [s],Stellgrad [%],Winkel [deg]", "duty"),
        ("Zeit [s],STELL PERCENT,Winkel [deg]", "duty"),
        ("t,Stellgröße,yaw_counts", "voltage_V"),
        ("time_s,Stellgröße,yaw_rad", "voltage_V"),
    ],
)
def test_a_command_under_an_unknown_name_is_told_by_lines_that_are_a_rig_file(
    tmp_path: Path, names: str, command: str
) -> None:
    rows = [f"{k / 100},{(-1) ** (k // 50) * 40},{k // 3}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join([names, *rows]))
    with pytest.raises(LogError, match="no column is taken for a command") as said:
        first_rig([tmp_path / "run.csv"], NOTHING)
    lines = re.findall("`([a-z_.]+ = [^`]*)`", str(said.value).partition("a file with the lines")[2])
    rig = parse_rig("\n".join(lines))
    (log,) = read_logs([tmp_path / "run.csv"], rig)
    assert log.input == command and {*log.outputs} == {"yaw_rad"} and rig.free
    assert ("so is the unit V" in str(said.value)) == (command == "voltage_V")


def test_an_unknown_command_too_large_for_volts_gets_a_scale_that_is_said_to_be_a_guess(tmp_path: Path) -> None:
    rows = [f"{k / 100},{(-1) ** (k // 50) * 255},{k // 3}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["time_s,Stell,yaw_rad", *rows]))
    with pytest.raises(LogError, match="is a first rig; .* is a guess, and so is the scale$") as said:
        first_rig([tmp_path / "run.csv"], NOTHING)
    assert 'voltage_V = { column = "Stell", scale = "12 V / 255" }' in str(said.value)


@pytest.mark.parametrize(
    ("name", "low"),
    [
        ("temperature_C", -1),
        ("temp [°C]", -1),
        ("accel_m_s2", -1),
        ("load_torque_Nm", -1),
        ("temperature", 1),
        ("note", math.nan),
    ],
)
def test_a_column_of_another_unit_or_of_one_sign_is_no_command_of_a_first_rig(
    tmp_path: Path, name: str, low: float
) -> None:
    rows = [f"{k / 100},{(low if k % 2 else 2) if low == low else 'x'},{0.01 * k}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join([f"time_s,{name},yaw_rad", *rows]))
    with pytest.raises(LogError, match="no column is taken for a command|has to be a number") as said:
        first_rig([tmp_path / "run.csv"], NOTHING)
    assert "is a first rig" not in str(said.value)


def test_beside_a_temperature_the_other_unknown_column_is_the_command(tmp_path: Path) -> None:
    rows = [f"{k / 100},{(-1) ** (k // 50)},{20 + k / 100},{0.01 * k}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["time_s,Stell,temperature_C,yaw_rad", *rows]))
    with pytest.raises(LogError, match='voltage_V = "Stell" }` and `fit'):
        first_rig([tmp_path / "run.csv"], NOTHING)


def test_of_several_unknown_columns_the_user_has_to_say_which_is_the_command(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(
        "time_s,foo,bar,yaw_rad\n" + "\n".join(f"{k},{k % 7 - 3},{k % 3 - 1},{k}" for k in range(50))
    )
    with pytest.raises(LogError, match=r'voltage_V = "NAME" }` and `fit\.free = '):
        first_rig([tmp_path / "run.csv"], NOTHING)


@pytest.mark.parametrize("name", ["foo", "load_torque_Nm"])
def test_a_log_without_a_command_is_told_what_commands_there_are(tmp_path: Path, name: str) -> None:
    (tmp_path / "run.csv").write_text(f"millis,{name},encoder\n" + "\n".join(f"{k},{k % 7},{k}" for k in range(50)))
    with pytest.raises(LogError) as said:
        first_rig([tmp_path / "run.csv"], NOTHING)
    assert all(name in str(said.value) for name in ("voltage_V", "duty", "command_A", "command_Nm", "goal_rad"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "given",
    [{}, {"axis_inertia": 0.02}, {"mass": 0.4, "length": 0.3}, {"supply": 12.0, "no_load_speed": 6.0}],
    ids=["nothing", "inertia", "weight", "speed"],
)
@pytest.mark.parametrize("kind", ["joint", "platform"])
def test_logs_of_a_servo_tell_every_number_that_is_free(kind: str, given: dict[str, Any], tmp_path: Path) -> None:
    t = 0.01 * np.arange(600)
    goal = np.sign(np.sin(2.0 * t)) * (t > 0.3) + 0.3 * np.sin(9.0 * t)
    text = f'kind = "{kind}"\naxis.inertia = 0.02\naxis.friction.viscous = 0.05\ndrive.servo.kp = 2.0\ndrive.servo.acts_on = "voltage"\n'
    text += "drive.gain = 0.3" if kind == "platform" else "motor.torque_constant = 0.3\nmotor.resistance = 1.0"
    moved = simulate(parse_rig(text), t, {"goal_rad": goal})["yaw_rad"]
    write_log(tmp_path / "run.csv", {"time_s": t, "goal_rad": goal, "yaw_rad": np.asarray(moved)}, {})
    rig = parse_rig(text_of([tmp_path / "run.csv"], Datasheet(**given), kind))
    said = [
        str(finding) for finding in check(rig, read_logs([tmp_path / "run.csv"], rig)) if finding.about == "numbers"
    ]
    assert not [line for line in said if "fix one" in line], said
    scaled = "axis_inertia" in given or (kind == "joint" and "mass" in given)
    assert ("drive.servo.kp" in rig.free) == scaled and "axis.friction.viscous" in rig.free


def test_gravity_stands_ready_in_comments_where_nothing_is_known_of_it(tmp_path: Path) -> None:
    text = text_of(logs_of(platform("viscous = 0.02"), tmp_path, ("yaw_rad",)), NOTHING)
    told = re.sub(r"^# (?=\[axis\.gravity\]|torque|angle)", "", text, flags=re.MULTILINE)
    assert parse_rig(told).numbers["axis.gravity.torque"] > 0.0
    assert "axis.gravity.torque" not in parse_rig(text).numbers


@pytest.mark.slow
def test_a_speed_without_a_load_that_a_measured_motor_passes_frees_its_torque_constant(realdata: Path) -> None:
    log = realdata / "dcmotor_deadzone_l298n" / "staircase_run.csv"
    found = first_rig([log], Datasheet(supply=12.0, no_load_speed=300.0 * math.pi / 30.0, resistance=1.371))
    rig = parse_rig(found.text)
    assert rig.numbers["motor.friction"] == 0.0 and {*rig.free} == {"motor.torque_constant", "wheel.inertia"}
    assert any("times as fast per volt" in note for note in found.notes)


@pytest.mark.slow
def test_a_measured_servo_tells_every_number_that_is_free(realdata: Path) -> None:
    log = realdata / "feetech_sts3215_pendulum" / "sin_sin_L100_m0535_kp16.csv"
    rig = parse_rig(text_of([log], NOTHING))
    assert not [
        finding
        for finding in check(rig, read_logs([log], rig))
        if finding.about == "numbers" and finding.kind != "guessed"
    ]


def servo_log(folder: Path) -> list[Path]:
    """A log of a servo's goal and position."""
    t = 0.01 * np.arange(200)
    write_log(folder / "run.csv", {"time_s": t, "goal_rad": np.sin(t), "position_rad": np.sin(t - 0.1)}, {})
    return [folder / "run.csv"]


@pytest.mark.parametrize(("bob", "inertia", "torque"), [(False, 0.4 * 0.09 / 3.0, 0.2), (True, 0.4 * 0.09, 0.4)])
def test_a_mass_is_that_of_a_rod_or_of_a_bob(bob: bool, inertia: float, torque: float, tmp_path: Path) -> None:
    text = text_of(servo_log(tmp_path), Datasheet(mass=0.4, length=0.3, bob=bob))
    found = parse_rig(text)
    assert found.numbers["axis.inertia"] == pytest.approx(inertia, rel=1e-2)
    assert found.numbers["axis.gravity.torque"] == pytest.approx(torque * 9.81 * 0.3, rel=1e-2)
    assert ("of a bob, m l²" in text) == bob and ("of a bob at its end twice that" in text) == (not bob)


def test_a_weight_tells_the_torques_of_a_motor_under_a_voltage_as_it_does_those_of_a_servo(tmp_path: Path) -> None:
    inertia, weight = 0.4 * 0.5**2 / 3.0, 0.5 * 0.4 * 9.81 * 0.5
    motor = "[motor]\ntorque_constant = 0.3\nresistance = 1.0"
    axis = f"[axis]\ninertia = {inertia}\nfriction.viscous = 0.05\ngravity.torque = {weight}\ngravity.angle = 0.0"
    paths = logs_of(parse_rig(f'kind = "joint"\n{motor}\n{axis}\n'), tmp_path, ("yaw_rad",))
    found = parse_rig(text_of(paths, Datasheet(mass=0.4, length=0.5), "joint"))
    assert "motor.torque_constant" in found.free and "axis.gravity.torque" not in found.free
    assert found.numbers["axis.gravity.torque"] == pytest.approx(0.981)
    assert found.numbers["motor.torque_constant"] == pytest.approx(0.3, rel=0.1)
    assert found.numbers["axis.inertia"] == pytest.approx(inertia, rel=0.1)
    for given in ({"torque_constant": 0.3, "resistance": 1.0}, {"axis_inertia": 0.03}):
        known = parse_rig(text_of(paths, Datasheet(mass=0.4, length=0.5, **given), "joint"))
        assert "axis.gravity.torque" in known.free


@pytest.mark.parametrize("command", ["voltage_V", "command_A"])
def test_a_current_tells_the_torques_so_that_the_weight_stays_free(command: str, tmp_path: Path) -> None:
    t = 0.01 * np.arange(400)
    columns = {"time_s": t, command: np.sin(3.0 * t), "yaw_rad": 0.2 * np.sin(3.0 * t - 1.0)}
    for more, free in (({}, False), ({"current_A": 0.4 * np.sin(3.0 * t)}, True)):
        write_log(tmp_path / "run.csv", columns | more, {})
        found = parse_rig(text_of([tmp_path / "run.csv"], Datasheet(mass=0.4, length=0.5), "joint"))
        assert ("axis.gravity.torque" in found.free) == free and "motor.torque_constant" in found.free


def test_a_number_of_the_datasheet_that_the_file_does_not_use_is_said(tmp_path: Path) -> None:
    paths = servo_log(tmp_path)
    said = first_rig(paths, Datasheet(supply=12.0, resistance=1.4), "joint").notes[0]
    assert said.startswith(
        "--supply is not used: no number of this file comes from it; it tells a motor together with --no-load"
    )
    given = Datasheet(supply=12.0, no_load_speed=6.0, stall_torque=2.0, torque_constant=0.1, resistance=2.0)
    assert unused(paths, given) == ["--supply", "--stall-torque", "--no-load-speed"]
    assert unused(paths, Datasheet(supply=12.0, stall_torque=2.0, no_load_speed=6.0, mass=0.4, length=0.3)) == []
    volts = logs_of(wheel(0.0), tmp_path, ("wheel_rad_s",))
    assert unused(volts, Datasheet(mass=0.4, length=0.3)) == ["--mass", "--length"]


@pytest.mark.parametrize(("supply", "scale"), [(9.0, "9 V / 255"), (None, "12 V / 255")])
def test_a_supply_is_that_of_a_pwm(supply: float | None, scale: str, tmp_path: Path) -> None:
    rows = [f"{10 * k},{255 * (-1) ** (k // 50)},{30 * k}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["ms,pwm,counts", *rows, ""]))
    given = Datasheet(supply=supply)
    assert f'voltage_V = {{ column = "pwm", scale = "{scale}" }}' in text_of([tmp_path / "run.csv"], given)
    assert unused([tmp_path / "run.csv"], given) == []


def unused(paths: list[Path], given: Datasheet) -> list[str]:
    """Options that the notes of a first rig call unused."""
    return [note.split()[0] for note in first_rig(paths, given).notes if "is not used" in note]


def test_the_file_of_a_servo_says_the_command_that_the_terminal_says(tmp_path: Path) -> None:
    assert text_of(servo_log(tmp_path), NOTHING).splitlines()[0].endswith("then `rwjax check`.")


@pytest.mark.parametrize(
    ("columns", "full", "where"),
    [
        ("ms,pwm,counts", 255, "`scale` under [columns]"),
        ("ms,throttle_pct,counts", 100, "`drive.supply`"),
        ("ms,throttle,counts", 46, "`scale` under [columns]"),
    ],
)
def test_a_supply_that_is_not_given_is_a_guess_and_said_to_be_one(
    columns: str, full: int, where: str, tmp_path: Path
) -> None:
    rows = [f"{10 * k},{full * (-1) ** (k // 50)},{30 * k}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join([columns, *rows, ""]))
    found = first_rig([tmp_path / "run.csv"], NOTHING)
    (said,) = [note for note in found.notes if "--supply" in note]
    assert "\n" not in said and f"12 V in {where} is a guess" in said
    (line,) = [line for line in found.text.splitlines() if line.startswith(("supply", "voltage_V"))]
    assert "a guess" in line.partition("#")[2] and parse_rig(found.text).free
    given = first_rig([tmp_path / "run.csv"], Datasheet(supply=9.0))
    assert not any("--supply" in note for note in given.notes) and "12" not in given.text.partition("[fit]")[0]


def test_a_column_that_is_called_a_guess_is_none(tmp_path: Path) -> None:
    rows = [f"{10 * k},{5 * (-1) ** (k // 50)},1,{30 * k}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["ms,volts_V,12 V is a guess,counts", *rows, ""]))
    assert not any("--supply" in note for note in first_rig([tmp_path / "run.csv"], NOTHING).notes)


def test_a_supply_that_is_logged_is_no_guess_that_is_noted(tmp_path: Path) -> None:
    rows = [f"{10 * k},{100 * (-1) ** (k // 50)},11.1,{30 * k}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["ms,throttle_pct,vbat,counts", *rows, ""]))
    assert not any("--supply" in note for note in first_rig([tmp_path / "run.csv"], NOTHING).notes)


def test_the_gain_of_a_platform_may_be_given(tmp_path: Path) -> None:
    paths = logs_of(platform("viscous = 0.02"), tmp_path, ("yaw_rad",))
    found = parse_rig(text_of(paths, Datasheet(gain=0.4)))
    assert found.kind == "platform" and found.numbers["drive.gain"] == 0.4 and "drive.gain" not in found.free
    assert found.numbers["axis.inertia"] == pytest.approx(0.1, rel=0.05)
    with pytest.raises(LogError, match="--gain is given, and a first rig of kind `joint` has no drive.gain"):
        text_of(paths, Datasheet(gain=0.4), "joint")
    for command in ("duty", "goal_rad"):  # of a joint, were the gain not given
        columns = {"time_s": 0.01 * np.arange(400), command: np.sin(np.arange(400)), "yaw_rad": np.cos(np.arange(400))}
        write_log(tmp_path / f"{command}.csv", columns, {})
        assert parse_rig(text_of([tmp_path / f"{command}.csv"], Datasheet(gain=0.4))).kind == "platform"


def test_a_supply_is_a_guess_beside_a_mujoco_model_too(tmp_path: Path) -> None:
    rows = [f"{10 * k},{255 * (-1) ** (k // 50)},{30 * k}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["ms,pwm,counts", *rows, ""]))
    numbers = ("axis.inertia", "axis.friction.viscous", "motor.torque_constant", "motor.resistance")
    hinge = MujocoJoint("elbow", {name: Known(0.02, "of the model") for name in numbers}, False, {}, ())
    counts = "guesses, which stay as they are: encoder.counts_per_rev; write the true ones"
    said, besides = first_rig([tmp_path / "run.csv"], NOTHING, None, hinge).notes
    assert said.startswith("--supply is not given: 12 V in `scale` under [columns] is a guess") and besides == counts
    given = first_rig([tmp_path / "run.csv"], Datasheet(supply=9.0), None, hinge)
    assert given.notes == (counts,) and '"9 V / 255"' in given.text
    paths = logs_of(platform("viscous = 0.02"), tmp_path, ("yaw_rad",))
    (said,) = first_rig(paths, Datasheet(supply=9.0), None, hinge).notes
    assert said.startswith("--supply is not used: ")


def test_a_temperature_is_no_command_by_hand(tmp_path: Path) -> None:
    rows = [f"{k / 100},{math.sin(k)},{math.sin(0.05 * k)}" for k in range(200)]
    (tmp_path / "run.csv").write_text("\n".join(["time_s,motor_temp,angle_rad", *rows]))
    with pytest.raises(LogError, match="no column is taken for a command") as said:
        text_of([tmp_path / "run.csv"], NOTHING)
    assert "is a first rig" not in str(said.value)
