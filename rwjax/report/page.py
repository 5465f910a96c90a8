"""What every HTML page of this program shares: its template's environment, numbers in words, and figures inside it."""

import io
import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files
from typing import Any

import jinja2
from markupsafe import Markup, escape
from matplotlib import rc_context
from matplotlib.figure import Figure

from rwjax.errors import printable_lines
from rwjax.report.style import any_letters

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "rwjax",  # names inside the SVG are the same in every run
}


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


def code(text: str) -> Markup:
    """A text in which what stands between backticks is set as code.

    Args:
        text: the text.

    Returns:
        The same as HTML.
    """
    parts = [escape(part) for part in printable_lines(text).split("`")]
    if len(parts) % 2 == 0:  # a backtick of its own
        return escape(printable_lines(text))
    return Markup("").join(Markup("<code>{}</code>").format(part) if k % 2 else part for k, part in enumerate(parts))


def _part(name: str) -> Markup:
    """A style sheet or script of this package, as it stands on the page."""
    return Markup((files("rwjax.report") / name).read_text(encoding="utf-8"))


def _shown(value: Any) -> Any:
    """What the page shows of a value: no control characters, which HTML has none of."""
    return printable_lines(value) if isinstance(value, str) and not isinstance(value, Markup) else value


@contextmanager
def drawing(size: tuple[float, float]) -> Iterator[Figure]:
    """A figure in the style of the pages.

    Args:
        size: its width and height [inch].

    Yields:
        The figure.
    """
    with rc_context(STYLE), any_letters():
        yield Figure(figsize=size, layout="constrained")


def svg_of(figure: Figure, name: str) -> str:
    """A figure as it stands on a page.

    Args:
        figure: the figure, inside `drawing`.
        name: its name on the page; its ids begin with that, so that no other figure has them.

    Returns:
        All of its SVG behind the name of the first tag, so that a template can give that further attributes.
    """
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    svg = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", text.getvalue())
    return svg[svg.index("<svg") + len("<svg") :]


def rendered_page(template: str, words: Mapping[str, Callable[..., Any]], **values: Any) -> str:
    """A page.

    Args:
        template: name of its template in this package.
        words: filters of this page alone, by name; `short`, `percent`, `signed`, `by_chance` and `code` are those of every page.
        values: what it shows, by name.

    Returns:
        The HTML text.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("rwjax", "report"),
        autoescape=jinja2.select_autoescape(["j2"], default=True),
        finalize=_shown,
    )
    shared = {"short": short, "percent": percent, "signed": signed, "by_chance": by_chance, "code": code}
    environment.filters |= {**shared, **words}
    return environment.get_template(template).render(part=_part, **values)
