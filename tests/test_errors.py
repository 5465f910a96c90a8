"""Errors of unusable input, and the nearest valid name."""

import pytest

from rwjax.errors import InputError, LogError, RigError, alike, nearest


@pytest.mark.parametrize("error", [InputError, RigError, LogError])
def test_a_message_stays_on_one_line(error: type[InputError]) -> None:
    assert str(error("a\nb\r\nc")) == r"a\nb\nc" and isinstance(error(""), ValueError)


def test_the_nearest_name_is_found_however_unlike() -> None:
    assert nearest("inerta", ["friction", "inertia", "gravity"]) == "inertia"
    assert nearest("x", ["friction"]) == "friction"


@pytest.mark.parametrize(
    ("name", "slip"), [("yaw_count", True), ("yaw_counts", True), ("temperature_C", False), ("", False)]
)
def test_only_what_may_be_a_typing_mistake_is_alike(name: str, slip: bool) -> None:
    assert alike(name, ["time_s", "yaw_counts"]) == slip
