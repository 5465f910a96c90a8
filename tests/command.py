"""The command `rwjax` within the process of a test."""

import sys
from pathlib import Path

import pytest

from experiments.testbed.campaign import RIG
from rwjax.cli.main import main


def rwjax(patch: pytest.MonkeyPatch, *arguments: object) -> int:
    """Status with which the command ends."""
    patch.setattr(sys, "argv", ["rwjax", *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)


def refuses(
    patch: pytest.MonkeyPatch,
    captured: pytest.CaptureFixture[str],
    folder: Path,
    arguments: tuple[str, ...],
    said: str,
) -> None:
    """Asserts that a command with bad input says one line that begins so, ends with 2 and writes nothing.

    Among its arguments RIG stands for the testbed's rig file, and OUT for a name in `folder`, which is empty.
    """
    full = [{"RIG": RIG}.get(a, a.replace("OUT", str(folder / "OUT"))) for a in arguments]
    assert rwjax(patch, *full) == 2
    error = captured.readouterr().err
    assert error.replace(f"{folder}/", "").startswith(f"rwjax: {said}") and error.count("\n") == 1
    assert list(folder.iterdir()) == []
