"""The measured rigs that every tool is given, each as one equation, J a = drive − c v − f sgn v − o − m g l sin x.

What a tool fits are four numbers: J, c, f and either the offset o, where the drive's gain is known, or the gain of a servo.
"""

from typing import Any, NamedTuple

import numpy as np

from experiments.realdata import need


class Log(NamedTuple):
    """Time [s] on a uniform grid, command (n, 2) and reading."""

    t: np.ndarray
    u: np.ndarray
    y: np.ndarray

    def coarser(self, every: int) -> "Log":
        """The same in steps of several samples, each with the mean command of its samples."""
        count = len(self.t) // every
        mean = self.u[: every * count].reshape(count, every, -1).mean(axis=1)
        return Log(self.t[::every][:count], mean, self.y[::every][:count])


class Problem(NamedTuple):
    """A rig with the log that is fitted and the one that has to be followed.

    Attributes:
        unit: Unit of errors.
        per_si: Errors in it per SI unit.
        scale: Sizes of the four numbers.
        bounds: Lowest and highest of each, in sizes.
        width: Rate within which a smoothed sign turns.
        every: Samples to a step of a slow tool.
        train: The fitted log.
        other: The other one.
        text: rwjax's rig file, with the four terms.
        bare: The same with inertia and viscous friction alone.
        reads: 0 where the position is read, 1 where the rate is.
        gain: Force or torque per command; None where it is the fourth number.
        kp: Duty per rad of a servo whose goal and supply are the command; None without one.
        load: m g l of a pendulum.
        skipped: First samples that do not count.
    """

    unit: str
    per_si: float
    scale: tuple[float, ...]
    bounds: tuple[tuple[float, float], ...]
    width: float
    every: int
    train: Log
    other: Log
    text: str
    bare: str
    reads: int = 0
    gain: float | None = None
    kp: float | None = None
    load: float = 0.0
    skipped: int = 0

    def acceleration(self, m: Any, x: Any, v: Any, u: Any, z: Any, sign: Any = None) -> Any:
        """The equation, for numpy, JAX or CasADi as `m`; the sign of the rate smoothed where none is given."""
        J, c, f, last = (z[k] * self.scale[k] for k in range(4))
        sign = m.tanh(v / self.width) if sign is None else sign
        return (
            self.drive(m, x, u, last) - c * v - f * sign - (0.0 if self.gain is None else last) - self.load * m.sin(x)
        ) / J

    def drive(self, m: Any, x: Any, u: Any, last: Any) -> Any:
        """Force or torque of the drive."""
        return (last if self.gain is None else self.gain) * self.effort(m, x, u)

    def effort(self, m: Any, x: Any, u: Any) -> Any:
        """The command, or the voltage that a servo makes of its goal."""
        return u[0] if self.kp is None else u[1] * m.fmin(m.fmax(self.kp * (u[0] - x), -1.0), 1.0)

    def start(self, log: Log) -> tuple[float, float]:
        """First position and rate: the reading, and 0 for the other one."""
        return (float(log.y[0]), 0.0) if self.reads == 0 else (0.0, float(log.y[0]))


FOUR = 'free = ["axis.inertia", "axis.friction.viscous", "axis.friction.coulomb", "axis.bias_torque.T"]\n'
TWO = 'fit.free = ["axis.inertia", "axis.friction.viscous"]\n'
"""Free numbers of a platform."""


def emps() -> Problem:
    """EMPS: a carriage on a ball screw, its force by the voltage; the benchmark's own two logs."""

    def log(name: str) -> Log:
        t, u, x = np.genfromtxt(need() / "emps" / f"{name}.csv", delimiter=",", skip_header=1, usecols=(0, 1, 2)).T
        return Log(t, np.stack([u, u], axis=1), x)

    bare = 'kind = "platform"\ndrive.gain = 35.15065\naxis.inertia = 80.0\naxis.friction.viscous = 250.0\n'
    more = 'axis.friction.coulomb = 10.0\n[effects."axis.bias_torque"]\nT = 0.0\n[fit]\n'
    return Problem(
        unit="mm",
        per_si=1e3,
        gain=35.15065,
        scale=(80.0, 250.0, 10.0, 3.0),
        bounds=((0.5, 2.5), (0.0, 2.4), (0.0, 6.0), (-3.3, 3.3)),
        width=2e-3,
        every=10,
        train=log("DATA_EMPS"),
        other=log("DATA_EMPS_PULSES"),
        text=bare + more + FOUR,
        bare=bare + TWO,
        skipped=20,
    )


UP, DOWN = 30.0, 48.0
"""Seconds of the geared motor's log from which positive steps turn it, which are fitted, and from which negative ones do [s]."""


def geared_motor() -> Problem:
    """A geared motor on an L298N bridge, whose rate is read; positive steps are fitted, negative ones followed."""
    path = need() / "dcmotor_deadzone_l298n" / "staircase_run.csv"
    t, u, rpm = np.genfromtxt(path, delimiter=",", skip_header=1, usecols=(0, 1, 2)).T
    rate = rpm * np.pi / 30.0
    up, down = (
        Log(t[part] - t[part][0], np.stack([u, u], axis=1)[part], rate[part])
        for part in ((t >= UP) & (t < DOWN), t >= DOWN)
    )
    bare = 'kind = "platform"\ndrive.gain = 1.0\naxis.inertia = 0.1\naxis.friction.viscous = 0.5\n'
    more = 'axis.friction.coulomb = 1.0\n[effects."axis.bias_torque"]\nT = 0.0\n[fit]\n'
    return Problem(
        unit="rpm",
        per_si=30.0 / np.pi,
        reads=1,
        gain=1.0,
        scale=(0.1, 0.5, 1.0, 0.3),
        bounds=((0.05, 5.0), (0.0, 4.0), (0.0, 6.0), (-5.0, 5.0)),
        width=0.05,
        every=2,
        train=up,
        other=down,
        text=bare + more + FOUR,
        bare=bare + TWO,
    )


KP, LOAD, INERTIA = 0.16489 * 16, 0.5422, 0.006745
"""Duty per rad of the servo, m g l [N m] and m l² [kg m²] of the pendulum, as published."""
STEP = 0.01
"""Grid on which the servo's irregular samples are laid [s]."""


def servo_pendulum() -> Problem:
    """A Feetech STS3215 that carries a pendulum: one trajectory of goals is fitted, another one followed."""

    def log(name: str) -> Log:
        path = need() / "feetech_sts3215_pendulum" / f"{name}_L100_m0535_kp16.csv"
        t, goal, x, supply = np.genfromtxt(path, delimiter=",", skip_header=1, usecols=(0, 1, 3, 5)).T
        grid = np.arange(t[0], t[-1], STEP)
        held = np.searchsorted(t, grid, side="right") - 1
        return Log(grid - grid[0], np.stack([goal, supply], axis=1)[held], np.interp(grid, t, x))

    bare = (
        f'kind = "joint"\n[motor]\ntorque_constant = 1.0\nresistance = 3.0\ninertia = 0.02\n[drive.servo]\nacts_on = "duty"\nkp = {KP}\n'
        f"[axis]\ninertia = {INERTIA}\n[axis.gravity]\ntorque = {LOAD}\n[axis.friction]\nviscous = 0.3\nMORE"
        '[columns]\ntime_s = "time_s"\ngoal_rad = "goal_rad"\nsupply_V = "supply_V"\nposition_rad = "position_rad"\n[fit]\n'
        'free = ["motor.torque_constant", "motor.inertia", "axis.friction.viscous"FREE]\n'
    )
    return Problem(
        unit="mrad",
        per_si=1e3,
        kp=KP,
        load=LOAD,
        scale=(0.03, 0.6, 0.1, 0.4),
        bounds=((0.05, 5.0), (0.0, 5.0), (0.0, 5.0), (0.2, 5.0)),
        width=0.02,
        every=1,
        train=log("sin_sin"),
        other=log("sin_time_square"),
        text=bare.replace("MORE", "coulomb = 0.1\n").replace("FREE", ', "axis.friction.coulomb"'),
        bare=bare.replace("MORE", "").replace("FREE", ""),
    )


PROBLEMS = {"emps": emps, "geared-motor": geared_motor, "servo-pendulum": servo_pendulum}
"""What makes each problem, by its name."""
