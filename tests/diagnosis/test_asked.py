"""Candidates that are asked for, or left out."""

import pytest

from rwjax.diagnosis.asked import asked
from rwjax.diagnosis.hypothesis import candidates
from rwjax.errors import InputError
from tests.systems import platform

RIG = platform("viscous = 0.02")
EVERY = candidates(RIG)


def test_without_a_wish_all_candidates_are_compared() -> None:
    among = asked(RIG)
    assert among.names == EVERY and not among.restricted and among.said() == []


def test_only_some_in_the_order_of_the_library() -> None:
    among = asked(RIG, only=["drive.delay", "parameter.drive.gain", "axis.coulomb"], without=["drive.delay"])
    assert among.names == tuple(name for name in EVERY if name in ("axis.coulomb", "parameter.drive.gain"))
    assert among.restricted and "only axis.coulomb, parameter.drive.gain" in among.said()[0]


def test_what_a_rig_cannot_lack_may_be_left_out_even_so() -> None:
    among = asked(RIG, without=["wheel.cogging", "drive.delay"])
    assert {*EVERY} - {*among.names} == {"drive.delay"} and among.without == ("drive.delay",)
    assert "drive.delay" in among.said()[0] and "wheel.cogging" not in among.said()[0]
    assert not asked(RIG, without=["wheel.cogging"]).restricted


@pytest.mark.parametrize(
    ("only", "without", "said"),
    [
        (["stribeck"], [], "`stribeck` is no effect and no fixed number of this rig; nearest `axis.stribeck`"),
        (["axis.stribek"], [], "`axis.stribek` is no effect and no fixed number of this rig; nearest `axis.stribeck`"),
        ([], ["parameter.drive.gian"], "nearest `parameter.drive.gain`"),
        (["wheel.cogging"], [], "`wheel.cogging` cannot be missing in this rig: it is no part of a `platform` rig"),
        (["axis.viscous"], [], "or the rig file holds it"),
        (["axis.coulomb"], ["axis.coulomb"], "no candidate is left to compare"),
    ],
)
def test_a_name_that_is_none_is_refused_in_one_line(only: list[str], without: list[str], said: str) -> None:
    with pytest.raises(InputError) as wrong:
        asked(RIG, only, without)
    assert said in str(wrong.value) and "\n" not in str(wrong.value)


@pytest.mark.parametrize("option", ["only", "without"])
def test_one_name_that_is_no_list_is_not_read_letter_by_letter(option: str) -> None:
    with pytest.raises(
        InputError, match=f"^`{option}` is one name; give names in a list, as {option}=\\['drive.lag'\\]$"
    ):
        asked(platform(), **{option: "drive.lag"})
