"""All tools that a rig may be written for, and how large what they leave out is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax import InputError, parse_rig, simulate
from rwjax.cli.export import Target
from rwjax.export.targets import TARGETS, export, moved_by, with_logged_supply
from tests.joints import joint, logged, servo
from tests.systems import platform, record


def test_the_logs_tell_the_supply_that_a_file_lacks_where_the_tool_needs_it() -> None:
    t = 0.01 * np.arange(200)
    rig, volts = servo(joint(), "duty"), np.where(t < 1.0, 12.0, 11.0)
    log = logged(rig, t, goal_rad=np.sin(t), supply_V=volts)
    for to in ("mjcf", "c"):
        known, said = with_logged_supply(rig, to, [replace(log, supply=None), log])
        assert known.numbers["drive.supply"] == pytest.approx(11.5) and "11.5 V is taken for it, the mean" in said
        assert export(known, to).text
    for other, to, logs in (
        (rig, "json", [log]),
        (rig, "mjcf", []),
        (servo(joint(drive__supply=10.0), "duty"), "c", [log]),
        (servo(joint()), "mjcf", [log]),
    ):
        assert with_logged_supply(other, to, logs) == (other, "")
    with pytest.raises(InputError, match=r"write \[drive\] supply = 12 \(volts\), or give logs that hold `supply_V`"):
        export(rig, "mjcf")


@pytest.mark.parametrize("to", TARGETS)
def test_every_tool_says_of_the_same_rig_what_it_leaves_out(to: str) -> None:
    effects = {"axis.coulomb": {"M_c": 0.03}, "drive.delay": {"tau": 0.02}}
    found = export(replace(platform("viscous = 0.02"), name="yaw", effects=effects), to)
    assert "yaw" in found.text
    assert {*found.left_out} == ({"drive.delay"} if to in ("c", "python-control") else set())
    assert (found.held is not None) == (to == "mjcf")


def test_the_command_line_names_every_tool() -> None:
    assert [target.value for target in Target] == [*TARGETS]


@pytest.mark.parametrize("to", [to for to in TARGETS if to != "json"])
def test_an_answer_goes_into_json_alone(to: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="into JSON alone"):
        export(platform("viscous = 0.02"), to, tmp_path / "answer.json")


def test_what_an_effect_moves_is_the_difference_of_free_runs() -> None:
    rig = replace(platform("viscous = 0.02"), effects={"drive.asymmetric_gain": {"a": 0.1}})
    t = 0.01 * np.arange(300)
    u = np.where(t >= 0.6, 1.0, 0.0)
    log = record(t, u, {"yaw_rad": np.asarray(simulate(rig, t, u)["yaw_rad"])})
    late = np.maximum(t - 0.6, 0.0)
    tenth = 0.1 * 0.4 / 0.02 * (late - 5.0 * (1.0 - np.exp(-late / 5.0)))  # of I w' + b w = k V from rest
    moved = moved_by(rig, replace(rig, effects={}), [log])
    assert moved == {"yaw_rad": pytest.approx(np.sqrt(np.mean(tenth**2)), rel=1e-3)}


def test_a_load_without_an_angle_hangs_down() -> None:
    rig = parse_rig('kind = "joint"\n[axis]\ninertia = 0.1\n[axis.gravity]\ntorque = 0.3\n')
    assert 'pos="0 0 -' in export(rig, "mjcf").text and "friction_torque" in export(rig, "c").text


def test_a_tool_that_is_none_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(InputError, match="^export: `to` is a `list`; it has to be a text$"):
        export(platform(), ["json"])  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="^to `urdf`: is no tool; it has to be one of mjcf, c, python-control, json$"):
        export(platform(), "urdf")
