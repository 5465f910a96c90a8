"""Runs one after the other keep to the travel together."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import InputError
from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import pose
from rwjax.planning.amplitude import SizedDesign
from rwjax.planning.campaign import recommend
from rwjax.planning.designs import DESIGNS, LONGEST_S, Design
from rwjax.planning.envelope import Envelope, envelope
from rwjax.planning.files import Run
from rwjax.planning.motion import peaks, simulated_motion
from rwjax.planning.sequence import play_runs
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig
from tests.planning.campaign_rigs import SLIDE
from tests.systems import platform, record


def in_a_row(rig: Rig, runs: tuple[Run, ...], wait: float) -> np.ndarray:
    """The axis's angle when all runs are played one after the other with `wait` seconds in between, as one log."""
    commands = [np.append(run.experiment.command()[1], np.zeros(round(100 * wait))) for run in runs]
    volts = np.concatenate(commands)
    structure = structure_of(rig)
    problem = pose(structure, [record(0.01 * np.arange(len(volts)), volts, {})], {})
    (found,) = predict_logs(problem, theta_of(rig, structure), with_floor=False)
    return found.outputs["yaw_rad"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rig", "travel"),
    [
        (SLIDE, 0.2),
        (platform("viscous = 0.02\ncoulomb = 0.05"), 5.0),
        (platform("viscous = 0.005"), 0.7),  # coasts for minutes: 20 s to lose two thirds of its rate
        (replace(platform(), effects={"axis.end_stop": {"low": -1.0, "high": 1.2, "k": 40.0, "d": 0.1}}), 3.0),
    ],
)
def test_all_runs_together_keep_to_the_travel(rig: Rig, travel: float) -> None:
    within = envelope(rig, 10.0, {"yaw_rad": travel})
    runs, _ = recommend(rig, within)
    assert len(runs) > 8 and {run.role for run in runs} == {"train", "validate"}
    angle = in_a_row(rig, runs, 200.0)
    assert 0.6 * within.limits["yaw_rad"] < np.abs(angle).max() <= within.limits["yaw_rad"]
    begin = 0.0
    for run in runs:  # what the plan says of each
        n = len(run.experiment.command()[1]) + 20_000
        part, angle = angle[:n], angle[n:]
        assert run.angle_range
        assert (
            run.angle_range[0] - 0.02 * travel < part.min() - begin
            and part.max() - begin < run.angle_range[1] + 0.02 * travel
        )
        begin = part[-1]
    assert [run.experiment for run in runs[:3]] == 3 * [runs[0].experiment]  # repeats stay repeats
    ways = {run.name: np.sign(run.experiment.amplitude) for run in runs}
    if "coast_fast" in ways:
        assert ways["coast_fast"] == -ways["coast_fast_back"]


@pytest.mark.slow
def test_where_the_rig_does_not_come_to_rest_no_travel_can_be_kept() -> None:
    rig = platform("viscous = 1e-6")
    with pytest.raises(InputError, match="no run moves the simulated rig, or lets it come to rest within 60 s"):
        recommend(rig, envelope(rig, 10.0, {"yaw_rad": 0.7}))
    assert recommend(rig, envelope(rig, 10.0, {"yaw_rad_s": 3.0}))[0]  # without a limit to it, it may coast


def test_alone_every_run_begins_at_angle_0_and_repeats_as_it_is() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05")
    within = Envelope(2.0, {"yaw_rad": np.inf, "yaw_rad_s": 40.0})
    sized = {name: SizedDesign(DESIGNS[name], 1.0, 1.0) for name in ("multisine", "square")}
    found = play_runs(rig, within, sized).runs
    assert [len(found[name]) for name in ("multisine", "square")] == [3, 1]
    one = found["multisine"][0]
    assert found["multisine"] == [one] * 3 and one.angle_range is None
    moved = peaks(simulated_motion(rig, [one.experiment], LONGEST_S))
    assert one.reaches == pytest.approx({name: float(value[0]) for name, value in moved.items()})
    assert play_runs(rig, within, {}) == ({}, {})


def coast(volts: float, offset: float = 0.0, length: float = 12.0) -> SizedDesign:
    return SizedDesign(Design("coast-down", 1.0, 4.0, length, "", offset=offset), volts, 1.0)


def test_a_run_is_another_one_by_its_sign_its_size_its_offset_or_its_shape() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05")
    within = Envelope(2.0, {"yaw_rad": np.inf, "yaw_rad_s": 40.0})
    back = SizedDesign(replace(coast(1.0).design, direction=-1.0), 1.0, 1.0)
    sized = {"one": coast(1.0), "back": back, "less": coast(0.8), "long": coast(1.0, length=13.0)}
    sized |= {"up": coast(1.0, 0.1), "down": coast(1.0, -0.1), "higher": coast(1.0, 0.2)}
    assert list(play_runs(rig, within, sized).runs) == list(sized)
    again = {"near": coast(0.92), "back_near": back._replace(amplitude=1.05), "up_near": coast(1.0, 0.105)}
    found = play_runs(rig, within, sized | again)
    assert list(found.runs) == list(sized) and found.twins == {"near": "one", "back_near": "back", "up_near": "up"}


def test_a_run_that_is_left_out_names_one_that_is_played() -> None:
    """Each is alike the one before; the third is no more alike the first."""
    rig = platform("viscous = 0.02\ncoulomb = 0.05")
    within = Envelope(2.0, {"yaw_rad": np.inf, "yaw_rad_s": 40.0})
    found = play_runs(rig, within, {"a": coast(1.0), "b": coast(0.93), "c": coast(0.86), "d": coast(0.8)})
    assert list(found.runs) == ["a", "c"] and found.twins == {"b": "a", "d": "c"}


def test_within_a_travel_a_run_that_is_left_out_moves_nothing() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05")
    within = envelope(rig, 10.0, {"yaw_rad": 5.0})
    ways = {"forth": coast(0.3), "home": coast(0.3)}  # the second is turned round, as it ends nearer the middle
    rest = {"square": SizedDesign(DESIGNS["square"], 0.6, 0.4)}
    once, twice = (play_runs(rig, within, sized) for sized in (ways | rest, ways | {"again": coast(0.3)} | rest))
    assert list(once.runs) == ["forth", "home", "square"] and once.twins == {}
    assert twice.runs == once.runs and twice.twins["again"] in ways


def test_a_run_back_that_is_played_first_keeps_its_name() -> None:
    """The axis has gone forward before, so that there is more room the other way."""
    rig = platform("viscous = 0.02\ncoulomb = 0.05")
    back = SizedDesign(replace(coast(0.3).design, direction=-1.0), 0.3, 1.0)
    sized = {"before": coast(0.27), "fast": coast(0.3), "fast_back": back}
    played = play_runs(rig, envelope(rig, 10.0, {"yaw_rad": 2.0}), sized).runs
    assert [*played] == ["before", "fast_back", "fast"]
    assert [np.sign(run.experiment.amplitude) for (run,) in played.values()] == [1.0, -1.0, 1.0]


def test_a_run_whose_own_direction_is_back_keeps_its_name() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05")
    first = SizedDesign(replace(coast(0.3).design, direction=-1.0), 0.3, 1.0)
    played = play_runs(rig, envelope(rig, 10.0, {"yaw_rad": 5.0}), {"fast": first, "fast_back": coast(0.3)}).runs
    assert {name: np.sign(run.experiment.amplitude) for name, (run,) in played.items()} == {
        "fast": -1.0,
        "fast_back": 1.0,
    }


def test_within_a_travel_a_run_and_its_way_back_are_left_out_together() -> None:
    rig = platform("viscous = 0.02\ncoulomb = 0.05")
    back = SizedDesign(replace(coast(0.3).design, direction=-1.0), 0.3, 1.0)
    sized = {"fast": coast(0.3), "fast_back": back, "slow": coast(0.29), "slow_back": back._replace(amplitude=0.29)}
    found = play_runs(rig, envelope(rig, 10.0, {"yaw_rad": 5.0}), sized)
    assert list(found.runs) == ["fast", "fast_back"] and {*found.twins} == {"slow", "slow_back"}
    assert {*found.twins.values()} == {*found.runs}
