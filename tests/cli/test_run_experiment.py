"""`rwjax run-experiment`, as a user calls it."""

from pathlib import Path

import pytest

from experiments.testbed.campaign import RIG, TRUTH, bench
from firmware.simavr.avr import Avr, build
from firmware.simavr.bench import Bench
from firmware.simavr.protocol_simavr import url
from firmware.simavr.spin import Spin, constant, still
from rwjax.link import messages, recorder, rest
from tests.boards import need_simavr
from tests.cli.shell import DEMO
from tests.command import refuses
from tests.command import rwjax as within
from tests.link.stubborn import Stubborn


@pytest.mark.slow
def test_an_experiment_is_played_recorded_and_fitted(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    need_simavr()
    port, log = url(bench(TRUTH)), tmp_path / "square.csv"
    asked = ("--kind", "square", "--volts", 2.5, "--period", 2, "--seconds", 4, "--role", "train")
    assert within(monkeypatch, "run-experiment", RIG, port, "-o", log, *asked) == 0
    assert capsys.readouterr().out == f"{log}\n"
    assert "# experiment: square, 2.5 V about 0 V, period 2 s, 4 s" in log.read_text()
    assert within(monkeypatch, "predict", RIG, log, "-o", tmp_path / "p.csv") == 0  # other commands take it
    assert within(monkeypatch, "record", RIG, port, "-o", tmp_path / "rest.csv", "--seconds", 0.5) == 0
    assert len((tmp_path / "rest.csv").read_text().splitlines()) > 50
    assert within(monkeypatch, "run-experiment", RIG, port, "-o", log, *asked) == 2
    assert capsys.readouterr().err.startswith(f"rwjax: {log}: exists already; a recording never replaces another")


@pytest.mark.slow
def test_an_experiment_that_begins_while_the_rig_moves_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    need_simavr()
    monkeypatch.setattr(rest, "LONGEST_WAIT", 300)
    port, log = url(Bench(Avr(build()), Spin(still, constant(900.0)))), tmp_path / "run.csv"
    assert within(monkeypatch, "run-experiment", RIG, port, "-o", log, "--kind", "square", "--seconds", 1) == 0
    said = capsys.readouterr()
    assert said.out == f"{log}\n" and said.err == "note: the rig still moved after a wait of 60 s\n"
    assert "# start: the rig still moved after a wait of 60 s\n" in log.read_text()


def test_after_a_latched_fault_the_command_works_as_it_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port, log = Stubborn(), tmp_path / "run.csv"
    port.state = messages.FAULT
    monkeypatch.setattr(recorder, "open_port", lambda _: port)
    asked = ("run-experiment", RIG, "port", "-o", log, "--kind", "square", "--seconds", 1)
    assert within(monkeypatch, *asked) == 2
    said = "scripted: fault: silence of the host; `rwjax run-experiment --clear` clears it"
    assert capsys.readouterr().err == f"rwjax: {said}\n" and list(tmp_path.iterdir()) == []
    assert within(monkeypatch, *asked, "--clear") == 0
    assert capsys.readouterr().out == f"{log}\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ("run-experiment", "RIG", "loop://", "--kind", "square", "--volts", "12", "-o", "OUT.csv"),
            "12 V about 0 V: the",
        ),
        (
            ("run-experiment", "BARE", "loop://", "--kind", "square", "-o", "OUT.csv"),
            f"{DEMO}/rig.toml: no `drive.pwm`; a recording needs",
        ),
        (
            ("run-experiment", "RIG", "loop://", "--kind", "square", "--volts", "nan", "-o", "OUT.csv"),
            "--volts nan: has to be a finite number",
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
    bare = str(DEMO / "rig.toml")
    refuses(monkeypatch, capsys, tmp_path, tuple(bare if a == "BARE" else a for a in arguments), said)
