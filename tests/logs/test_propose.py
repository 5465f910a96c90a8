"""Proposed sections: names, units and values of columns as loggers write them."""

from pathlib import Path

import numpy as np
import pytest

from rwjax.logs.array_sheet import ArraySheet
from rwjax.logs.propose import description, is_temperature, proposal, proposed
from rwjax.logs.read_sheet import read_sheet
from rwjax.rig.read import parse_rig
from tests.rig.texts import PLATFORM, WHEEL

K = np.arange(100.0)


@pytest.mark.parametrize(
    ("column", "values", "line"),
    [
        ("ms", 10 * K, 'time_s = { column = "ms", unit = "ms" }'),
        ("t", 0.01 * K, 'time_s = "t"'),
        ("timestamp", 10 * K, 'time_s = { column = "timestamp", unit = "ms" }'),
        ("micros", 1e4 * K, 'time_s = { column = "micros", unit = "us" }'),
        ("Zeit [s]", 0.01 * K, 'time_s = "Zeit [s]"'),
        ("Temps [ms]", 10 * K, 'time_s = { column = "Temps [ms]", unit = "ms" }'),
        ("motor_temps", K, "# passed over: motor_temps"),
        ("pwm", 255 - K, 'voltage_V = { column = "pwm", scale = "12 V / 255" }'),
        ("throttle_pct", 0.3 * K, 'duty = { column = "throttle_pct", unit = "percent" }   # needs [drive] supply'),
        ("throttle_temp", K, "# passed over: throttle_temp"),
        ("Throttle Temp [°C]", K, "# passed over: Throttle Temp [°C]"),
        ("throttle_position", K, "# passed over: throttle_position"),
        *(
            (name, 20 + 0.1 * K, f"# passed over: {name}")
            for name in ("motor_temp", "motor temperature [°C]", "cmd_Temp1")
        ),
        ("joint", 0.01 * K, 'yaw_rad = "joint"'),
        ("joint_1_deg", K, 'yaw_rad = { column = "joint_1_deg", unit = "deg" }'),
        ("joint_effort", K, "# passed over: joint_effort"),
        *(
            (
                name,
                1000 + 10 * K,
                f'voltage_V = {{ column = "{name}", scale = "12 V / 500", offset = 1500 }}   # 12 V is a guess: write the supply\'s voltage; pulses in us, 12 V at 2000 and',
            )
            for name in ("throttle", "throttle_us", "throttle_cmd", "pwm", "pwm_1 [us]")
        ),
        ("throttle_cmd", 255 - K, 'voltage_V = { column = "throttle_cmd", scale = "12 V / 255" }'),
        *(
            (
                name,
                46.0 * np.sin(K),
                f'voltage_V = {{ column = "{name}", scale = "12 V / 100" }}   # 12 V is a guess: write the supply\'s voltage; 100 is full power: right?',
            )
            for name in ("throttle", "motor_duty", "throttle_cmd", "Tastgrad")
        ),
        ("throttle_V", 0.4 * K, 'voltage_V = "throttle_V"'),
        ("Throttle", 0.01 * K, 'duty = "Throttle"   # of 1, needs [drive] supply: right?'),
        ("duty_pct", 0.3 * K, 'duty = { column = "duty_pct", unit = "percent" }   # needs [drive] supply'),
        ("Tastgrad [%]", 0.3 * K, 'duty = { column = "Tastgrad [%]", unit = "percent" }   # needs [drive] supply'),
        ("motor_duty", 0.01 * K, 'duty = "motor_duty"   # of 1, needs [drive] supply: right?'),
        ("u", 0.1 * K, 'voltage_V = "u"'),
        ("command_norm", 0.01 * K, 'voltage_V = "command_norm"   # V? Of full power it is a duty'),
        ("volts (mV)", 100 * K, 'voltage_V = { column = "volts (mV)", unit = "mV" }'),
        ("angle_deg", K, 'yaw_rad = { column = "angle_deg", unit = "deg" }'),
        ("angle", 0.01 * K, 'yaw_rad = "angle"'),
        ("angle", 3.3 * K, 'yaw_rad = { column = "angle", unit = "deg" }   # degrees by its size: right?'),
        ("counts", K, 'yaw_counts = "counts"   # needs [encoder] counts_per_rev'),
        ("speed [rpm]", K, 'yaw_rad_s = { column = "speed [rpm]", unit = "rpm" }'),
        ("motor_rpm", K, 'yaw_rad_s = { column = "motor_rpm", unit = "rpm" }'),
        ("wheel_rpm", K, "# passed over: wheel_rpm"),
        ("cmd_rpm", K, "# passed over: cmd_rpm"),
        ("gyro_dps", K, 'yaw_rad_s = { column = "gyro_dps", unit = "deg/s" }'),
        (
            "speed_abs_rpm",
            K,
            'yaw_rad_s = { column = "speed_abs_rpm", unit = "rpm", unsigned = true }   # never negative, so a size without sign',
        ),
        ("speed_abs_rpm", K - 9, 'yaw_rad_s = { column = "speed_abs_rpm", unit = "rpm" }'),
        ("encoder_freq_Hz", K, "# passed over: encoder_freq_Hz"),
        ("angle [A]", K, "# passed over: angle [A]"),
        ("motor_angle_deg", K, 'yaw_rad = { column = "motor_angle_deg", unit = "deg" }'),
        ("cmd_angle_deg", K, "# passed over: cmd_angle_deg"),
        ("enc_a", K, 'yaw_counts = "enc_a"'),
        ("goal", 0.01 * K, 'goal_rad = "goal"   # needs [drive.servo]'),
        ("pos_des", 0.01 * K, 'goal_rad = "pos_des"   # needs [drive.servo]'),
        ("voltage_des_V", 0.1 * K, 'voltage_V = "voltage_des_V"'),
        ("voltage_des", 0.1 * K, 'voltage_V = "voltage_des"'),
        ("torque_des_Nm", K, "# passed over: torque_des_Nm"),
        ("torque_ref_Nm", K, "# passed over: torque_ref_Nm"),
        ("tau_des", K, "# passed over: tau_des"),
        ("i_des_A", K, "# passed over: i_des_A"),
        ("vel_des", K, "# passed over: vel_des"),
        ("speed_des_rad_s", K, "# passed over: speed_des_rad_s"),
        ("target_speed_rpm", K, "# passed over: target_speed_rpm"),
        ("vbat", 12 + 0 * K, 'supply_V = "vbat"'),
        ("yaw_rad", K, 'yaw_rad = "yaw_rad"'),
        ("pitch_rad", 0.01 * K, 'yaw_rad = "pitch_rad"'),
        ("pitch_rad_s", 0.01 * K, 'yaw_rad_s = "pitch_rad_s"'),
        ("tilt_deg", K, 'yaw_rad = { column = "tilt_deg", unit = "deg" }'),
        ("pitch_rate_est_rad_s", 0.01 * K, 'yaw_rad_s = "pitch_rate_est_rad_s"'),
        ("tilt_deg_s", K, 'yaw_rad_s = { column = "tilt_deg_s", unit = "deg/s" }'),
        ("pitch_counts", K, 'yaw_counts = "pitch_counts"   # needs [encoder] counts_per_rev'),
        ("tach_counts_s", K, "# passed over: tach_counts_s"),
        ("encoder counts/s", K, "# passed over: encoder counts/s"),
    ],
)
def test_a_column_is_known_by_name_unit_and_values(column: str, values: np.ndarray, line: str) -> None:
    text = proposal(ArraySheet("run", {}, [column, "state"], {column: values, "state": ["on"] * 100}), "platform")
    assert any(found.startswith(line) for found in text.splitlines()) and "state" in text.rsplit("# passed over: ")[1]
    parse_rig(PLATFORM + text)


def test_a_wheel_has_a_wheels_columns_and_what_is_missing_is_said() -> None:
    sheet = ArraySheet("run", {}, ["counts", "rpm", "current_mA"], {"counts": K, "rpm": K, "current_mA": K})
    text = proposal(sheet, "wheel")
    assert 'wheel_counts = "counts"   # needs [wheel_encoder] counts_per_rev' in text
    assert 'wheel_rad_s = { column = "rpm", unit = "rpm" }' in text
    assert 'current_A = { column = "current_mA", unit = "mA" }' in text
    assert '# time_s = { column = "…", unit = "ms" }' in text and '# voltage_V = "…"' in text
    parse_rig(WHEEL + text)
    turns = ArraySheet("run", {}, ["angle_rad"], {"angle_rad": 0.3 * K + 0.1})
    assert 'wheel_rad = "angle_rad"' in proposal(turns, "wheel")
    many = ArraySheet("run", {}, ["angle"], {"angle": 7.3 * K + 0.1})  # no degrees: a wheel turns many times
    assert 'wheel_rad = "angle"' in proposal(many, "wheel") and 'unit = "deg"' in proposal(many, "platform")


@pytest.mark.parametrize("wheel", ["wheel_rpm", "flywheel_rpm", "wheelspeed_rpm", "wheels_rpm", "rw_rpm"])
def test_a_column_that_names_the_wheel_is_the_wheels(wheel: str) -> None:
    sheet = ArraySheet("run", {}, ["angle", wheel], {"angle": 0.01 * K, wheel: K})
    lines = proposal(sheet, "reaction").splitlines()
    assert {'yaw_rad = "angle"', f'wheel_rad_s = {{ column = "{wheel}", unit = "rpm" }}'} <= {*lines}


@pytest.mark.parametrize(
    ("supply", "scale", "why"),
    [
        (None, "12 V / 255", "12 V is a guess: write the supply's voltage; 255 is full power: right?"),
        (9.0, "9 V / 255", "255 is full power: right?"),
        (7.4, "7.4 V / 255", "255 is full power: right?"),
    ],
)
def test_a_pwm_is_scaled_by_the_supply_that_is_given(supply: float | None, scale: str, why: str) -> None:
    sheet = ArraySheet("run", {}, ["ms", "pwm", "counts"], {"ms": 10 * K, "pwm": 255 - K, "counts": K})
    text = proposal(sheet, "platform", supply=supply)
    assert f'voltage_V = {{ column = "pwm", scale = "{scale}" }}   # {why}' in text.splitlines()
    parse_rig(f"encoder.counts_per_rev = 100\n{PLATFORM}{text}")


@pytest.mark.parametrize(("kind", "name"), [("platform", "yaw_rad"), ("wheel", "wheel_rad"), ("joint", "yaw_rad")])
def test_that_no_column_is_taken_for_a_reading_is_said(kind: str, name: str) -> None:
    columns = {"time_s": 0.01 * K, "motor_V": np.sin(K), "hoop_sensor_V": np.cos(K)}
    sheet = ArraySheet("run", {}, [*columns], columns)
    line = f'# {name} = "…"   # no column is taken for a reading, and every log needs one'
    assert line in proposal(sheet, kind).splitlines()
    named = ArraySheet("run", {}, [*columns, name], columns | {name: K})
    assert "no column is taken" not in proposal(named, kind)


def test_columns_are_described_by_their_range() -> None:
    sheet = ArraySheet("run", {}, ["a", "b"], {"a": K - 3.0, "b": ["x"] * 100})
    assert [*description(sheet)] == ["  a: -3 to 96", "  b: no numbers"]


def test_beside_a_goal_a_voltage_is_the_supply_and_a_current_that_never_changes_is_none() -> None:
    t = 0.01 * np.arange(40)
    columns = {
        "time_s": t,
        "goal_position_rad": np.sin(t),
        "input_voltage_V": 12.0 + 0.1 * np.sin(t),
        "load_raw": 0.0 * t,
        "current_raw": 17.0 * np.abs(np.sin(t)),
        "position_rad": np.sin(t),
    }
    lines = proposal(ArraySheet("a.csv", {}, [*columns], columns), "joint").splitlines()
    assert 'supply_V = "input_voltage_V"' in lines and not any(line.startswith("voltage_V") for line in lines)
    assert 'current_A = "current_raw"   # A? Else a unit' in lines and "# passed over: load_raw" in lines
    fewer = proposal(ArraySheet("a.csv", {}, [*columns], columns), "joint", ("current_A", "supply_V"))
    assert "# passed over: input_voltage_V, load_raw, current_raw" in fewer


def test_beside_an_angle_its_counts_are_passed_over() -> None:
    columns = {"t_ms": 10 * K, "pwm": 255 - K, "ticks": K, "angle_deg": 0.1 * K}
    section = proposal(ArraySheet("run", {}, [*columns], columns), "platform")
    assert "yaw_counts" not in section and section.endswith("# passed over: ticks")


@pytest.mark.parametrize(
    ("columns", "taken"),
    [
        ("roll_deg", {"yaw_rad": "roll_deg"}),
        ("roll_deg pitch_deg pitch_rate_dps", {"yaw_rad": "roll_deg"}),
        ("pitch_rad gyro_x_raw pitch_rate_rad_s", {"yaw_rad": "pitch_rad", "yaw_rad_s": "pitch_rate_rad_s"}),
        ("tilt_rad_s speed", {"yaw_rad_s": "tilt_rad_s"}),
        ("roll_deg heading_angle_rad", {"yaw_rad": "heading_angle_rad"}),
        ("pitch_rad_s heading_angle_rad", {"yaw_rad": "heading_angle_rad"}),
        ("pitch_rad yaw_rad_s", {"yaw_rad_s": "yaw_rad_s"}),
        ("yaw_rate pitch_rate_dps", {"yaw_rad_s": "yaw_rate"}),
        ("wheel_rad pitch_rad", {"wheel_rad": "wheel_rad", "yaw_rad": "pitch_rad"}),
    ],
)
def test_one_axis_is_taken_yaw_before_any_other(columns: str, taken: dict[str, str]) -> None:
    table = {"time_s": 0.01 * K, "voltage_V": 0.1 * K} | {name: 0.01 * K for name in columns.split()}
    found = proposed(ArraySheet("run", {}, [*table], table), "reaction" if "wheel" in columns else "joint")
    assert {name: one.column for name, one in found.items() if name not in ("time_s", "voltage_V")} == taken


def test_the_text_for_which_a_column_is_passed_over_is_said(tmp_path: Path) -> None:
    rows = [f"{0.01 * k},{k % 7},{'ERR' if k == 5 else k},idle" for k in range(50)]
    (tmp_path / "run.csv").write_text("\n".join(["time_s,volts,angle_rad,mode", *rows]))
    assert (
        "run.csv:7: `angle_rad` is 'ERR'"
        in proposal(read_sheet(tmp_path / "run.csv"), "platform").split("# passed over: ")[1]
    )


def test_of_two_rates_the_one_with_a_unit_is_taken() -> None:
    columns = {"time_s": 0.01 * K, "gyro_x_raw": K, "arm_rate_rad_s": 0.1 * K, "base_rate_rad_s": 0.2 * K}
    section = proposal(ArraySheet("run", {}, [*columns], columns), "platform")
    assert 'yaw_rad_s = "arm_rate_rad_s"' in section and "# passed over: gyro_x_raw, base_rate_rad_s" in section
    section = proposal(ArraySheet("run", {}, ["time_s", "gyro_x_raw"], columns), "platform")
    assert 'yaw_rad_s = "gyro_x_raw"' in section


def test_the_thesis_s_layout_is_known() -> None:
    columns = dict.fromkeys(("t", "pos1", "pos2", "speed2", "pwm_1", "pwm_2"), K)
    section = proposal(ArraySheet("run", {}, [*columns], columns), "platform")
    assert dict(parse_rig(PLATFORM + section).columns) == {"position": "pos1", "pulse": "pwm_1"}


def test_a_voltage_of_both_signs_drives_whatever_goal_stands_beside_it() -> None:
    columns = {"t": 0.01 * K, "position_ref": 0.01 * K, "motor_V": np.sin(K), "angle": 0.01 * K}
    assert 'voltage_V = "motor_V"' in proposal(ArraySheet("run", {}, [*columns], columns), "platform")
    columns["motor_V"] = 12.0 + 0.1 * np.sin(K)
    section = proposal(ArraySheet("run", {}, [*columns], columns), "platform")
    assert "goal_rad" in section and 'supply_V = "motor_V"' in section


@pytest.mark.parametrize("torque", ["torque_cmd_Nm", "torque_setpoint_Nm"])
def test_a_commanded_torque_drives_whatever_angle_is_desired_beside_it(torque: str) -> None:
    columns = {"t": 0.01 * K, "position_des_rad": 0.01 * K, "torque_meas_Nm": 0.1 * np.sin(K), "angle": 0.01 * K}
    assert 'goal_rad = "position_des_rad"' in proposal(ArraySheet("run", {}, [*columns], columns), "joint")
    idle = columns | {torque: 0.0 * K}  # a feed-forward that is not used
    assert "goal_rad" in proposal(ArraySheet("run", {}, [*idle], idle), "joint")
    columns[torque] = 0.1 * np.sin(K)
    section = proposal(ArraySheet("run", {}, [*columns], columns), "joint")
    assert 'yaw_rad = "angle"' in section and f'\ncommand_Nm = "{torque}"' in section
    assert "\ngoal_rad" not in section and "enabled" not in section


def test_a_load_without_a_unit_is_no_current() -> None:
    columns = {"t": 0.01 * K, "u": 0.1 * K, "speed": K, "load_raw": 300.0 * K}
    assert proposal(ArraySheet("run", {}, [*columns], columns), "wheel").endswith("# passed over: load_raw")


def test_a_current_that_is_a_size_by_its_name_and_values_is_said_to_be_one() -> None:
    columns = {"t": 0.01 * K, "u": np.sin(K), "counts": K, "current_abs_mA": K}
    section = proposal(ArraySheet("run", {}, [*columns], columns), "wheel")
    assert 'current_A = { column = "current_abs_mA", unit = "mA", unsigned = true }' in section
    assert parse_rig(f"wheel_encoder.counts_per_rev = 100\n{WHEEL}{section}").sources["current_A"].unsigned


def test_dates_are_time_without_a_unit_and_nothing_else() -> None:
    dates = np.datetime64("2026-11-23T18:00:00") + np.arange(10) * np.timedelta64(2, "s")
    sheet = ArraySheet("run", {}, ["time_ms", "angle"], {"time_ms": dates, "angle": dates})
    text = proposal(sheet, "platform")
    assert 'time_s = "time_ms"' in text.splitlines() and "# passed over: angle" in text
    assert description(sheet)[0] == "  time_ms: 0 to 18"


def test_a_temperature_is_known_by_a_word_of_its_name() -> None:
    assert all(map(is_temperature, ("motorTemp", "temp_1", "coil temperature", "T [°C]", "ntc")))
    assert not any(map(is_temperature, ("attempt", "template_id", "time", "tempo")))


@pytest.mark.parametrize("number", [np.full(100, 3.0), np.floor(0.1 * K), np.floor(0.05 * K)])
@pytest.mark.parametrize("angle", ["position", "angle_deg", "counts"])
def test_a_joint_beside_an_angle_is_its_number(number: np.ndarray, angle: str) -> None:
    sheet = ArraySheet("run", {}, ["joint", angle], {"joint": number, angle: K})
    assert "# passed over: joint" in proposal(sheet, "platform").splitlines()


def test_a_joint_that_never_changes_is_no_angle() -> None:
    sheet = ArraySheet("run", {}, ["t", "joint_1"], {"t": 0.01 * K, "joint_1": 0.0 * K})
    assert "# passed over: joint_1" in proposal(sheet, "joint").splitlines()


@pytest.mark.parametrize(
    ("kind", "line", "passed"),
    [
        (
            "joint",
            'goal_rad = { column = "goal_deg", unit = "deg" }',
            "duty_pct: a log holds one command, and goal_deg is taken for it; to use duty_pct, write in the place of the line goal_rad: "
            'duty = { column = "duty_pct", unit = "percent" }',
        ),
        (
            "platform",
            'duty = { column = "duty_pct", unit = "percent" }',
            "goal_deg: a log holds one command, and duty_pct is taken for it; to use goal_deg, write in the place of the line duty: "
            'goal_rad = { column = "goal_deg", unit = "deg" }',
        ),
        (
            "wheel",
            'duty = { column = "duty_pct", unit = "percent" }',
            "goal_deg: a `wheel` rig does not take a goal_rad, and duty_pct is its command",
        ),
    ],
)
def test_of_a_goal_and_a_duty_one_is_taken_by_the_kind_and_the_other_passed_over_with_the_reason(
    kind: str, line: str, passed: str
) -> None:
    t = 0.01 * np.arange(400)
    columns = {"time_s": t, "goal_deg": 40.0 * np.sin(t), "duty_pct": 60.0 * np.cos(t), "pos_deg": 40.0 * np.sin(t)}
    lines = proposal(ArraySheet("a.csv", {}, [*columns], columns), kind).splitlines()
    assert [one.partition("   #")[0] for one in lines if one.startswith(("goal_rad", "duty"))] == [line]
    assert [one for one in lines if one.startswith("#")] == [f"# passed over: {passed}"]
