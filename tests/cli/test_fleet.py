"""`rwjax fleet`, as a user calls it."""

import json
from pathlib import Path

import pytest

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
