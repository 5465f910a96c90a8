"""Ctrl-C while the program starts."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.shell import DEMO, ROOT


@pytest.mark.usefixtures("hears_ctrl_c")
@pytest.mark.parametrize("program", [("-m", "rwjax"), (str(Path(sys.executable).with_name("rwjax")),)])
@pytest.mark.parametrize(
    ("library", "arguments"), [("typer", ["--version"]), ("jax", ["region", DEMO / "rig.toml"])], ids=["typer", "jax"]
)
def test_ctrl_c_while_the_program_starts_is_one_line(
    tmp_path: Path, program: tuple[str, ...], library: str, arguments: list[str | Path]
) -> None:
    """A library that interrupts its own import, as Ctrl-C does that comes then."""
    (tmp_path / f"{library}.py").write_text(
        "import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(9)\n"
    )
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
