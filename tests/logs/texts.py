"""Texts of log files and rigs for tests."""

from rwjax.rig.read import parse_rig

PLATFORM = parse_rig('kind = "platform"\ndrive.gain = 1\naxis.inertia = 1\nencoder.counts_per_rev = 256')
MOTOR = "motor = { torque_constant = 1, resistance = 1 }\nwheel.inertia = 1\n"
THESIS = """columns = { position = "pos2", pulse = "pwm_1" }
drive.pwm = { neutral_us = 1500, volts_per_us = 0.02 }
"""
WHEEL = parse_rig('kind = "wheel"\n' + MOTOR + THESIS + "wheel_encoder.counts_per_rev = 100")
REACTION = parse_rig('kind = "reaction"\n' + MOTOR + THESIS + "axis.inertia = 1\nencoder.counts_per_rev = 2048")
ROWS = [f"{k / 100},{k % 3},{7 * k}" for k in range(12)]
HEADER = "time_s,voltage_V,yaw_counts"
THESIS_HEADER = "t;pos1;pos2;speed2;pwm_1;pwm_2"
THESIS_ROWS = [f"junk;{k};{2 * k};nan;{1500 + k};1500" for k in range(12)]


def changed(row: int, line: str) -> list[str]:
    """A good log with one row (counted from 0 below the header in line 1) replaced."""
    return [HEADER, *ROWS[:row], line, *ROWS[row + 1 :]]
