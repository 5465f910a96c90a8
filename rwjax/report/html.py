"""The report of a diagnosis: one HTML file that needs nothing beside it, and its figures as files."""

import io
import math
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rwjax.diagnosis.result import Diagnosis
from rwjax.diagnosis.words import UNIT, left_words, where_words
from rwjax.effects.library import unit_of_number
from rwjax.errors import InputError, printable_lines
from rwjax.report import plots
from rwjax.report.motions import motions
from rwjax.report.png import write_png
from rwjax.report.style import any_letters
from rwjax.rig.write import write_rig
from rwjax.text_files import write_text

REPORT = "report.html"
"""Name of the page."""
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
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "rwjax",  # names inside the SVG are the same in every run
}


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
    chosen["ranking"] = (plots.plot_ranking, (9.0, 2.8))
    return chosen


def _draw(d: Diagnosis, plot: Plot, size: tuple[float, float], png: Path) -> str:
    """SVG of a plot, all behind the name of its first tag; saved as PNG besides."""
    with rc_context(STYLE), any_letters():
        figure = Figure(figsize=size, layout="constrained")
        plot(d, figure.subplots())
        write_png(figure, png)
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None})
    svg = text.getvalue()
    return svg[svg.index("<svg") + len("<svg") :]


def short(value: float | None) -> str:
    """A number with four significant digits.

    Args:
        value: the number, in the unit of its column [any]; None where there is none.

    Returns:
        Its digits, or a dash for what is no finite number.
    """
    return "–" if value is None or not math.isfinite(value) else f"{value:.4g}"


def percent(value: float | None) -> str:
    """A share in percent, with one decimal.

    Args:
        value: the share [1]; None where there is none.

    Returns:
        Such as `12.5 %`, or a dash for what is no finite number.
    """
    return "–" if value is None or not math.isfinite(value) else f"{100.0 * value:.1f} %"


def signed(value: float) -> str:
    """A shift with its sign, with one decimal.

    Args:
        value: the shift, in the unit of its column [any].

    Returns:
        Such as `+1.5`, or a dash for what is no finite number.
    """
    return f"{value:+.1f}" if math.isfinite(value) else "–"


def by_chance(p: float) -> str:
    """How often chance alone gives as much, in words.

    Args:
        p: the probability [1].

    Returns:
        Such as `about 1 in 20`; `often` from one in three on, `less than 1 in 1000` below it.
    """
    if not math.isfinite(p):
        return "–"
    if p >= 1.0 / 3.0:
        return "often"
    return f"about 1 in {1.0 / p:.0f}" if p >= 1e-3 else "less than 1 in 1000"


def _part(name: str) -> Markup:
    """A style sheet or script of this package, as it stands on the page."""
    return Markup((files("rwjax.report") / name).read_text(encoding="utf-8"))


def _shown(value: Any) -> Any:
    """What the page shows of a value: no control characters, which HTML has none of."""
    return printable_lines(value) if isinstance(value, str) and not isinstance(value, Markup) else value


def write_report(d: Diagnosis, folder: Path) -> Path:
    """Writes `report.html` and its figures as PNG.

    Args:
        d: the diagnosis.
        folder: folder of the results, which exists.

    Returns:
        Path of the report.

    Raises:
        InputError: the report cannot be written.
    """
    drawn = {name: _draw(d, plot, size, folder / f"{name}.png") for name, (plot, size) in figures_of(d).items()}
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("rwjax", "report"),
        autoescape=jinja2.select_autoescape(["j2"], default=True),
        finalize=_shown,
    )
    environment.filters |= {
        "short": short,
        "percent": percent,
        "signed": signed,
        "by_chance": by_chance,
        "unit_of_number": unit_of_number,
        "where_words": partial(where_words, limits=d.settings.report),
        "left_words": lambda left: left_words(left.share, left.where, left.windows, d.settings.report),
    }
    page = environment.get_template("report.html.j2").render(
        d=d,
        sentence=d.sentence,
        figures=drawn,
        shows=FIGURES,
        unit=UNIT,
        corrected=write_rig(d.corrected),
        motions=motions(d),
        part=_part,
    )
    path = folder / REPORT
    write_text(path, page, InputError)
    return path
