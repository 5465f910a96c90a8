"""What is asked of the diagnosis, and what its newest answers to cases that no search had served reach: the first table of docs/verdict.md.

Each row takes the newest files of its kind of case, as many as hold forty cases where there are so many. A file holds answers of one search, or of a few; none
of it was asked before.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

from experiments.blind.draw import cases
from experiments.blind.score import RIGHT, Judged, Line, among_small, outcome, share
from experiments.promised import held
from experiments.real.published import PUBLISHED
from experiments.real.run import outcome as outcome_of_pair
from experiments.speed.table import Table
from rwjax.diagnosis.verdict import CLAIMS

FILES = {
    "single": ("fourth",),
    "pair": ("final_pairs", "fourth"),
    "messy": ("third", "third_messy", "third_rest", "third_now", "fourth"),
    "none": ("final_single", "third_others", "fourth"),
    "outside": ("third_others", "third_rest", "third_now", "fourth"),
}
"""Files of each group of simulated cases: one cause, two, large ones among small ones, none, and one outside the list."""
PROMISED, SETUPS, SETS = ("promised",), ("repeated_friction",), ("sets",)
"""Files of fresh runs of rigs whose causes were named, of changed set-ups of measured rigs, and of published sets."""
LARGE = 5.0
"""Size that the rig without one of two causes has, with the other one in the model, where both are asked for [1]."""
MINUTE = 60.0
"""Time that a measured set may take [s]."""
Lines = Callable[[str], Sequence[Line]]
"""The answers of a file by its name."""


class Row(NamedTuple):
    """A figure that is asked for.

    Attributes:
        what: What is counted.
        least: What is asked, at least or at most.
        cases: The groups of simulated cases (`FILES`), or the files of measured ones.
        counted: Whether an answer is a hit; None for one that does not count.
    """

    what: str
    least: str
    cases: Sequence[str]
    counted: Callable[[Line, Judged], bool | None]


def newest(lines: Lines, cases: Sequence[str]) -> Iterator[tuple[str, Line]]:
    """The newest answers, each with the file that it is of.

    Args:
        lines: The answers of a file by its name.
        cases: Groups of simulated cases (`FILES`), or files of measured ones.

    Yields:
        The file's name and the answer.
    """
    for group in cases:
        for name in FILES.get(group, (group,)):
            yield from ((name, line) for line in lines(name) if line.get("group", group) == group)


def _within(*outcomes: str) -> Callable[[Line, Judged], bool]:
    return lambda line, alike: outcome(line, alike) in outcomes


@lru_cache
def _needed(name: str) -> dict[int, float]:
    """Of every pair of a set, by its number, the smaller of the two sizes that it has with one of its causes modelled [1]."""
    return {row["index"]: min(row["needed"].values()) for row in cases(name) if "needed" in row}


def _of_two(*outcomes: str) -> Callable[[Line, Judged], bool | None]:
    """Whether the answer to two causes is one of some outcomes; None where one of them hardly matters."""
    return lambda line, alike: (
        outcome(line, alike) in outcomes if _needed(line["set"])[line["index"]] >= LARGE else None
    )


def _among_small(*outcomes: str) -> Callable[[Line, Judged], bool]:
    return lambda line, alike: among_small(line) in outcomes


def _true_in_part(line: Line, alike: Judged) -> bool | None:
    """Whether all names under `partial` are true; None of another verdict."""
    if line.get("verdict") != "partial":
        return None
    return among_small(line) in ("named", "part") if line["group"] == "messy" else outcome(line, alike) == "part"


def worth_of_pair(line: Line) -> str:
    """The outcome of a pair of measured set-ups by today's rule, whatever its line says."""
    sets = [line["effects"], *line["alternatives"]]
    return outcome_of_pair(line["verdict"], sets, line["changed"], PUBLISHED[line["data"]].present)


def _of_setup(*outcomes: str) -> Callable[[Line, Judged], bool | None]:
    """Whether an answer to a changed set-up is worth one of some outcomes; None where nothing was changed."""
    return lambda line, alike: worth_of_pair(line) in outcomes if line["changed"] else None


def _asked(line: Line, hit: bool) -> bool | None:
    """A hit of a published set; None of one that was not asked."""
    return None if "reason" in line else hit


def _claims(line: Line, alike: Judged) -> bool:
    return line.get("verdict") in CLAIMS


EVERY = (*FILES,)
ROWS = (
    Row("one cause: it alone, or with what the logs cannot tell from it", "93 %", ("single",), _within(*RIGHT)),
    Row("… a wrong name", "at most 1 %", ("single",), _within("wrong")),
    Row(f"two causes, each of size {LARGE:g} without the other: both", "70 %", ("pair",), _of_two(*RIGHT)),
    Row("… any false name", "at most 4 %", ("pair",), _of_two("wider", "wrong")),
    Row("large causes among small ones: all large ones", "70 %", ("messy",), _among_small("named")),
    Row("… true names, not all of them", "", ("messy",), _among_small("part")),
    Row("… a true set beside one that is not", "", ("messy",), _among_small("wider")),
    Row("… false names alone", "at most 5 %", ("messy",), _among_small("false")),
    Row("nothing missing: any name", "at most 1 %", ("none",), _claims),
    Row("a cause outside the list: any name", "at most 6 %", ("outside",), _claims),
    Row("`ci95` holds what 12 fresh runs close", "90 to 99 %", PROMISED, lambda line, _: held(line)),
    Row("names under `partial`: all true", "95 %", EVERY, _true_in_part),
    Row(
        "measured rig, changed: a change, alone or beside what is published",
        "60 %",
        SETUPS,
        _of_setup("named", "in part", "beside published"),
    ),
    Row("… a false name", "at most 10 %", SETUPS, _of_setup("wrong", "named with others")),
    Row(
        "published sets: a name that the source contradicts",
        "at most 1",
        SETS,
        lambda line, _: _asked(line, line.get("beside_published") == "contradicts"),
    ),
    Row("… within a minute", "all", SETS, lambda line, _: _asked(line, (line.get("seconds") or 0.0) <= MINUTE)),
)


def standing(lines: Lines, alike: Callable[[str], Judged], rows: Sequence[Row] = ROWS) -> Table:
    """What is asked and what is reached.

    Args:
        lines: The answers of a file by its name.
        alike: What the oracle cannot tell apart in a file, by its name.
        rows: What is counted.

    Returns:
        The table, a row for each figure.
    """
    told = []
    for row in rows:
        answers = [*newest(lines, row.cases)]
        hits = [hit for name, line in answers if (hit := row.counted(line, alike(name))) is not None]
        files = "all of them" if row.cases == EVERY else ", ".join(f"`{name}`" for name in dict(answers))
        told.append([row.what, row.least, str(len(hits)), share(sum(hits), len(hits)), files])
    return Table("Asked and reached by the newest answers", ["", "asked", "cases", "reached", "files"], told)
