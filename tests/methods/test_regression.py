"""Regression: known numbers come back, delays are refused."""

import pytest

from rwjax.methods.regression import equation_error, weak_form
from tests.methods.known_numbers import (
    Method,
    finds_a_wheel,
    finds_an_axis,
    finds_an_effect_on_the_command,
    refuses_a_delay,
)


# what each is known for: the weak form loses what lies near standstill, filtered accelerations are biased
@pytest.mark.parametrize(("method", "within"), [(weak_form, 0.05), (equation_error, 0.25)])
def test_known_numbers_of_an_axis_come_back(method: Method, within: float) -> None:
    finds_an_axis(method, within)


def test_known_numbers_of_a_wheel_come_back() -> None:
    finds_a_wheel(weak_form, 0.05)


def test_an_effect_on_the_command_is_estimated() -> None:
    finds_an_effect_on_the_command(weak_form, 0.1)


@pytest.mark.parametrize("method", [weak_form, equation_error])
def test_a_method_that_knows_no_delay_says_so(method: Method) -> None:
    refuses_a_delay(method)
