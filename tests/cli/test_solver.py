"""The options that choose the solver."""

import pytest

from rwjax.cli.solver import SolverName, solver_of
from rwjax.errors import InputError
from rwjax.simulation.exact import EXACT
from rwjax.simulation.smooth import Smooth
from tests.cli.shell import Shell


def test_each_name_is_its_solver() -> None:
    assert solver_of(SolverName.EXACT, None) is EXACT
    assert solver_of(SolverName.DIFFRAX, None) == Smooth() and solver_of(SolverName.DIFFRAX, 0.02) == Smooth(0.02)
    assert {SolverName.EXACT: EXACT.name, SolverName.DIFFRAX: Smooth.name} == {n: n.value for n in SolverName}


@pytest.mark.parametrize("width", [-0.01, 0.0, float("nan"), float("inf")])
def test_a_width_has_to_be_positive(width: float) -> None:
    with pytest.raises(InputError, match=f"^--smooth {width:g}: has to be "):
        solver_of(SolverName.DIFFRAX, width)


@pytest.mark.parametrize(
    ("options", "wrong"),
    [
        (
            ["--smooth", "0.01"],
            "--smooth 0.01: is of the smooth solver; give --solver diffrax with it, or leave it out",
        ),
        (["--solver", "diffrax", "--smooth", "-1"], "--smooth -1: has to be positive"),
        (["--solver", "diffrax", "--smooth", "nan"], "--smooth nan: has to be a finite number"),
        (
            ["--solver", "diffrax", "--method", "two-stage"],
            "--solver and --smooth: the method two-stage simulates nothing; leave them out",
        ),
    ],
)
def test_wrong_options_are_one_line(shell: Shell, options: list[str], wrong: str) -> None:
    code, out, err = shell("fit", "rig.toml", "log.csv", *options)
    assert (code, out) == (2, "") and err.endswith(f"{wrong}\n") and err.count("\n") == 1, err
