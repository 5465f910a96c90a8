"""The command that shows and empties the folder of compiled programs."""

from pathlib import Path

import pytest

from rwjax.cache_folder import VARIABLE
from tests.cli.shell import Shell


def test_it_shows_the_folder_and_removes_programs_alone(
    shell: Shell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "cache"
    monkeypatch.setenv(VARIABLE, str(folder))
    assert shell("cache") == (0, f"{folder}: 0 programs, 0.0 MB, of at most 1000 MB\n", "")
    assert not folder.exists()
    folder.mkdir(mode=0o700)
    (folder / f"jit_call-{0:064x}-cache").write_bytes(bytes(1_200_000))
    (folder / "notes.txt").write_text("mine")
    assert shell("cache") == (0, f"{folder}: 1 program, 1.2 MB, of at most 1000 MB\n", "")
    folder.chmod(0o777)
    assert shell("cache")[1].splitlines()[1] == f"not used, since others can write {folder} (mode 777)"
    assert shell("cache", "clear") == (0, f"{folder}: removed 1 program, 1.2 MB\n", "")
    assert [path.name for path in folder.iterdir()] == ["notes.txt"]
    monkeypatch.setenv(VARIABLE, "")
    assert shell("cache")[:2] == shell("cache", "clear")[:2]
    assert VARIABLE in shell("cache")[1]


def test_what_it_cannot_do_is_said(shell: Shell) -> None:
    status, out, err = shell("cache", "empty")
    assert (status, out) == (2, "") and "clear" in err and err.count("\n") == 1
