"""The page of a fleet: what came out, which rigs changed, numbers over rigs and over sessions, and what failed."""

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from matplotlib.axes import Axes

from rwjax.diagnosis.verdict import CLAIMS
from rwjax.effects.library import unit_of_number
from rwjax.errors import InputError, counted
from rwjax.fleet.changes import Changes
from rwjax.fleet.pooled import Pooled
from rwjax.fleet.sessions import FEWEST, MISFIT
from rwjax.fleet.work import NOTHING
from rwjax.report.page import drawing, rendered_page, svg_of
from rwjax.report.style import AFTER, BEFORE, FLOOR, drawn_name
from rwjax.text_files import write_text

PAGE = "fleet.html"
"""Name of the page."""
MOST_LINES = 200
"""Lines of a table on the page; the Parquet file holds all."""
MOST_NUMBERS = 12
"""Numbers that are drawn."""
MISSES = 2.0
"""Misfit from which a fit counts as one that misses its readings [1]."""
MOST_POINTS = 3000
"""Rigs that are drawn of a number, besides those that changed."""


class Fleet(NamedTuple):
    """What the page shows.

    Attributes:
        command: What was done for every rig.
        rows: Results (`rwjax.fleet.store.schema`).
        changes: Rigs that changed.
        appeared: Effects that few rigs have (`rwjax.fleet.appeared.appeared`).
        pooled: Numbers of the fleet and of its rigs.
        false: Share of the alarms that may be false [1].
        remarks: What to know of the plan: of numbers that rigs are said to share, of rigs without logs; one sentence each.
    """

    command: str
    rows: pl.DataFrame
    changes: Changes
    appeared: pl.DataFrame
    pooled: Pooled
    false: float
    remarks: tuple[str, ...] = ()

    def __str__(self) -> str:
        """The result in lines."""
        lines = [self.sentence, *(f"  {what}: {count}" for what, count in outcomes(self.rows).items())]
        lines += [f"  note: {note}" for note in self.notes]
        for one in self.changes.alarms.head(MOST_LINES).iter_rows(named=True):
            lines.append(f"  {_who(one)} differs from {one['against']}: {change_words(one)}")
        for one in self.changes.lacking.head(MOST_LINES).iter_rows(named=True):
            lines.append(f"  {_who(one)} tells no {one['numbers']}, as most others do")
        for one in self.appeared.head(MOST_LINES).iter_rows(named=True):
            lines.append(f"  {_who(one)} has {one['effect']}, as {one['siblings']} of the {one['of']} rigs")
        for one in failures(self.rows).head(MOST_LINES).iter_rows(named=True):
            lines.append(f"  {_who(one)} failed: {one['line']}")
        return "\n".join(lines)

    @property
    def sentence(self) -> str:
        """The result as one sentence."""
        rigs, failed = self.rows["rig"].n_unique(), failures(self.rows).height
        whole, jobs = counted(rigs, "rig"), counted(self.rows.height, "job")
        tail = f"; {failed} of {jobs} failed." if failed else "."
        if self.command not in ("fit", "diagnose"):
            return f"{whole}{tail}"
        if not self.changes.rigs:
            return f"{whole}, of which too few tell numbers to be compared: that takes {FEWEST}, as do the fleet's numbers{tail}"
        different = pl.concat([self.changes.alarms["rig"], self.appeared["rig"]]).n_unique()
        left = rigs - len(self.changes.rigs)
        beside = f"; {left} {'was' if left == 1 else 'were'} not compared" if left else ""
        return f"{different} of {whole} differ from their siblings or from themselves{beside}{tail}"

    @property
    def notes(self) -> list[str]:
        """What to know besides, one sentence each."""
        notes = [*self.remarks]
        several = self.rows.filter(status="done").group_by("rig").len().filter(pl.col("len") > 1).height
        if self.changes.rigs and several and not self.changes.earlier:
            have = "has" if several == 1 else "have"
            notes.append(
                f"only {counted(several, 'rig')} {have} two sessions, too few to say what a rig changes by: none was compared with itself"
            )
        misfits = self.rows["misfit"].drop_nulls()
        if (off := misfits.filter(misfits > MISSES).len()) > 0.5 * max(misfits.len(), 1):
            miss = "misses its" if off == 1 else "miss their"
            notes.append(
                f"{off} of {counted(misfits.len(), 'fit')} {miss} readings by more than {MISSES:g} times their noise: the rig file lacks "
                "something that all rigs have, which hides what changed; `rwjax diagnose` one rig, and take its corrected.toml"
            )
        return notes


def change_words(one: dict[str, Any]) -> str:
    """An alarm in words.

    Args:
        one: An alarm (`rwjax.fleet.changes.Changes`).

    Returns:
        The number, those that may be it in its place, and its change with its interval.
    """
    other = f" (or {one['or']})" if one["or"] else ""
    if one["number"] == MISFIT:
        ends = f"{one['from_95']:.3g} to {one['to_95']:.3g}"
        return f"{MISFIT}{other} is {one['change']:.3g} times ({ends}) the expected {one['expected']:.3g}"
    ends = f"{one['from_95']:+.3g} to {one['to_95']:+.3g}"
    share = f" ({100.0 * one['change'] / one['expected']:+.1f} %)" if one["expected"] else ""
    unit = f" {_unit(one['number'])}".rstrip()
    return f"{one['number']}{other} by {one['change']:+.3g}{unit}{share}, 95 %: {ends}; expected {one['expected']:.4g}"


def _unit(number: str) -> str:
    """Unit of a number, "" of one that has none, and of a drive's, which depends on what that is given."""
    try:
        return "" if number.startswith("drive") else unit_of_number(number)
    except KeyError:
        return ""


def _who(one: dict[str, Any]) -> str:
    """A rig with its session."""
    return f"{one['rig']}, {one['when']}" if one["when"] else one["rig"]


def failures(rows: pl.DataFrame) -> pl.DataFrame:
    """The jobs that failed.

    Args:
        rows: Results.

    Returns:
        Their rows.
    """
    return rows.filter(pl.col("status") != "done")


def outcomes(rows: pl.DataFrame) -> dict[str, int]:
    """How often each outcome came.

    Args:
        rows: Results.

    Returns:
        Counts by verdict and first set of effects, of comparisons by the best method, the most frequent first.
    """
    done = rows.filter(pl.col("status") == "done", pl.col("verdict").is_not_null())
    of = Counter(_outcome(*one) for one in done.select("command", "verdict", "effects").iter_rows())
    return dict(of.most_common(MOST_LINES))


def _outcome(command: str, verdict: str, effects: list[str] | None) -> str:
    """The outcome of a job in words."""
    if command == "compare" and verdict != NOTHING:
        return f"best on held-out data: {verdict}"
    return f"{verdict}: {effects[0]}" if effects else verdict


def write_fleet(fleet: Fleet, folder: Path, report: Callable[[dict[str, Any]], str | None]) -> Path:
    """Writes the page.

    Args:
        fleet: What it shows.
        folder: Folder of the results, which exists.
        report: From a row to the path of its report below the folder, None where it has none.

    Returns:
        Path of the page.

    Raises:
        InputError: It cannot be written.
    """
    told = [MISFIT] if fleet.rows["misfit"].is_not_null().any() else []
    drawn = [(name, _drawn(fleet, name)) for name in (*told, *numbers_of(fleet.rows)[:MOST_NUMBERS])]
    page = rendered_page(
        "fleet.html.j2",
        {"report": report, "change_words": change_words},
        fleet=fleet,
        outcomes=outcomes(fleet.rows),
        changed=fleet.changes.alarms.head(MOST_LINES).to_dicts(),
        lacking=fleet.changes.lacking.head(MOST_LINES).to_dicts(),
        appeared=fleet.appeared.head(MOST_LINES).to_dicts(),
        failed=failures(fleet.rows).head(MOST_LINES).to_dicts(),
        missing=something_missing(fleet).to_dicts(),
        numbers=[one | {"unit": _unit(one["number"])} for one in fleet.pooled.fleet.to_dicts()],
        figures=drawn,
        most=MOST_LINES,
    )
    path = folder / PAGE
    write_text(path, page, InputError)
    return path


def something_missing(fleet: Fleet) -> pl.DataFrame:
    """The rows with a verdict that says that something is missing.

    Args:
        fleet: The fleet.

    Returns:
        The first of them, those with the largest gap first.
    """
    named = fleet.rows.filter(pl.col("status") == "done", pl.col("verdict").is_in([*CLAIMS, "unknown"]))
    return named.sort("before", descending=True, nulls_last=True).head(MOST_LINES)


def numbers_of(rows: pl.DataFrame) -> list[str]:
    """Names of the numbers that were estimated.

    Args:
        rows: Results.

    Returns:
        The names, those of most rigs first.
    """
    named = rows.select(pl.col("numbers").list.eval(pl.element().struct.field("name")).alias("name")).explode("name")
    counts = named.drop_nulls()["name"].value_counts(sort=True)
    return counts.sort(["count", "name"], descending=[True, False])["name"].to_list()


def _drawn(fleet: Fleet, name: str) -> str:
    """SVG of a number over rigs, or over sessions."""
    if name == MISFIT:
        one = fleet.rows.select("rig", "when", value=MISFIT, standard_error=pl.lit(0.0)).drop_nulls()
    else:
        whole = fleet.rows.select("rig", "when", "numbers").explode("numbers").unnest("numbers")
        one = whole.filter(pl.col("name") == name)
    alarmed = set(fleet.changes.alarms.filter(number=name)["rig"].to_list())
    with drawing((9.0, 2.2)) as figure:
        ax = figure.subplots()
        if one["when"].n_unique() > 1:
            _over_sessions(ax, one, alarmed)
        else:
            _over_rigs(ax, one, alarmed)
        ax.set_ylabel(drawn_name(f"{name} [{_unit(name)}]" if _unit(name) else name))
        return svg_of(figure, name)


def _over_rigs(ax: Axes, one: pl.DataFrame, alarmed: set[str]) -> None:
    """A number of every rig with two standard errors."""
    at, value, error = np.arange(one.height), one["value"].to_numpy(), one["standard_error"].to_numpy()
    mark = np.array([rig in alarmed for rig in one["rig"]])
    shown = ~mark & (at % (-(-len(at) // MOST_POINTS)) == 0)
    ax.errorbar(at[shown], value[shown], 2.0 * error[shown], fmt=".", ms=3, lw=0.6, color=AFTER)
    ax.errorbar(at[mark], value[mark], 2.0 * error[mark], fmt="o", ms=4, lw=0.8, color=BEFORE)
    for k in np.flatnonzero(mark)[:MOST_NUMBERS]:
        ax.annotate(drawn_name(one["rig"][int(k)]), (at[k], value[k]), (4, 4), textcoords="offset points", fontsize=7)
    ax.set_xlabel("rig, by name")


def _over_sessions(ax: Axes, one: pl.DataFrame, alarmed: set[str]) -> None:
    """The median and the middle 95 % of a number over sessions, and the rigs that changed."""
    whens = sorted(one["when"].unique().to_list())
    at = {when: k for k, when in enumerate(whens)}
    low, middle, high = np.array(
        [np.percentile(one.filter(when=w)["value"].to_numpy(), [2.5, 50, 97.5]) for w in whens]
    ).T
    ax.fill_between(range(len(whens)), low, high, color=FLOOR, alpha=0.3, lw=0)
    ax.plot(range(len(whens)), middle, color=AFTER, lw=1.4)
    for rig in sorted(alarmed)[:MOST_LINES]:
        own = one.filter(rig=rig).sort("when")
        values = own["value"].to_numpy()
        ax.plot([at[w] for w in own["when"]], values, "o-", ms=3, lw=0.8, color=BEFORE)
        if len(alarmed) <= MOST_NUMBERS:
            last = at[own["when"][-1]], values[-1]
            ax.annotate(drawn_name(rig), last, (5, 0), textcoords="offset points", fontsize=7)
    ax.set_xticks(range(len(whens)), [drawn_name(w) for w in whens], fontsize=7)
