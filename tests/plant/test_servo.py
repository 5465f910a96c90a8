"""The sampled loop of a servo, against a loop in plain Python between exact solutions of the linear joint."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import expm

from rwjax.errors import RigError
from rwjax.fitting.predict import predict
from rwjax.kinds import SERVO
from rwjax.plant.servo import integral, slope
from rwjax.rig.model import Rig
from rwjax.simulation.simulate import simulate
from tests.joints import COUNT, joint, logged, servo

T = np.arange(201) * 0.01
GOAL = np.where(T > 0.2, 0.8, 0.0) + 0.2 * np.sin(3.0 * T)


def by_hand(rig: Rig, goal: np.ndarray, on: np.ndarray, supply: np.ndarray) -> np.ndarray:
    """Positions of a linear joint at `T`, whose servo ticks at the samples and between them, by matrix exponentials."""
    n = {"ki": 0.0, "kd": 0.0, "derivative_filter": 0.0, "error_limit": np.inf, "limit": np.inf}
    n |= {name.removeprefix(f"{SERVO}."): value for name, value in rig.numbers.items()}
    N, K, R, L = n["gear.ratio"], n["motor.torque_constant"], n["motor.resistance"], n.get("motor.inductance", 0.0)
    I = n["axis.inertia"] + N**2 * n["motor.inertia"]
    per_volt, braking = N * K / R / I, (N * K) ** 2 / R / I
    period, acts_on = n["period"], rig.servo.acts_on
    x, whole, s, before = np.zeros(2 + (L > 0.0)), 0.0, 0.0, None
    found = []
    for k in range(round(T[-1] / period) + 1):
        now = min(int(k * period / 0.01 + 1e-9), len(T) - 1)
        if abs(k * period - T[now]) < 1e-9:
            found.append(x[0])
        error = np.clip(goal[now] - x[0], -n["error_limit"], n["error_limit"])
        damped = error if rig.servo.damping_on == "error" else -x[0]
        s = (
            0.0
            if before is None
            else (n["derivative_filter"] * s + damped - before) / (n["derivative_filter"] + period)
        )
        before = damped
        asked = n["kp"] * error + n["ki"] * whole + n["kd"] * s
        most = min(n["limit"], 1.0 if acts_on == "duty" else np.inf)
        given = np.clip(asked, -most, most)
        if given == asked or np.sign(asked) != np.sign(error):
            whole += period * error
        if not on[now]:
            whole, given = 0.0, 0.0
        u = given * (supply[now] if acts_on == "duty" else 1.0)
        A, b = np.zeros((len(x), len(x))), np.zeros(len(x))
        A[0, 1], A[1, 1] = 1.0, -n["axis.friction.viscous"] / I
        if not on[now]:
            x[2:] = 0.0
        elif acts_on == "current":
            b[1] = N * K / I * u
        elif acts_on == "torque":
            b[1] = u / I
        elif L > 0.0:
            A[1, 2], A[2, 1], A[2, 2], b[2] = N * K / I, -K * N / L, -R / L, u / L
        else:
            A[1, 1] -= braking
            b[1] = per_volt * u
        M = expm(period * np.block([[A, b[:, None]], [np.zeros((1, len(x) + 1))]]))
        x = M[:-1, :-1] @ x + M[:-1, -1]
    return np.array(found)


EVERY = {
    "voltage": servo(joint(), kp=15.0, ki=30.0, kd=0.3, derivative_filter=0.02, error_limit=0.5, limit=6.0),
    "inductance": servo(joint(motor__inductance=2e-3), kp=15.0, ki=4.0, limit=6.0),
    "duty": servo(joint(), "duty", damping_on="speed", kp=3.0, kd=0.05),
    "current": servo(joint(), "current", kp=0.3, kd=0.02),
    "torque": servo(joint(), "torque", kp=0.3, kd=0.02, period=0.0025),
}
SLOW = {"current", "torque", "duty"}


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in EVERY])
def test_between_ticks_a_joint_moves_as_its_exact_solution(name: str) -> None:
    rig, on, supply = EVERY[name], ~((T > 0.9) & (T < 1.2)), 12.0 - 0.5 * np.sin(7.0 * T)
    columns = {"goal_rad": GOAL, "supply_V": supply, "enabled": on.astype(float)}
    found = np.asarray(simulate(rig, T, columns)["yaw_rad"])
    np.testing.assert_allclose(found, by_hand(rig, GOAL, on, supply), rtol=0.0, atol=1e-9)
    assert np.ptp(found) > 0.2


def test_a_slope_is_filtered_by_a_backward_step() -> None:
    assert float(slope(*map(jnp.asarray, (2.0, 1.0, 1.3, 0.3)), 0.1)) == pytest.approx((0.3 * 2.0 + 0.3) / 0.4)


@pytest.mark.parametrize(
    ("asked", "given", "error", "grows"), [(1.0, 1.0, 0.2, True), (2.0, 1.0, 0.2, False), (2.0, 1.0, -0.2, True)]
)
def test_an_integral_rests_where_it_would_wind_up(asked: float, given: float, error: float, grows: bool) -> None:
    found = integral(*map(jnp.asarray, (0.5, error, asked, given)), 0.1)
    assert float(found) == pytest.approx(0.5 + 0.1 * error * grows)


def with_effect(rig: Rig, name: str, **values: float) -> Rig:
    return Rig(**{**vars(rig), "effects": {name: values}})


def test_a_delay_within_the_loop_is_that_of_the_command() -> None:
    """Of a whole number of periods: the loop by hand with a row of outputs that wait."""
    rig, n = servo(joint(), "torque", kp=0.2, kd=0.03), 3
    period, I, b = 0.005, 0.02, 0.02
    x, row, before, found = np.zeros(2), None, 0.0, []
    M = expm(period * np.array([[0.0, 1.0, 0.0], [0.0, -b / I, 1.0 / I], [0.0, 0.0, 0.0]]))
    for k in range(2 * (len(T) - 1) + 1):
        found.append(x[0])
        error = GOAL[k // 2] - x[0]
        u = 0.2 * error + 0.03 * (0.0 if row is None else (error - before) / period)
        row, before = [u] * (n + 1) if row is None else [u, *row[:-1]], error
        x = M[:2, :2] @ x + M[:2, 2] * row[-1]
    late = with_effect(rig, "drive.delay", tau=n * period)
    got = np.asarray(simulate(late, T, {"goal_rad": GOAL})["yaw_rad"])
    np.testing.assert_allclose(got, found[::2], rtol=0.0, atol=1e-9)


def test_a_late_reading_delays_the_loop_as_a_late_output_does() -> None:
    """At rest before a goal that the loop is told as late as its reading, the motion is the same, only later."""
    rig = servo(joint(), "torque", kp=0.2, kd=0.03, damping_on="speed")
    goal = np.where(T > 0.3, 0.5, 0.0)
    later = np.where(T > 0.32, 0.5, 0.0)
    of_output = np.asarray(simulate(with_effect(rig, "drive.delay", tau=0.02), T, {"goal_rad": goal})["yaw_rad"])
    of_reading = with_effect(rig, "sensor.delay", tau=0.02)
    shown = np.asarray(simulate(of_reading, T, {"goal_rad": later})["yaw_rad"])
    np.testing.assert_allclose(shown[2:], of_output[:-2], rtol=0.0, atol=2e-5)  # a line between two ticks is read


def test_a_late_goal_is_an_earlier_goal_of_a_loop_that_does_not_know() -> None:
    """Of half a sample: the mean of two goals over the period that begins at a tick."""
    rig = servo(joint(), kp=8.0, period=0.01)
    late = np.asarray(simulate(with_effect(rig, "drive.goal_delay", tau=0.025), T, {"goal_rad": GOAL})["yaw_rad"])
    two, three = (np.append(np.full(k, GOAL[0]), GOAL[:-k]) for k in (2, 3))
    told = np.asarray(simulate(rig, T, {"goal_rad": 0.5 * (two + three)})["yaw_rad"])
    np.testing.assert_allclose(late, told, rtol=0.0, atol=1e-9)
    assert np.max(np.abs(late - np.asarray(simulate(rig, T, {"goal_rad": GOAL})["yaw_rad"]))) > 0.02


@pytest.mark.parametrize(("name", "values"), [("drive.lag", {"T": 0.03, "q": 0.0}), ("drive.rate_limit", {"r": 20.0})])
def test_what_follows_within_the_loop_begins_settled(name: str, values: dict[str, float]) -> None:
    rig, goal = servo(joint(), kp=5.0, period=0.01), {"goal_rad": np.full(len(T), 0.4)}
    plain, y = (np.asarray(simulate(r, T, goal)["yaw_rad"]) for r in (rig, with_effect(rig, name, **values)))
    assert y[1] == pytest.approx(plain[1], abs=1e-12) and abs(y[10] - plain[10]) > 1e-4
    assert y[-1] == pytest.approx(0.4, abs=0.01)


def test_positive_gains_restore_whatever_the_sign_of_a_platform() -> None:
    numbers = {"axis.inertia": 0.02, "axis.friction.viscous": 0.1}
    runs = [
        simulate(servo(Rig("platform", "p", numbers | {"drive.gain": gain}), kp=2.0), T, {"goal_rad": GOAL})["yaw_rad"]
        for gain in (0.3, -0.3)
    ]
    np.testing.assert_array_equal(*runs)
    assert abs(float(runs[0][-1]) - GOAL[-1]) < 0.3


def test_a_loop_that_has_integrated_its_error_away_goes_on_holding() -> None:
    """A log that begins long after the last change of its goal: the motor holds gravity, and the error is 0."""
    rig = servo(joint(axis__gravity__torque=0.6, axis__gravity__angle=0.3), kp=6.0, ki=30.0)
    time = np.arange(1201) * 0.01
    held = 512 * COUNT
    goal = held + np.where(time > 10.0, 0.3, 0.0)
    log = logged(rig, time, goal_rad=goal).cut(900, 1201)
    assert np.all(log.outputs["yaw_rad"][:50] == held)
    np.testing.assert_allclose(predict(rig, log)["yaw_rad"], log.outputs["yaw_rad"], rtol=0.0, atol=COUNT)


def test_a_delay_that_its_line_does_not_hold_is_refused() -> None:
    rig = with_effect(servo(joint(), period=0.001), "drive.delay", tau=0.03)
    said = "`drive.delay` is 0.03 s late; a servo remembers 24 ticks, 0.024 s: tick less often, by `drive.servo.period`"
    with pytest.raises(RigError, match=said):
        simulate(rig, T, {"goal_rad": GOAL})
