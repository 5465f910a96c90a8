"""Files: texts read as plain lines, all written whole or not at all."""

import os
import resource
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rwjax.errors import InputError, LogError, RigError
from rwjax.text_files import (
    DEAD_AFTER,
    beside,
    check_writable,
    left_over,
    parse_toml,
    read_text,
    write_files,
    write_text,
)


@pytest.mark.parametrize("data", [b"a\nb\n", b"a\r\nb\r\n", b"a\rb\r", b"\xef\xbb\xbfa\nb\n"])
def test_line_ends_and_a_byte_order_mark_do_not_matter(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "x").write_bytes(data)
    assert read_text(tmp_path / "x", InputError) == "a\nb\n"


def test_toml_of_the_size_of_a_file_is_read() -> None:
    assert parse_toml('a.b = 1\nc = "\u2028"\n') == {"a": {"b": 1}, "c": "\u2028"}
    assert parse_toml("#" + 3_999 * "x") == {} == parse_toml(100 * ("#" + 2_498 * "x" + "\n"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = 1\n" + ".".join(10_000 * ["a"]) + " = 1", "20003 characters on one line, 4000 at most (at line 2)"),
        ("a = " + "[" * 1500, "tables or lists stand too deep within one another"),
        (251 * (1_000 * "\n"), "251000 characters, and such a file has 250000 at most"),
        ("a = = 1", "Invalid value (at line 1, column 5)"),
    ],
)
def test_toml_that_would_take_minutes_is_refused_as_what_is_no_toml(text: str, said: str) -> None:
    with pytest.raises(ValueError) as error:
        parse_toml(text)
    assert str(error.value) == said


def test_what_cannot_be_read_is_the_callers_error(tmp_path: Path) -> None:
    (tmp_path / "latin").write_bytes(b"one\ntwo \xb5\n")
    with pytest.raises(LogError, match="latin:2: byte 0xb5 is not UTF-8; save the file as UTF-8"):
        read_text(tmp_path / "latin", LogError)
    with pytest.raises(
        RigError, match="none: cannot be read: No such file or directory; give the path of a readable file"
    ):
        read_text(tmp_path / "none", RigError)
    with pytest.raises(RigError, match=f"latine: cannot be read: No such .*; beside it lies {tmp_path / 'latin'}$"):
        read_text(tmp_path / "latine", RigError)
    (tmp_path / "folder").mkdir()
    (tmp_path / "dangling").symlink_to("nowhere")
    for name in ("folders", "dangling"):  # neither a folder nor the link itself is a file to give in its place
        with pytest.raises(RigError, match="give the path of a readable file$"):
            read_text(tmp_path / name, RigError)


def test_a_file_is_replaced_whole_also_through_a_link(tmp_path: Path) -> None:
    (tmp_path / "target").write_text("old")
    (tmp_path / "link").symlink_to("target")
    write_text(tmp_path / "link", "µ\n", InputError)
    assert (tmp_path / "target").read_bytes() == b"\xc2\xb5\n" and (tmp_path / "link").is_symlink()
    assert sorted(os.listdir(tmp_path)) == ["link", "target"]  # no temporary file stays


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "x").write_text("old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(
        LogError, match="x: cannot be written: No space left on device; give a path in a writable folder"
    ):
        write_text(tmp_path / "x", "new", LogError)
    assert (tmp_path / "x").read_text() == "old" and os.listdir(tmp_path) == ["x"]


def test_a_folder_is_no_file_and_a_missing_one_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder; give the path of a file"):
        write_text(tmp_path, "x", InputError)
    with pytest.raises(InputError, match="cannot be written: there is no folder .*none; make it first"):
        write_text(tmp_path / "none" / "x", "x", InputError)


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="this system shows no processes as files")
def test_a_folder_in_which_no_file_can_be_made_is_not_said_to_be_missing() -> None:
    for attempt in (
        lambda: check_writable("/proc/x.csv", InputError),
        lambda: write_text("/proc/x.csv", "", InputError),
    ):
        with pytest.raises(
            InputError, match=r"^/proc/x\.csv: cannot be written: .*; give a path in a writable folder$"
        ):
            attempt()


def test_what_is_no_plain_file_is_written_to_and_not_replaced() -> None:
    write_text("/dev/null", "x", InputError)
    assert Path("/dev/null").is_char_device()


def test_files_that_belong_together_are_written_all_or_none(tmp_path: Path) -> None:
    (tmp_path / "table").write_text("old")
    (tmp_path / "figure").mkdir()
    with pytest.raises(InputError, match="figure: is a folder; give the path of a file"):
        write_files({f"{tmp_path}/table": b"new", f"{tmp_path}/figure": b"new"}, InputError)
    assert (tmp_path / "table").read_text() == "old" and sorted(os.listdir(tmp_path)) == ["figure", "table"]
    (tmp_path / "figure").rmdir()
    write_files({f"{tmp_path}/table": b"new", f"{tmp_path}/figure": b"\x89PNG"}, InputError)
    assert (tmp_path / "table").read_bytes() == b"new" and (tmp_path / "figure").read_bytes() == b"\x89PNG"


def test_a_disk_that_is_full_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))  # the system refuses to write more
    try:
        with pytest.raises(InputError, match="x: cannot be written: File too large; give a path in a writable folder"):
            write_text(tmp_path / "x", "new" * 1000, InputError)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (tmp_path / "x").read_text() == "old" and os.listdir(tmp_path) == ["x"]


def test_permissions_are_those_of_the_old_file_or_of_any_new_one(tmp_path: Path) -> None:
    (tmp_path / "old").write_text("")
    (tmp_path / "old").chmod(0o604)
    before = os.umask(0o027)
    try:
        for name in ("old", "new"):
            write_text(tmp_path / name, "x", InputError)
    finally:
        os.umask(before)
    assert [(tmp_path / name).stat().st_mode & 0o777 for name in ("old", "new")] == [0o604, 0o640]


def test_writers_of_one_file_do_not_disturb_each_other(tmp_path: Path) -> None:
    with ThreadPoolExecutor(8) as threads:
        written = [
            threads.submit(write_text, tmp_path / "x", str(k) * 1000, InputError) for k in range(10) for _ in "ab"
        ]
    assert [one.exception() for one in written] == [None] * 20
    assert len(set((tmp_path / "x").read_text())) == 1 and os.listdir(tmp_path) == ["x"]


def test_a_name_may_be_long_and_need_not_be_text(tmp_path: Path) -> None:
    for name in ("n" * 255, os.fsdecode(b"run\xff.csv"), "ψ" * 127):
        write_text(tmp_path / name, name, InputError)
    assert len(os.listdir(tmp_path)) == 3
    assert (tmp_path / os.fsdecode(b"run\xff.csv")).read_text("utf-8") == r"run\udcff.csv"
    with pytest.raises(
        InputError, match="nnn: cannot be written: File name too long; give a path in a writable folder"
    ):
        write_text(tmp_path / ("n" * 256), "x", InputError)


def test_what_a_killed_writer_left_is_removed_once_it_is_old(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = subprocess.Popen(["true"])
    gone.wait()
    target, longer = tmp_path / ("x" * 50 + "-a"), tmp_path / ("x" * 50 + "-b")
    mine = beside(target)
    left, of_another = (
        path.with_name(path.name.replace(str(os.getpid()), str(gone.pid))) for path in (mine, beside(longer))
    )
    for path in (mine, left, of_another):
        path.write_text("torn")
    write_text(target, "whole", InputError)  # its process may run on another machine
    assert set(tmp_path.iterdir()) == {mine, left, of_another, target}
    assert list(left_over(target, 0.0)) == [left]
    later = time.time() + DEAD_AFTER + 1.0
    monkeypatch.setattr(time, "time", lambda: later)
    write_text(target, "whole", InputError)
    assert set(tmp_path.iterdir()) == {mine, of_another, target}


def test_whether_a_file_can_be_written_is_told_before(tmp_path: Path) -> None:
    check_writable(tmp_path / "new", InputError)
    check_writable("/dev/null", InputError)
    assert os.listdir(tmp_path) == []
    for path, said in (("", "is a folder"), ("a/b", "there is no folder .*/a; make it first")):
        with pytest.raises(InputError, match=said):
            check_writable(tmp_path / path, InputError)


def test_a_pipe_is_written_to_by_its_descriptor(tmp_path: Path) -> None:
    read, write = os.pipe()
    write_text(f"/dev/fd/{write}", "a\n", InputError)
    check_writable(f"/dev/fd/{write}", InputError)
    os.close(write)
    with os.fdopen(read) as pipe:
        assert pipe.read() == "a\n"
