"""`rwjax fleet`, as a user calls it."""

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from rwjax.cli import interrupt
from rwjax.cli.fleet import STOPPING
from rwjax.cli.main import main
from tests.cli.shell import Shell, program
from tests.fleet.small import write_small

pytest.importorskip("distributed", reason="a fleet needs the extra `fleet`")


@pytest.mark.slow
def test_a_fleet_is_fitted_and_its_page_written(tmp_path: Path) -> None:
    write_small(tmp_path)
    done = program("fleet", "fleet.toml", "-o", "out", "--workers", "1", "--json", "--quiet", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert (answer["schema"], answer["jobs"], answer["failed"], answer["compared"]) == ("rwjax.fleet/1", 3, [], 0)
    assert (tmp_path / "out" / "fleet.html").exists() and (tmp_path / answer["results"]).exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("no.toml",), "no.toml: cannot be read"),
        (("fleet.toml", "--scheduler", "tcp://a:1", "--workers", "2"), "--workers and --memory: a cluster that runs"),
        (("fleet.toml", "--false-alarms", "2"), "--false-alarms 2: is a share"),
    ],
)
def test_what_is_wrong_is_one_line(arguments: tuple[str, ...], said: str, shell: Shell) -> None:
    write_small(shell.folder, ("a",))
    status, _, err = shell("fleet", *arguments, "--quiet")
    assert status == 2 and said in err and err.count("\n") == 1


@pytest.fixture
def own_handler() -> Iterator[None]:
    """The command's handler of Ctrl-C, within a test."""
    before = signal.signal(signal.SIGINT, interrupt.heard)
    yield
    signal.signal(signal.SIGINT, before)


class Left(Exception):
    """The end of the process."""


@pytest.mark.usefixtures("own_handler")
def test_the_first_ctrl_c_is_answered_at_once_and_the_next_ones_do_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    write_small(tmp_path, ("a",))
    said: list[str] = []

    def interrupted(*given: object, **more: object) -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            said.append(capfd.readouterr().err)
            signal.raise_signal(signal.SIGINT)  # while the cluster closes

    def leave() -> None:
        raise Left

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("rwjax.fleet.run.run", interrupted)
    monkeypatch.setattr(interrupt, "leave", leave)
    monkeypatch.setattr("sys.argv", ["rwjax", "fleet", "fleet.toml", "-o", "out", "--quiet"])
    with pytest.raises(Left):
        main()
    assert said == [f"{STOPPING}\n"] and signal.getsignal(signal.SIGINT) is interrupt.heard
    assert capfd.readouterr().err == "note: out holds what is done; the same command goes on from there\n"
