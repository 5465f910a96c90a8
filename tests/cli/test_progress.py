"""The spinner: on a terminal only, and never where the user wants none."""

import time

import pytest
from rich.console import Console

from rwjax.cli import progress as shown
from rwjax.cli.progress import progress


@pytest.mark.parametrize(("terminal", "quiet"), [(True, True), (False, False)])
def test_nothing_is_shown(
    terminal: bool, quiet: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Console, "is_terminal", terminal)
    with progress(quiet) as show:
        show("fitting")
    assert capsys.readouterr() == ("", "")


def test_a_terminal_sees_the_step_that_runs(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Console, "is_terminal", True)
    monkeypatch.setenv("TERM", "xterm")
    with progress(quiet=False) as show:
        show("fitting [s]")
    out, err = capsys.readouterr()
    assert out == "" and "fitting [s]" in err


def test_elsewhere_each_step_that_is_looked_at_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shown, "EVERY_S", 0.05)
    with progress(quiet=False, lines=True) as show:
        time.sleep(0.2)
        assert capsys.readouterr().err == ""  # no step has begun
        show("3 of 36 candidates")
        show("7 of 36 candidates")
        time.sleep(0.3)  # an estimate that is told again would be wrong by then
        assert capsys.readouterr().err.splitlines() == ["7 of 36 candidates"]
        show("8 of 36 candidates")
        time.sleep(0.3)
        assert capsys.readouterr().err.splitlines() == ["8 of 36 candidates"]
    with progress(quiet=True, lines=True) as show:
        show("fitting")
        time.sleep(0.1)
    assert capsys.readouterr().err == ""
