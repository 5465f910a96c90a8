"""The diagnosis in words."""

import numpy as np
import pytest

from rwjax.diagnosis.gap import Gap
from rwjax.diagnosis.localise.where import Where
from rwjax.diagnosis.settings import ReportSettings
from rwjax.diagnosis.waterfall import Rung
from rwjax.diagnosis.words import (
    UNIT,
    beside_runaways,
    explanations,
    gap_line,
    moved,
    not_compared,
    numbers_of,
    several_sentence,
    sure_of,
    unfinished_sentence,
    verdict_sentence,
    where_words,
    why_not,
    without_error,
)
from tests.systems import platform

SETTINGS = ReportSettings()
GAP = Gap(0.05, 0.01, 0.009, 0.976, (0.9, 0.99), 0.99)


def rung(numbers: dict[str, tuple[float, float]], own: dict[str, tuple[float, float]], drift=(np.nan, np.nan)) -> Rung:
    return Rung((), 1.0, numbers, dict.fromkeys(numbers, drift), own)


def test_numbers_are_told_with_their_errors_and_units() -> None:
    own = {"axis.stribeck.M_c": (0.45, 0.01), "axis.stribeck.n": (1.5, np.inf), "axis.inertia": (0.2, 0.003)}
    assert numbers_of(platform(), rung({}, own)) == [
        "axis.stribeck: M_c = 0.45 ± 0.01 N m, n = 1.5 (not told by these logs)",
        "axis.inertia = 0.2 ± 0.003 kg m2",
    ]


@pytest.mark.parametrize(
    ("before", "after", "drift", "told"),
    [
        ((1.0, 0.1), (1.04, 0.01), (0.4, 4.0), []),
        ((1.0, 0.01), (1.06, 0.01), (4.2, 6.0), ["J moves by +6.0 % (+4.2 sigma) when the effects are added"]),
        ((1.0, 5.0), (1.9, 0.01), (0.2, 90.0), ["J moves by +90.0 % (+0.2 sigma) when the effects are added"]),
        ((1.0, 5.0), (1.9, 4.0), (0.1, 90.0), []),
        ((1.0, np.inf), (2.0, 0.01), (np.nan, 100.0), ["J moves by +100.0 % when the effects are added"]),
        ((0.0, 5.0), (2.0, 0.01), (0.4, np.nan), ["J moves by +2 (+0.4 sigma) when the effects are added"]),
        ((1.0, 0.1), (9.0, np.inf), (np.nan, 800.0), []),
    ],
    ids=["hardly", "surely", "far", "far by chance", "not told before", "from none", "not told after"],
)
def test_base_numbers_that_move_are_told(before, after, drift, told: list[str]) -> None:
    assert moved(rung({"J": before}, {}), rung({"J": after}, {}, drift), SETTINGS) == told


def test_coordinates_in_which_a_law_removes_as_much_are_told() -> None:
    def words(**shares: float) -> str:
        return where_words(Where("yaw_rate", shares["yaw_rate"], None, None, shares, ()), SETTINGS)

    assert words(yaw_rate=0.99, yaw=0.989, voltage=0.5) == "yaw rate (as one in yaw)"
    assert words(yaw_rate=0.4, voltage=1.0) == "yaw rate" == words(yaw_rate=0.0, yaw=0.0)


@pytest.mark.parametrize(
    ("verdict", "effects", "alternatives", "uninformative", "said"),
    [
        ("none", (), (), None, "Nothing is missing: the rig explains the logs down to the floor (0.05 of 0.009 rad)."),
        (
            "effect",
            ("axis.coulomb",),
            (),
            None,
            "The rig lacks dry friction (axis.coulomb): on held-out runs the error falls from 0.05 to 0.01 rad and closes "
            "98 % of the gap.",
        ),
        (
            "ambiguous",
            ("parameter.drive.gain",),
            (("axis.inertia",), ("a", "b")),
            None,
            "The rig's file is wrong in drive.gain; or the rig lacks axis.inertia (axis.inertia); or the rig lacks "
            "a (a) and b (b): these logs cannot tell them apart.",
        ),
        (
            "unknown",
            ("a", "b"),
            (),
            None,
            "Unknown: a (a) and b (b) together close 98 % of the gap, but this is no claim: 0.01 rad stay, 1.1 times the floor, and no "
            "effect of the library was found that explains these.",
        ),
        (
            "partial",
            ("a", "b"),
            (),
            None,
            "Only in part: the rig lacks a (a) and b (b); this closes 98 % of the gap on held-out runs, and for the 0.01 rad that stay "
            "(1.1 times the floor) no effect of the library was found that holds.",
        ),
        (
            "partial",
            ("a",),
            (("b", "parameter.c"),),
            None,
            "Only in part: the rig lacks a (a); or the rig lacks b (b), and its file is wrong in c; this closes 98 % of the gap on "
            "held-out runs, and for the 0.01 rad that stay (1.1 times the floor) no effect of the library was found that holds.",
        ),
        (
            "unknown",
            (),
            (),
            None,
            "Unknown: a gap above the floor remains (0.05 of 0.009 rad), and no effect of the library was found that explains it.",
        ),
        (
            "unknown",
            (),
            (),
            "nothing moves in these logs",
            "Unknown: nothing moves in these logs, so that they do not say whether anything is missing.",
        ),
    ],
    ids=["none", "effect", "ambiguous", "in part", "partial", "one of two", "unknown", "uninformative"],
)
def test_every_verdict_has_its_sentence(verdict, effects, alternatives, uninformative, said: str) -> None:
    assert verdict_sentence(verdict, effects, alternatives, GAP, "rad", uninformative) == said


def test_several_explanations_are_a_sentence_and_a_list() -> None:
    assert several_sentence("ambiguous", 3, GAP, "0.01 rad of yaw_rad") == (
        "These logs do not tell which of 3 explanations is true; the first closes 98 % of the gap."
    )
    assert several_sentence("partial", 2, GAP, "0.01 rad of yaw_rad") == (
        "Only in part, and these logs do not tell which of 2 explanations is true; the first closes 98 % of the gap; "
        "0.01 rad of yaw_rad stay."
    )
    said = explanations(("a", "parameter.c"), (("parameter.d",),))
    assert said == ("the rig lacks a (a), and its file is wrong in c", "the rig's file is wrong in d")


def test_it_is_said_how_a_number_is_kept_that_is_known() -> None:
    assert sure_of("parameter.c").endswith("ask again with `--without parameter.c`")


def test_it_is_said_why_a_candidate_is_not_named() -> None:
    assert why_not(0.03, ("a", "b"), 0.01, "rad") == "It leaves 0.03 rad on held-out runs, 3 times what a + b leaves."
    assert why_not(0.009, (), 0.01, "rad").startswith(
        "It leaves 0.009 rad of the held-out runs, where the rig as it is leaves 0.01, but"
    )
    assert (
        why_not(0.03, ("a",), 0.0, "rad") == "It leaves 0.03 rad on held-out runs, and a leaves nothing."
    )  # an axis at rest
    likelier = why_not(0.009, ("a",), 0.01, "rad", more_evidence=True)
    assert likelier.startswith(
        "It leaves 0.009 rad of the held-out runs, where a leaves 0.01, and the fitted runs alone speak"
    )
    assert why_not(None, ("a",), 0.01, "rad", more_evidence=True) == "It was not judged on held-out runs."
    assert why_not(None, ("a",), 0.01, "rad") == "The training runs speak more for a."


@pytest.mark.parametrize(
    ("effects", "untried", "said"),
    [
        (
            (),
            36,
            "a gap above the floor remains (0.05 of 0.009 rad), and the search was ended with 36 candidates not compared.",
        ),
        (
            ("axis.coulomb",),
            1,
            "so far dry friction (axis.coulomb) closes 98 % of the gap, which is no claim: the search was ended with 1 candidate not compared.",
        ),
        (
            ("a", "b"),
            0,
            "so far a (a) and b (b) close 98 % of the gap, which is no claim: the search was ended before it was through.",
        ),
    ],
)
def test_an_unfinished_search_says_what_leads_and_what_is_left(effects, untried: int, said: str) -> None:
    assert unfinished_sentence(effects, untried, GAP, "rad") == f"Unfinished: {said}"


def test_it_is_said_beside_which_runaways_nothing_is_claimed() -> None:
    assert beside_runaways({"wheel.inertia": 4.81e7}) == (
        "beside it wheel.inertia (4.8e+07 times the file's) runs away, as where something holds a part, and what that is is not named"
    )
    both = beside_runaways({"a": 1e5, "b": 2e6})
    assert both.startswith("beside it a (100000 times the file's) and b (2e+06 times the file's) run away, as")


def test_a_gap_is_a_line() -> None:
    said = "* yaw_rad: before 0.05, after 0.01, floor 0.009 rad, closed 97.6 % (95 %: 90.0 to 99.0)"
    assert gap_line("yaw_rad", GAP, marked=True, told=True) == said
    assert gap_line("yaw_rad", GAP, marked=True, told=False) == said.partition(", closed")[0]
    bare = "  current_A: before 0.1, after 0.1, floor 0.1 A"
    assert gap_line("current_A", Gap(0.1, 0.1, 0.1, None, None, None), marked=False, told=True) == bare


def test_units() -> None:
    assert (
        UNIT["yaw_rad_s"] == UNIT["wheel_2_rad_s"] == "rad/s"
        and UNIT["pitch_rad"] == "rad"
        and UNIT["current_1_A"] == "A"
    )


def test_another_output_that_stays_far_off_is_named() -> None:
    other = ("current_A", Gap(4.0, 4.0, 1.0, 0.0, None, None))
    said = verdict_sentence("unknown", ("axis.coulomb",), (), GAP, "rad", None, elsewhere=other)
    assert said.endswith(
        " closes 98 % of the gap, but this is no claim: 4 A of current_A stay, 4 times the floor, and no effect of the library was found "
        "that explains these."
    )
    said = verdict_sentence("partial", ("axis.coulomb",), (), GAP, "rad", None, elsewhere=other)
    assert said.endswith(
        ", and for the 4 A of current_A that stay (4 times the floor) no effect of the library was found that holds."
    )


def test_hundreds_of_floors_are_written_out() -> None:
    far = Gap(400.0, 17.0, 0.1, 0.96, None, 170.0)
    for verdict in ("unknown", "partial"):
        said = verdict_sentence(verdict, ("axis.coulomb",), (), far, "rad", None)
        assert "170 times the floor" in said and "e+" not in said


def test_a_number_without_an_error_at_an_end_of_its_range_is_said_to_be_there() -> None:
    own = {"drive.deadzone.u_0": (0.2, 0.01), "drive.deadzone.j": (0.0, np.inf)}
    assert numbers_of(platform(), rung({}, own)) == [
        "drive.deadzone: u_0 = 0.2 ± 0.01 V, j = 0 V (the least that it may be)"
    ]
    assert without_error("axis.stribeck.n", 4.0) == "the most that it may be"
    assert without_error("drive.deadzone.j", 0.1) == "not told by these logs" == without_error("axis.inertia", 0.0)


def test_of_many_candidates_that_were_not_compared_the_first_are_named() -> None:
    names = tuple(f"drive.{k}" for k in range(SETTINGS.untried + 2))
    assert not_compared((), SETTINGS) == "every candidate was compared by then"
    assert not_compared(names[:-1], SETTINGS) == f"not compared were {', '.join(names[:-1])}"
    assert not_compared(names, SETTINGS) == (
        f"not compared were {', '.join(names[: SETTINGS.untried])} and 2 more (`untried` in diagnosis.json)"
    )
