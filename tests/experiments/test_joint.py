"""The separate simulator's joints against closed forms, energy and an integration by scipy; the joints that are drawn."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.blind.joint import (
    AMPERE,
    CURRENT,
    DUTY,
    ELASTIC,
    GAP,
    LOSS,
    PSI,
    PSI_DRIVE,
    TORQUE,
    WORK,
    Inputs,
    Joint,
    Servo,
    W,
    energy,
    move,
)
from experiments.joints.draw import SORTS, draw, make_case, numbers

TIME = np.arange(301) * 0.01
ONE, NONE = np.ones(301), np.zeros(301)
SQUARE = np.where(TIME < 0.05, 0.0, np.sign(np.sin(4.0 * TIME)))
JOINT = Joint(ratio=10.0, K=0.05, R=2.0, rotor=1e-4, I=0.02, viscous=0.01, coulomb=0.04, excess=0.02, gravity=0.3)
SMOOTH = replace(JOINT, coulomb=0.0, excess=0.0)


@pytest.mark.parametrize(
    "joint",
    [
        JOINT,
        replace(JOINT, L=2e-3),
        replace(JOINT, given=CURRENT),
        replace(JOINT, given=TORQUE),
        replace(JOINT, L=2e-3, coupling=ELASTIC, stiffness=30.0, damping=0.05),
        replace(JOINT, coupling=GAP, stiffness=200.0, gap=0.05),
    ],
)
@pytest.mark.slow
def test_what_comes_in_is_stored_or_lost(joint: Joint) -> None:
    command = SQUARE * (4.0 if joint.given < DUTY else 0.5)
    x, _ = move(joint, None, Inputs(TIME, command, ONE, ONE), TIME)
    balance = energy(joint, x) - x[:, WORK] + x[:, LOSS]
    assert x[-1, LOSS] > 0.1
    assert np.ptp(balance) < 1e-8


@pytest.mark.slow
def test_a_geared_joint_coasts_down_in_closed_form() -> None:
    joint = replace(JOINT, gravity=0.0, excess=0.0)
    x, _ = move(joint, None, Inputs(TIME, NONE, ONE, NONE), TIME, (0.0, 2.0))
    b, dry, inertia = 0.01, 0.04, 0.02 + 100.0 * 1e-4
    stop = inertia / b * np.log1p(b * 2.0 / dry)
    exact = np.where(stop > TIME, (2.0 + dry / b) * np.exp(-b / inertia * TIME) - dry / b, 0.0)
    assert 0.5 < stop < 2.0
    assert np.max(np.abs(x[:, W] - exact)) < 1e-9
    assert np.all(x[stop < TIME, W] == 0.0)


@pytest.mark.slow
def test_a_held_link_lets_go_when_the_current_has_risen() -> None:
    joint = replace(JOINT, gravity=0.0, L=2.0)
    fine = np.arange(0.0, 0.2, 1e-4)
    x, _ = move(joint, None, Inputs(TIME, 2.0 * ONE, ONE, ONE), fine)
    current = (0.04 + 0.02) / (10.0 * 0.05)  # at which the motor's torque reaches breakaway
    lets_go = -joint.L / joint.R * np.log(1.0 - current * joint.R / 2.0)
    assert np.all(x[fine < lets_go, PSI] == 0.0)
    assert np.all(x[fine > lets_go + 1e-4, PSI] > 0.0)
    assert x[fine < lets_go, AMPERE] == pytest.approx(1.0 - np.exp(-fine[fine < lets_go]), rel=1e-9)


def loop_by_scipy(joint: Joint, servo: Servo, goal: float, until: float, start: float) -> np.ndarray:
    """Angle after every period of a loop that reads the link, by scipy's integration from tick to tick."""
    inertia, at_link = joint.I + joint.ratio**2 * joint.rotor, joint.ratio * joint.K
    x, integral, slope, before, angles = np.array([start, 0.0, 0.0]), 0.0, 0.0, goal - start, []
    for k in range(round(until / servo.period)):
        e = np.clip(goal - x[0], -servo.error_limit, servo.error_limit)
        slope = -x[1] if k == 0 else (servo.filter * slope + e - before) / (servo.filter + servo.period)
        before = e
        asked = servo.kp * e + servo.ki * integral + servo.kd * slope
        u = float(np.clip(asked, -servo.limit, servo.limit))
        integral += servo.period * e if u == asked or asked * e <= 0.0 else 0.0

        def rates(t: float, y: np.ndarray, u: float = u) -> list[float]:
            load = at_link * y[2] - joint.viscous * y[1] - joint.gravity * np.sin(y[0])
            return [y[1], load / inertia, (u - joint.R * y[2] - at_link * y[1]) / joint.L]

        x = solve_ivp(rates, (0.0, servo.period), x, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        angles.append(x[0])
    return np.array(angles)


@pytest.mark.slow
def test_a_loop_follows_scipy_from_tick_to_tick() -> None:
    joint = replace(SMOOTH, L=5e-3)
    servo = Servo(kp=30.0, ki=40.0, kd=0.8, filter=0.01, error_limit=0.4, limit=9.0, period=0.01)
    goal = 0.8
    x, _ = move(joint, servo, Inputs(TIME, goal * ONE, ONE, ONE), TIME)
    apart = x[1:41, PSI] - loop_by_scipy(joint, servo, goal, 0.4, 0.0)
    assert np.max(np.abs(apart)) < 1e-9


@pytest.mark.slow
def test_the_goal_of_a_tick_is_its_mean_over_the_period_and_comes_late() -> None:
    goal = np.where(TIME < 0.999, 0.0, 1.0)  # from 1.00 s on
    heavy = Joint(given=TORQUE, I=1e9)
    servo = Servo(kp=1.0, period=0.008)
    at = np.arange(0.0, 1.2, 0.008) + 0.004
    _, loop = move(heavy, replace(servo, phase=0.004), Inputs(TIME, goal, ONE, ONE), at)
    assert loop[at < 0.99, 0] == pytest.approx(0.0, abs=1e-12)
    assert loop[np.isclose(at, 0.996), 0] == pytest.approx(0.5)  # half of its period lies after 1 s
    _, late = move(replace(heavy, goal_delay=0.016), replace(servo, phase=0.004), Inputs(TIME, goal, ONE, ONE), at)
    assert late[2:, 0] == pytest.approx(loop[:-2, 0], abs=1e-9)


def test_a_loop_that_reads_late_takes_the_angle_of_before() -> None:
    joint = Joint(given=TORQUE, I=0.02, viscous=0.1, sensor_delay=0.021)
    servo, inputs = Servo(kp=0.5, period=0.008), Inputs(TIME, ONE, ONE, ONE)
    ticks = 0.2 + np.arange(60) * 0.008
    _, loop = move(joint, servo, inputs, ticks)
    before, _ = move(joint, servo, inputs, ticks - 0.021)
    assert np.ptp(before[:, PSI]) > 0.1
    assert loop[:, 0] == pytest.approx(0.5 * (1.0 - before[:, PSI]), abs=1e-9)


def test_with_torque_off_a_joint_has_no_motor() -> None:
    enabled = np.where(TIME < 1.0, 1.0, 0.0)
    servo = Servo(kp=30.0, kd=0.5, limit=12.0, period=0.004)
    x, _ = move(replace(JOINT, L=1e-3), servo, Inputs(TIME, 0.7 * ONE, ONE, enabled), TIME)
    alone = replace(JOINT, given=TORQUE)
    rest = TIME[100:] - 1.0
    free, _ = move(alone, None, Inputs(rest, 0.0 * rest, 1.0 + rest, 1.0 + rest), rest, (x[100, PSI], x[100, W]))
    assert np.ptp(x[100:, PSI]) > 0.3
    assert np.max(np.abs(x[100:, PSI] - free[:, PSI])) < 1e-9


def test_a_loop_before_the_gap_does_not_see_the_play() -> None:
    joint = replace(SMOOTH, gravity=0.0, coupling=GAP, gap=0.1, stiffness=500.0, damping=0.2, coulomb=0.02)
    servo = Servo(kp=30.0, ki=20.0, kd=0.5, limit=12.0, period=0.004)
    ends = [
        move(joint, replace(servo, motor_side=side), Inputs(TIME, 0.5 * ONE, ONE, ONE), TIME)[0][-1] for side in (0, 1)
    ]
    assert ends[1][PSI_DRIVE] == pytest.approx(0.5, abs=2e-3)
    assert abs(ends[1][PSI] - 0.5) > 0.02


@pytest.mark.parametrize("sort", SORTS)
def test_a_drawn_joint_says_all_of_itself_in_its_file(sort: str) -> None:
    drawn, case = draw(sort, 7), make_case(sort, 7)
    fixed = {name: value for name, value in numbers(drawn).items() if name not in drawn.free}
    lines = case.rig.splitlines()
    for name, value in fixed.items():
        assert f"{name.rsplit('.', 1)[1]} = {value:.10g}" in lines
    assert case.truth["true_numbers"].keys() == {*drawn.free}
    header = [text.splitlines()[int(text.startswith("#"))].split(",") for text in case.logs.values()]
    assert [text.startswith("# role: validate") for text in case.logs.values()] == [False, False, False, True]
    assert all(("enabled" in columns) == (sort == "torque_off") for columns in header)
    assert all(("goal_rad" in columns) == (drawn.servo is not None) for columns in header)
