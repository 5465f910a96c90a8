"""Diagnosis: as JSON, as text, and the subsystem that it names."""

import json
import re
from dataclasses import replace
from operator import methodcaller

import numpy as np
import pytest

from rwjax.diagnosis.estimates import Estimates
from rwjax.diagnosis.gap import Gap, HeldOut
from rwjax.diagnosis.localise.left_torque import LeftTorque
from rwjax.diagnosis.localise.where import Where
from rwjax.diagnosis.result import Diagnosis, Left, Ranked
from rwjax.diagnosis.settings import Settings
from rwjax.diagnosis.waterfall import Rung
from rwjax.diagnosis.worst_windows import Window
from rwjax.logs.coverage import Outside, Split
from tests.systems import platform, reaction, wheel

NONE = HeldOut({}, {}, {}, {}, {})
FIRST = Rung((), 0.05, {"axis.inertia": (0.1, 0.001)}, {"axis.inertia": (0.0, 0.0)}, {})
SECOND = Rung(
    ("axis.coulomb",),
    0.01,
    {"axis.inertia": (0.09, np.inf)},
    {"axis.inertia": (np.nan, -10.5)},
    {"axis.coulomb.M_c": (0.03, 0.001)},
)
CORRECTED = replace(platform(), effects={"axis.coulomb": {"M_c": 0.03}}, standard_error={"axis.coulomb.M_c": 1e-3})
DIAGNOSIS = Diagnosis(
    rig=platform(),
    logs=(),
    verdict="effect",
    complete=True,
    untried=(),
    restricted=False,
    uninformative=None,
    effects=("axis.coulomb",),
    alternatives=(),
    ranking=(Ranked("axis.coulomb", 1.0, 0.01), Ranked("none", 0.0, 0.05, "It leaves more.")),
    where=Where("yaw_rate", 0.98, "yaw_rate", (-0.1, 0.2), {"yaw_rate": 0.98}, ()),
    windows=(Window("a.csv", 1.0, 2.0, 0.5),),
    left=None,
    left_torque=LeftTorque(0.02, 0.1, np.array([0.0, 2.0, 4.0]), np.array([1e-4, 5e-5])),
    signal="yaw_rad",
    gaps={"yaw_rad": Gap(0.05, 0.01, 0.009, 0.976, (0.9, 0.99), 0.99)},
    held_out="leave-one-run-out",
    next_experiment="none needed",
    proposal=None,
    waterfall=(FIRST, SECOND),
    alternatives_waterfall=(),
    refused={"axis.spring": "runs ask for different amounts of it"},
    remarks=("one run was fitted",),
    split=Split((Outside("a.csv", "yaw_rad_s [rad/s]", 0.4, (0.0, 3.0), (0.0, 1.0)),), "b.csv"),
    corrected=CORRECTED,
    before=NONE,
    after=NONE,
    settings=Settings(),
    estimates=Estimates({"axis.coulomb.M_c": (0.03, 1e-3)}, np.array([[1e-6]])),
)


def test_the_json_is_plain_and_its_keys_are_those_that_programs_read() -> None:
    found = json.loads(json.dumps(DIAGNOSIS.json(), allow_nan=False))
    assert list(found) == [
        "schema", "rig", "verdict", "complete", "untried", "untold", "effects", "alternatives", "ranking", "where", "left", "left_torque",
        "gap", "held_out", "split",
        "next_experiment", "drift", "numbers", "covariance_of", "covariance", "refused", "remarks",
    ]  # fmt: skip
    assert found["schema"] == "rwjax.diagnosis/2" and found["untold"] is None
    assert (
        found["gap"]["signal"] == "yaw_rad"
        and found["gap"]["after"] == found["gap"]["signals"]["yaw_rad"]["after"] == 0.01
    )
    assert found["split"]["proposed"] == "b.csv" and found["split"]["outside"][0]["share"] == 0.4
    assert found["gap"]["segment_s"] is None
    assert found["left_torque"]["spectrum"][1] == {"from_hz": 2.0, "to_hz": 4.0, "density_N2m2_per_Hz": 5e-5}
    assert found["where"]["subsystem"] == "axis" and found["where"]["interval"] == [-0.1, 0.2]
    assert found["where"]["windows"] == [{"log": "a.csv", "from_s": 1.0, "to_s": 2.0, "share": 0.5}]
    assert found["drift"][1]["numbers"]["axis.inertia"] == {
        "value": 0.09, "standard_error": None, "shift_sigmas": None, "shift_percent": -10.5,
    }  # fmt: skip
    assert found["drift"][1]["effect_numbers"]["axis.coulomb.M_c"] == {
        "value": 0.03,
        "standard_error": 0.001,
        "unit": "N m",
    }


def test_the_json_has_the_estimates_that_the_logs_tell_as_the_corrected_rig_holds_them() -> None:
    found = DIAGNOSIS.json()
    assert found["rig"] == platform().name and found["covariance_of"] == ["axis.coulomb.M_c"]
    assert found["covariance"] == [[1e-6]]
    assert found["numbers"] == {"axis.coulomb.M_c": {"value": 0.03, "standard_error": pytest.approx(1e-3)}}


def test_an_unfinished_answer_says_so_in_the_text_and_the_json() -> None:
    found = replace(DIAGNOSIS, verdict="unknown", complete=False, untried=("drive.lag",))
    assert str(found).startswith("Unfinished: so far dry friction (axis.coulomb) closes 98 % of the gap")
    assert found.json()["complete"] is False and found.json()["untried"] == ["drive.lag"]
    assert DIAGNOSIS.json()["complete"] is True and DIAGNOSIS.json()["untried"] == []


def test_what_is_left_stands_in_the_json_and_in_the_text() -> None:
    where = Where("time", 0.3, "time", (2.0, 9.0), {"time": 0.3}, ())
    left = Left(0.04, where, (Window("b.csv", 4.0, 5.0, 0.6),))
    found = replace(DIAGNOSIS, verdict="partial", left=left)
    assert found.json()["left"] == {
        "share": 0.04,
        "coordinate": "time",
        "interval": [2.0, 9.0],
        "windows": [{"log": "b.csv", "from_s": 4.0, "to_s": 5.0, "share": 0.6}],
    }
    assert DIAGNOSIS.json()["left"] is None and "left:" not in str(DIAGNOSIS)
    assert "  left: 4 % of the excess squared error; nearest to it comes a law in time" in str(found)
    assert "it is largest from 4.0 to 5.0 s of b.csv, where 60 % of it lies" in str(
        found
    ) and "The rig lacks" not in str(found)
    nowhere = replace(found, left=replace(left, where=None))
    assert nowhere.json()["left"]["coordinate"] is None and "nearest" not in str(nowhere)


def test_of_a_gap_that_hardly_exists_no_share_is_told() -> None:
    hardly = Gap(1.05, 0.93, 1.0, 2.4, (1.0, 3.0), None)
    found = replace(DIAGNOSIS, gaps=DIAGNOSIS.gaps | {"yaw_rad_s": hardly})
    assert [found.has_gap(name) for name in ("yaw_rad", "yaw_rad_s")] == [True, False]
    line = next(line for line in str(found).splitlines() if "yaw_rad_s:" in line)
    assert line.endswith("floor 1 rad/s") and "closed" in str(found)


def test_the_ranking_says_why_a_candidate_is_not_named() -> None:
    first, none = DIAGNOSIS.json()["ranking"]
    assert first["why_not"] is None and none == {
        "effect": "none", "probability": 0.0, "gap_after": 0.05, "why_not": "It leaves more.",
    }  # fmt: skip


def test_the_ranking_is_a_table() -> None:
    sheet = DIAGNOSIS.to_frame()
    assert sheet.columns == ["effect", "probability", "gap_after", "why_not"]
    assert sheet.rows() == [("axis.coulomb", 1.0, 0.01, None), ("none", 0.0, 0.05, "It leaves more.")]


def test_a_notebook_shows_the_sentence_and_the_lines_as_text() -> None:
    found = replace(DIAGNOSIS, remarks=("a remark <b>&",))
    shown = methodcaller("_repr_html_")(found)  # as notebooks do
    assert shown.startswith(f"<p><b>{DIAGNOSIS.sentence}</b></p><pre>")
    assert "a remark &lt;b&gt;&amp;" in shown and shown.count(DIAGNOSIS.sentence) == 1


def test_a_claim_among_some_candidates_says_so() -> None:
    asked = replace(DIAGNOSIS, restricted=True)
    assert asked.sentence == f"{DIAGNOSIS.sentence[:-1]}; only the candidates asked for were compared."
    assert (
        replace(asked, verdict="none", effects=()).sentence == replace(DIAGNOSIS, verdict="none", effects=()).sentence
    )
    unknown = replace(asked, verdict="unknown", effects=()).sentence
    assert unknown.startswith("Unknown: a gap above the floor remains (0.05 of ")
    assert unknown.endswith(" rad), and no candidate asked for was found that explains it.")


def test_of_several_explanations_the_headline_says_how_many_and_the_list_which() -> None:
    several = replace(DIAGNOSIS, verdict="ambiguous", alternatives=(("axis.stribeck",), ("parameter.axis.inertia",)))
    assert "which of 3 explanations is true" in several.headline and len(several.explanations) == 3
    assert several.explanations[2] == "the rig's file is wrong in axis.inertia"
    assert replace(several, restricted=True).headline.endswith("; only the candidates asked for were compared.")
    assert f"{several.gaps['yaw_rad'].after:.3g} rad of yaw_rad stay" in replace(several, verdict="partial").headline
    assert DIAGNOSIS.headline == DIAGNOSIS.sentence and DIAGNOSIS.explanations == ()


def test_where_nothing_is_missing_no_place_is_told() -> None:
    nothing = replace(DIAGNOSIS, verdict="none", effects=())
    assert nothing.json()["where"] is None and nothing.subsystem is None
    assert "where:" not in str(nothing)


def test_the_text_is_the_sentence_and_a_line_for_each_finding() -> None:
    assert str(DIAGNOSIS).splitlines() == [
        DIAGNOSIS.sentence,
        "",
        "  yaw_rad: before 0.05, after 0.01, floor 0.009 rad, closed 97.6 % (95 %: 90.0 to 99.0)",
        "  where: axis; a law in yaw rate removes 98 % of the excess squared error",
        "  axis.coulomb: M_c = 0.03 ± 0.001 N m",
        "  note: spring is not claimed: runs ask for different amounts of it",
        "  note: one run was fitted",
        "  held out: leave-one-run-out; next experiment: none needed",
    ]
    both = replace(DIAGNOSIS, gaps=DIAGNOSIS.gaps | {"yaw_rad_s": DIAGNOSIS.gaps["yaw_rad"]})
    assert [line[:2] for line in str(both).splitlines()[2:4]] == ["* ", "  "]


@pytest.mark.parametrize(
    ("rig", "effects", "coordinate", "subsystem"),
    [
        (platform(), ("parameter.drive.gain",), "voltage", "drive"),
        (platform(), ("sensor.delay",), "time", "sensor"),
        (wheel(), (), "current", "motor"),
        (wheel(), (), "time", "wheel"),
        (reaction(), (), "wheel_rate", "wheel"),
        (reaction(), (), "yaw_rate", "axis"),
    ],
)
def test_the_subsystem_is_that_of_the_first_effect_or_of_the_coordinate(rig, effects, coordinate, subsystem) -> None:
    where = Where(coordinate, 0.5, None, None, {coordinate: 0.5}, ())
    assert replace(DIAGNOSIS, rig=rig, verdict="unknown", effects=effects, where=where).subsystem == subsystem


def test_names_that_close_a_gap_and_do_not_hold_are_said_to_do_so_with_the_reason() -> None:
    """The gap's line says 98 % closed beside it."""
    spring = {"effects": ("axis.spring",), "refused": {"axis.spring": "runs ask for different amounts of it"}}
    left = Gap(0.05, 0.02, 0.009, 0.98, None, 170.0)
    found = replace(DIAGNOSIS, verdict="unknown", gaps=DIAGNOSIS.gaps | {"yaw_rad": left}, alternatives=(), **spring)
    assert found.sentence.endswith(
        " (axis.spring) would close 98 % of the gap, but this is no claim: runs ask for different amounts of it; 0.02 rad of yaw_rad stay."
    )
    several = replace(found, effects=("axis.coulomb", "axis.spring"))
    assert re.search("this is no claim: [a-z ]*(spring|cable)[a-z ]*: runs ask for different", several.sentence)
    assert "found that holds" not in found.sentence + replace(found, refused={}).sentence


def test_all_of_the_excess_is_100_percent_in_words() -> None:
    found = replace(DIAGNOSIS, verdict="partial", left=Left(0.996, None, ()))
    assert "left: 100 % of the excess squared error" in str(found)
