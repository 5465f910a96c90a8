"""Joints and their loops as the library moves them, against integrations of their own, energy and torque off."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import expm

from rwjax import parse_rig, simulate
from rwjax.kinds import SERVO
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import LONGEST_STEP, OF_INDUCTIVE_JOINTS, OF_JOINTS
from rwjax.rig.model import Rig
from rwjax.simulation.free_run import free_run
from rwjax.simulation.layout import OF_JOINT, lay_out
from rwjax.simulation.trajectory import trajectory_of

JOINT = """
kind = "joint"
[gear]
ratio = 20.0
[motor]
torque_constant = 0.03
resistance = 2.5
inertia = 2e-5
{motor}
[axis]
inertia = 0.02
[axis.friction]
viscous = 0.01
{friction}
{rest}
"""
N, K, R, I, B = 20.0, 0.03, 2.5, 0.02 + 20.0**2 * 2e-5, 0.01
LOOP = """
[drive]
supply = 12.0
[drive.servo]
acts_on = "{acts_on}"
period = 0.02
{gains}
"""
GAINS = {"voltage": (30.0, 40.0, 0.6), "duty": (2.5, 3.0, 0.05), "current": (4.0, 6.0, 0.3), "torque": (2.4, 3.0, 0.2)}
LIMIT = {"voltage": 9.0, "duty": 1.0, "current": 1.2, "torque": 0.7}
FINE = np.arange(201) * 0.005  # s, the grid's points, three of which lie between two ticks
GOAL = np.where(FINE < 0.1, 0.0, np.where(FINE < 0.55, 0.6, -0.5))
THIRD = 0.005 / 3.0  # s, by which ticks lie between the points of this grid, and of four times as fine a one alike
SMALL = 0.1 * GOAL  # within the loop's limits


def joint(motor: str = "", friction: str = "", rest: str = "") -> Rig:
    return parse_rig(JOINT.format(motor=motor, friction=friction, rest=rest))


def servo(acts_on: str, more: str = "", hanging: str = "", **parts: str) -> Rig:
    kp, ki, kd = GAINS[acts_on]
    gains = f"kp = {kp}\nki = {ki}\nkd = {kd}\nlimit = {LIMIT[acts_on]}\n{more}"
    return joint(rest=LOOP.format(acts_on=acts_on, gains=gains) + hanging, **parts)


def linear(acts_on: str, L: float) -> tuple[np.ndarray, np.ndarray]:
    """Matrices of angle, rate and current under an output held."""
    A, b = np.zeros((3, 3)), np.zeros(3)
    A[0, 1], A[1, 1] = 1.0, -B / I
    if acts_on in ("current", "torque"):
        b[1] = (N * K if acts_on == "current" else 1.0) / I
    elif L > 0.0:
        A[1, 2], A[2, 1], A[2, 2], b[2] = N * K / I, -N * K / L, -R / L, 1.0 / L
    else:
        A[1, 1] -= (N * K) ** 2 / (R * I)
        b[1] = N * K / (R * I)
    return A, 12.0 * b if acts_on == "duty" else b


class Loop:
    """The loop by the words of the interface."""

    def __init__(self, rig: Rig) -> None:
        n = {name.removeprefix(f"{SERVO}."): v for name, v in rig.numbers.items() if name.startswith(f"{SERVO}.")}
        self.kp, self.ki, self.kd, self.T = n["kp"], n["ki"], n["kd"], n["period"]
        self.filter, self.most = n.get("derivative_filter", 0.0), n.get("error_limit", np.inf)
        self.limit = n["limit"]
        self.on_speed = rig.servo.damping_on == "speed"
        self.sum, self.slope, self.before = 0.0, None, 0.0

    def tick(self, goal: float, position: float, rate: float, on: bool = True) -> float:
        e = min(max(goal - position, -self.most), self.most)
        d = -position if self.on_speed else e
        if self.slope is None:
            self.slope = -rate
        else:
            self.slope = (self.filter * self.slope + d - self.before) / (self.filter + self.T)
        self.before = d
        if not on:
            self.sum = 0.0
            return 0.0
        asked = self.kp * e + self.ki * self.sum + self.kd * self.slope
        output = min(max(asked, -self.limit), self.limit)
        if output == asked or np.sign(asked) != np.sign(e):
            self.sum += self.T * e
        return output


Move = Callable[[np.ndarray, float, float, float], np.ndarray]
"""Moves a state under an output, from one time to another."""


def run_loop(loop: Loop, move: Move, time: np.ndarray, goal: np.ndarray, start: np.ndarray, phase: float) -> np.ndarray:
    """States at the samples of a log; the goal of a tick is its mean over the period that begins there."""
    area = np.concatenate([[0.0], np.cumsum(goal[:-1] * np.diff(time))])

    def until(t: float) -> float:
        k = max(int(np.searchsorted(time, t, side="right")) - 1, 0)
        return area[k] + goal[k] * (t - time[k])

    x, u, states = start.copy(), 0.0, []
    ticks = phase + loop.T * np.arange(
        np.ceil(-phase / loop.T - 1e-9), np.floor((time[-1] - phase) / loop.T + 1e-9) + 1
    )
    events = np.union1d(np.round(ticks, 12), np.round(time, 12))
    for t, end in zip(events, np.append(events[1:], events[-1]), strict=True):
        if np.min(np.abs(ticks - t)) < 1e-9:
            u = loop.tick((until(t + loop.T) - until(t)) / loop.T, x[0], x[1])
        if np.min(np.abs(time - t)) < 1e-9:
            states.append(x)
        x = move(x, u, t, end)
    return np.array(states)


def held(A: np.ndarray, b: np.ndarray) -> Move:
    """What moves a linear plant exactly."""

    def move(x: np.ndarray, u: float, begin: float, end: float) -> np.ndarray:
        whole = expm(np.block([[A, (b * u)[:, None]], [np.zeros((1, 4))]]) * (end - begin))
        return (whole @ np.append(x, 1.0))[:3]

    return move


@pytest.mark.parametrize(
    ("acts_on", "L"),
    [
        ("voltage", 5e-3),
        ("torque", 0.0),
        *(
            pytest.param(*other, marks=pytest.mark.slow)
            for other in (("voltage", 0.0), ("duty", 5e-3), ("current", 0.0))
        ),
    ],
)
def test_a_linear_joint_follows_its_loop_exactly_between_ticks(acts_on: str, L: float) -> None:
    more = 'derivative_filter = 0.015\nerror_limit = 0.4\ndamping_on = "speed"' if acts_on in ("duty", "torque") else ""
    rig = servo(acts_on, more, motor=f"inductance = {L}")
    found = simulate(rig, FINE, {"goal_rad": GOAL}, start={"w": 0.3})
    exact = run_loop(Loop(rig), held(*linear(acts_on, L)), FINE, GOAL, np.array([0.0, 0.3, 0.0]), 0.0)
    assert np.ptp(exact[:, 0]) > 0.5
    assert np.max(np.abs(found["yaw_rad"] - exact[:, 0])) < 1e-9
    assert np.max(np.abs(found["yaw_rad_s"] - exact[:, 1])) < 1e-8


def refined(
    rig: Rig, time: np.ndarray, columns: dict[str, np.ndarray], refine: int, start: dict[str, float] | None = None
) -> np.ndarray:
    """Angle of a run whose steps are divided further."""
    name = next(iter(columns))
    enabled = columns["enabled"] > 0.0 if "enabled" in columns else None
    log = Log("run", time, columns[name], {}, {}, {}, False, None, 0.0, input=name, enabled=enabled)
    rig, logs = driven(rig, [log])
    structure = structure_of(rig)
    batch = lay_out(structure, logs, [{}], refine=refine)
    first = np.array([[(start or {}).get(name, 0.0) for name in structure.states]])
    readings = free_run(structure, theta_of(rig, structure), first, batch)[0][0]
    return np.asarray(trajectory_of(structure, batch, logs[0], readings)["yaw_rad"])


def order(rig: Rig, exact: np.ndarray, time: np.ndarray, columns: dict[str, np.ndarray]) -> float:
    """By which power of the step the error of the angle falls, with steps a quarter as long.

    What lies a third into a step lies a third into a quarter of it as well: the place within a step counts too.
    """
    off = [np.sqrt(np.mean((refined(rig, time, columns, refine) - exact) ** 2)) for refine in (1, 4)]
    return float(np.log(off[0] / off[1]) / np.log(4.0))


@pytest.mark.slow
def test_ticks_between_grid_points_are_met_to_second_order() -> None:
    rig = servo("voltage", f"phase = {THIRD}")
    exact = run_loop(Loop(rig), held(*linear("voltage", 0.0)), FINE, SMALL, np.zeros(3), THIRD)
    assert 1.7 < order(rig, exact[:, 0], FINE, {"goal_rad": SMALL}) < 2.5


HANGS = "[axis.gravity]\ntorque = 0.4\nangle = 0.3"
STRIBECK = "coulomb = 0.12\nstatic = 0.18\nstribeck_velocity = 0.3"


def apart(rig: Rig, time: np.ndarray, columns: dict[str, np.ndarray], late: float = 0.0, **more: float) -> np.ndarray:
    """States of the separate simulator, which meets every tick, stick and slip where it is."""
    pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")
    from experiments.blind import joint as other

    n, words = rig.numbers, rig.servo
    given = {"voltage": other.VOLTAGE, "current": other.CURRENT, "torque": other.TORQUE}[
        words.acts_on if words else "voltage"
    ]
    truth = other.Joint(
        given=given,
        ratio=N,
        K=K,
        R=R,
        L=n.get("motor.inductance", 0.0),
        rotor=2e-5,
        I=0.02,
        viscous=B,
        coulomb=n.get("axis.friction.coulomb", 0.0),
        excess=n.get("axis.friction.static", 0.0) - n.get("axis.friction.coulomb", 0.0) if STRIBECK_SPEED in n else 0.0,
        v_s=n.get(STRIBECK_SPEED, 0.1),
        gravity=n.get("axis.gravity.torque", 0.0),
        gravity_angle=n.get("axis.gravity.angle", 0.0),
        **more,
    )
    loop = None
    if words:
        gains = {name: n[f"{SERVO}.{name}"] for name in ("kp", "ki", "kd", "limit", "period")}
        loop = other.Servo(**gains, phase=n.get(f"{SERVO}.phase", 0.0))
    one = np.ones(len(time))
    inputs = other.Inputs(time, next(iter(columns.values())), one, columns.get("enabled", one))
    return other.move(truth, loop, inputs, np.maximum(time - late, time[0]))[0]


STRIBECK_SPEED = "axis.friction.stribeck_velocity"


@pytest.mark.slow
def test_gravity_is_moved_to_second_order() -> None:
    rig = servo("torque", hanging=HANGS)
    columns = {"goal_rad": SMALL}
    assert 1.7 < order(rig, apart(rig, FINE, columns)[:, 0], FINE, columns) < 2.5


@pytest.mark.slow
@pytest.mark.parametrize(("acts_on", "motor", "power"), [("voltage", "inductance = 5e-3", 2.0), ("current", "", 1.0)])
def test_stick_and_slip_within_a_loop_are_met_ever_closer(acts_on: str, motor: str, power: float) -> None:
    """Where a tick within a step makes the torque jump, the body breaks away up to a step late: there to first order."""
    rig = servo(acts_on, f"phase = {THIRD}", motor=motor, friction=STRIBECK, hanging=HANGS)
    columns = {"goal_rad": GOAL}
    exact = apart(rig, FINE, columns)
    assert np.mean(exact[:, 1] == 0.0) > 0.05  # it sticks
    assert np.max(np.abs(refined(rig, FINE, columns, 1) - exact[:, 0])) < 4e-3
    assert order(rig, exact[:, 0], FINE, columns) == pytest.approx(power, abs=0.1)


def test_what_a_winding_takes_is_stored_or_lost() -> None:
    rig = joint("inductance = 5e-3", "coulomb = 0.05", HANGS)
    dt = 1e-4  # s
    time = np.arange(10001) * dt
    volts = 6.0 * np.sin(5.0 * time)
    found = simulate(rig, time, volts)
    w, i, psi = found["yaw_rad_s"], found["current_A"], found["yaw_rad"]
    losses = R * i**2 + B * w**2 + 0.05 * np.abs(w)
    came = float(np.sum(volts[:-1] * 0.5 * (i[1:] + i[:-1])) * dt)  # a voltage is held between samples
    lost = float(np.sum(0.5 * (losses[1:] + losses[:-1])) * dt)
    energy = 0.5 * I * w**2 + 0.5 * 5e-3 * i**2 - 0.4 * np.cos(psi + 0.3)
    assert came > 1.0
    assert came == pytest.approx(lost + energy[-1] - energy[0], rel=1e-5)


def test_with_torque_off_a_joint_moves_as_one_without_a_motor() -> None:
    rig = servo("voltage", motor="inductance = 5e-3", friction=STRIBECK, hanging=HANGS)
    enabled = np.where(FINE < 0.25, 1.0, 0.0)
    found = simulate(rig, FINE, {"goal_rad": GOAL, "enabled": enabled})
    text = JOINT.replace('"joint"', '"platform"').replace("inertia = 0.02", f"inertia = {I}")
    text = text[: text.index("[gear]")] + "[drive]\ngain = 1.0\n" + text[text.index("[axis]") :]
    alone = parse_rig(text.format(friction=STRIBECK, rest=HANGS))
    first = {"psi": found["yaw_rad"][50], "w": found["yaw_rad_s"][50]}
    steps = OF_JOINT * round(LONGEST_STEP / OF_INDUCTIVE_JOINTS)  # the same for both
    free = refined(alone, FINE[50:], {"voltage_V": 0.0 * FINE[50:]}, steps, first)
    assert np.ptp(free) > 0.3
    assert np.max(np.abs(found["yaw_rad"][50:] - free)) < 1e-9
    assert not found["current_A"][51:].any()


@pytest.mark.slow
@pytest.mark.parametrize(("motor", "step"), [("", OF_JOINTS), ("inductance = 5e-3", OF_INDUCTIVE_JOINTS)])
def test_torque_is_switched_off_and_on_again_between_two_grid_points(motor: str, step: float) -> None:
    rig = servo("voltage", motor=motor, friction=STRIBECK, hanging=HANGS)
    time = np.append(0.0, FINE[1:] + step / 3.0)
    columns = {"goal_rad": GOAL, "enabled": np.where(np.abs(FINE - 0.4) < 0.12, 0.0, 1.0)}
    exact = apart(rig, time, columns)[:, 0]
    power = order(rig, exact, time, columns)
    assert power == pytest.approx(2.0, abs=0.1)  # with the switch at the next grid point it would be 1
    assert np.max(np.abs(refined(rig, time, columns, 4) - exact)) < 3e-5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "truth", "late", "scale"),
    [
        ('[effects."drive.delay"]\ntau = 0.031', {"delay": 0.031}, 0.0, 1.0),
        ('[effects."sensor.delay"]\ntau = 0.04', {"sensor_delay": 0.04}, 0.04, 1.0),
        ('[effects."sensor.scale"]\ns = 0.1', {"scale": float(np.log(1.1))}, 0.0, 1.1),
    ],
)
def test_what_is_late_or_off_within_the_loop_changes_the_motion(
    effect: str, truth: dict[str, float], late: float, scale: float
) -> None:
    rig = servo("torque", hanging=HANGS + "\n" + effect)
    found = refined(rig, FINE, {"goal_rad": GOAL}, 4)
    exact, without = apart(rig, FINE, {"goal_rad": GOAL}, late, **truth), apart(rig, FINE, {"goal_rad": GOAL})
    assert np.max(np.abs(scale * exact[:, 0] - without[:, 0])) > 0.05
    assert np.max(np.abs(found - scale * exact[:, 0])) < 1e-4
