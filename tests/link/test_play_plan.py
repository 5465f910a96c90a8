"""A plan played on the board, and what is refused before anything is armed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.testbed.campaign import RIG, TRUTH, bench
from firmware.simavr.protocol_simavr import url
from rwjax.link import frames, messages, play_plan, recorder
from rwjax.link.play_experiment import play
from rwjax.link.port import LinkError
from rwjax.link.session import Session
from rwjax.logs.read import read_log
from rwjax.planning.experiment import Experiment
from rwjax.planning.files import Plan, Run, write_plan
from rwjax.rig.read import read_rig
from tests.boards import need_simavr
from tests.command import rwjax
from tests.link.ports import HELLO, SAMPLE, Scripted, resting, stream, wire

ONE = Run("coast", Experiment("coast-down", 2.0, 0.0, 1.0, 3.0), "train", "coasting", (), {"wheel_rad_s": 100.0})
TWO = Run("square", Experiment("square", 1.5, 0.2, 1.0, 2.0), "validate", "a kind of its own", (), {})
PLAN = Plan("testbed", {"voltage_V": 10.0}, (ONE, TWO))


@pytest.mark.slow
def test_every_run_of_a_plan_becomes_a_log_of_its_own(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    need_simavr()
    (tmp_path / "plan").mkdir()
    write_plan(tmp_path / "plan", PLAN)
    port, logs, rig = url(bench(TRUTH)), tmp_path / "logs", read_rig(RIG)
    assert rwjax(monkeypatch, "run-experiment", RIG, port, "--plan", tmp_path / "plan", "-o", logs) == 0
    assert capsys.readouterr().out == f"{logs / 'coast.csv'}\n{logs / 'square.csv'}\n"
    for planned in PLAN.runs:
        log = read_log(logs / f"{planned.name}.csv", rig)
        assert log.validate == (planned.role == "validate") and log.notes["why"] == planned.why
        assert log.notes["experiment"] == planned.experiment.words() and log.notes["run"] == planned.name
        began, volts = int(np.flatnonzero(log.command)[0]), planned.experiment.command()[1][60:-1]
        end = min(began + len(volts), len(log.command))
        assert began in (60, 61) and end - began >= len(volts) - 2  # a pulse is in force from the next tick on
        assert np.abs(log.command[began:end] - volts[: end - began]).max() < 0.03  # rounded to 0.01 V and 127ths
        first = log.outputs["wheel_rad"][:50]
        assert np.ptp(first) == 0.0  # begins at rest, whatever was played before
    assert rwjax(monkeypatch, "run-experiment", RIG, port, "--plan", tmp_path / "plan", "-o", logs) == 2
    assert capsys.readouterr().err.startswith(f"rwjax: {logs / 'coast.csv'}: exists already")


@pytest.mark.parametrize(
    ("planned", "options", "said"),
    [
        (replace(PLAN, rig="other"), (), "PLAN: made for the rig `other`, and this is `testbed`; make a plan for it"),
        (
            replace(PLAN, runs=(ONE, replace(TWO, experiment=Experiment("square", 9.0, 2.0, 1.0, 2.0)))),
            (),
            "PLAN: run `square`: 9 V about 2 V: the pulses reach -10 to 10 V; give less",
        ),
        (
            replace(PLAN, runs=(ONE, replace(TWO, experiment=Experiment("square", 1.0, 0.0, 700.0, 2.0)))),
            (),
            "PLAN: run `square`: a period of 700 s: has to lie between 0.04 and 655 s",
        ),
        (
            replace(
                PLAN, runs=(replace(TWO, reaches={"yaw_rad_s": 1.0}), replace(ONE, reaches={"wheel_rad_s": 250.0}))
            ),
            (),
            "run `coast`: the wheel reaches 250 rad/s, and the board stops at 193.3 rad/s; "
            "make a plan with `rwjax plan --rpm 1846`",
        ),
        (PLAN, ("--run", "squares"), "PLAN: the plan holds no run `squares`; the nearest is `square`"),
        (PLAN, ("--volts", "2"), "--volts: belongs to one experiment; a plan says it for each run"),
        (PLAN, ("--kind", "square"), "give either --kind for one experiment or --plan for the runs of a plan"),
    ],
)
def test_what_cannot_be_played_is_said_before_anything_is_armed(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    planned: Plan,
    options: tuple[str, ...],
    said: str,
) -> None:
    port, folder = Scripted(stream(range(200))), tmp_path / "plan"
    monkeypatch.setattr(recorder, "open_port", lambda _: port)
    monkeypatch.setattr(play_plan, "open_port", lambda _: port)
    folder.mkdir()
    write_plan(folder, planned)
    logs = tmp_path / "logs"
    assert rwjax(monkeypatch, "run-experiment", RIG, "port", "--plan", folder, "-o", logs, *options) == 2
    error = capsys.readouterr().err
    assert error.startswith("rwjax: " + said.replace("PLAN", str(folder))) and error.count("\n") == 1
    assert not logs.exists()
    assert messages.ARM not in [frame.type for frame in frames.Decoder().feed(port.written)]


FORTH = replace(ONE, name="forth", reaches={"yaw_rad": 0.3}, angle_range=(-0.3, 0.02))
AGAIN = replace(FORTH, name="again")
BACK = replace(FORTH, name="back", angle_range=(-0.02, 0.3))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("second", "plays"),
    [
        (AGAIN, False),
        (BACK, True),
        (replace(AGAIN, angle_range=None), False),
    ],
)
def test_a_run_that_would_leave_the_travel_from_where_the_axis_stands_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], second: Run, plays: bool
) -> None:
    need_simavr()
    (tmp_path / "plan").mkdir()
    write_plan(tmp_path / "plan", replace(PLAN, limits={"yaw_rad": 0.31}, runs=(FORTH, second)))
    port, logs = url(bench(TRUTH)), tmp_path / "logs"
    status = rwjax(monkeypatch, "run-experiment", RIG, port, "--plan", tmp_path / "plan", "-o", logs)
    angle = read_log(logs / "forth.csv", read_rig(RIG)).outputs["yaw_rad"]
    assert angle[-1] - angle[0] < -0.01  # so far from where it began
    error = capsys.readouterr().err
    if plays:
        assert status == 0 and (logs / f"{second.name}.csv").exists(), error
    else:
        before, why = error.splitlines()
        assert (
            before
            == "note: the axis has to stand in the middle of its travel of 0.31 rad (17.76°; a linear axis: 0.31 m) either way now"
        )
        assert status == 2 and why.startswith("rwjax: run `again`: the axis stands -0.")
        assert error.endswith("beyond the 0.31 of the plan; bring it back there and go on with --run again\n")
        assert {path.name for path in logs.iterdir()} == {"forth.csv", "forth.raw", "forth.notes"}


def test_what_a_run_needs_from_the_middle_is_its_plans_care() -> None:
    wide = replace(ONE, reaches={"yaw_rad": 0.5})
    play_plan.check_travel(wide, 0.0, 0.4, "")
    with pytest.raises(LinkError, match="the axis stands 0.01 rad from where the plan began, and would go on to 0.51"):
        play_plan.check_travel(wide, 0.01, 0.4, "")


def test_where_travel_is_limited_a_rig_that_does_not_come_to_rest_is_not_driven() -> None:
    said = [wire(SAMPLE._replace(tick=k, count_1=5 * k), k + 1) for k in range(6_100)]
    port = Scripted([*stream(range(1))[:1], *said])
    (task,) = play_plan.tasks_of_plan(replace(PLAN, limits={"yaw_rad": 0.3}, runs=(FORTH,)), read_rig(RIG))
    with pytest.raises(
        LinkError, match="axis still moves after 60 s, and its travel is limited; bring it to the middle"
    ):
        task.ready(Session(port))
    assert messages.ARM not in [frame.type for frame in frames.Decoder().feed(port.written)]


def test_a_run_that_ended_well_is_no_failure_though_the_axis_goes_on_and_the_next_one_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(play_plan, "play", lambda *_: lambda session: None)
    first, second = play_plan.tasks_of_plan(
        replace(PLAN, limits={"yaw_rad": 0.3}, runs=(FORTH, replace(FORTH, name="again"))), read_rig(RIG)
    )
    first.act(
        Session(
            Scripted([wire(HELLO, 0), *(wire(SAMPLE._replace(tick=k, count_1=5 * k), k + 1) for k in range(6_100))])
        )
    )
    with pytest.raises(LinkError, match="run `again`: the axis still moves .* go on with --run again"):
        second.ready(resting(0, 7))


def test_a_board_whose_esc_turns_one_way_refuses_a_plan_that_reverses(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port, folder = Scripted(stream(range(200), HELLO._replace(pulse_min=3000))), tmp_path / "plan"
    monkeypatch.setattr(recorder, "open_port", lambda _: port)
    monkeypatch.setattr(play_plan, "open_port", lambda _: port)
    folder.mkdir()
    write_plan(folder, PLAN)
    assert rwjax(monkeypatch, "run-experiment", RIG, "port", "--plan", folder, "-o", tmp_path / "logs") == 2
    said = "run `square`: 1.5 V about 0.2 V: the pulses reach 0 to 10 V; this ESC turns one way: add an offset"
    assert capsys.readouterr().err == f"rwjax: {said}\n" and not (tmp_path / "logs").exists()


def test_a_leftover_of_any_run_is_met_before_the_first_is_played(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port, logs = Scripted(stream(range(200))), tmp_path / "logs"
    monkeypatch.setattr(recorder, "open_port", lambda _: port)
    monkeypatch.setattr(play_plan, "open_port", lambda _: port)
    (tmp_path / "plan").mkdir()
    write_plan(tmp_path / "plan", PLAN)
    logs.mkdir()
    (logs / "square.raw").write_bytes(b"precious")
    assert rwjax(monkeypatch, "run-experiment", RIG, "port", "--plan", tmp_path / "plan", "-o", logs) == 2
    assert capsys.readouterr().err.startswith(f"rwjax: {logs / 'square.raw'}: exists already")
    assert port.written == b""


def test_of_plan_refuses_what_play_refuses() -> None:
    rig, long = read_rig(RIG), Experiment("square", 1.0, 0.0, 1.0, 4000.0)
    with pytest.raises(LinkError, match="a length of 4000 s"):
        play(long, rig)
    with pytest.raises(LinkError, match="run `coast`: a length of 4000 s"):
        play_plan.tasks_of_plan(replace(PLAN, runs=(replace(ONE, experiment=long),)), rig)
