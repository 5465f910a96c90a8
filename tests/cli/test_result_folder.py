"""Result folders: exchanged whole, with what is no result kept, also when a process is killed or two write at once."""

import errno
import os
import random
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rwjax.cli.result_folder import ResultFolder
from rwjax.errors import InputError
from tests.cli.shell import ROOT

NAMES = ("a.json", "b.png", "figure.png")
WRITER = """
import sys
from pathlib import Path
from rwjax.cli.result_folder import ResultFolder
assert "jax" not in sys.modules

def clear(folder):
    for name in ("a.json", "b.png", "figure.png"):
        (folder / name).unlink(missing_ok=True)

who, number = sys.argv[1], 0
while True:
    number += 1
    with ResultFolder(Path("out"), clear, ()).renewed() as folder:
        for name in ("a.json", "b.png"):
            (folder / name).write_text(f"{who} {number}")
        if number % 2:
            (folder / "figure.png").write_text(f"{who} {number}")
    print(number, flush=True)
"""


def clear(folder: Path) -> None:
    for name in NAMES:
        (folder / name).unlink(missing_ok=True)


def write(folder: Path, text: str, *inputs: Path) -> None:
    with ResultFolder(folder, clear, inputs).renewed() as new:
        (new / "a.json").write_text(text)
        (new / "b.png").write_text(text)


def holds(folder: Path) -> dict[str, str]:
    return {
        str(p.relative_to(folder)): p.read_text()
        for p in sorted(folder.rglob("*"))
        if p.is_file() and not p.is_symlink()
    }


def whole(folder: Path) -> str:
    """The text of a result, all of whose files have to agree."""
    (text,) = {text for name, text in holds(folder).items() if name in NAMES}
    assert (int(text.split()[1]) % 2 == 1) == (folder / "figure.png").exists()
    return text


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def test_a_result_replaces_the_earlier_one_and_nothing_else(out: Path) -> None:
    write(out / "deep", "1")
    assert holds(out) == {"deep/a.json": "1", "deep/b.png": "1"}
    (out / "deep" / "figure.png").write_text("of the earlier result")
    (out / "deep" / "own" / "empty").mkdir(parents=True)
    (out / "deep" / "own" / "log.csv").write_text("mine")
    (out / "deep" / "link").symlink_to("own/log.csv")
    number = (out / "deep" / "own" / "log.csv").stat().st_ino
    (out / "deep").chmod(0o750)
    (out / "deep" / "own").chmod(0o555)
    write(out / "deep", "2")
    assert holds(out) == {"deep/a.json": "2", "deep/b.png": "2", "deep/own/log.csv": "mine"}
    assert (out / "deep" / "own" / "log.csv").stat().st_ino == number and (out / "deep" / "own" / "empty").is_dir()
    assert os.readlink(out / "deep" / "link") == "own/log.csv"
    assert [(out / "deep" / name).stat().st_mode & 0o777 for name in (".", "own")] == [0o750, 0o555]
    assert os.listdir(out) == ["deep"]


def test_an_unfinished_result_changes_nothing(out: Path) -> None:
    target = ResultFolder(out / "deep", clear, ())
    target.check()
    assert not out.exists()
    for error in (InputError("no"), KeyboardInterrupt()):
        with pytest.raises(type(error)), target.renewed() as new:
            (new / "a.json").write_text("torn")
            raise error
        assert not out.exists()
    write(out / "deep", "1")
    with pytest.raises(InputError, match=r"^\S+/deep: cannot make this folder \(No space left on device\)"):
        with target.renewed() as new:
            (new / "a.json").write_text("torn")
            raise OSError(errno.ENOSPC, "No space left on device")
    with pytest.raises(InputError, match=f"^{out}/deep/b.png: cannot be written$"), target.renewed() as new:
        raise InputError(f"{new}/b.png: cannot be written")  # by the name that the user knows
    assert holds(out) == {"deep/a.json": "1", "deep/b.png": "1"} and os.listdir(out) == ["deep"]


def test_an_input_that_results_would_replace_is_spared_by_whatever_name(out: Path, tmp_path: Path) -> None:
    write(out, "1")
    (out / "rig.toml").write_text("rig")
    (tmp_path / "inside").symlink_to(out / "a.json")
    (out / "b.png").unlink()
    (out / "b.png").symlink_to("rig.toml")
    for path in (out / "a.json", tmp_path / "inside", out / "b.png"):
        with pytest.raises(InputError, match=f"^{path}: is an input, and the results would replace it; give another"):
            ResultFolder(out, clear, (out / "rig.toml", path)).check()
    write(out, "2", out / "rig.toml")
    assert holds(out) == {"a.json": "2", "b.png": "2", "rig.toml": "rig"}  # what a link led to is not written into
    with pytest.raises(InputError, match="rig.toml: is an input"):  # a name that only the finished result has
        with ResultFolder(out, clear, (out / "rig.toml",)).renewed() as new:
            (new / "rig.toml").unlink()
            (new / "rig.toml").write_text("result")
    assert holds(out)["rig.toml"] == "rig"


def test_a_link_to_a_folder_stays_one(out: Path, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("out")
    write(tmp_path / "link", "1")
    write(tmp_path / "link", "2")
    assert holds(out) == {"a.json": "2", "b.png": "2"} and os.readlink(tmp_path / "link") == "out"


@pytest.mark.parametrize(
    ("path", "said"),
    [
        (".", "holds the folder that you are in, and is replaced as a whole; give a folder of its own with -o"),
        ("..", "holds the folder that you are in"),
        ("/proc", "is where a file system begins, which cannot be replaced; give a folder of its own with -o"),
        ("file", "is a file, and a folder is wanted; give another with -o"),
        ("file/out", r"cannot make this folder \("),
        ("n" * 300, r"cannot make this folder \(File name too long\)"),
        ("full", "holds more than 3 files besides results; give a folder of its own with -o"),
    ],
)
def test_a_folder_that_cannot_be_exchanged_is_refused_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, path: str, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("rwjax.cli.result_folder.MOST_FILES", 3)
    Path("file").write_text("")
    Path("full").mkdir()
    for name in "abcd":
        Path("full", name).write_text("")
    with pytest.raises(InputError, match=f"^{path}: {said}".replace("..", r"\.\.")) as refused:
        ResultFolder(Path(path), clear, ()).check()
    assert str(refused.value).count("\n") == 0 and sorted(os.listdir()) == ["file", "full"]


def test_what_comes_into_the_folder_meanwhile_stays(out: Path) -> None:
    write(out, "1")
    (out / "notes").write_text("early")
    with ResultFolder(out, clear, ()).renewed() as new:
        (new / "a.json").write_text("2")
        (out / "new").mkdir()
        (out / "new" / "log.csv").write_text("late")
        (out / "edited").write_text("late")
        (out / "edited").replace(out / "notes")
        write(out, "another process")
    assert holds(out) == {"a.json": "2", "new/log.csv": "late", "notes": "late"}


def no_swap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ctypes.CDLL", lambda *given, **named: object())


def no_links(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*given: object, **named: object) -> None:
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", refuse)


@pytest.mark.parametrize("lack", [no_swap, no_links])
def test_file_systems_that_can_do_less(
    out: Path, monkeypatch: pytest.MonkeyPatch, lack: Callable[[pytest.MonkeyPatch], None]
) -> None:
    lack(monkeypatch)
    write(out, "1")
    (out / "own").mkdir()
    (out / "own" / "log.csv").write_text("mine")
    write(out, "2")
    assert holds(out) == {"a.json": "2", "b.png": "2", "own/log.csv": "mine"} and os.listdir(out.parent) == ["out"]


def test_what_a_killed_process_left_is_settled(out: Path) -> None:
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    write(out, "1")
    out.rename(out.with_name(f".out.{gone.pid}.0123abcd.old"))  # killed between the two steps of a slow exchange
    (left := out.with_name(f".out.{gone.pid}.0123abcd.new")).mkdir()
    (left / "torn").write_text("of a folder that was not complete")
    left.rename(out.with_name(f".out.{gone.pid}.{left.stat().st_ino:x}.new"))
    (out.with_name(f".out.{os.getpid()}.0123abcd.new")).mkdir()  # of a process that runs
    ResultFolder(out, clear, ()).check()
    assert holds(out) == {"a.json": "1", "b.png": "1"}
    assert sorted(os.listdir(out.parent)) == [f".out.{os.getpid()}.0123abcd.new", "out"]


def begun(folder: Path, who: str) -> subprocess.Popen[str]:
    """A process that writes result after result into a folder, and has written one."""
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, who],
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert process.stdout is not None and process.stdout.readline() == "1\n"
    return process


def ended(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate()


def test_a_result_is_whole_wherever_its_writer_is_killed(out: Path) -> None:
    out.mkdir()
    (out / "own.csv").write_text("mine")
    moments = random.Random(0)
    for round_ in range(8):
        process = begun(out.parent, str(round_))
        time.sleep(moments.uniform(0.0, 0.02))
        ended(process)
        assert whole(out).startswith(f"{round_} ") and (out / "own.csv").read_text() == "mine"
    ResultFolder(out, clear, ()).check()
    assert os.listdir(out.parent) == ["out"]


def test_of_two_writers_the_last_one_wins_whole_and_no_file_of_the_users_is_lost(out: Path) -> None:
    writers = [begun(out.parent, who) for who in "ab"]
    number, last = 0, time.monotonic() + 0.7
    while time.monotonic() < last:
        number += 1
        (out / f"{number}.csv").write_text(str(number))
        time.sleep(0.005)
    assert [writer.poll() for writer in writers] == [None, None]  # neither has ended in an error
    for writer in writers:
        ended(writer)
    assert whole(out)
    ResultFolder(out, clear, ()).check()  # takes over what a killed writer did not
    assert os.listdir(out.parent) == ["out"]
    assert {name: text for name, text in holds(out).items() if name not in NAMES} == {
        f"{k}.csv": str(k) for k in range(1, number + 1)
    }
