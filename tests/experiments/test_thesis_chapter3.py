"""What chapter 3 of the thesis finds, and which of its equations cannot be as printed."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from experiments.thesis import friction_laws, motor, platform_models, regenerate, two_stages
from experiments.thesis.table import rms, run
from rwjax import parse_rig
from rwjax.fitting.predict import predict

TIME = np.arange(2001) * 0.01


def turned(volts: float, where: str) -> float:
    """Angle [rad] after 20 s at a constant voltage from rest, by the library or by the script that made the logs."""
    command = np.full_like(TIME, volts)
    if where == "library":
        return predict(platform_models.PLATFORM, run(TIME, command))["yaw_rad"][-1]
    return regenerate.platform(command[:300])[-1]


@pytest.mark.parametrize("where", ["library", "regenerate"])
def test_the_platform_moves_at_4_25_volts_and_not_by_the_last_digit_at_4_2(where: str) -> None:
    assert turned(4.2, where) == 0.0
    assert turned(-4.2, where) == 0.0
    assert turned(4.25, where) > 0.0


def test_at_4_volts_the_platform_rests_or_turns_by_its_past() -> None:
    t = np.arange(8000) * 0.05
    pushed = run(t, np.where(t < 30.0, 6.0, np.where(t < 230.0, 4.0, 3.6)))
    rate = predict(platform_models.PLATFORM, pushed)["yaw_rad_s"]
    assert turned(4.0, "library") == 0.0
    balance = platform_models.settled(4.0)[1]
    assert regenerate.FRICTION(balance) == pytest.approx(4.0 * regenerate.GAIN)
    assert rate[t < 230.0][-1] == pytest.approx(balance, rel=0.01)
    assert rate[-1] == 0.0  # 3.6 V is below the least friction of a moving platform


def stuck_miss(gain: float, damping: float, volts: float, span: float) -> float:
    """RMS rate over a span of a linear model that is pushed while the platform rests:
    w = gain u (1 - exp(-a t)) / a, squared and integrated."""
    aT = damping * span
    part = 1.0 - 2.0 * (1.0 - np.exp(-aT)) / aT + (1.0 - np.exp(-2.0 * aT)) / (2.0 * aT)
    return gain * abs(volts) / damping * np.sqrt(part)


@pytest.mark.parametrize("experiment", [1, 2])
def test_neither_linear_model_overlaps_the_platform(experiment: int) -> None:
    t, volts = platform_models.command(experiment)
    rig = predict(platform_models.PLATFORM, run(t, volts))["yaw_rad_s"]
    first = t < 0.5 * platform_models.PERIOD  # a quarter of the run
    assert np.all(rig[first] == 0.0)
    constants = ((0.428 / 0.228, 0.082 / 0.228), (0.08911, 0.09091))
    for model, (gain, damping) in zip(platform_models.MODELS.values(), constants, strict=True):
        miss = predict(model, run(t, volts))["yaw_rad_s"] - rig
        least = stuck_miss(gain, damping, volts[0], 0.5 * platform_models.PERIOD)
        assert rms(miss[first]) == pytest.approx(least, rel=1e-3)  # a sum over 3142 samples for an integral
        assert rms(miss) > 0.5 * least > 1.5


def test_no_ratio_of_rate_to_voltage_fits_a_rest_and_a_motion() -> None:
    weak, strong, rate = -3.6, -4.4, -3.0
    least = abs(weak * rate) / np.sqrt(2.0 * (weak**2 + strong**2))  # the distance of (0, rate) from the line
    assert platform_models.least_linear_miss(np.array([weak, strong]), np.array([0.0, rate])) == pytest.approx(least)


def test_the_motor_of_table_3_1() -> None:
    b = motor.friction_from_limit_speed(motor.SLOPE)
    low, _ = motor.critical_inductances(b)
    assert b == pytest.approx(4.07e-6, abs=0.005e-6)
    assert low == pytest.approx(0.0641, abs=0.00005)
    assert motor.damping_ratio(b, low) == pytest.approx(1.0)
    assert motor.damping_ratio(b, motor.L_CHAPTER_4) < 0.9  # listing A.4's motor overshoots
    t = np.arange(3001) * 0.001
    volts = np.full_like(t, 8.0)
    rig = parse_rig(
        f'kind = "wheel"\n[motor]\ntorque_constant = {motor.K}\nresistance = {motor.R}\ninductance = {low}\n'
        f"friction = {b}\n[wheel]\ninertia = {motor.J}"
    )
    free = predict(rig, run(t, volts))
    assert np.max(np.abs(motor.clipped(volts, 0.001, b, low, np.inf)[:, 0] - free["wheel_rad_s"])) < 1e-6
    held = motor.clipped(volts, 0.001, b, low, motor.CLIP)
    assert np.max(free["current_A"]) > 2.0 * np.max(held[:, 1]) == 2.0 * motor.CLIP
    assert held[-1, 0] == pytest.approx(8.0 * motor.SLOPE, rel=1e-3)  # the clip delays, it does not limit the speed


def test_only_all_three_corrections_make_eq_3_14_agree_with_3_13() -> None:
    printed, digit = two_stages.ACCELERATION_PRINTED, Polynomial([0.3757, -0.0525, 2.05e-2, -6.89e-4])
    assert two_stages.contradiction(regenerate.SPEED, -digit) < 0.07
    for speed in (two_stages.SPEED_PRINTED, regenerate.SPEED):
        for acceleration in (printed, -printed, digit, -digit):
            if (speed, acceleration) != (regenerate.SPEED, -digit):
                assert two_stages.contradiction(speed, acceleration) > 1.0
    assert np.min(regenerate.SPEED(two_stages.TIME)) > 0.0 > two_stages.SPEED_PRINTED(15.0)


def test_the_printed_digits_fix_the_curve_and_not_its_coefficients() -> None:
    found = two_stages.stage_two(regenerate.SPEED, two_stages.TIME)
    w = regenerate.SPEED(two_stages.TIME)
    assert rms(Polynomial(found)(w) - regenerate.FRICTION(w)) < 0.07
    assert np.all(np.abs(found / regenerate.FRICTION.coef - 1.0) > 0.3)
    low, high = two_stages.under_rounding(200)
    assert np.all(high - low > 0.3 * np.abs(found))
    assert np.all((regenerate.FRICTION.coef < low) | (regenerate.FRICTION.coef > high))  # printed from something else


def test_the_polynomial_drives_beyond_the_measured_speeds() -> None:
    beyond = platform_models.settled(0.0)[-1]
    assert beyond > regenerate.SPEED(0.0)
    assert regenerate.FRICTION(1.01 * beyond) < 0.0 < regenerate.FRICTION(0.99 * beyond)


def left_of_level(n: float, s: np.ndarray) -> np.ndarray:
    """1 - F/F_c after a displacement of s F_c/sigma from 0 force, eq. 3.8 integrated."""
    if n == 1.0:
        return np.exp(-s)
    return np.maximum(1.0 - (1.0 - n) * s, 0.0) ** (1.0 / (1.0 - n))


@pytest.mark.parametrize("n", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_dahl_approaches_its_level_as_integrated_by_hand(n: float, way: float) -> None:
    sigma, F_c, speed = 30.0, 0.4, 0.01
    t = np.linspace(0.0, 4.0 * F_c / sigma / speed, 201)
    force = friction_laws.dahl(t, lambda s: way * speed, sigma, F_c, n)
    exact = way * F_c * (1.0 - left_of_level(n, sigma * speed * t / F_c))
    assert np.max(np.abs(force - exact)) < 1e-6 * F_c  # the solver's tolerance is 1e-8 a step


def test_dahl_turns_at_the_closed_form_of_its_loop() -> None:
    x, force = friction_laws.dahl_loop(1.0, 0.1)
    assert np.max(force) == pytest.approx(np.tanh(np.max(x)), abs=2e-4)  # the third loop is not quite the last one
    assert np.min(force) == pytest.approx(-np.tanh(np.max(x)), abs=2e-4)


def test_dahl_knows_the_way_and_not_the_speed() -> None:
    slow = friction_laws.dahl_loop(2.0, 0.1)[1]
    fast = friction_laws.dahl_loop(2.0, 10.0)[1]
    assert np.max(np.abs(slow - fast)) < 1e-5
    t = np.linspace(0.0, 4.0, 401)  # the same way, first slowly and then fast, against steadily
    uneven = friction_laws.dahl(t, lambda s: 0.5 * s, 1.0, 1.0, 2.0)
    assert np.max(np.abs(uneven - (1.0 - left_of_level(2.0, 0.25 * t**2)))) < 1e-6


def test_stribeck_falls_between_its_regions_and_comes_closest() -> None:
    numbers = [0.6, 0.4, 1.0, 0.15]
    law = friction_laws.LAWS["Stribeck and viscous"][0]
    first, last = friction_laws.falling(numbers)
    curve = friction_laws.friction(law, numbers, np.array([0.5 * first, first, last, 2.0 * last]))
    assert curve[0] < curve[1] > curve[2] < curve[3]
    w = np.linspace(0.01, 10.9, 100)
    left = [
        rms(friction_laws.friction(law, friction_laws.closest(name, w), w) - regenerate.FRICTION(w))
        for name, (law, _) in friction_laws.LAWS.items()
    ]
    assert left[0] == pytest.approx(np.std(regenerate.FRICTION(w)), rel=1e-4)  # a constant leaves the spread
    assert left[1] == pytest.approx(rms(Polynomial.fit(w, regenerate.FRICTION(w), 1)(w) - regenerate.FRICTION(w)))
    assert left[2] < 0.5 * left[1] < 0.25 * left[0]
