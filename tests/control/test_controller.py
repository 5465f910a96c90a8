"""The controller's timing: delays in whole periods and their rest, steps of the plant, and a wheel that keeps its rate."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.control.controller import (
    LEAST_STEPS,
    LONGEST_STEP,
    LoopTiming,
    loop_timing,
    split_delay,
    wheel_holding_voltage,
)
from tests.systems import platform


@given(st.floats(0.0, 5.0), st.floats(1e-3, 1.0))
def test_a_delay_is_its_whole_periods_and_a_rest_within_one(delay: float, period: float) -> None:
    whole, rest = split_delay(delay, period)
    assert whole * period + rest == pytest.approx(delay, abs=2e-9 * period)
    assert 0.0 <= rest < period


def test_a_delay_of_whole_periods_has_no_rest_though_it_is_rounded() -> None:
    assert split_delay(0.3, 0.1) == (3, pytest.approx(0.0, abs=1e-12))  # 0.3/0.1 is below 3 in binary


def test_an_extra_delay_comes_on_top() -> None:
    timing = LoopTiming(0.01, 4, 1.0)
    assert timing.delay == pytest.approx(0.0025)
    later = timing.with_extra_delay(0.03)
    assert later.delay == pytest.approx(0.0325) and later.delay_parts == (3, pytest.approx(1.0))
    assert later._replace(delay_steps=1.0) == timing


@given(st.floats(1e-3, 0.2), st.floats(0.0, 1.0))
def test_a_period_is_cut_into_steps_that_are_short_enough(period: float, share: float) -> None:
    rig = replace(platform(), counts_per_rev={"axis": 2048.0})
    timing = loop_timing(rig, period, share * period)
    assert timing.steps >= LEAST_STEPS and period / timing.steps <= LONGEST_STEP * (1.0 + 1e-8)
    assert timing.delay == pytest.approx(share * period) and timing.counts == 2048
    assert loop_timing(platform()).counts == 0


def test_a_wheel_keeps_its_rate_where_its_torque_balances_its_friction() -> None:
    K, R, b, Omega = 0.02, 0.8, 4e-6, 300.0
    numbers = {"motor.torque_constant": K, "motor.resistance": R, "motor.friction": b}
    current = (wheel_holding_voltage(numbers) * Omega - K * Omega) / R
    assert K * current == pytest.approx(b * Omega)
    assert wheel_holding_voltage({"motor.torque_constant": K, "motor.resistance": R}) == K
