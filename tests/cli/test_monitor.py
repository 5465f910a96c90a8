"""`rwjax monitor`, as a user calls it."""

from pathlib import Path

import pytest

from experiments.testbed.campaign import RIG
from tests.command import rwjax as within


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
    full = [{"RIG": RIG}.get(a, a.replace("OUT", str(tmp_path / "OUT"))) for a in arguments]
    assert within(monkeypatch, *full) == 2
    error = capsys.readouterr().err
    assert error.replace(f"{tmp_path}/", "").startswith(f"rwjax: {said}") and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
