"""Writes the tables of docs/verdict.md and docs/measured.md from stored results: `python -m experiments.verdict_page`.

A table stands between `<!-- table: NAME -->` and `<!-- end -->`, under a line that says which files it is of, and of which commit where
these say so. All else on the page is written by hand. To show a new campaign, change `FILES` of `experiments.standing` or an entry of `BLOCKS`.
"""

import re
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

from experiments import standing
from experiments.asked_again import run as asked_again
from experiments.blind.draw import read
from experiments.blind.score import (
    TITLES,
    Judged,
    Line,
    by,
    calibrations,
    families,
    judged,
    judgement,
    messy,
    outside,
    risk,
    share,
    worth,
)
from experiments.speed.table import Table, markdown
from rwjax.diagnosis.settings import Limits, PartialSettings
from rwjax.diagnosis.verdict import CLAIMS
from rwjax.rig.columns import unit_of

ROOT = Path(__file__).resolve().parents[1]
PAGES = tuple(ROOT / "docs" / f"{name}.md" for name in ("verdict", "measured"))
SIMULATED, MEASURED = ROOT / "experiments" / "blind" / "results", ROOT / "experiments" / "real" / "results"
MEASURED_FILES = SETS, PAIRS = "sets", "repeated_friction"
"""Files of measured rigs: each set of published logs, and pairs of set-ups of which one's label is withheld."""
ASKED_AGAIN, AGAIN = ROOT / "experiments" / "asked_again" / "results", "asked_again"
"""Folder and file of the same questions asked otherwise."""
TOLD = "fourth_told"
"""File of messy cases whose true names were the only candidates."""
BLOCK = re.compile(r"(<!-- table: ([\w-]+) -->\n).*?(<!-- end -->)", re.S)


class Block(NamedTuple):
    """A table, and the names of the result files that it is of; none where the page's own table of files says it."""

    files: tuple[str, ...]
    table: Table


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
    files = ", then ".join(map(source, block.files))
    return f"\n*{title}.{f' From {files}.' if files else ''}*\n\n{markdown(head, rows)}\n\n"


def of_newest(make: Callable[[Sequence[Line], Judged], Table], *groups: str) -> Callable[[], Block]:
    """A table of the newest answers to all groups of cases, or to some."""

    def block() -> Block:
        among, alike = list[Line](), Judged()
        for name, line in standing.newest(lines, groups or (*standing.FILES,)):
            alike[len(among)] = told_by_the_oracle(name).get(line["index"], set())
            among.append(line | {"index": len(among)})  # sets number their cases alike
        return Block((), make(among, alike))

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


def measured_pairs() -> Block:
    """What is said of pairs of measured set-ups, by what was changed."""
    among, rows = lines(PAIRS), []
    groups = {what: [line for line in among if what_was_changed(line) == what] for what in (*CHANGED, "nothing")}
    groups["all that changed"] = [line for line in among if line["changed"]]
    for what, group in groups.items():
        if not group:
            continue
        count = Counter(standing.worth_of_pair(line) for line in group)
        rest = len(group) - sum(count[one] for one in OF_PAIRS)
        told = [share(count[one], len(group)) for one in OF_PAIRS]
        rows.append([what, str(len(group)), *told, share(rest, len(group))])
    named = ["named alone", "in a set with another", "in part", "beside what is published"]
    head = ["changed", "pairs", *named, "a false name", "nothing said"]
    return Block((PAIRS,), Table("Pairs of measured set-ups", head, rows))


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
    return Block((), standing.standing(lines, told_by_the_oracle))


def all_told() -> Block:
    """Messy cases whose true names were the only candidates."""
    return Block((TOLD,), messy("All true names told", lines(TOLD)))


def answered() -> Block:
    """The files of the newest answers, with the commits that were asked."""
    groups: dict[str, list[str]] = {}
    for group, names in standing.FILES.items():
        for name in names:
            groups.setdefault(name, []).append(group)
    rows = [
        [
            source(name, held),
            str(sum(line["group"] in held for line in lines(name))),
            ", ".join(TITLES[g].lower() for g in held),
        ]
        for name, held in groups.items()
    ]
    return Block((), Table("Files of the newest answers", ["file", "cases", "of which groups"], rows))


BLOCKS: dict[str, Callable[[], Block]] = {
    "standing": where_it_stands,
    "files": answered,
    "worth": of_newest(worth),
    "reached": of_newest(reached),
    "by-size": of_newest(partial(by, "size"), "single"),
    "by-kind": of_newest(partial(by, "kind"), "single"),
    "messy": of_newest(lambda among, _: messy("Large causes among small ones", among), "messy"),
    "messy-closed": of_newest(lambda among, _: closed_by_the_truth(among), "messy"),
    "told-all": all_told,
    "outside": of_newest(outside, "outside"),
    "subsystems": of_newest(partial(families, "subsystem"), "single"),
    "coordinates": of_newest(partial(families, "coordinate"), "single"),
    "said": of_newest(lambda among, _: calibrations(among)[0], "single", "pair", "none"),
    "risk-probability": of_newest(risk, "single", "outside", "none"),
    "risk-floors": of_newest(partial(risk, by_floors=True), "single", "outside", "none"),
    "asked-again": partial(asked_otherwise, 0),
    "asked-again-differ": partial(asked_otherwise, 1),
    "measured-sets": measured_sets,
    "measured-pairs": measured_pairs,
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
