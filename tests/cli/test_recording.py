"""What the commands that talk to a board share."""

import builtins
from pathlib import Path

import pytest

from experiments.testbed.campaign import RIG
from tests.command import rwjax as within


def test_without_pyserial_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    real = builtins.__import__

    def without(name: str, *rest: object, **more: object) -> object:
        if name == "serial":
            raise ImportError(name)
        return real(name, *rest, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    assert within(monkeypatch, "monitor", RIG, "port") == 2
    assert capsys.readouterr().err.endswith("needs pyserial: pip install pyserial\n")
