"""The options that choose the solver: `--solver exact|diffrax` and `--smooth WIDTH`."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import finite, positive
from rwjax.errors import InputError

if TYPE_CHECKING:
    from rwjax.simulation.solver import Solver


class SolverName(StrEnum):
    """Ways to simulate a rig."""

    EXACT = "exact"
    DIFFRAX = "diffrax"


SolverOption = Annotated[
    SolverName,
    typer.Option("--solver", help="exact: friction holds a resting body; diffrax: friction with a smooth sign"),
]
Width = Annotated[
    float | None,
    typer.Option(
        "--smooth",
        metavar="WIDTH",
        help="width of the smooth sign [rad/s], with --solver diffrax",
        show_default="what the readings can hardly show",
    ),
]


def solver_of(name: SolverName, width: float | None) -> "Solver":
    """The solver that the options choose.

    Args:
        name: the solver.
        width: width of its smooth sign [rad/s], None where the user leaves that open.

    Returns:
        The solver.

    Raises:
        InputError: a width that is no positive number, or one for the exact solver, which has none.
    """
    if name is SolverName.EXACT:
        from rwjax.simulation.exact import EXACT

        if width is not None:
            raise InputError(
                f"--smooth {width:g}: is of the smooth solver; give --solver diffrax with it, or leave it out"
            )
        return EXACT
    from rwjax.simulation.smooth import Smooth

    if width is not None:
        finite(smooth=width)
        positive(smooth=width)
    return Smooth(width)
