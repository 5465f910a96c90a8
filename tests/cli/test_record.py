"""`rwjax record`, as a user calls it."""

from pathlib import Path

import pytest

from experiments.testbed.campaign import RIG
from rwjax.cli.record import record
from rwjax.link import recorder
from tests.command import refuses
from tests.command import rwjax as within
from tests.link.ports import Scripted, stream
from tests.link.stubborn import Stubborn


def test_a_recording_without_a_log_is_no_success(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(recorder, "open_port", lambda _: Scripted(stream([*range(5), *range(100, 105)])))
    log = tmp_path / "run.csv"
    assert within(monkeypatch, "record", RIG, "port", "-o", log, "--seconds", 0.1) == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err == (
        "note: 2 stretches of under 10 samples are left out\n"
        f"rwjax: {log}: no log; {tmp_path / 'run.raw'} holds all that came\n"
    )
    assert within(monkeypatch, "decode", RIG, tmp_path / "run.raw") == 2
    assert capsys.readouterr().err.endswith(
        "holds no stretch of samples for a log; 2 stretches of under 10 samples are left out\n"
    )


@pytest.mark.parametrize(
    ("acks_every", "said"),
    [
        (None, "scripted: the board is silent for 1 s; is it on?"),
        (1, "scripted: the board answers and has sent no sample"),
    ],
    ids=("greets", "acknowledges"),
)
def test_a_board_that_only_greets_or_only_acknowledges_is_one_line_and_status_2(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    acks_every: int | None,
    said: str,
) -> None:
    monkeypatch.setattr(recorder, "open_port", lambda _: Stubborn(samples_every=None, acks_every=acks_every))
    assert within(monkeypatch, "record", RIG, "port", "-o", tmp_path / "run.csv", "--seconds", 1) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"rwjax: {said}") and error.count("\n") == 1
    assert error.endswith(f"; {tmp_path / 'run.raw'} holds all that came\n")


class Interrupted(Scripted):
    """Ctrl-C once everything has been read."""

    def read(self, size: int = 1) -> bytes:
        if not self.pieces:
            raise KeyboardInterrupt
        return super().read(size)


def test_ctrl_c_is_the_usual_end_of_a_recording_that_has_begun(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "run.csv"
    for pieces in ([], stream(range(50))):
        monkeypatch.setattr(recorder, "open_port", lambda _, pieces=pieces: Interrupted(pieces))
        if not pieces:
            with pytest.raises(KeyboardInterrupt):
                record(RIG, "port", log)
            assert list(tmp_path.iterdir()) == []
        else:
            record(RIG, "port", log)
            assert capsys.readouterr().out == f"{log}\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ("record", "RIG", "/dev/ttyNOPE", "-o", "OUT.csv"),
            "/dev/ttyNOPE: cannot be opened: No such file or directory",
        ),
        (("record", "RIG", "/dev/ttyNOPE", "-o", "OUT.txt"), "OUT.txt: a log's name ends in .csv"),
        (("record", "RIG", "loop://", "-o", "OUT.csv", "--role", "test"), "--role test: is unknown; it is `train` or"),
        *(
            (
                ("record", "RIG", "loop://", "-o", "OUT.csv", "--seconds", seconds),
                f"--seconds {seconds}: has to be ",
            )
            for seconds in ("1e307", "inf", "nan", "86401", "0.09")
        ),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: tuple[str, ...],
    said: str,
) -> None:
    refuses(monkeypatch, capsys, tmp_path, arguments, said)
