"""The measured joints: which logs are fitted and which are held out, and a rig file from what their authors say of the hardware."""

from collections.abc import Iterator
from typing import NamedTuple

TRAIN, HELD_OUT = ("sin_sin", "lift_and_drop"), ("sin_time_square", "up_and_down")
"""Trajectories of the pendulums that are fitted and those that are held out. Torque is off in `lift_and_drop` alone, which tells the
motor's braking from friction."""
OF_ARM, HELD_OUT_OF_ARM = ("backlash_detection", "friction_gravity"), ("static_holding",)
"""The same of the arm."""
DUTY_PER_RAD = {
    "feetech_sts3215_pendulum": 0.16489,
    "feetech_sts3250_pendulum": 0.163829,
    "bam_xl330_pendulum": 0.005755,
}
"""Duty per rad of error and unit of kp, as the logs' authors measured it [1/rad]."""
POSITION = 'position_rad = "position_rad"'
GOAL, ENABLED, SUPPLY = 'goal_rad = "goal_position_rad"', 'enabled = "torque_enable"', 'supply_V = "input_voltage_V"'


class Case(NamedTuple):
    """One joint with its logs.

    Attributes:
        data: Folder of the published logs.
        name: Name of the joint or its load.
        rig: Text of its rig file.
        train: Logs that are fitted.
        held_out: Logs that are not.
    """

    data: str
    name: str
    rig: str
    train: tuple[str, ...]
    held_out: tuple[str, ...]


def rig_file(
    motor: tuple[float, float],
    servo: str,
    supply: str,
    columns: list[str],
    load: tuple[float, float],
    free_gravity: bool,
) -> str:
    """Text of a joint's rig file: inertia, viscous and dry friction, bias and scale of the torque free, and a late goal.

    Args:
        motor: Torque constant behind the gear [N m/A] and resistance [ohm].
        servo: Lines of `[drive.servo]`.
        supply: Line of `[drive]`, "" where the supply is logged.
        columns: Lines of `[columns]`.
        load: Inertia of the load [kg m2] and its largest torque [N m].
        free_gravity: Whether the load's torque is free, and not the motor's.

    Returns:
        The text.
    """
    scale = '"axis.gravity.torque"' if free_gravity else '"motor.torque_constant"'
    free = [
        scale,
        *([] if free_gravity else ['"motor.resistance"']),
        '"motor.inertia"',
        '"axis.friction.viscous"',
        '"axis.friction.coulomb"',
    ]
    free += ['"axis.bias_torque.T"', '"drive.goal_delay.tau"']
    return "\n".join(
        [
            'kind = "joint"',
            "[motor]",
            f"torque_constant = {motor[0]}",
            f"resistance = {motor[1]}",
            f"inertia = {load[0]}",
            "[drive]",
            supply,
            "[drive.servo]",
            servo,
            "[axis]",
            f"inertia = {load[0]}",
            f"gravity = {{ torque = {load[1]}, angle = 0.0 }}",
            "friction = { viscous = 0.05, coulomb = 0.05 }",
            "[encoder]",
            "counts_per_rev = 4096",
            "[columns]",
            *columns,
            '[effects."axis.bias_torque"]',
            "T = 0.0",
            '[effects."drive.goal_delay"]',
            "tau = 0.005",
            "[fit]",
            f"free = [{', '.join(free)}]",
        ]
    )


PUBLISHED = {
    "feetech_sts3215_pendulum": (2.885, 6.28),
    "feetech_sts3250_pendulum": (2.124, 2.81),
    "bam_xl330_pendulum": (0.3867, 4.017),
    "unitree_go1_pendulum": (1.0, 1.0),
    "so101_arm": (2.885, 6.28),
}
"""Torque constant [N m/A] and resistance [ohm] behind the gear, those of the Feetech servos for 12 V where their authors took 15 V."""
LOADS = {
    "L100_m0535": (0.006745, 0.5422),
    "L100_m0741": (0.009273, 0.7444),
    "L100_m1168": (0.014615, 1.1630),
    "L150_m0535": (0.013688, 0.8236),
    "L150_m0741": (0.018793, 1.1269),
    "L150_m1168": (0.029472, 1.7549),
    "m0000": (0.000585, 0.0574),
    "m1000": (0.023085, 1.529),
    "m3000": (0.068085, 4.472),
}
"""Inertia [kg m2] and largest torque [N m] of the pendulums' loads, as published."""


def cases() -> Iterator[Case]:
    """All joints.

    Yields:
        Eight pendulums with two held-out runs each, and four joints of an arm with one each.
    """
    of_servo = ['time_s = "time_s"', GOAL, ENABLED, SUPPLY, POSITION]
    for data, load, kp in (
        ("feetech_sts3215_pendulum", "L100_m0535", 16),
        ("feetech_sts3215_pendulum", "L150_m1168", 32),
        ("feetech_sts3250_pendulum", "L100_m0535", 8),
        ("feetech_sts3250_pendulum", "L150_m1168", 32),
    ):
        servo = f'acts_on = "duty"\nkp = {DUTY_PER_RAD[data] * kp}\nperiod = 0.005'
        text = rig_file(PUBLISHED[data], servo, "", of_servo, LOADS[load], False)
        yield _pendulum(data, f"{load}_kp{kp:02d}", text)
    for kp in (100, 400):
        data = "bam_xl330_pendulum"
        servo = f'acts_on = "duty"\nkp = {DUTY_PER_RAD[data] * kp}\nperiod = 0.005'
        yield _pendulum(data, f"kp{kp}", rig_file(PUBLISHED[data], servo, "", of_servo, (0.0049, 0.4807), False))
    for mass in ("m0000", "m1000"):
        data, servo = (
            "unitree_go1_pendulum",
            'acts_on = "torque"\nkp = 10.0\nkd = 0.3\ndamping_on = "speed"\nlimit = 23.7',
        )
        columns = ['time_s = "time_s"', GOAL, ENABLED, POSITION]
        yield _pendulum(data, mass, rig_file(PUBLISHED[data], servo, "", columns, LOADS[mass], True))
    for joint in ("rotation", "pitch", "elbow", "wrist_pitch"):
        data, servo = "so101_arm", 'acts_on = "duty"\nkp = 2.6\nperiod = 0.005'
        columns = ['time_s = "time_s"', f'goal_rad = "{joint}_cmd_rad"', f'position_rad = "{joint}_pos_rad"']
        text = rig_file(PUBLISHED[data], servo, "supply = 12.0", columns, (0.01, 0.1), True)
        yield Case(data, joint, text, *(tuple(f"{t}.csv" for t in of) for of in (OF_ARM, HELD_OUT_OF_ARM)))


def _pendulum(data: str, name: str, text: str) -> Case:
    """A pendulum, whose logs are named by trajectory and load."""
    return Case(data, name, text, *(tuple(f"{t}_{name}.csv" for t in of) for of in (TRAIN, HELD_OUT)))
