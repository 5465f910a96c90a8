"""Logs from lines of text."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.logs.texts import PLATFORM


@pytest.fixture
def log(tmp_path: Path) -> Callable:
    """Writes lines to a file and reads it as a log."""
    from rwjax.logs.read import read_log

    def read(lines, rig=PLATFORM, ending="\n", **options):
        path = tmp_path / "run.csv"
        path.write_bytes(ending.join(lines).encode())
        return read_log(path, rig, **options)

    return read


@pytest.fixture
def refused(log: Callable) -> Callable:
    """Asserts that lines are refused in one line that names the file and holds the message."""
    from rwjax.errors import LogError

    def check(lines, message, rig=PLATFORM):
        with pytest.raises(LogError) as error:
            log(lines, rig)
        assert "run.csv:" in str(error.value) and message in str(error.value)
        assert len(str(error.value).splitlines()) == 1

    return check
