"""Runs one after the other keep to the travel together."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import InputError
from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import pose
from rwjax.planning.amplitude import SizedDesign
from rwjax.planning.campaign import recommend
from rwjax.planning.designs import DESIGNS, LONGEST_S
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
    found = play_runs(rig, within, sized)
    assert [len(found[name]) for name in ("multisine", "square")] == [3, 1]
    one = found["multisine"][0]
    assert found["multisine"] == [one] * 3 and one.angle_range is None
    moved = peaks(simulated_motion(rig, [one.experiment], LONGEST_S))
    assert one.reaches == pytest.approx({name: float(value[0]) for name, value in moved.items()})
    assert play_runs(rig, within, {}) == {}
