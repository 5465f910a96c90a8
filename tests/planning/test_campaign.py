"""The recommended campaign: within the limits, through all regimes, and one line where that cannot be."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rwjax import InputError, read_log, read_rig
from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import pose
from rwjax.logs.log import Log
from rwjax.planning.campaign import recommend
from rwjax.planning.envelope import LIMITS, Envelope, envelope
from rwjax.planning.files import Plan, write_plan
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Pwm, Rig
from tests.joints import as_platform, joint, servo
from tests.planning.campaign_rigs import RIGS

DEMO = Path(__file__).parents[2] / "data" / "demo" / "rig.toml"


def longer(log: Log) -> Log:
    """The same with nothing until 25 s, when all is at rest: logs of one length are simulated by one program."""
    time = np.arange(2500) * 0.01
    return replace(log, time=time, command=np.pad(log.command, (0, len(time) - len(log.command))))


def played(rig: Rig, within: Envelope, folder: Path) -> dict[str, tuple[Log, dict[str, np.ndarray]]]:
    """What the rig does under the commands that the plan's files hold, by the way of `rwjax predict`."""
    runs, _ = recommend(rig, within)
    write_plan(folder, Plan(rig.name, within.known, runs))
    logs = [longer(read_log(folder / f"{run.name}.csv", rig, outputs_required=False)) for run in runs]
    structure = structure_of(rig)
    found = predict_logs(pose(structure, logs, {}), theta_of(rig, structure), with_floor=False)
    return {run.name: (log, p.outputs) for run, log, p in zip(runs, logs, found, strict=True)}


@pytest.mark.parametrize(
    "kind", [kind if kind == "wheel" else pytest.param(kind, marks=pytest.mark.slow) for kind in RIGS]
)
@given(data=st.data())
@settings(max_examples=2, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
def test_a_plan_uses_a_rig_and_stays_within_its_limits(kind: str, data: st.DataObject, tmp_path: Path) -> None:
    factor = st.floats(0.4, 2.5)
    rig = RIGS[kind].with_values({name: v * data.draw(factor, name) for name, v in RIGS[kind].numbers.items()})
    usual = {"current_A": 4.0, "wheel_rad_s": 200.0, "yaw_rad_s": 3.0, "yaw_rad": 20.0}
    most = {name: v * data.draw(factor, name) for name, v in usual.items() if kind in LIMITS[name].kinds}
    within = envelope(rig, 10.0 * data.draw(factor, "volts"), most)
    used = dict.fromkeys(within.known, 0.0)
    for log, outputs in played(rig, within, tmp_path).values():
        peaks = {"voltage_V": log.command, **{name: outputs[name] for name in most}}
        for name, values in peaks.items():
            used[name] = max(used[name], float(np.max(np.abs(values))) / within.known[name])
    assert max(used.values()) <= 1.0 + 1e-9, used
    assert max(used.values()) > 0.7, used  # something binds


@pytest.mark.parametrize("kind", ["platform", pytest.param("reaction", marks=pytest.mark.slow)])
def test_every_regime_is_visited(kind: str, tmp_path: Path) -> None:
    rig = RIGS[kind]
    runs = played(rig, envelope(rig, 6.0, {"yaw_rad_s": 2.0}), tmp_path)
    top = max(np.abs(outputs["yaw_rad_s"]).max() for _, outputs in runs.values())
    for name, (log, outputs) in runs.items():
        w, on = outputs["yaw_rad_s"], log.command != 0.0
        slides, forward, backward = w != 0.0, w > 0.02 * top, w < -0.02 * top
        broke = np.flatnonzero(~slides[:-1] & slides[1:])
        if name.startswith(("triangle", "staircase", "multisine", "square")):
            assert len(broke) >= 1 and forward.any() and backward.any(), name  # breaks away, reverses
        if name == "staircase_small":  # sticks under a command, and leaves that both ways
            stuck = np.mean(~slides[on])
            assert 0.1 < stuck < 0.97, stuck
            after = [np.sign(w[k + 1]) for k in broke if on[k]]
            assert {-1.0, 1.0} <= {*after}
        if name.startswith("coast"):
            coasting = ~on & slides
            assert coasting.sum() * 0.01 > 0.2 and w[-1] == 0.0, name  # until standstill
    assert np.abs(runs["coast_fast"][1]["yaw_rad_s"]).max() > 0.5 * top
    assert np.sign(runs["coast_fast"][1]["yaw_rad"][-1]) == -np.sign(runs["coast_fast_back"][1]["yaw_rad"][-1])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("neutral", "per_us", "directions", "volts"),
    [
        (1500.0, 0.02, (1.0, -1.0), 10.0),
        (1000.0, 0.01, (1.0,), 10.0),
        (1000.0, -0.01, (-1.0,), 10.0),
        (1060.0, 0.01, (1.0,), 9.4),  # 60 us below it are no way to turn
        (1200.0, 0.02, (1.0, -1.0), 4.0),  # 200 us below it
    ],
)
def test_the_neutral_pulse_says_which_ways_an_esc_turns(
    neutral: float, per_us: float, directions: tuple[float, ...], volts: float
) -> None:
    rig = replace(RIGS["reaction"], pwm=Pwm(neutral, per_us))
    within = envelope(rig, most={"wheel_rad_s": 200.0})
    assert within.directions == directions and within.volts == pytest.approx(volts)
    runs, remarks = recommend(rig, within)
    for run in runs:
        pulses = neutral + run.experiment.command()[1] / per_us
        assert pulses.min() >= 1000.0 - 1e-9 and pulses.max() <= 2000.0 + 1e-9, run.name
    assert any("the ESC turns one way" in remark for remark in remarks) == (len(directions) == 1)
    assert len(runs) >= 2


@pytest.mark.slow
def test_a_neutral_pulse_off_the_middle_is_said_where_it_is_what_limits_the_runs() -> None:
    rig = replace(RIGS["reaction"], pwm=Pwm(1700.0, 0.02))
    said = "`neutral_us` is 1700, off the middle of the pulses: the runs keep to the 6 V that they reach both ways"
    for volts, limits in ((None, True), (4.0, False)):
        runs, remarks = recommend(rig, envelope(rig, volts, {"wheel_rad_s": 200.0}))
        assert (said in remarks) == limits
        assert max(run.experiment.most_volts for run in runs) <= (volts or 6.0)


@pytest.mark.parametrize("travel", [{}, pytest.param({"yaw_rad": 0.5}, marks=pytest.mark.slow)])
def test_a_run_that_came_out_as_another_one_is_left_out_and_said(travel: dict[str, float]) -> None:
    rig = read_rig(DEMO.parents[1] / "thesis" / "yaw.toml")
    runs, remarks = recommend(rig, envelope(rig, 12.0, {"wheel_rad_s": 314.0, **travel}))
    names = [run.name for run in runs]
    assert "coast_fast" in names and "coast_slow" not in names
    assert any("would repeat another one" in one and "coast_slow (as coast_fast)" in one for one in remarks)
    assert sum("coast_slow" in one for one in remarks) == 1  # it does move the rig
    once = [run.experiment for run in runs if not run.name.startswith("multisine_")]
    assert len({*once}) == len(once)


def test_limits_that_are_missing_or_too_tight_are_one_line() -> None:
    demo = read_rig(DEMO)
    with pytest.raises(
        InputError, match="nothing says how many volts the drive gives; add --volts, such as --volts 12"
    ):
        envelope(demo)
    with pytest.raises(InputError, match="--rpm: a `platform` rig has no rate of the wheel; leave the option out"):
        envelope(demo, 10.0, {"wheel_rad_s": 100.0})
    with pytest.raises(InputError, match=r"within these limits \(0.1 V\) no run moves the simulated rig; raise"):
        recommend(RIGS["platform"], envelope(RIGS["platform"], 0.1))
    said = r"\(12 V, rate of the axis 3 rad/s, travel of the axis 0.01 rad\) no run moves the simulated rig, or lets it come to rest"
    with pytest.raises(InputError, match=said):
        recommend(demo, envelope(demo, 12.0, {"yaw_rad": 0.01, "yaw_rad_s": 3.0}))


@pytest.mark.parametrize(("volts", "most"), [(None, 12.0), (5.0, 5.0)])
def test_how_a_drive_that_takes_a_duty_plays_volts_is_said(volts: float | None, most: float) -> None:
    rig = replace(RIGS["wheel"], numbers=RIGS["wheel"].numbers | {"drive.supply": 12.0})
    runs, remarks = recommend(rig, envelope(rig, volts))
    assert max(abs(run.experiment.amplitude) for run in runs) <= most
    said = f"the commands are volts, up to {most:g} V: a drive that takes a duty gets `voltage_V` / 12 (`drive.supply`)"
    assert said in remarks


@pytest.mark.slow
def test_a_servo_is_planned_by_goals_and_let_go() -> None:
    rig = servo(joint(axis__friction__coulomb=0.05, axis__gravity__torque=0.3), kp=15.0, period=0.01)
    runs, _ = recommend(rig, envelope(rig, most={"yaw_rad_s": 2.0}, goal=1.0))
    assert any("drive.goal_delay" in run.tells_apart for run in runs)
    assert {run.experiment.input for run in runs} == {"goal_rad"} and any(run.experiment.switches for run in runs)
    assert max(run.experiment.most_volts for run in runs) <= 1.0
    assert 1.0 < max(run.reaches["yaw_rad_s"] for run in runs) <= 2.0
    still = servo(as_platform(rig), kp=15.0, period=0.01)
    runs, _ = recommend(still, envelope(still, goal=1.0))
    assert runs and not any(run.experiment.kind == "coast-down" for run in runs)  # it has no torque that could be off
