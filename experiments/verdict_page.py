"""Writes the tables of docs/verdict.md, docs/verdict_by_search.md and docs/measured.md from stored results: `python -m experiments.verdict_page`.

A table stands between `<!-- table: NAME -->` and `<!-- end -->`, under a line that says which files it is of, and of which commit where
these say so. All else on the page is written by hand. To show a new campaign, change `SET` or an entry of `BLOCKS`.
"""

import re
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

from experiments.asked_again import run as asked_again
from experiments.blind.changed import TITLES, both_of, counted, judgement
from experiments.blind.draw import read
from experiments.blind.inseparable import beside
from experiments.blind.score import (
    AT_FLOOR,
    RIGHT,
    Judged,
    Line,
    among_small,
    by,
    calibrations,
    coordinates_of,
    excess,
    families,
    judged,
    messy,
    nothing,
    outcome,
    outside,
    pairs,
    places_of,
    risk,
    share,
    shares,
    times,
    worth,
)
from experiments.speed.table import Table, markdown
from experiments.standing import standing, worth_of_pair
from rwjax.diagnosis.settings import Limits, PartialSettings
from rwjax.diagnosis.verdict import CLAIMS
from rwjax.rig.columns import unit_of

ROOT = Path(__file__).resolve().parents[1]
PAGES = tuple(ROOT / "docs" / f"{name}.md" for name in ("verdict", "verdict_by_search", "measured"))
SIMULATED, MEASURED = ROOT / "experiments" / "blind" / "results", ROOT / "experiments" / "real" / "results"
MEASURED_FILES = SETS, PAIRS, LATER_PAIRS, REPEATED, FREED = (
    "sets",
    "frozen",
    "frozen_later",
    "repeated",
    "repeated_friction",
)
"""Files of measured rigs: each set of published logs, and pairs of set-ups of which one's label is withheld, by two searches."""
ASKED_AGAIN, AGAIN = ROOT / "experiments" / "asked_again" / "results", "asked_again"
"""Folder and file of the same questions asked otherwise."""
SET = "second"
"""File of the set that the page is about."""
FINAL = "final"
FINAL_PARTS = FINAL, *(f"final_{part}" for part in ("later", "third", "fourth", "fifth", "sixth"))
"""Files of six parts of the final set: the one diagnosed first, messy and small cases of a later search, and messy ones of four still later."""
FRESH, NEWEST = "fresh", "fresh_further"
FRESH_PARTS = FRESH, "fresh_messy", NEWEST, "fresh_last", "third", "third_messy", "third_now", "fourth"
"""Files of the set `fresh`, drawn when the messy places of the final set had all been asked: its first part, and cases of later searches; then those of `third` and of `fourth`."""
OTHERS = "third_others"
"""File of wheels and platforms of the set `third` with two causes, one outside the list, or nothing missing."""
ONE_CAUSE = "final_single"
"""File of cases of the final set with one cause, nothing missing or a cause outside the list, by the newest search."""
CONTACTS = "final_contacts"
"""File of cases of the final set that lack play, an elastic coupling, an end stop, presliding or a sagging supply, by a search mended for these."""
TOLD = "final_told_all"
"""File of cases of the fourth part whose true names were the only candidates."""
BLOCK = re.compile(r"(<!-- table: ([\w-]+) -->\n).*?(<!-- end -->)", re.S)


class Block(NamedTuple):
    """A table, the names of the result files that it is of, and the groups of their cases; all where none is named."""

    files: tuple[str, ...]
    table: Table
    groups: tuple[str, ...] = ()


def path(name: str) -> Path:
    """A file of results."""
    if name == AGAIN:
        return ASKED_AGAIN / f"{name}.jsonl"
    return (MEASURED if name in MEASURED_FILES else SIMULATED) / f"{name}.jsonl"


@cache
def lines(name: str) -> Sequence[Line]:
    """The answers that a file holds."""
    if not (found := read(path(name))):
        raise SystemExit(f"{path(name)} holds no results")
    return found


def source(name: str, groups: Collection[str] = ()) -> str:
    """A file and the commits that its lines name, or those of some groups; older lines name none."""
    among = [line for line in lines(name) if not groups or line["group"] in groups]
    commits = Counter(line["commit"] for line in among if line.get("commit"))
    said = ", ".join(f"`{one}`" + (f" in {count}" if len(commits) > 1 else "") for one, count in commits.items())
    return f"`{name}.jsonl`" + (f" (commit {said})" if said else "")


def text(block: Block) -> str:
    """What stands between the markers."""
    title, head, rows = block.table
    files = ", then ".join(source(name, block.groups) for name in block.files)
    return f"\n*{title}.{f' From {files}.' if files else ''}*\n\n{markdown(head, rows)}\n\n"


def asked(among: Sequence[Line], alike: Judged) -> Table:
    """What was asked of the diagnosis before any case was seen, and what is reached."""
    single, none, beyond = ([x for x in among if x["group"] == name] for name in ("single", "none", "outside"))
    count = Counter(outcome(line, alike) for line in single)
    located = [line for line in single if "error" not in line and line["verdict"] != "none"]
    places = sum(line["subsystem"] in places_of(line) for line in located)
    coordinates = sum(line["coordinate"] in coordinates_of(line) for line in located)

    def said(group: Sequence[Line], *verdicts: str) -> str:
        return share(sum(line.get("verdict") in verdicts for line in group), len(group))

    seen = [line for line in beyond if excess(line)]
    left = f"outside the list, where the best explanation leaves more than {AT_FLOOR} floors"
    right = sum(count[c] for c in RIGHT)
    rows = [
        (
            "one cause: exact, or in a set that the logs cannot tell apart",
            "at least 90 %",
            single,
            share(right, len(single)),
        ),
        ("… a wrong name", "at most 3 %", single, share(count["wrong"], len(single))),
        ("… subsystem of the gap", "at least 90 %", single, share(places, len(single))),
        ("… coordinate of the gap", "at least 80 %", single, share(coordinates, len(single))),
        ("nothing missing: any name", "at most 2 %", none, said(none, *CLAIMS)),
        (f"{left}: `unknown`", "at least 80 %", seen, said(seen, "unknown")),
        ("… a name alone (`effect`)", "at most 10 %", seen, said(seen, "effect")),
        ("… any name", "", seen, said(seen, *CLAIMS)),
        ("outside the list, all: `unknown`", "", beyond, said(beyond, "unknown")),
        ("… a name alone", "", beyond, said(beyond, "effect")),
        ("… any name", "", beyond, said(beyond, *CLAIMS)),
    ]
    table = [[what, wish, str(len(group)), found] for what, wish, group, found in rows]
    return Table("Asked and reached", ["", "asked", "cases", "reached"], table)


def of(make: Callable[[Sequence[Line], Judged], Table], *groups: str, name: str = SET) -> Callable[[], Block]:
    """A table of a file, or of some groups of its cases."""

    def block() -> Block:
        among = [line for line in lines(name) if not groups or line["group"] in groups]
        return Block((name,), make(among, judged(path(name))), groups)

    return block


def before_and_after(earlier: str, later: str, *asked_about: str, shared: bool = False) -> Callable[[], Block]:
    """The same cases in two files, by what the oracle was asked about these or about other answers to them."""

    def block() -> Block:
        alike = judged(*(path(name) for name in (earlier, later, *asked_about)))
        return Block((earlier, later), counted(both_of(lines(earlier), lines(later)), alike, shared))

    return block


OUTCOMES = {
    "right": ("right",),
    "true in part, or as good": ("part", "twin"),
    "a name too many": ("wider",),
    "wrong": ("wrong", "wrong, with a true name", "false"),
    "`unknown`": ("unknown",),
    "`none`, or an error": ("none", "error"),
}
"""Columns of `reached`, and the judgements that each holds."""


def reached(among: Sequence[Line], alike: Judged) -> Table:
    """Outcomes by what the rig lacks."""
    rows = []
    for group, title in TITLES.items():
        said = [judgement(line, alike) for line in among if line["group"] == group]
        shares_of = (share(sum(one in held for one in said), len(said)) for held in OUTCOMES.values())
        rows += [[title, str(len(said)), *shares_of]] if said else []
    return Table("Outcomes by what the rig lacks", ["", "cases", *OUTCOMES], rows)


LEAST = PartialSettings().closes, Limits().barely
"""Shares of the gap that names have to close under `partial`: where the fitted runs show a visible part too, and where they do not [1]."""


def closed_by_the_truth(among: Sequence[Line]) -> Table:
    """In how many cases the large causes alone close enough of the gap, in the simulator's own equations."""
    groups = {
        kind: [line for line in among if line["kind"] == kind] for kind in sorted({line["kind"] for line in among})
    }
    rows = []
    for kind, group in (groups | {"all": among}).items():
        closes = [1.0 - line["left"] / line["size"] for line in group]
        by_much = (share(sum(c >= least for c in closes), len(group)) for least in LEAST)
        rows.append([kind, str(len(group)), *by_much])
    head = ["", "cases", *(f"at least {100 * least:.0f} %" for least in LEAST)]
    return Table("What the large causes alone close, by the simulator's own equations", head, rows)


def every_messy() -> Block:
    """`closed_by_the_truth` of all messy cases that were asked."""
    among = [line for name in FINAL_PARTS for line in lines(name) if line["group"] == "messy"]
    return Block(FINAL_PARTS, closed_by_the_truth(among), ("messy",))


def messy_by_search() -> Block:
    """Messy cases by the search that was asked; no case stands in two rows."""
    files, rows = (*FINAL_PARTS, *FRESH_PARTS), []
    for name in files:
        among = [line for line in lines(name) if line["group"] == "messy"]
        count = Counter(among_small(line) for line in among)
        held = (("named",), ("part",), ("wider",), ("false",), ("unknown", "none", "error"))
        told = (share(sum(count[one] for one in ones), len(among)) for ones in held)
        rows.append([f"`{name}`", str(len(among)), *told])
    head = ["run", "cases", "named", "in part", "a name too many", "false", "nothing said"]
    return Block(files, Table("Large causes among small ones, by search", head, rows), ("messy",))


def beside_small_causes() -> Block:
    """What the oracle, told the small causes too, says of messy answers that hold a name that is not true."""
    large = {line["index"]: line["effect"] for line in lines(NEWEST) if line["group"] == "messy"}
    rows = [
        [
            str(one["index"]),
            *(names.replace("+", " + ") for names in (large[one["index"]], one["option"])),
            *(f"{one[key]:.2f}" for key in ("misfit", "misfit_true")),
            "no" if one["inseparable"] else "yes",
        ]
        for one in read(beside(path(NEWEST)))
        if one["index"] in large
    ]
    head = ["case", "large causes", "offered", "it leaves [floors]", "the truth leaves [floors]", "told apart"]
    return Block((NEWEST,), Table("What the oracle says of sets with a name that is not true", head, rows), ("messy",))


def measured_sets() -> Block:
    """What is said of each set of published logs, beside difference equations."""
    rows = []
    for one in lines(SETS):
        if "reason" in one:
            rows.append([f"`{one['data']}`", f"not asked: {one['reason']}", *["-"] * 4])
            continue
        said = " or ".join(" + ".join(names) for names in (one["effects"], *one["alternatives"]) if names)
        ended = "" if one["complete"] else ", unfinished"
        unit = unit_of(one["signal"])
        rows.append(
            [
                f"`{one['data']}`",
                f"`{one['verdict']}`{ended}{f': {said}' if said else ''}",
                one["beside_published"] if one["verdict"] in CLAIMS else "-",
                f"{', '.join(f'{one[key]:.3g}' for key in ('before', 'after', 'floor'))} {unit}",
                f"{one['baseline']:.3g}",
                f"{one['seconds']:.0f}",
            ]
        )
    head = ["set", "answer", "beside what is published", "before, after, floor", "difference equations", "time [s]"]
    return Block((SETS,), Table("Every set of published logs", head, rows))


CHANGED = "gain of the servo", "payload or arm", "motor"
OF_PAIRS = "named", "named with others", "in part", "beside published", "wrong"
"""Outcomes of `experiments.real.run` that name something."""


def what_was_changed(line: Line) -> str:
    """Which kind of pair a line is."""
    if not line["changed"]:
        return "nothing"
    if line.get("given_data"):
        return "motor"
    return "gain of the servo" if all("kp" in name for name in line["changed"]) else "payload or arm"


def measured_pairs(name: str) -> Block:
    """What is said of pairs of measured set-ups in a file of results, by what was changed."""
    among, rows = lines(name), []
    groups = {what: [line for line in among if what_was_changed(line) == what] for what in (*CHANGED, "nothing")}
    groups["all that changed"] = [line for line in among if line["changed"]]
    for what, group in groups.items():
        if not group:
            continue
        count = Counter(worth_of_pair(line) for line in group)
        rest = len(group) - sum(count[one] for one in OF_PAIRS)
        told = [share(count[one], len(group)) for one in OF_PAIRS]
        rows.append([what, str(len(group)), *told, share(rest, len(group))])
    named = ["named alone", "in a set with another", "in part", "beside what is published"]
    head = ["changed", "pairs", *named, "a false name", "nothing said"]
    return Block((name,), Table("Pairs of measured set-ups", head, rows))


def asked_otherwise(number: int) -> Block:
    """One of the tables of the same questions asked otherwise."""
    return Block((AGAIN,), asked_again.tables(lines(AGAIN))[number])


@cache
def told_by_the_oracle(name: str) -> Judged:
    """What the oracle cannot tell apart, by what it was asked about any answers to a file's set."""
    of_set = SIMULATED.glob(f"{lines(name)[0].get('set', name)}*.inseparable.jsonl")
    return judged(*(one.with_name(one.name.replace(".inseparable", "")) for one in sorted(of_set)))


def where_it_stands() -> Block:
    """What is asked, and what the newest answers reach."""
    return Block((), standing(lines, told_by_the_oracle))


BLOCKS: dict[str, Callable[[], Block]] = {
    "standing": where_it_stands,
    "worth": of(worth),
    "asked": of(asked),
    "final": of(reached, name=FINAL),
    "told-all": of(lambda among, _: messy("All true names told", among), "messy", name=TOLD),
    "one-cause": of(reached, name=ONE_CAUSE),
    "fourth": of(reached, name="fourth"),
    "contacts": of(lambda among, alike: by("effect", among, alike), "single", name=CONTACTS),
    "fresh": of(reached, name=FRESH),
    "third-others": of(reached, name=OTHERS),
    "fresh-messy": of(lambda among, _: messy("Large causes among small ones", among), "messy", name=NEWEST),
    "messy-by-search": messy_by_search,
    "messy-oracle": beside_small_causes,
    "asked-again": partial(asked_otherwise, 0),
    "asked-again-differ": partial(asked_otherwise, 1),
    "messy-closed": every_messy,
    "measured-sets": measured_sets,
    "measured-pairs": partial(measured_pairs, PAIRS),
    "measured-pairs-later": partial(measured_pairs, LATER_PAIRS),
    "measured-pairs-repeated": partial(measured_pairs, REPEATED),
    "measured-pairs-freed": partial(measured_pairs, FREED),
    "partial-second": before_and_after("second_later", "second_again", "second"),
    "partial-own": before_and_after("partial_before", "partial"),
    "pairs": before_and_after("test", "test_pair_382d076", shared=True),
    "pairs-final": before_and_after("final", "final_now", shared=True),
    "pairs-fresh": of(pairs, name="final_pairs"),
    "pairs-smaller": of(pairs, name="final_pairs_smaller"),
    "subsystems": of(lambda among, alike: families("subsystem", among, alike), "single"),
    "coordinates": of(lambda among, alike: families("coordinate", among, alike), "single"),
    "said": of(lambda among, _: calibrations(among)[0]),
    "said-alone": of(lambda among, _: calibrations(among)[1]),
    "risk-probability": of(risk),
    "risk-floors": of(lambda among, alike: risk(among, alike, by_floors=True)),
    "shares": of(shares, "single"),
    "by-size": of(lambda among, alike: by("size", among, alike), "single"),
    "by-kind": of(lambda among, alike: by("kind", among, alike), "single"),
    "nothing": of(lambda among, _: nothing(among), "none"),
    "outside": of(outside, "outside"),
    "by-effect": of(lambda among, alike: by("effect", among, alike), "single"),
    "seconds": of(lambda among, _: times(among)),
}


def written(page: str) -> str:
    """The page with every table as the stored results have it."""
    marked = [name for _, name, _ in BLOCK.findall(page)]
    if unknown := {*marked} - {*BLOCKS}:
        raise SystemExit(f"no table is called {', '.join(sorted(unknown))}")
    if page.count("<!-- table:") != len(marked) or page.count("<!-- end -->") != len(marked):
        raise SystemExit("a table's marker has no end, or an end has no table")
    return BLOCK.sub(lambda found: found[1] + text(BLOCKS[found[2]]()) + found[3], page)


def main() -> None:
    """Command line."""
    for path in PAGES:
        page = path.read_text()
        new = written(page)
        path.write_text(new)
        print(f"{path.relative_to(ROOT)}: {'as it was' if new == page else 'rewritten'}")


if __name__ == "__main__":
    main()
