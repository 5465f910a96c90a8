"""Result folders: exchanged whole, with what is no result kept, also when a process is killed or two write at once."""

import errno
import os
import random
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from rwjax.cli.result_folder import ResultFolder
from rwjax.errors import InputError
from rwjax.text_files import DEAD_AFTER, beside
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


def test_what_comes_in_under_the_name_of_a_result_stays_beside(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def spare(folder: Path) -> None:
        if (folder / "a.json").exists() and (folder / "a.json").read_text() != "mine":
            (folder / "a.json").unlink()

    write(out, "1")
    with ResultFolder(out, spare, ()).renewed() as new:
        (new / "a.json").write_text("2")
        (out / "a.json").write_text("mine")
    assert holds(out) == {"a.json": "2", "b.png": "1"} and holds(new) == {"a.json": "mine"}
    assert capsys.readouterr().err.startswith(
        f"note: {new} is what {out} was before; what came in while it was replaced"
    )


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


@pytest.fixture
def gone() -> int:
    """The number of a process that is no more."""
    process = subprocess.Popen(["true"])
    process.wait()
    return process.pid


def an_hour_later(monkeypatch: pytest.MonkeyPatch) -> None:
    later = time.time() + DEAD_AFTER + 1.0
    monkeypatch.setattr(time, "time", lambda: later)


def left(out: Path, process: int, ending: str) -> Path:
    """A new folder beside the target with the name that a process gives it before the exchange."""
    folder = beside(out).with_suffix(ending)
    folder.mkdir()
    parts = folder.name.split(".")
    return folder.rename(
        folder.with_name(".".join([*parts[:-3], str(process), f"{folder.stat().st_ino:x}", parts[-1]]))
    )


def test_what_a_killed_process_left_is_settled(out: Path, gone: int, monkeypatch: pytest.MonkeyPatch) -> None:
    write(out, "1")
    old = left(out, gone, ".old")
    old.rmdir()
    out.rename(old)  # killed between the two steps of a slow exchange
    unfinished, empty, running = left(out, gone, ".new"), left(out, gone, ".new"), left(out, os.getpid(), ".new")
    (unfinished / "own").mkdir()
    (unfinished / "own" / "torn").write_text("of a folder that was not complete")
    empty = empty.rename(empty.with_name(empty.name.replace(".new", "0.new")))  # before it had its number
    ResultFolder(out, clear, ()).check()
    assert holds(out) == {"a.json": "1", "b.png": "1"}
    assert set(out.parent.iterdir()) == {out, unfinished, empty, running}  # their process may run on another machine
    an_hour_later(monkeypatch)
    ResultFolder(out, clear, ()).check()
    assert set(out.parent.iterdir()) == {out, running}


def test_a_folder_whose_writer_was_killed_after_the_exchange_stays_beside(
    out: Path, gone: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write(out, "1")
    old = left(out, gone, ".new")
    old = old.rename(
        old.with_name(old.name.replace(".new", "0.new"))
    )  # the number of the folder that is at the target now
    (old / "plan.toml").write_text("of another command")
    an_hour_later(monkeypatch)
    ResultFolder(out, clear, ()).check()
    write(out, "2")
    assert holds(out) == {"a.json": "2", "b.png": "2"} and holds(old) == {"plan.toml": "of another command"}
    assert capsys.readouterr().err == (
        f"note: {old} is what {out} was before; what came in while it was replaced may be there alone: look, and remove it\n"
    )


@pytest.mark.parametrize("error", [OSError(errno.ENOSPC, "No space left on device"), KeyboardInterrupt()])
def test_what_cannot_be_taken_over_is_not_removed(
    out: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    write(out, "1")

    def fail(*_: object) -> None:
        raise error

    with suppress(KeyboardInterrupt), ResultFolder(out, clear, ()).renewed() as new:
        (new / "a.json").write_text("2")
        (out / "log.csv").write_text("late")
        monkeypatch.setattr(os, "replace", fail)
    assert holds(out) == {"a.json": "2"} and holds(new) == {"log.csv": "late"}


def test_a_folder_that_is_never_empty_is_given_up(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(out, "1")

    def full(*_: object) -> None:
        raise OSError(errno.ENOTEMPTY, "Directory not empty")

    with ResultFolder(out, clear, ()).renewed() as new:
        (new / "a.json").write_text("2")
        monkeypatch.setattr(os, "rmdir", full)
    assert holds(out) == {"a.json": "2"} and new.exists()


def test_a_new_folder_has_the_group_of_the_old_one(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[tuple[int, int]] = []
    write(out, "1")
    monkeypatch.setattr(os, "chown", lambda _, user, group: given.append((user, group)))
    write(out, "2")
    assert given == [(-1, out.stat().st_gid)]


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


@pytest.mark.parametrize("rounds", [2, pytest.param(40, marks=pytest.mark.slow)])
def test_a_result_is_whole_wherever_its_writer_is_killed(
    out: Path, monkeypatch: pytest.MonkeyPatch, rounds: int
) -> None:
    out.mkdir()
    (out / "own.csv").write_text("mine")
    moments = random.Random(0)
    for round_ in range(rounds):
        process = begun(out.parent, str(round_))
        time.sleep(moments.uniform(0.0, 0.02))
        ended(process)
        assert whole(out).startswith(f"{round_} ") and (out / "own.csv").read_text() == "mine"
    an_hour_later(monkeypatch)
    ResultFolder(out, clear, ()).check()
    for beside_it in set(out.parent.iterdir()) - {out}:
        assert set(holds(beside_it)) <= {*NAMES, "own.csv"}
        assert beside_it.name.split(".")[-2] != f"{beside_it.stat().st_ino:x}"  # it was exchanged


@pytest.mark.parametrize("seconds", [0.1, pytest.param(3.0, marks=pytest.mark.slow)])
def test_of_two_writers_the_last_one_wins_whole_and_no_file_of_the_users_is_lost(out: Path, seconds: float) -> None:
    writers = [begun(out.parent, who) for who in "ab"]
    number, last = 0, time.monotonic() + seconds
    while time.monotonic() < last:
        number += 1
        (out / f"{number}.csv").write_text(str(number))
        time.sleep(0.005)
    assert [writer.poll() for writer in writers] == [None, None]  # neither has ended in an error
    for writer in writers:
        ended(writer)
    assert whole(out)
    ResultFolder(out, clear, ()).check()
    kept = {path.name: path.read_text() for path in out.parent.glob("*/*.csv")}  # in it, or beside it after the kill
    assert kept == {f"{k}.csv": str(k) for k in range(1, number + 1)}
