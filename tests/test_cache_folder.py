"""The folder of compiled programs: others cannot change it, its size has an end, and only programs are removed."""

import os
import pwd
from pathlib import Path

import pytest

from rwjax import cache_folder
from rwjax.cache_folder import (
    VARIABLE,
    WRITES_BETWEEN_TRIMS,
    clear,
    has_room,
    opened,
    place,
    programs,
    trim,
    weak_point,
)
from rwjax.errors import InputError
from rwjax.lowering.program_files import write


def program(folder: Path, number: int, size: int = 10, used: float = 0.0) -> Path:
    """A program's file, last used at a time [s since 1970]."""
    kinds = (("traced-free_run", ""), ("jit_call", "-cache"), ("lowered-runs", ""), ("kept-couplings", ""))
    begin, end = kinds[number % len(kinds)]
    path = folder / f"{begin}-{number:064x}{end}"
    path.write_bytes(bytes(size))
    os.utime(path, (used, used))
    return path


def test_it_lies_where_the_user_says_else_in_the_users_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv(VARIABLE, raising=False)
    assert place() == tmp_path / "rwjax"
    monkeypatch.setenv(VARIABLE, str(tmp_path / "own"))
    assert place() == tmp_path / "own"
    monkeypatch.setenv(VARIABLE, "")
    assert place() is None


def test_a_user_without_a_home_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(user: int) -> None:
        raise KeyError(user)

    for name in ("HOME", "XDG_CACHE_HOME", VARIABLE):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(pwd, "getpwuid", unknown)
    assert place() is None


def test_it_is_made_for_the_user_alone(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        assert opened(tmp_path / "cache" / "rwjax")
    finally:
        os.umask(before)
    assert [path.stat().st_mode & 0o777 for path in (tmp_path / "cache", tmp_path / "cache" / "rwjax")] == [0o700] * 2


def test_below_a_file_there_is_none(tmp_path: Path) -> None:
    (tmp_path / "home").write_text("a file")
    assert not opened(tmp_path / "home") and not opened(tmp_path / "home" / "cache")


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o770, 0o702])
def test_a_folder_that_others_can_write_is_refused(tmp_path: Path, mode: int) -> None:
    folder = tmp_path / "cache"
    folder.mkdir()
    folder.chmod(mode)
    with pytest.raises(
        InputError, match=f"executed, and others can write {folder} .mode {mode:o}.; .*{VARIABLE}.*chmod"
    ):
        opened(folder)


def test_so_is_one_in_such_a_folder_also_behind_a_link(tmp_path: Path) -> None:
    shared = tmp_path / "shared"
    (shared / "cache").mkdir(parents=True)
    (tmp_path / "link").symlink_to(shared / "cache")
    (shared / "hop").symlink_to(tmp_path / "own")
    (tmp_path / "own").mkdir()
    (tmp_path / "two").symlink_to("shared/../shared/hop")
    paths = (shared / "cache", tmp_path / "link", shared / "new", tmp_path / "two")
    shared.chmod(0o777)
    for path in paths:
        with pytest.raises(InputError, match=f"others can write {shared} "):
            opened(path)
    shared.chmod(0o1777)  # as /tmp, where each user may rename only what is their own
    assert all(opened(path) for path in paths)
    shared.chmod(0o755)
    assert all(opened(path) for path in paths)


def test_a_folder_of_another_user_is_refused_and_one_of_root_is_not(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert weak_point(Path("/")) is None
    owner = tmp_path.stat().st_uid
    monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    if owner == 0:
        assert weak_point(tmp_path) is None
        os.chown(tmp_path, owner + 2, -1)
        owner += 2
    assert (weak_point(tmp_path) or "").endswith(f" belongs to user {owner}")


def test_a_full_disk_has_no_room(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(cache_folder, "LEAST_FREE_BYTES", 0)
    assert has_room(tmp_path)
    monkeypatch.setattr(cache_folder, "LEAST_FREE_BYTES", 10**18)
    assert not has_room(tmp_path)


def test_the_least_recently_used_go_first_and_nothing_else_goes(tmp_path: Path) -> None:
    kept = [program(tmp_path, 0, used=400.0), program(tmp_path, 1, used=300.0)]
    gone = [program(tmp_path, 2, used=100.0), program(tmp_path, 3, used=200.0)]
    others = [
        tmp_path / "notes.txt",
        tmp_path / "traced-notes",
        tmp_path / "my-cache",
        tmp_path / ("d-" + "0" * 64 + "-cache"),
    ]
    for other in others[:3]:
        other.write_bytes(bytes(1000))
        os.utime(other, (0.0, 0.0))
    others[3].mkdir()
    assert [p.path for p in programs(tmp_path)] == [*gone, *kept[::-1]]
    trim(tmp_path, most=29)
    assert {*tmp_path.iterdir()} == {*kept, *others}
    trim(tmp_path, most=20)
    assert {*tmp_path.iterdir()} == {*kept, *others}
    assert [p.path for p in clear(tmp_path)] == kept[::-1]
    assert {*tmp_path.iterdir()} == {*others}


def test_what_the_library_writes_itself_is_counted_and_trimmed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    every = [tmp_path / f"{kind}-runs-{k:064x}" for kind in ("traced", "lowered") for k in range(60)]
    for path in every:
        write(path, b"program")
    assert {p.path for p in programs(tmp_path)} == {*every}
    trims = []
    monkeypatch.setattr(cache_folder, "trim", trims.append)
    for k in range(2 * WRITES_BETWEEN_TRIMS):
        write(tmp_path / f"lowered-run-{k:064x}", b"program")
    assert trims == [tmp_path] * 2


def test_a_program_that_another_process_removes_meanwhile_is_no_harm(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for number in range(3):
        program(tmp_path, number, used=float(number))
    unlink = Path.unlink

    def twice(path: Path, missing_ok: bool = False) -> None:
        unlink(path)
        unlink(path, missing_ok=missing_ok)

    monkeypatch.setattr(Path, "unlink", twice)
    trim(tmp_path, most=10)
    assert len(programs(tmp_path)) == 1
    trim(tmp_path / "absent", most=10)
    assert clear(tmp_path / "absent") == []
