"""Settings: every limit says what it means and where it comes from."""

from dataclasses import FrozenInstanceError, astuple, fields, is_dataclass, replace

import pytest

from experiments.blind.calibrate import GRID
from rwjax.diagnosis.settings import Limits, Settings


def leaves(group: object) -> int:
    assert is_dataclass(group)
    values = [getattr(group, one.name) for one in fields(group)]
    return sum(leaves(value) if is_dataclass(value) else 1 for value in values)


def test_every_limit_has_a_meaning_and_an_origin() -> None:
    every = list(Settings().described())
    assert len(every) == len({one.name for one in every}) == leaves(Settings())
    for one in every:
        assert len(one.meaning.split()) >= 3, one.name
        assert one.origin in ("calibrated", "proposed"), one.name


def test_the_calibrated_limits_are_those_that_are_calibrated() -> None:
    calibrated = {one.name for one in Settings().described() if one.origin == "calibrated"}
    assert calibrated == {f"verdict.{name}" for name in GRID}
    assert all(value in tried for value, tried in zip(astuple(Limits()), GRID.values(), strict=True))


def test_described_tells_the_values_in_use() -> None:
    settings = replace(Settings(), verdict=Limits(nothing=2.5))
    assert {one.name: one.value for one in settings.described()}["verdict.nothing"] == 2.5
    assert {one.name: one.value for one in settings.described()}["localisation.momentum.level"] == 0.01


def test_settings_are_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        Settings().search.needed = 1.0  # pyright: ignore[reportAttributeAccessIssue]
