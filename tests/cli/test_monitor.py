"""`rwjax monitor`, as a user calls it."""

from pathlib import Path

import pytest

from tests.command import refuses


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
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
    refuses(monkeypatch, capsys, tmp_path, arguments, said)
