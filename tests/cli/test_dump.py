"""`rwjax dump`, as a user calls it."""

import json

import pytest

from tests.cli.shell import Shell


@pytest.mark.slow
def test_dump_writes_its_course(shell: Shell) -> None:
    shell.patch.setattr("rwjax.cli.progress.EVERY_S", 0.01)
    code, out, err = shell("dump", "rig.toml", "--spin", "4000", "--json", "-o", "dump.csv")
    assert code == 0, err
    answer = json.loads(out)
    assert answer["bound_s"] < answer["least_time_s"] < 1.1 * answer["bound_s"] and answer["moved_deg"] < 1e-3
    steps, _, rest = err.partition("the wheel stands after ")
    assert (shell.folder / "dump.png").exists() and rest.startswith(f"{answer['least_time_s']:.3f} s; ")
    assert steps.splitlines()[-1].startswith("looking for the least time: search ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("dump", "--spin", "0"), "--spin 0 1/min (0 rad/s): has to be a number other than 0"),
        (("dump", "--spin", "100", "--margin", "1.5"), "--margin 1.5: has to lie above 0 and not above 1"),
    ],
)
def test_bad_input_ends_in_one_line(shell: Shell, arguments: tuple[str, ...], message: str) -> None:
    command, *options = arguments
    code, out, err = shell(command, "rig.toml", *options)
    assert code == 2 and out == "" and err.startswith(f"rwjax: {message}") and err.count("\n") == 1
