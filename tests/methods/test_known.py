"""Lines of a first rig file."""

import tomllib

from rwjax.methods.known import Known


def test_a_line_is_toml_and_says_symbol_unit_and_source() -> None:
    line = Known(1.5e-3, "of the model").line("axis.inertia", "voltage")
    assert tomllib.loads(line) == {"inertia": 1.5e-3}
    assert line.endswith("# I, kg m2: of the model")


def test_units_of_a_servo_are_those_of_what_it_acts_on() -> None:
    assert Known(4.0, "so").line("drive.servo.kp", "torque").endswith("# k_p, N m/rad: so")
    assert Known(4.0, "so").line("drive.servo.kd", "voltage").endswith("# k_d, V s/rad: so")
    assert Known(4.0, "so").line("drive.servo.ki", "current").endswith("# k_i, A/(rad s): so")
    assert Known(4.0, "so").line("drive.servo.limit", "duty").endswith("# u_max, 1: so")
    assert Known(4.0, "so").line("drive.servo.period", "torque").endswith("# T, s: so")
