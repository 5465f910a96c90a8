"""Ctrl-C while the program starts, and later."""

import importlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from unittest.mock import Mock

import pytest

from rwjax import __version__
from rwjax.cli import interrupt
from tests.cli.shell import DEMO, ROOT

INTERRUPTED = "import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(9)\n"
SWALLOWED = f"try:\n    exec({INTERRUPTED!r})\nexcept BaseException:\n    pass\n"
MODULE, SCRIPT = ("-m", "rwjax"), (str(Path(sys.executable).with_name("rwjax")),)
REGION = ["region", DEMO / "rig.toml"]


@pytest.mark.usefixtures("hears_ctrl_c")
@pytest.mark.parametrize(
    ("program", "library", "content", "arguments"),
    [
        (MODULE, "typer", INTERRUPTED, ["--version"]),
        (SCRIPT, "typer", INTERRUPTED, ["--version"]),
        (MODULE, "jax", INTERRUPTED, REGION),
        (SCRIPT, "jax", SWALLOWED, REGION),
    ],
    ids=("typer", "typer, script", "jax", "jax, which goes on"),
)
def test_ctrl_c_while_the_program_starts_is_one_line(
    tmp_path: Path, program: tuple[str, ...], library: str, content: str, arguments: list[str | Path]
) -> None:
    """A library that interrupts its own import, as Ctrl-C does that comes then."""
    (tmp_path / f"{library}.py").write_text(content)
    paths = {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"}
    done = subprocess.run(
        [sys.executable, *program, *map(str, arguments)],
        capture_output=True,
        text=True,
        env=os.environ | paths,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "rwjax: interrupted\n")


@pytest.mark.usefixtures("hears_ctrl_c")
@pytest.mark.parametrize("number", interrupt.SIGNALS)
def test_ctrl_c_after_the_work_is_done_changes_nothing(tmp_path: Path, number: signal.Signals) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        f"import atexit, os, signal\natexit.register(os.kill, os.getpid(), {int(number)})\n"
    )
    done = subprocess.run(
        [sys.executable, *MODULE, "--version"],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, f"rwjax {__version__}\n", "")


@pytest.mark.usefixtures("hears_ctrl_c")
@pytest.mark.parametrize(
    ("own", "given", "handled"),
    [
        ("/bin/rwjax", "-m", True),
        ("/bin/rwjax", "fit -m x", True),
        ("-X dev -m rwjax", "fit -m", True),
        ("-m other", "-m rwjax", False),
        ("/bin/other", "-m rwjax", False),
        ("-c pass", "/bin/rwjax", False),
    ],
)
def test_only_what_python_was_given_before_the_program_tells_which_it_is(
    monkeypatch: pytest.MonkeyPatch, own: str, given: str, handled: bool
) -> None:
    program = own if own.startswith("/") else own.split()[-2]
    monkeypatch.setattr(sys, "orig_argv", ["python", *own.split(), *given.split()])
    monkeypatch.setattr(sys, "argv", [program, *given.split()])
    for hook in ("excepthook", "unraisablehook"):
        monkeypatch.setattr(sys, hook, getattr(sys, hook))
    interrupt.begin()
    assert (signal.getsignal(signal.SIGINT) is interrupt.heard) == handled


@pytest.mark.parametrize("ignored", [signal.SIG_IGN, signal.default_int_handler], ids=["in a script", "by hand"])
def test_sigterm_ends_with_its_own_word_and_status_also_where_ctrl_c_is_ignored(
    tmp_path: Path, ignored: object
) -> None:
    (tmp_path / "jax.py").write_text(INTERRUPTED.replace("SIGINT", "SIGTERM"))
    before = signal.signal(signal.SIGINT, ignored)  # pyright: ignore[reportArgumentType]
    try:
        done = subprocess.run(
            [sys.executable, *MODULE, *map(str, REGION)],
            capture_output=True,
            text=True,
            env=os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
            check=False,
        )
    finally:
        signal.signal(signal.SIGINT, before)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "rwjax: terminated\n")


class Ended(Exception):
    """The end of the process."""


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Statuses with which the process would have ended at once."""
    found: list[int] = []

    def end(status: int) -> None:
        found.append(status)
        raise Ended

    monkeypatch.setattr(os, "_exit", end)
    return found


def test_ctrl_c_outside_an_import_lets_the_program_tidy_up(left: list[int]) -> None:
    with pytest.raises(KeyboardInterrupt):
        interrupt.heard(signal.SIGINT, None)
    assert left == []


def test_ctrl_c_within_an_import_ends_the_process(
    left: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "slow_library.py").write_text(
        "import sys\nfrom rwjax.cli import interrupt\ninterrupt.heard(2, sys._getframe())\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(Ended):
        importlib.import_module("slow_library")
    assert left == [130] and capfd.readouterr().err == "rwjax: interrupted\n"


@pytest.mark.usefixtures("hears_ctrl_c")
def test_a_program_that_imports_the_library_keeps_its_ctrl_c() -> None:
    ask = "import signal, rwjax; print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    done = subprocess.run(
        [sys.executable, "-c", ask],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    assert done.stdout == "True\n"


@pytest.mark.usefixtures("hears_ctrl_c")
def test_a_process_that_the_command_begins_keeps_its_ctrl_c(tmp_path: Path) -> None:
    (tmp_path / "rwjax").write_text(
        "import multiprocessing, signal, rwjax.cli\n"
        "def ask(): print(signal.getsignal(signal.SIGINT) is signal.default_int_handler, flush=True)\n"
        "if __name__ == '__main__':\n"
        "    ask()\n"
        "    child = multiprocessing.get_context('spawn').Process(target=ask)\n"
        "    child.start(), child.join()\n"
    )
    done = subprocess.run(
        [sys.executable, str(tmp_path / "rwjax")],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    assert done.stdout == "False\nTrue\n"


@pytest.fixture
def own_handler() -> Iterator[None]:
    """The command's handler of Ctrl-C and SIGTERM, within a test."""
    before = [(number, signal.signal(number, interrupt.heard)) for number in interrupt.SIGNALS]
    yield
    for number, handler in before:
        signal.signal(number, handler)


@pytest.mark.usefixtures("own_handler")
@pytest.mark.parametrize("number", interrupt.SIGNALS)
def test_the_first_ctrl_c_asks_and_the_second_interrupts(
    number: signal.Signals, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(interrupt, "SAME_S", 0.0)
    ask = Mock(return_value=True)
    with pytest.raises(KeyboardInterrupt), interrupt.first(ask):
        signal.raise_signal(number)
        assert ask.call_count == 1 and capfd.readouterr().err == f"{interrupt.ASKED}\n"
        signal.raise_signal(signal.SIGINT)
    assert ask.call_count == 1 and [signal.getsignal(one) for one in interrupt.SIGNALS] == [interrupt.heard] * 2


@pytest.mark.usefixtures("own_handler")
@pytest.mark.parametrize("second", interrupt.SIGNALS)
def test_a_signal_that_is_sent_twice_at_once_asks_for_the_answer_so_far(
    second: signal.Signals, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As GNU `timeout` does, which signals the program and then its whole group."""
    monkeypatch.setattr(interrupt, "SAME_S", 1e9)
    ask = Mock(side_effect=lambda: signal.raise_signal(second) is None)
    with interrupt.first(ask):
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(second)
    assert ask.call_count == 1 and capfd.readouterr().err == f"{interrupt.ASKED}\n"
    assert [signal.getsignal(one) for one in interrupt.SIGNALS] == [interrupt.heard] * 2


@pytest.mark.usefixtures("own_handler")
def test_where_there_is_no_answer_to_come_the_first_ctrl_c_interrupts(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KeyboardInterrupt), interrupt.first(lambda: False):
        signal.raise_signal(signal.SIGINT)
    assert capfd.readouterr().err == "" and signal.getsignal(signal.SIGINT) is interrupt.heard


@pytest.mark.usefixtures("hears_ctrl_c")
def test_a_program_that_calls_a_command_keeps_its_own_handler() -> None:
    with interrupt.first(lambda: True):
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_what_is_said_where_there_is_no_answer_ends_with_the_answer_and_with_an_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(os, "_exit", Mock())  # goes on
    with interrupt.unanswered() as answered:
        interrupt.leave()
        assert capsys.readouterr().err.endswith(f"{interrupt.NO_ANSWER}\n")
        answered()
        interrupt.leave()
    with suppress(ValueError), interrupt.unanswered():
        raise ValueError
    interrupt.leave()
    with interrupt.unanswered():
        pass
    interrupt.leave()
    said = capsys.readouterr().err
    assert interrupt.NO_ANSWER not in said and said.count("\n") == 3
