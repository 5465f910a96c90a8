"""Files of programs: whole or not at all, and found again by all that they depend on."""

from pathlib import Path

import jax
import pytest

from rwjax.lowering import program_files


def test_what_was_written_is_read_and_a_torn_file_is_not(tmp_path: Path) -> None:
    path = tmp_path / "folder" / "program"
    assert program_files.read(path) is None
    program_files.write(path, b"code")
    assert program_files.read(path) == b"code"
    path.write_bytes(path.read_bytes()[:-1])
    assert program_files.read(path) is None
    assert [*path.parent.iterdir()] == [path]


def test_names_differ_with_kind_function_and_key(tmp_path: Path) -> None:
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    try:
        names = {
            program_files.file_of(*parts) for parts in (("a", "f", 1), ("b", "f", 1), ("a", "g", 1), ("a", "f", 2))
        }
        assert len(names) == 4 and program_files.file_of("a", "f", 1) in names
    finally:
        jax.config.update("jax_compilation_cache_dir", before)


def test_without_a_folder_nothing_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", None)
    try:
        assert program_files.file_of("a", "f", 1) is None
        program_files.write(None, b"code")
        assert program_files.read(None) is None
    finally:
        jax.config.update("jax_compilation_cache_dir", before)


def test_a_folder_that_cannot_be_written_costs_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    program_files.write(tmp_path / "file" / "program", b"code")
    assert program_files.read(tmp_path / "file" / "program") is None


def test_on_a_disk_that_is_nearly_full_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rwjax.cache_folder.LEAST_FREE_BYTES", 10**18)
    program_files.write(tmp_path / "program", b"code")
    assert not [*tmp_path.iterdir()]
