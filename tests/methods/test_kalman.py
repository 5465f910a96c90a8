"""Prediction error: known numbers come back, delays are refused."""

import pytest

from rwjax.methods.kalman import prediction_error
from tests.methods.known_numbers import (
    finds_a_wheel,
    finds_an_axis,
    finds_an_effect_on_the_command,
    refuses_a_delay,
)


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
