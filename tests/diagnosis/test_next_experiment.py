"""The next experiment: what is proposed can be played, stays where the logs have been, and tells the rivals apart."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rwjax import parse_rig, read_log
from rwjax.diagnosis.next_experiment import Rival, propose
from rwjax.diagnosis.settings import NextExperimentSettings
from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import pose
from rwjax.logs.driven import driven
from rwjax.planning.amplitude import COASTING
from rwjax.planning.files import read_plan, write_plan
from rwjax.plant.from_rig import structure_of, theta_of
from tests.systems import platform, record

SETTINGS = NextExperimentSettings()
TIME = np.arange(1201) * 0.01
COMMAND = np.where(TIME > 0.6, 0.9 * np.sign(np.sin(1.7 * TIME)), 0.0)
LOG = record(TIME, COMMAND)
RIG = platform("viscous = 0.02")


STRUCTURE = structure_of(RIG).with_effects("axis.coulomb", "drive.deadzone")


def rival(effect: str, number: str, value: float) -> Rival:
    """The rig with an effect, on a square wave under which dry friction and a dead zone do nearly the same."""
    theta = theta_of(RIG, STRUCTURE)
    theta[STRUCTURE.names.index(f"{effect}.{number}")] = value
    return Rival((effect,), pose(STRUCTURE, [LOG], {"yaw_rad": 2e-3}), theta)


TWO = rival("axis.coulomb", "M_c", 0.04), rival("drive.deadzone", "u_0", 0.1)


@pytest.mark.slow
def test_the_proposed_run_separates_its_rivals(tmp_path: Path) -> None:
    left = {"yaw_rad": 0.02}
    sentence, plan = propose("a rig", TWO, [0], left, SETTINGS)
    assert plan is not None
    (planned,) = read_plan(write_plan(tmp_path, plan)).runs
    assert planned.experiment == plan.runs[0].experiment and planned.tells_apart == ("axis.coulomb", "drive.deadzone")
    log = read_log(tmp_path / f"{planned.name}.csv", RIG, outputs_required=False)
    y = []
    for each in TWO:  # another way to the same motion: from the file, by `rwjax predict`
        y.append(predict_logs(pose(each.problem.structure, [log], {}), each.theta, with_floor=False)[0].outputs)
    apart = np.sqrt(np.mean((y[0]["yaw_rad"] - y[1]["yaw_rad"]) ** 2)) / left["yaw_rad"]
    said = re.search(r"axis.coulomb and drive.deadzone differ by ([\d.]+) times the error that is left", sentence)
    assert said and apart > 1.0 and apart == pytest.approx(float(said[1]), rel=0.02, abs=0.06)
    assert (
        np.abs(log.command).max() <= 0.9
        and np.abs(y[0]["yaw_rad_s"]).max() <= SETTINGS.beyond * plan.limits["yaw_rad_s"]
    )


def test_where_no_run_separates_them_that_is_said() -> None:
    sentence, plan = propose("a rig", TWO, [0], {"yaw_rad": 1e3}, SETTINGS)
    assert plan is None and sentence.startswith(
        "no command within 0.9 V, hardly further than these logs have gone, separates"
    )


def test_a_command_without_a_unit_is_a_share_of_full_scale() -> None:
    rig = parse_rig(
        'kind = "joint"\n[motor]\ntorque_constant = 0.4\nresistance = 1.0\n[drive]\nsupply = 12.0\n[axis]\ninertia = 0.1\n'
    )
    rig, (log,) = driven(rig, [replace(LOG, input="duty")])
    structure = structure_of(rig).with_effects("axis.coulomb", "drive.deadzone")
    problem = pose(structure, [log], {"yaw_rad": 2e-3})
    two = [Rival((name,), problem, theta_of(rig, structure)) for name in ("axis.coulomb", "drive.deadzone")]
    sentence, plan = propose("a rig", two, [0], {"yaw_rad": 1e3}, SETTINGS)
    assert plan is None and sentence.startswith("no command within 0.9 of full scale, hardly further than these logs")


@pytest.mark.slow
def test_where_the_travel_is_limited_the_way_until_the_rig_rests_counts() -> None:
    """An axis that one rival lets coast for minutes goes on into what no log has shown."""
    rig = platform("viscous = 0.0004")  # slows down within 250 s
    structure = structure_of(rig).with_effects("axis.end_stop", "axis.coulomb", "drive.deadzone")
    time = np.arange(2001) * 0.01
    log = record(time, 0.9 * ((time > 0.6) & (time < 2.6)) - 0.9 * ((time > 2.6) & (time < 4.6)))
    two = []
    for effect, number, value in (("axis.coulomb", "M_c", 3e-3), ("drive.deadzone", "u_0", 1e-6)):
        theta = theta_of(rig, structure)
        theta[structure.names.index(f"{effect}.{number}")] = value
        two.append(Rival((effect,), pose(structure, [log], {"yaw_rad": 2e-3}), theta))
    _, plan = propose("a rig", two, [0], {"yaw_rad": 0.02}, SETTINGS)
    assert plan is not None
    (run,) = plan.runs
    _, volts = run.experiment.command()
    many = np.concatenate([volts, np.zeros(20_000)])
    long = record(np.arange(len(many)) * 0.01, many)
    most = plan.limits["yaw_rad"]
    for each in two:
        y = predict_logs(pose(each.problem.structure, [long], {"yaw_rad": 2e-3}), each.theta, with_floor=False)[
            0
        ].outputs["yaw_rad"]
        later = y[len(volts) + 6000 :]  # than the minute for which a board waits
        assert np.abs(y - y[0]).max() <= SETTINGS.beyond * most and np.abs(later - later[0]).max() <= COASTING * most


@pytest.mark.slow
def test_where_nothing_limits_the_travel_a_rig_without_friction_may_coast() -> None:
    rig = platform("viscous = 0.0")
    structure = structure_of(rig).with_effects("drive.deadzone", "drive.lag")
    log = record(TIME, np.where(TIME > 0.6, 0.9, 0.0) * (TIME < 4.0))  # it coasts on, as every such log does
    two = []
    for effect, number, value in (("drive.deadzone", "u_0", 0.1), ("drive.lag", "T", 0.2)):
        theta = theta_of(rig, structure)
        theta[structure.names.index(f"{effect}.{number}")] = value
        two.append(Rival((effect,), pose(structure, [log], {"yaw_rad": 2e-3}), theta))
    sentence, plan = propose("a rig", two, [0], {"yaw_rad": 0.02}, SETTINGS)
    assert plan is not None and "differ by" in sentence


@pytest.mark.slow
def test_where_every_command_goes_too_far_nothing_is_said_to_be_the_same() -> None:
    rig = platform("viscous = 0.002")
    structure = structure_of(rig).with_effects("axis.end_stop", "axis.bias_torque", "drive.bias")
    time = np.arange(501) * 0.01
    log = record(time, np.where(time > 0.6, 0.3 * np.sign(np.sin(2.0 * np.pi * time)), 0.0))
    two = []
    for effect, number, value in (("axis.bias_torque", "T", 0.01), ("drive.bias", "u_b", 0.03)):
        theta = theta_of(rig, structure)
        theta[structure.names.index(f"{effect}.{number}")] = value  # it never rests
        two.append(Rival((effect,), pose(structure, [log], {"yaw_rad": 2e-3}), theta))
    sentence, plan = propose("a rig", two, [0], {"yaw_rad": 0.02}, SETTINGS)
    assert plan is None
    assert sentence == (
        "none found that separates axis.bias_torque and drive.bias: every command would take the rig further than these logs "
        "have gone, or not let it come to rest within 60 s"
    )
