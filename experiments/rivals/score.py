"""How often the rivals are right, each answering as many cases as the library does.

`python -m experiments.rivals.score build/rivals.jsonl --library RESULTS.jsonl` takes the library's answers to the same cases, as
`experiments.blind.campaign` writes them. Without such answers `--coverage 0.95` says how many cases of one cause are answered.

A rival's answer is kept where its confidence reaches a threshold, set so that it answers as many cases of one cause as the library. The
same threshold decides on rigs that lack nothing: each name there is a false one. An answer is *right* where it gives the truth alone,
*wider* where it gives the truth and more, else *wrong*. The library's answers are judged by `experiments.blind.score`, so a set that its
logs cannot separate is right; true names that leave something (`partial`) count as wider. Cases whose cause a rival has no word for stand in rows of their own. Intervals are Clopper and Pearson's, 95 %.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from experiments.blind.draw import read
from experiments.blind.score import Judged, accepted, judged, matches, outcome, share
from experiments.rivals.dictionary import BEYOND
from experiments.rivals.friction_list import ON_AXIS, ON_WHEEL
from experiments.speed.table import show
from rwjax.diagnosis.verdict import CLAIMS

Line = dict
OWN = 0.15
"""Confidence from which a rival's answer counts by its own threshold, chosen on ten cases of `calibrate` [1]."""
OF_LIBRARY = {"exact": "right", "set": "right", "part": "wider", "wider": "wider", "twin": "wrong", "wrong": "wrong"}


class Scored(NamedTuple):
    """What became of the cases: numbers of cases."""

    cases: int
    answered: int
    right: int
    first: int  # the first name is true
    wider: int
    wrong: int
    nones: int
    false: int  # names on rigs that lack nothing
    unsayable: int
    answered_unsayable: int

    def row(self, name: str) -> list[str]:
        """The cells of a table."""
        return [
            name,
            f"{self.answered} of {self.cases}",
            share(self.right, self.answered),
            share(self.first, self.answered) if self.first >= 0 else "",
            share(self.wider, self.answered),
            share(self.wrong, self.answered),
            f"{self.false} of {self.nones}: {share(self.false, self.nones)}",
            f"{self.answered_unsayable} of {self.unsayable}",
        ]


HEAD = (
    "",
    "answered",
    "right",
    "first name right",
    "wider",
    "wrong",
    "names where nothing lacks",
    "cannot be said: answered",
)


def sayable(line: Line) -> bool:
    """Whether a rival has a word for a case's cause."""
    if line["rival"] == "friction_list":
        return bool({*accepted(line)} & {name for model in (*ON_AXIS, *ON_WHEEL) for name in model})
    return any(name not in BEYOND for name in accepted(line))


def judge(line: Line) -> str:
    """Right, wider or wrong, of a rival's answer to a case with one cause."""
    if matches(frozenset(line["names"]), line):
        return "right"
    return "wider" if {*line["names"]} & {*accepted(line)} else "wrong"


def threshold(lines: Sequence[Line], count: int) -> float:
    """Confidence from which a rival answers so many cases of one cause, or all that it names; infinite for none."""
    sure = sorted((x["confidence"] for x in lines if x["group"] == "single" and x["names"]), reverse=True)[:count]
    return sure[-1] if sure else float("inf")


def scored(lines: Sequence[Line], least: float) -> Scored:
    """A rival's score at a threshold."""
    given = [line for line in lines if line["names"] and line["confidence"] >= least]
    singles = [line for line in given if line["group"] == "single"]
    beyond = [line for line in lines if line["group"] == "single" and not sayable(line)]
    words = [judge(line) for line in singles]
    return Scored(
        cases=sum(line["group"] == "single" for line in lines),
        answered=len(singles),
        right=words.count("right"),
        first=sum(line["names"][0] in accepted(line) for line in singles),
        wider=words.count("wider"),
        wrong=words.count("wrong"),
        nones=sum(line["group"] == "none" for line in lines),
        false=sum(line["group"] == "none" for line in given),
        unsayable=len(beyond),
        answered_unsayable=sum(not sayable(line) for line in singles),
    )


def of_library(lines: Sequence[Line], alike: Judged) -> Scored:
    """The library's score."""
    singles = [line for line in lines if line["group"] == "single"]
    nones = [line for line in lines if line["group"] == "none"]
    words = [OF_LIBRARY.get(outcome(line, alike), "") for line in singles]
    false = sum(line.get("verdict") in CLAIMS for line in nones)
    right, wider, wrong = (words.count(word) for word in ("right", "wider", "wrong"))
    return Scored(len(singles), right + wider + wrong, right, -1, wider, wrong, len(nones), false, 0, 0)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", type=Path)
    parser.add_argument("--library", type=Path, help="the library's answers to the same cases")
    parser.add_argument("--coverage", type=float, help="share of the cases of one cause to be answered")
    a = parser.parse_args()
    lines = read(a.path)
    of = {name: [x for x in lines if x["rival"] == name] for name in dict.fromkeys(x["rival"] for x in lines)}
    table, answered = [], None
    if a.library:
        known = {(x["set"], x["index"]): x for x in read(a.library)}
        for name, some in of.items():
            of[name] = [x for x in some if (x["set"], x["index"]) in known]
        held = {(x["set"], x["index"]) for some in of.values() for x in some}
        library = of_library([x for at, x in known.items() if at in held], judged(a.library))
        if not held:
            parser.error(f"{a.library} answers none of these cases")
        table.append(library.row("rwjax"))
        answered = library.answered / library.cases if library.cases else 0.0
    coverage = a.coverage if a.coverage is not None else answered
    show(f"By their own threshold, {OWN}", HEAD, [scored(some, OWN).row(name) for name, some in of.items()])
    if coverage is None:
        return
    for name, some in of.items():
        count = round(coverage * sum(x["group"] == "single" for x in some))
        table.append(scored(some, threshold(some, count)).row(name))
    show(f"At {100 * coverage:.0f} % of the cases of one cause answered", HEAD, table)


if __name__ == "__main__":
    main()
