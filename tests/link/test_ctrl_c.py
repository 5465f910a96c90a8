"""Ctrl-C during a recording: the board is disarmed, and there is a whole log or nothing."""

import os
import signal
from pathlib import Path

import pytest

from experiments.testbed.campaign import RIG
from rwjax.link import ctrl_c, messages, recorder
from rwjax.link.play_experiment import play
from rwjax.link.recorder import listen, record
from rwjax.link.session import Session
from rwjax.link.stream_to_logs import write_logs
from rwjax.logs.read import read_log
from rwjax.planning.experiment import Experiment
from rwjax.rig.model import Rig
from rwjax.rig.read import read_rig
from tests.link.ports import Scripted, stream
from tests.link.stubborn import Stubborn

SQUARE = Experiment("square", 2.0, 0.0, 1.0, 2.0)


@pytest.fixture
def pressed_twice(scripted, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """A recording in which Ctrl-C comes twice while the log is written, the second time after a wait."""

    def recorded(patience_s: float) -> recorder.Recorded:
        def written(raw: Path, rig: Rig, output: Path) -> tuple[list[Path], list[str]]:
            signal.raise_signal(signal.SIGINT)
            signal.raise_signal(signal.SIGINT)
            return write_logs(raw, rig, output)

        monkeypatch.setattr(ctrl_c, "PATIENCE_S", patience_s)
        monkeypatch.setattr(recorder, "write_logs", written)
        scripted(Scripted(stream(range(99))))
        return record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(0.5))

    return recorded


@pytest.mark.usefixtures("hears_ctrl_c")
def test_ctrl_c_while_the_log_is_written_costs_nothing_and_ends_a_plan(pressed_twice, tmp_path: Path) -> None:
    done = pressed_twice(patience_s=ctrl_c.PATIENCE_S)
    assert isinstance(done.failure, KeyboardInterrupt) and done.logs == [tmp_path / "run.csv"]
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)  # heard again


@pytest.mark.usefixtures("hears_ctrl_c")
@pytest.mark.parametrize("handled", [True, False])
def test_sigterm_is_noted_where_the_program_handles_it(handled: bool) -> None:
    came: list[int] = []
    before = signal.signal(signal.SIGTERM, (lambda number, frame: came.append(number)) if handled else signal.SIG_IGN)
    try:
        with ctrl_c.CtrlC() as noted:
            signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert (noted.pressed, came) == ((True, [signal.SIGTERM]) if handled else (False, []))
    assert noted.number == (signal.SIGTERM if handled else signal.SIGINT)


@pytest.mark.usefixtures("hears_ctrl_c")
@pytest.mark.parametrize("late", [True, False])
def test_a_program_with_its_own_handler_hears_of_it_after_the_recording(
    scripted, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, late: bool
) -> None:
    came: list[tuple[int, bool]] = []
    output = tmp_path / "run.csv"

    def terminated(*given: object) -> None:
        signal.raise_signal(signal.SIGTERM)

    def written(*given) -> tuple[list[Path], list[str]]:
        terminated()
        return write_logs(*given)

    def waited(session: Session) -> dict[str, str]:
        session.samples()
        return {}

    monkeypatch.setattr(recorder, "write_logs", written if late else write_logs)
    monkeypatch.setattr(recorder, "check_board", recorder.check_board if late else terminated)
    scripted(Scripted(stream(range(99))))
    before = signal.signal(signal.SIGTERM, lambda number, frame: came.append((number, output.exists())))
    try:
        if late:
            assert record("port", read_rig(RIG), output, {}, listen(0.5)).logs == [output]
        else:
            with pytest.raises(KeyboardInterrupt):
                record("port", read_rig(RIG), output, {}, listen(0.5), ready=waited)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert came == [(signal.SIGTERM, late)]


@pytest.mark.usefixtures("hears_ctrl_c")
def test_a_later_ctrl_c_leaves_a_disk_that_takes_nothing(pressed_twice, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        pressed_twice(patience_s=0.0)
    assert {path.name for path in tmp_path.iterdir()} == {"run.raw", "run.notes"}
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)  # heard again


@pytest.mark.usefixtures("hears_ctrl_c")
def test_a_handler_that_python_did_not_set_becomes_the_systems(
    scripted, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Of such a handler Python says None."""
    given: list[object] = []

    def foreign(number: int, handler: object) -> None:
        given.append(handler)

    monkeypatch.setattr(signal, "signal", foreign)
    scripted(Scripted(stream(range(99))))
    record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(0.5))
    assert given[1:] == [signal.SIG_DFL]


@pytest.mark.usefixtures("hears_ctrl_c")
@pytest.mark.parametrize("step", ("read", "write", "flush", "close"))
@pytest.mark.parametrize("when", (0.05, 1.5, 3.0))
def test_ctrl_c_at_any_step_leaves_the_board_disarmed_and_a_log_or_nothing(
    scripted, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, step: str, when: float
) -> None:
    """It comes at the end of the step, where an exception would lose what the step has returned."""
    port = scripted(Stubborn("end"))
    real = getattr(port, step)

    def interrupted(*given: object) -> object:
        got = real(*given)
        if port.now >= when or step in ("flush", "close"):
            signal.raise_signal(signal.SIGINT)
        return got

    monkeypatch.setattr(port, step, interrupted)
    try:
        done = record("port", read_rig(RIG), tmp_path / "run.csv", {}, play(SQUARE, read_rig(RIG)))
    except KeyboardInterrupt:
        assert step == "close" or not list(tmp_path.iterdir())
        done = None
    assert port.heard[-1][1] == messages.DISARM and port.state == messages.DISARMED
    if done and port.tick > 20:
        assert len(read_log(done.logs[0], read_rig(RIG)).time) > 0


@pytest.mark.usefixtures("hears_ctrl_c")
def test_ctrl_c_as_the_files_are_begun_leaves_none(scripted, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    real = os.open

    def interrupted(path: Path, *given: int) -> int:
        opened = real(path, *given)
        if str(path).endswith(".raw"):
            signal.raise_signal(signal.SIGINT)
        return opened

    monkeypatch.setattr(recorder.os, "open", interrupted)
    scripted(Stubborn())
    with pytest.raises(KeyboardInterrupt):
        record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(1.0))
    assert list(tmp_path.iterdir()) == []
