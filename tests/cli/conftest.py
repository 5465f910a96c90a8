"""What the tests of the commands share."""

import signal
from contextlib import suppress
from pathlib import Path

import pytest

from rwjax.cli import interrupt
from tests.cli.shell import Shell


@pytest.fixture(autouse=True)
def ctrl_c_came_last() -> None:
    """Whatever the signals of other tests were."""
    with suppress(KeyboardInterrupt):
        interrupt.heard(signal.SIGINT, None)


@pytest.fixture
def shell(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Shell:
    return Shell(tmp_path, capsys, monkeypatch)
