"""Prediction error: known numbers come back, delays are refused."""

import pytest

from rwjax.methods.kalman import prediction_error
from tests.methods.known_numbers import (
    finds_a_wheel,
    finds_an_axis,
    finds_an_effect_on_the_command,
    refuses_a_delay,
)
from tests.methods.logs import FREE, axis_log
from tests.systems import platform


@pytest.mark.slow
def test_known_numbers_of_an_axis_come_back() -> None:
    finds_an_axis(prediction_error, 0.01)


@pytest.mark.slow
def test_known_numbers_of_a_wheel_come_back() -> None:
    finds_a_wheel(prediction_error, 0.01)


def test_an_effect_on_the_command_is_estimated() -> None:
    finds_an_effect_on_the_command(prediction_error, 0.05)


def test_a_method_that_knows_no_delay_says_so() -> None:
    refuses_a_delay(prediction_error)


@pytest.mark.slow
def test_machine_code_and_xla_lead_to_the_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = platform(free=FREE)
    believed = truth.with_values({name: 1.15 * truth.values[name] for name in truth.free})
    log = axis_log(truth)
    found = prediction_error(believed, [log]).rig
    monkeypatch.setenv("RWJAX_THROUGH_XLA", "1")
    other = prediction_error(believed, [log]).rig
    for name in truth.free:
        assert found.values[name] == pytest.approx(other.values[name], abs=1e-3 * other.standard_error[name])
