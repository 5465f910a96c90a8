"""The report of a diagnosis: one HTML file that needs nothing beside it, and its figures as files."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import isfinite
from pathlib import Path

from matplotlib.axes import Axes

from rwjax.diagnosis.result import Diagnosis
from rwjax.diagnosis.words import UNIT, left_words, where_words, without_error
from rwjax.errors import InputError, counted, printable
from rwjax.logs.segments import runs_of
from rwjax.report import plots
from rwjax.report.motions import motions
from rwjax.report.page import drawing, rendered_page, short, svg_of
from rwjax.report.png import write_png
from rwjax.rig.number_unit import unit_in_rig
from rwjax.rig.write import write_rig
from rwjax.text_files import write_text

REPORT = "report.html"
"""Name of the page."""
GENERATOR = "rwjax diagnosis"
"""What wrote the page, as its head says: a file without that is none, and is never replaced."""
BEGIN, TITLE = b"<!doctype html>", b"<title>rwjax: "
"""How a page and its title begin; the only mark of pages that earlier versions wrote."""
HEAD = 500
"""Bytes in which a page says what wrote it."""
FIGURES = {
    "motion": "The measured motion of the held-out run that is followed worst, and the simulated one.",
    "waterfall": "Error on held-out runs after each effect is added; the floor is what a perfect model would still leave.",
    "runs": "Error of free runs on the runs that took no part in fit or choice.",
    "missing": "What the rig as it is cannot account for in the smoothed motion, at its own fitted numbers. The cause may have bent these: "
    "a slope here need not be friction.",
    "shares": "What the best law in each coordinate removes.",
    "ranking": "Share of the evidence of each candidate.",
}
"""What each figure that a diagnosis may have shows, by its name; each is a PNG file, too."""
Plot = Callable[[Diagnosis, Axes], Axes]


def figures_of(d: Diagnosis) -> dict[str, tuple[Plot, tuple[float, float]]]:
    """The figures that a diagnosis has, in their order on the page.

    Args:
        d: the diagnosis.

    Returns:
        By name of the figure: the function that draws it, and its width and height [inch].
    """
    chosen: dict[str, tuple[Plot, tuple[float, float]]] = {"motion": (plots.plot_motion, (9.0, 3.2))}
    if len(d.waterfall) > 1:
        chosen["waterfall"] = (plots.plot_waterfall, (9.0, 1.2 + 0.45 * len(d.waterfall)))
    chosen["runs"] = (plots.plot_runs, (9.0, 3.2))
    if d.where is not None and d.verdict != "none":
        if d.where.drawn is not None:
            chosen["missing"] = (plots.plot_missing, (9.0, 3.6))
        chosen["shares"] = (plots.plot_shares, (9.0, 2.4))
    if len(d.ranking) > 1:
        chosen["ranking"] = (plots.plot_ranking, (9.0, 2.8))
    return chosen


def _draw(d: Diagnosis, plot: Plot, size: tuple[float, float], png: Path) -> str:
    """SVG of a plot, saved as PNG besides."""
    with drawing(size) as figure:
        plot(d, figure.subplots())
        write_png(figure, png)
        return svg_of(figure, png.stem)


def corrected_text(d: Diagnosis) -> str:
    """The corrected rig file, with what is not sure of it in its first lines.

    Args:
        d: the diagnosis.

    Returns:
        The text.
    """
    return write_rig(replace(d.corrected, cautions=tuple(dict.fromkeys([*d.rig.cautions, *_cautions(d)]))))


def _cautions(d: Diagnosis) -> tuple[str, ...]:
    """What is not sure of a corrected rig of which nothing is claimed, or which is one of several."""
    if d.verdict == "unknown":
        return (f"not claimed: {printable(d.sentence)}",)
    if d.alternatives:
        others = "; or ".join(" + ".join(names) for names in d.alternatives)
        part = " of a part" if d.verdict == "partial" else ""
        return (f"this is one explanation{part} of several: {' + '.join(d.effects)}; or {others}",)
    return ()


def check_page(folder: Path) -> None:
    """Refuses a folder whose `report.html` is no page of a diagnosis: it would be replaced.

    Args:
        folder: folder of the results; it may hold none.

    Raises:
        InputError: for such a file.
    """
    path = folder / REPORT
    if path.is_file() and not is_page(path):
        raise InputError(
            f"{path}: is no page that rwjax wrote, and would be replaced; move that file, or give another folder"
        )


def is_page(path: Path) -> bool:
    """Whether a file is the page of a diagnosis.

    Args:
        path: the file.

    Returns:
        False where there is none that can be read, and for any other file.
    """
    try:
        with path.open("rb") as file:
            head = file.read(HEAD)
    except OSError:
        return False
    return head.startswith(BEGIN) and (
        f'<meta name="generator" content="{GENERATOR}">'.encode() in head or TITLE in head
    )


def too_tight(d: Diagnosis) -> str:
    """What to know of the ± beside a diagnosis's numbers.

    Args:
        d: the diagnosis.

    Returns:
        The sentence, without its end; "" where there is nothing to know.
    """
    if d.verdict != "partial":
        return ""
    return "the ± of its numbers are too tight: under `partial` the model is known to lack something more"


def write_report(d: Diagnosis, folder: Path) -> Path:
    """Writes `report.html` and its figures as PNG.

    Args:
        d: the diagnosis.
        folder: folder of the results, which exists.

    Returns:
        Path of the report.

    Raises:
        InputError: the report cannot be written, or would replace a file that is no such page.
    """
    check_page(folder)
    drawn = {name: _draw(d, plot, size, folder / f"{name}.png") for name, (plot, size) in figures_of(d).items()}
    words = {
        "unit_in_rig": partial(unit_in_rig, d.rig),
        "where_words": partial(where_words, limits=d.settings.report),
        "with_error": _with_error,
        "left_words": lambda left: left_words(left.share, left.where, left.windows, d.settings.report),
    }
    page = rendered_page(
        "report.html.j2",
        words,
        generator=GENERATOR,
        too_tight=too_tight(d).replace("the ± of its numbers", "The ± below"),
        d=d,
        figures=drawn,
        shows=FIGURES,
        unit=UNIT,
        corrected=corrected_text(d),
        runs=counted(len({*runs_of(d.logs).tolist()}), "run"),
        motions=motions(d),
    )
    path = folder / REPORT
    write_text(path, page, InputError)
    return path


def _with_error(pair: tuple[float, float], name: str) -> str:
    """An estimate of what was added, with its standard error, or with why it has none."""
    value, error = pair
    return f"{short(value)} ± {short(error)}" if isfinite(error) else f"{short(value)} ({without_error(name, value)})"
