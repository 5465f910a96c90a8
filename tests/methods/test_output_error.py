"""Output error: known numbers come back."""

from rwjax.methods.output_error import finite_differences
from tests.methods.known_numbers import finds_a_wheel, finds_an_axis, finds_an_effect_on_the_command


def test_known_numbers_of_an_axis_come_back() -> None:
    finds_an_axis(finite_differences, 0.005)


def test_known_numbers_of_a_wheel_come_back() -> None:
    finds_a_wheel(finite_differences, 0.01)


def test_an_effect_on_the_command_is_estimated() -> None:
    finds_an_effect_on_the_command(finite_differences, 0.05)
