"""`rwjax compare`, as a user calls it; the comparison itself is tested where it is made."""

import json
from types import SimpleNamespace

import pytest

from rwjax.errors import RigError
from tests.cli.shell import LOGS, Shell
from tests.systems import platform


class Result:
    """A comparison, of which the command takes only this."""

    rows = (SimpleNamespace(rig=platform(), notes=()),)

    def __str__(self) -> str:
        return "a table"

    def json(self) -> dict:
        return {"schema": "rwjax.comparison/1"}


@pytest.fixture
def compared(shell: Shell) -> Shell:
    shell.patch.setattr("rwjax.methods.comparison.compare", lambda rig, logs, progress, solver: Result())
    shell.patch.setattr("rwjax.report.comparison.write_figure", lambda result, path: path)
    return shell


def test_every_result_is_a_file(compared: Shell) -> None:
    assert compared("compare", "rig.toml", *LOGS[:2], "-o", "out") == (0, "a table\nfigure: out/comparison.png\n", "")
    answer = (compared.folder / "out" / "comparison.json").read_text()
    assert json.loads(answer) == {"schema": "rwjax.comparison/1"}
    assert (compared.folder / "out" / "comparison.txt").read_text() == "a table\n"
    assert compared("compare", "rig.toml", *LOGS[:2], "-o", "out", "--json") == (0, answer, "")


def test_what_the_rig_lacks_is_said_with_its_file(compared: Shell) -> None:
    def refuse(*given: object, **more: object) -> None:
        raise RigError("nothing to fit")

    compared.patch.setattr("rwjax.methods.comparison.compare", refuse)
    assert compared("compare", "rig.toml", *LOGS[:2], "-o", "out") == (2, "", "rwjax: rig.toml: nothing to fit\n")
    assert not (compared.folder / "out").exists()
