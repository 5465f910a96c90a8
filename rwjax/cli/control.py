"""What the commands for control share: options, what is read off them, and how tables, figures and notes are given back."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rwjax.cli.options import axis, check_file, finite, of_file, positive
from rwjax.cli.terminal import document, tell
from rwjax.errors import InputError
from rwjax.report.answer import json_text

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
Plants = Annotated[
    int | None,
    typer.Option(
        min=1, max=100_000, help="plants drawn from --fit; by default 1000 of region, 200 of tune", show_default=False
    ),
]
Output = Annotated[Path | None, typer.Option("-o", metavar="CSV", help="stdout without it; a figure beside it")]

MOST_PAIRS = 1_000_000


def pairs(example: str = "0:100:101", **options: str) -> "tuple[np.ndarray, np.ndarray]":
    """The values of two options, at most `MOST_PAIRS` pairs of them.

    Args:
        example: what an error message shows as right.
        options: both options' text by their names, each `FROM:TO:COUNT`.

    Returns:
        The values of each [unit of the option], shapes `(p,)` and `(d,)`.

    Raises:
        InputError: a text is not as it should be, or the pairs are too many.
    """
    first, second = (axis(f"--{name}", text, example) for name, text in options.items())
    if len(first) * len(second) > MOST_PAIRS:
        given = " ".join(f"--{name} {text}" for name, text in options.items())
        raise InputError(f"{given}: {len(first) * len(second)} pairs are more than {MOST_PAIRS}; take fewer")
    return first, second


def on_edge(given: dict[str, str], ranges: "Sequence[np.ndarray]", best: "Sequence[int]") -> list[str]:
    """Lines on what was found best and lies on an edge of its range.

    Args:
        given: text of each range by its option's name, as `pairs` takes it.
        ranges: their values [unit of the option], in the same order.
        best: index of what was found best in each of them.

    Returns:
        A line for each range to widen. The edge at 0 has nothing beyond it, nor has a range of one value an edge.
    """
    return [
        f"it lies on the edge of --{name} {text}: widen that range"
        for (name, text), values, k in zip(given.items(), ranges, best, strict=True)
        if len(values) > 1 and values[k] > 0.0 and values[k] in (values.min(), values.max())
    ]


def timing_of(rig: "Rig", period: float, late: float, smooth: float) -> "LoopTiming":
    """What a controller's options say of its time, and of the encoder that it reads.

    Args:
        rig: the rig that it drives.
        period: sample time [s].
        late: time from a reading to its command [s].
        smooth: time constant of the derivative's filter [s].

    Returns:
        The timing of the sampled loop.

    Raises:
        InputError: an option is out of its range.
    """
    from rwjax.control.controller import loop_timing

    finite(period=period, late=late, smooth=smooth)
    positive(period=period)
    if not 0.0 <= late <= period:
        raise InputError(
            f"--late {late:g}: has to lie between 0 and the period of {period:g} s; a longer delay of the command or the encoder belongs "
            f"into the rig file, as effect {' or '.join(_delays())}"
        )
    if smooth < 0.0:
        raise InputError("--smooth: must not be negative")
    return loop_timing(rig, period, late)


def _delays() -> list[str]:
    """Names of the effects that delay the command or a reading."""
    from rwjax.effects.library import EFFECTS
    from rwjax.effects.ports import CommandDelay, EncoderDelay

    return [effect.name for effect in EFFECTS if issubclass(effect, CommandDelay | EncoderDelay)]


def with_fit(
    path: Path, rig: "Rig", fit: Path | None, plants: int | None = None
) -> "tuple[Rig, FitEstimate | None, list[str]]":
    """The rig with the estimates of a fit, if the user gave one.

    Args:
        path: the rig's file, for messages.
        rig: the rig as its file says.
        fit: what `rwjax fit --json` printed.
        plants: how many plants the user wants drawn from it, None where that is left open [1].

    Returns:
        The rig, the estimates with their covariance, and lines where the fit says other than the rig file.

    Raises:
        InputError: the fit cannot be read, or is not of this rig; plants are wanted without a fit.
    """
    from rwjax.control.fit_estimate import read_fit_estimate, with_fit_estimate

    if fit is None:
        if plants is not None:
            raise InputError(
                f"--plants {plants}: are drawn from a fit; give it with --fit FIT.json, or leave --plants out"
            )
        return rig, None, []
    estimate = read_fit_estimate(fit, rig)
    with of_file(path):
        found = with_fit_estimate(rig, estimate)
    compared = [(name, f"{found.values[name]:.6g}", f"{rig.values[name]:.6g}") for name in estimate.names]
    other = [f"{name} {new} (not {old})" for name, new, old in compared if new != old]
    lines = [f"taken from {fit} where {path} says otherwise: {', '.join(other)}"] if other else []
    if estimate.per_run:
        lines.append(
            f"of {', '.join(estimate.per_run)} every run has a value of its own: their mean counts, and their scatter in what is drawn"
        )
    return found, estimate, lines


def own_delay(rig: "Rig") -> list[str]:
    """A line on the rig's own delays in a loop.

    Args:
        rig: the rig.

    Returns:
        The line, or nothing where it has none.
    """
    from rwjax.control.delays import delays_of

    delays = delays_of(rig)
    if delays.loop[0] == 0.0:
        return []
    return [
        f"the rig's own delays are in the loop: commands {delays.commands[0]:g} s, readings {delays.readings[0]:g} s"
    ]


def check_table(output: Path | None, *inputs: Path | None) -> None:
    """Checks the path of a table, and that of the figure beside it, before the work for them begins.

    Args:
        output: the table's path; stdout without it.
        inputs: files that are read, which are not written over; None for one that the user did not give.

    Raises:
        InputError: a file cannot be written, or is one of the inputs.
    """
    if output is None:
        return
    if output.suffix.lower() == ".png":
        raise InputError(
            f"-o {output}: is the table's path, the figure is written beside it; take one that ends with .csv"
        )
    read = [path for path in inputs if path is not None]
    check_file(output, *read)
    if _has_figure(output):
        check_file(output.with_suffix(".png"), *read)


def _has_figure(output: Path) -> bool:
    """Whether a figure is written beside a table: a device, such as /dev/null, gets the table alone."""
    return output.is_file() or not output.exists()


def write_results(
    output: Path | None,
    table: str,
    figure: "Callable[[], Figure]",
    answer: dict,
    as_json: bool,
) -> list[str]:
    """Writes a table, and the figure beside it, to files; or prints the table or the answer.

    Args:
        output: the table's path; stdout without it. A device, such as /dev/null, gets the table alone.
        table: the table as text.
        figure: draws the figure.
        answer: the result as JSON holds it.
        as_json: whether the answer is printed.

    Returns:
        A line on what was written, or nothing.

    Raises:
        InputError: a file cannot be written, or the answer holds a number that is not finite.
    """
    from rwjax.report.png import png_of
    from rwjax.text_files import write_files

    text, written = json_text(answer), []
    if output is not None:
        contents, image = {str(output): table.encode()}, output.with_suffix(".png")
        if _has_figure(output):
            contents[str(image)] = png_of(figure())
            written.append(f"written to {output}, the figure to {image}")
        write_files(contents, InputError)
    if as_json:
        document(text + "\n")
    elif output is None:
        document(table)
    return written


def finite_json(values: "np.ndarray") -> list | float | None:
    """Numbers as JSON holds them.

    Args:
        values: numbers of any shape [any unit].

    Returns:
        Nested lists, or one number, in the same unit [any unit]; None for what is not finite.
    """
    import numpy as np

    found = np.array(values, object)
    found[~np.isfinite(values)] = None
    return found.tolist()


def remark(quiet: bool, *lines: str) -> None:
    """Prints notes on stderr.

    Args:
        quiet: whether the user wants none.
        lines: the notes.
    """
    if not quiet:
        tell(*lines)
