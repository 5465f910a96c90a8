"""The commands: what they write, and one line for what they cannot do."""

import builtins
import os
import subprocess
import sys
from pathlib import Path

import pytest

from experiments.testbed.campaign import RIG, TRUTH, bench
from firmware.simavr.avr import Avr, build
from firmware.simavr.bench import Bench
from firmware.simavr.protocol_simavr import url
from firmware.simavr.spin import Spin, constant, still
from rwjax.cli import link as cli
from rwjax.link import recorder, rest
from tests.boards import need_simavr
from tests.command import rwjax
from tests.link.ports import Scripted, stream

BARE = RIG.parents[1] / "demo" / "rig.toml"  # says nothing about pulses


def test_an_experiment_is_played_recorded_and_fitted(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    need_simavr()
    port, log = url(bench(TRUTH)), tmp_path / "square.csv"
    asked = ("--kind", "square", "--volts", 2.5, "--period", 2, "--seconds", 4, "--role", "train")
    assert rwjax(monkeypatch, "run-experiment", RIG, port, "-o", log, *asked) == 0
    assert capsys.readouterr().out == f"{log}\n"
    assert "# experiment: square, 2.5 V about 0 V, period 2 s, 4 s" in log.read_text()
    assert rwjax(monkeypatch, "predict", RIG, log, "-o", tmp_path / "p.csv") == 0  # other commands take it
    assert rwjax(monkeypatch, "record", RIG, port, "-o", tmp_path / "rest.csv", "--seconds", 0.5) == 0
    assert len((tmp_path / "rest.csv").read_text().splitlines()) > 50
    assert rwjax(monkeypatch, "run-experiment", RIG, port, "-o", log, *asked) == 2
    assert capsys.readouterr().err.startswith(f"rwjax: {log}: exists already; a recording never replaces another")


def test_an_experiment_that_begins_while_the_rig_moves_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    need_simavr()
    monkeypatch.setattr(rest, "LONGEST_WAIT", 300)
    port, log = url(Bench(Avr(build()), Spin(still, constant(900.0)))), tmp_path / "run.csv"
    assert rwjax(monkeypatch, "run-experiment", RIG, port, "-o", log, "--kind", "square", "--seconds", 1) == 0
    said = capsys.readouterr()
    assert said.out == f"{log}\n" and said.err == "note: the rig still moved after a wait of 60 s\n"
    assert "# start: the rig still moved after a wait of 60 s\n" in log.read_text()


def test_a_raw_stream_becomes_a_log(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    raw = tmp_path / "cut.raw"
    raw.write_bytes(b"".join(stream([*range(40), *range(44, 90)]))[:-9])
    assert rwjax(monkeypatch, "decode", RIG, raw) == 0
    said = capsys.readouterr()
    assert said.out == f"{tmp_path / 'cut.csv'}\n" and said.err == "note: cut.csv: gap of 4 samples before 0.44 s\n"
    assert len((tmp_path / "cut.csv").read_text().splitlines()) == 85 + 3


def test_a_recording_without_a_log_is_no_success(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(recorder, "open_port", lambda _: Scripted(stream([*range(5), *range(100, 105)])))
    log = tmp_path / "run.csv"
    assert rwjax(monkeypatch, "record", RIG, "port", "-o", log, "--seconds", 0.1) == 2
    said = capsys.readouterr()
    assert said.out == "" and said.err == (
        "note: 2 stretches of under 10 samples are left out\n"
        f"rwjax: {log}: no log; {tmp_path / 'run.raw'} holds all that came\n"
    )
    assert rwjax(monkeypatch, "decode", RIG, tmp_path / "run.raw") == 2
    assert capsys.readouterr().err.endswith(
        "holds no stretch of samples for a log; 2 stretches of under 10 samples are left out\n"
    )


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
                cli.record(RIG, "port", log)
            assert list(tmp_path.iterdir()) == []
        else:
            cli.record(RIG, "port", log)
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
        (
            ("run-experiment", "RIG", "loop://", "--kind", "square", "--volts", "12", "-o", "OUT.csv"),
            "12 V about 0 V: the",
        ),
        (
            ("run-experiment", "BARE", "loop://", "--kind", "square", "-o", "OUT.csv"),
            "thesis platform: no `drive.pwm`; a recording needs",
        ),
        (
            ("run-experiment", "RIG", "loop://", "--kind", "square", "--volts", "nan", "-o", "OUT.csv"),
            "--volts nan: has to be a finite number",
        ),
        (("record", "RIG", "loop://", "-o", "OUT.csv", "--seconds", "inf"), "--seconds inf: has to be a finite number"),
        (("decode", "RIG", "."), ".: is a folder; give the path of a raw stream"),
        (("decode", "RIG", "OUT.raw"), "OUT.raw: cannot be read: No such file or directory"),
        (("monitor", "RIG", "/dev/ttyNOPE"), "monitor draws on a terminal, and stderr is none; `rwjax record` writes"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    arguments: tuple[str, ...],
    said: str,
) -> None:
    full = [{"RIG": RIG, "BARE": BARE}.get(a, a.replace("OUT", str(tmp_path / "OUT"))) for a in arguments]
    assert rwjax(monkeypatch, *full) == 2
    error = capsys.readouterr().err
    assert error.replace(f"{tmp_path}/", "").startswith(f"rwjax: {said}") and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_without_pyserial_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    real = builtins.__import__

    def without(name: str, *rest: object, **more: object) -> object:
        if name == "serial":
            raise ImportError(name)
        return real(name, *rest, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    assert rwjax(monkeypatch, "monitor", RIG, "port") == 2
    assert capsys.readouterr().err.endswith("needs pyserial: pip install pyserial\n")


def test_what_was_printed_before_ctrl_c_arrives_in_a_pipe_too() -> None:
    code = """
from rwjax import cli
def app(*arguments, **options):
    print("run.csv")
    raise KeyboardInterrupt
cli.app = app
cli.main()
"""
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONUNBUFFERED": ""}
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=paths)
    assert (out.stdout, out.stderr, out.returncode) == ("run.csv\n", "rwjax: interrupted\n", 130)
