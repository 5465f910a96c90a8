"""What is printed: no control characters, any encoding, and a stdout that is full, closed or read no more."""

import ast
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import rwjax.cli
from rwjax.cli.terminal import document, forget, listed, next_command, note, say, tell
from tests.cli.shell import ROOT

NAME = os.fsdecode(b"\x1b[31mrun\x07 \xe2\x80\xae\xff \xc2\xb5.csv")
SHOWN = r"\x1b[31mrun\x07 \u202e\udcff µ.csv"
PROGRAM = """
import os
from rwjax.cli import main, terminal
def app(*given, **named):
    for number in range(COUNT):
        terminal.say(f"{number} \\u00b5 \\u00b1")
    terminal.document('name = "\\u00b5"\\n')
    terminal.note("\\u00b5")
main.app = app
main.main()
"""


def test_names_are_printable_and_lines_stay_lines(capsys: pytest.CaptureFixture[str]) -> None:
    say(f"a\n{NAME}")
    note(NAME, "b")
    tell(NAME)
    assert capsys.readouterr() == (f"a\n{SHOWN}\n", f"note: {SHOWN}\nnote: b\n{SHOWN}\n")


def test_a_document_is_the_files_bytes_and_on_a_terminal_lines(
    capsysbinary: pytest.CaptureFixture[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    document("a = 1 # µ\n\u202e\udcff\n")
    assert capsysbinary.readouterr().out == "a = 1 # µ\n\u202e\\udcff\n".encode()
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    document("a = 1 # µ\n\u202e\n")
    assert capsysbinary.readouterr().out == "a = 1 # µ\n\\u202e\n".encode()


def shell(count: int, after: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """The program that prints so many lines, as a shell runs it."""
    return subprocess.run(
        ["bash", "-c", f'set -o pipefail; "$0" -c "$1" {after}', sys.executable, PROGRAM.replace("COUNT", str(count))],
        capture_output=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "", **environment},
        check=False,
    )


@pytest.mark.parametrize("count", [1, 20_000])
def test_a_reader_that_has_enough_ends_the_program_quietly(count: int) -> None:
    done = shell(count, "| true" if count == 1 else "| head -n 1")
    assert done.stderr in (b"", "note: µ\n".encode()) and (count == 1 or done.returncode == 1)


def test_a_full_disk_is_said_in_one_line() -> None:
    for count in (1, 20_000):
        done = shell(count, "> /dev/full")
        assert done.returncode == 2
        (line,) = [line for line in done.stderr.decode().splitlines() if not line.startswith("note")]
        assert line == "rwjax: stdout: cannot be written: No space left on device; write to another place"


def test_a_stream_is_let_go_without_a_descriptor_more(tmp_path: Path) -> None:
    forget(None)
    with (tmp_path / "out").open("w") as stream:
        stream.write("lost")
        before = os.listdir("/proc/self/fd")
        forget(stream)
        assert os.listdir("/proc/self/fd") == before
    assert (tmp_path / "out").read_text() == ""


def test_closed_streams_and_poor_encodings_end_no_command() -> None:
    assert (shell(1, ">&- 2>&-").returncode, shell(1, "2> /dev/full").returncode) == (0, 0)
    poor = shell(1, "", PYTHONIOENCODING="ascii")
    assert (poor.returncode, poor.stdout, poor.stderr) == (
        0,
        b"0 \\xb5 \\xb1\n" + 'name = "µ"\n'.encode(),
        b"note: \\xb5\n",
    )


def test_every_command_prints_by_this_module() -> None:
    """Else names reach the terminal as they are, and a full disk or a closed pipe ends in a traceback."""
    room = Path(rwjax.cli.__file__).parent
    printing = {
        path.name
        for path in room.glob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
    }
    assert printing - {"interrupt.py"} == {"terminal.py"}  # whose one line holds no name


def test_many_names_are_counted() -> None:
    names = [f"{k:03d}.csv" for k in range(200)]
    assert listed(names[:2]) == "000.csv, 001.csv" and listed(names) == "200 logs, 000.csv to 199.csv"


def test_the_next_command_is_one_that_a_shell_takes_and_keeps_what_was_asked_for() -> None:
    words = shlex.split(
        next_command("fit", Path("my rig.toml"), "a.csv", segments=2.5, force=True).removeprefix("next: ")
    )
    assert words == ["rwjax", "fit", "my rig.toml", "a.csv", "--segments", "2.5", "--force"]
