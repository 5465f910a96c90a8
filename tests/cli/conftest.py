"""What the tests of the commands share."""

import signal
from pathlib import Path

import pytest

from rwjax.cli import interrupt
from tests.cli.shell import Shell


@pytest.fixture(autouse=True)
def nothing_came(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forgets the signals of other tests, which a process hears once."""
    monkeypatch.setattr(interrupt, "came", signal.SIGINT)


@pytest.fixture
def shell(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Shell:
    return Shell(tmp_path, capsys, monkeypatch)
