"""The program: its entry point, help, and what it says of unusable input."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.main import get_command

from rwjax import __version__
from rwjax.cli.main import COMMANDS, app
from rwjax.cli.options import one_name_each
from tests.cli.shell import DEMO, LOGS, Shell, program
from tests.command import rwjax as within


def test_what_it_is_and_how_to_go_on(tmp_path: Path) -> None:
    assert program("--version", cwd=tmp_path).stdout == f"rwjax {__version__}\n"
    bare = program(cwd=tmp_path)
    assert bare.returncode == 0 and "diagnose" in bare.stdout
    units = program("size", "--help", cwd=tmp_path).stdout
    assert all(f"[{unit}]" in units for unit in ("°", "s", "mm", "V", "A", "1/min"))


def test_help_waits_for_no_library_that_only_a_command_needs() -> None:
    code = "import sys, rwjax.cli.main; print(*{'jax', 'scipy', 'polars', 'matplotlib', 'llvmlite'} & {*sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=DEMO.parents[1])
    assert (done.stdout, done.returncode) == ("\n", 0), done.stderr


def test_commands_run_on_the_processor_unless_the_user_names_another_device(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("JAX_PLATFORMS", "cuda")  # for the command to find, and restored after it
    assert within(monkeypatch, "--version") == 0 and os.environ["JAX_PLATFORMS"] == "cuda"
    monkeypatch.delenv("JAX_PLATFORMS")
    monkeypatch.setenv("JAX_PLATFORM_NAME", "gpu")
    assert within(monkeypatch, "--version") == 0 and "JAX_PLATFORMS" not in os.environ
    monkeypatch.delenv("JAX_PLATFORM_NAME")
    assert within(monkeypatch, "--version") == 0 and os.environ["JAX_PLATFORMS"] == "cpu"


def test_ctrl_c_ends_a_command_with_a_word_and_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*given: object, **named: object) -> None:
        raise KeyboardInterrupt

    def leave(status: int) -> None:
        raise SystemExit(status)

    monkeypatch.setattr("rwjax.diagnosis.diagnosis.diagnose", interrupted)
    monkeypatch.setattr("os._exit", leave)
    assert within(monkeypatch, "diagnose", DEMO / "rig.toml", *LOGS, "-o", tmp_path / "out") == 130
    assert capsys.readouterr().err == "rwjax: interrupted; there is no answer yet, and nothing was written\n"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "arguments", [("\x1b[31m",), ("fit", "--\x1b[31m\n" + "n" * 5000), ("plan", "--volts", "\udcff\x07", "x")]
)
def test_what_is_typed_wrong_is_said_in_one_printable_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...]
) -> None:
    assert within(monkeypatch, *arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("rwjax: ") and said.count("\n") == 1 and len(said) < 2000 and said[:-1].isprintable()


def test_what_the_system_refuses_is_said_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for error, said in (
        (OSError(28, "No space left on device"), "No space left on device"),  # as `--help > /dev/full` does
        (PermissionError(13, "Permission denied", "a\nb.csv"), r"a\nb.csv: Permission denied"),
        (OSError("timed out"), "timed out"),
    ):

        def refused(*given: object, error: OSError = error, **named: object) -> None:
            raise error

        monkeypatch.setattr("rwjax.cli.main.app", refused)
        assert within(monkeypatch, "--help") == 2
        assert capsys.readouterr().err == f"rwjax: the system refuses: {said}; free room, or give other files\n"
    monkeypatch.setattr(sys, "stdout", None)  # closed when the program began
    assert within(monkeypatch, "--help") == 2


def test_what_was_printed_before_ctrl_c_arrives_in_a_pipe_too() -> None:
    code = """
from rwjax.cli import main
def app(*arguments, **options):
    print("run.csv")
    raise KeyboardInterrupt
main.app = app
main.main()
"""
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONUNBUFFERED": ""}
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=paths)
    assert (out.stdout, out.stderr, out.returncode) == ("run.csv\n", "rwjax: interrupted\n", 130)


def test_nothing_but_one_line_comes_out_of_a_process_with_unusable_input(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text((DEMO / "rig.toml").read_text())
    (tmp_path / "log.csv").write_text("time_s,voltage_V,yaw_count\n0,0,0\n")
    done = program("diagnose", "rig.toml", "log.csv", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1) and "yaw_count" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fit", "absent.toml", "log.csv"], "absent.toml"),
        (["fit", "rig.toml", "absent.csv"], "absent.csv"),
        (["diagnose", "rig.toml", "log.csv"], "yaw_count"),
        (["predict", "rig.toml", "log.csv"], "yaw_count"),
    ],
)
def test_unusable_input_ends_with_one_line_and_status_2(shell: Shell, arguments: list[str], words: str) -> None:
    (shell.folder / "log.csv").write_text("time_s,voltage_V,yaw_count\n0,0,0\n")
    code, out, err = shell(*arguments)
    assert code == 2 and out == "" and words in err and len(err.splitlines()) == 1


@pytest.mark.slow
def test_a_user_without_a_home_and_a_name_gets_the_result_and_no_warning(tmp_path: Path) -> None:
    code = "import pwd; pwd.getpwuid = {}.__getitem__; from rwjax.cli.main import main; main()"
    command = ["region", str(DEMO / "rig.toml"), "--kp", "1:9:3", "--kd", "1:9:3", "-o", "region.csv", "--quiet"]
    kept = {name: value for name, value in os.environ.items() if name in ("PATH", "TMPDIR")}
    paths = {**kept, "PYTHONPATH": os.pathsep.join([str(DEMO.parents[1]), *sys.path])}
    out = subprocess.run(
        [sys.executable, "-c", code, *command], capture_output=True, text=True, cwd=tmp_path, env=paths
    )
    assert (out.returncode, out.stderr) == (0, "")
    assert {path.name for path in tmp_path.iterdir()} == {"region.csv", "region.png"}


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.__name__)
def test_the_help_of_every_command_has_an_example_with_options_that_it_knows(command: Callable[..., None]) -> None:
    (example,) = re.findall(r"Example: `rwjax (.*?)`", command.__doc__ or "")
    name, *arguments = shlex.split(example)
    get_command(app).commands[name].make_context(name, one_name_each(arguments))
