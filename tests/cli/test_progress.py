"""The spinner: on a terminal only, and never where the user wants none."""

import pytest
from rich.console import Console

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
