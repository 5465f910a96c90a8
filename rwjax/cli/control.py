"""What the commands for control share: options, what is read off them, and how tables, figures and notes are given back."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import axis, finite, keep_input, of_file, positive
from rwjax.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure

    from rwjax.control.controller import LoopTiming
    from rwjax.control.fit_estimate import FitEstimate
    from rwjax.rig.model import Rig

Kp = Annotated[str, typer.Option(metavar="FROM:TO:COUNT", help="proportional gains [V/rad]")]
Kd = Annotated[str, typer.Option(metavar="FROM:TO:COUNT", help="derivative gains [V s/rad]")]
Sigma = Annotated[float, typer.Option(help="every pole left of minus this [1/s]")]
Late = Annotated[float, typer.Option(help="time from a reading to its command [s]; the rig's own delays come on top")]
Smooth = Annotated[float, typer.Option(help="time constant of the derivative's filter [s]")]
Volts = Annotated[float, typer.Option(help="largest command [V]")]
Rpm = Annotated[float, typer.Option(help="largest rate of the wheel [1/min]")]
FitFile = Annotated[
    Path | None,
    typer.Option(
        "--fit", metavar="FIT.json", help="what `rwjax fit RIG LOG… --json` printed for this rig; its values count"
    ),
]
Plants = Annotated[int, typer.Option(min=1, max=100_000, help="plants drawn from the fit")]
Output = Annotated[Path | None, typer.Option("-o", metavar="CSV", help="stdout without it; a figure beside it")]

PAIRS = 1_000_000


def pairs(example: str = "0:100:101", **options: str) -> "tuple[np.ndarray, np.ndarray]":
    """The values of two options, at most `PAIRS` of both."""
    first, second = (axis(f"--{name}", text, example) for name, text in options.items())
    if len(first) * len(second) > PAIRS:
        given = " ".join(f"--{name} {text}" for name, text in options.items())
        raise InputError(f"{given}: {len(first) * len(second)} pairs are more than {PAIRS}; take fewer")
    return first, second


def timing_of(rig: "Rig", period: float, late: float, smooth: float) -> "LoopTiming":
    """What a controller's options say of its time and of the encoder that it reads."""
    from rwjax.control.controller import loop_timing

    finite(period=period, late=late, smooth=smooth)
    positive(period=period)
    if not 0.0 <= late <= period:
        raise InputError(
            f"--late {late:g}: has to lie between 0 and the period of {period:g} s; a longer delay of the command or the encoder belongs "
            "into the rig file, as effect drive.delay or sensor.delay"
        )
    if smooth < 0.0:
        raise InputError("--smooth: must not be negative")
    return loop_timing(rig, period, late)


def with_fit(path: Path, rig: "Rig", fit: Path | None) -> "tuple[Rig, FitEstimate | None, list[str]]":
    """The rig with a fit's estimates, what the fit says of them, and lines where it says other than the rig file."""
    from rwjax.control.fit_estimate import read_fit_estimate, with_fit_estimate

    if fit is None:
        return rig, None, []
    spread = read_fit_estimate(fit, rig)
    with of_file(path):
        found = with_fit_estimate(rig, spread)
    compared = [(name, f"{found.values[name]:.6g}", f"{rig.values[name]:.6g}") for name in spread.names]
    other = [f"{name} {new} (not {old})" for name, new, old in compared if new != old]
    said = [f"taken from {fit} where {path} says otherwise: {', '.join(other)}"] if other else []
    if spread.per_run:
        said.append(
            f"of {', '.join(spread.per_run)} every run has a value of its own: their mean counts, and their scatter in what is drawn"
        )
    return found, spread, said


def own_delay(rig: "Rig") -> list[str]:
    """A line on the rig's own delays, if it has any, in a loop."""
    from rwjax.control.delays import delays_of

    late = delays_of(rig)
    if late.loop[0] == 0.0:
        return []
    return [f"the rig's own delays are in the loop: commands {late.commands[0]:g} s, readings {late.readings[0]:g} s"]


def write(
    inputs: tuple[Path, ...],
    output: Path | None,
    text: str,
    figure: "Callable[[], Figure]",
    answer: dict,
    as_json: bool,
) -> list[str]:
    """The table to a file, with the figure beside it, or to stdout; the answer there if wanted. A device gets the table alone.
    Returns a line on what was written."""
    from rwjax.report.control import write_png
    from rwjax.text_files import write_text

    written = []
    if output is not None:
        if output.suffix.lower() == ".png":
            raise InputError(
                f"-o {output}: is the table's path, the figure is written beside it; take one that ends with .csv"
            )
        keep_input(output, *inputs)
        write_text(output, text, InputError)
        if output.is_file():
            keep_input(output.with_suffix(".png"), *inputs)
            write_png(figure(), output.with_suffix(".png"))
            written.append(f"written to {output}, the figure to {output.with_suffix('.png')}")
    if as_json:
        print(json.dumps(answer, allow_nan=False))
    elif output is None:
        print(text, end="")
    return written


def plain(values: "np.ndarray") -> list | float | None:
    """Nested lists, or one number; None for what is not finite."""
    import numpy as np

    found = np.array(values, object)
    found[~np.isfinite(values)] = None
    return found.tolist()


def say(quiet: bool, *lines: str) -> None:
    """Notes, on stderr."""
    if not quiet:
        print("\n".join(lines), file=sys.stderr)
