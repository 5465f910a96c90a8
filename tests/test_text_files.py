"""Text files: read as plain lines, written whole or not at all."""

import os
from pathlib import Path

import pytest

from rwjax.errors import InputError, LogError, RigError
from rwjax.text_files import parse_toml, read_text, write_text


@pytest.mark.parametrize("data", [b"a\nb\n", b"a\r\nb\r\n", b"a\rb\r", b"\xef\xbb\xbfa\nb\n"])
def test_line_ends_and_a_byte_order_mark_do_not_matter(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "x").write_bytes(data)
    assert read_text(tmp_path / "x", InputError) == "a\nb\n"


def test_toml_of_the_size_of_a_file_is_read() -> None:
    assert parse_toml('a.b = 1\nc = "\u2028"\n') == {"a": {"b": 1}, "c": "\u2028"}
    assert parse_toml("#" + 9_999 * "x") == {} == parse_toml(100 * ("#" + 2_498 * "x" + "\n"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = 1\n" + ".".join(10_000 * ["a"]) + " = 1", "20003 characters on one line, 10000 at most (at line 2)"),
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


def test_what_is_no_plain_file_is_written_to_and_not_replaced() -> None:
    write_text("/dev/null", "x", InputError)
    assert Path("/dev/null").is_char_device()
