"""Tables of how often a campaign's diagnoses are right.

`python -m experiments.blind.score RESULTS.jsonl [--confusions]`

These are the outcomes of a case with one true name, where an *option* is `effects` or one of `alternatives`:

* exact: the verdict is `effect` and names the truth alone.
* set: the truth is an option. Each other option is declared the same thing (`same_as` of the label), or the oracle cannot tell it
  from the truth (`inseparable`). Exact and set together are *right*.
* twin: the truth is no option, but every option is the same or inseparable.
* wider: the truth or a twin is in an option, but some option holds a name too many or one that the logs rule out.
* part: the verdict is `partial`, and some option holds true names alone, or what is the same thing.
* wrong: other names. Under `partial` one name that is not true is enough. Then there are the verdicts `unknown` and `none`, and errors.

A *messy* case has large causes among small ones, and the group `small` has small ones alone. There a name is *true* where it is one of
either, or declared the same thing, and an option is true where all its names are. (The oracle is not asked: what absorbs small causes too
would pass for the large ones.)

* named: every option is true and holds all large causes. Of small causes alone one is named.
* part: every option is true, and a large cause lacks in some option.
* wider: some option is true, and some is not.
* false: no option is true. Then there are `unknown` and `none`, which say nothing, and errors. Of small causes alone `none` is right, too.

Intervals are Clopper and Pearson's, 95 %.
"""

import argparse
import re
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import permutations
from pathlib import Path

import numpy as np
from scipy.stats import binomtest

from experiments.blind.cases import split
from experiments.blind.draw import read
from experiments.blind.inseparable import beside, options
from experiments.speed.table import Table, show
from rwjax.diagnosis.hypothesis import coordinate_of
from rwjax.diagnosis.verdict import CLAIMS

CLASSES = ("exact", "set", "part", "twin", "wider", "wrong", "unknown", "none", "error")
RIGHT = ("exact", "set")
MESSY = ("messy", "small")
OF_MESSY = ("named", "part", "wider", "false", "unknown", "none", "error")
RIGHT_OF = {"messy": ("named",), "small": ("none", "named")}
BINS = (3.0, 5.0, 10.0, 30.0)  # sizes
SAID = (0.0, 0.5, 0.7, 0.9, 0.97, 1.0)  # probabilities
AT_FLOOR = 1.25  # error left, in floors, above which there is an excess
AT_LEAST = (0.0, 0.5, 0.7, 0.9, 0.97, 0.999)  # probabilities of the first name
AT_MOST = (float("inf"), 3.0, 2.0, 1.5, AT_FLOOR, 1.1)  # errors left, in floors

Line = dict
Judged = dict[int, set[frozenset[str]]]


def judged(*paths: Path) -> Judged:
    """Hypotheses of each case that the oracle cannot tell from the truth, by what it was asked about results of the same set."""
    found: Judged = {}
    for one in (one for path in paths for one in read(beside(path))):
        if one["inseparable"]:
            found.setdefault(one["index"], set()).add(frozenset(one["option"].split("+")))
    return found


def matches(option: frozenset[str], line: Line) -> bool:
    """Whether an option is the truth, up to names declared to be the same thing."""
    true = split(line["effect"])
    alike = [{name, *line["same_as"].get(name, ())} for name in true]
    return len(option) == len(true) and any(
        all(name in group for name, group in zip(order, alike, strict=True)) for order in permutations(option)
    )


def as_good(option: frozenset[str], line: Line, alike: Judged) -> bool:
    """Whether an option is the truth, or one that the oracle cannot tell from it."""
    return matches(option, line) or option in alike.get(line["index"], ())


def outcome(line: Line, alike: Judged) -> str:
    """One of `CLASSES`."""
    if "error" in line:
        return "error"
    if line["verdict"] in ("none", "unknown"):
        return line["verdict"]
    true, offered = frozenset(split(line["effect"])), options(line)
    fits = [as_good(o, line, alike) for o in offered]
    if line["verdict"] == "partial":
        held = any(all({name} & {*accepted(line)} for name in o) for o in offered)
        return "part" if held else "twin" if any(fits) else "wrong"
    if offered == [true]:
        return "exact"
    if all(fits):
        return "set" if true in offered else "twin"
    return "wider" if any(fits) or any(true <= o for o in offered) else "wrong"


def among_small(line: Line) -> str:
    """One of `OF_MESSY`, of a case with small causes."""
    if "error" in line:
        return "error"
    if line["verdict"] in ("none", "unknown"):
        return line["verdict"]
    groups = {name: {name, *line["same_as"].get(name, ())} for name in (*split(line["effect"]), *line["small"])}
    true = set().union(*groups.values())
    offered = options(line)
    held = [option <= true for option in offered]
    if not all(held):
        return "wider" if any(held) else "false"
    whole = all(o & groups[name] for name in split(line["effect"]) for o in offered)
    return "named" if whole else "part"


TITLES = {
    "single": "One cause",
    "pair": "Two causes",
    "outside": "A cause outside the list",
    "none": "Nothing missing",
    "messy": "Large causes among small ones",
    "small": "Small causes alone",
}
"""What the rig lacks, by the group of its cases."""


def judgement(line: Line, alike: Judged) -> str:
    """`right`, or what it is instead; of a cause outside the list `unknown` is right, where nothing is missing `none`."""
    if line["group"] in ("outside", "none"):
        right = "unknown" if line["group"] == "outside" else "none"
        said = line.get("verdict", "error")
        return "right" if said == right else said if said in ("none", "unknown", "error") else "wrong"
    if line["group"] in MESSY:
        found = among_small(line)
        return "right" if found in RIGHT_OF[line["group"]] else found
    found = outcome(line, alike)
    return "right" if found in RIGHT else "wrong, with a true name" if half(line, alike) else found


def share(hits: int, count: int) -> str:
    """Percent with its interval."""
    if count == 0:
        return "–"
    low, high = binomtest(hits, count).proportion_ci(method="exact")
    return f"{100 * hits / count:.1f} % ({100 * low:.1f} to {100 * high:.1f})"


def rows(lines: Sequence[Line], alike: Judged, by: Callable[[Line], str]) -> list[list[str]]:
    """One row for each value of `by`, numbers in it by their size, and one for all."""
    groups: dict[str, list[Line]] = {}
    for line in lines:
        groups.setdefault(by(line), []).append(line)
    found = []
    for name, group in [*sorted(groups.items(), key=natural), ("all", list(lines))]:
        count = Counter(outcome(line, alike) for line in group)
        right = sum(count[c] for c in RIGHT)
        found.append([name, str(len(group)), share(right, len(group)), *(str(count[c]) for c in CLASSES)])
    return found


def natural(item: tuple[str, object]) -> list[str | int]:
    """What a name is sorted by: its words and its numbers."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", item[0])]


def size_bin(line: Line) -> str:
    """Range of sizes that a case falls into."""
    k = int(np.clip(np.searchsorted(BINS, line["size"], "right") - 1, 0, len(BINS) - 2))
    return f"size {BINS[k]:.0f} to {BINS[k + 1]:.0f}"


BY: dict[str, Callable[[Line], str]] = {"size": size_bin, "kind": lambda x: x["kind"], "effect": lambda x: x["effect"]}


def by(what: str, lines: Sequence[Line], alike: Judged) -> Table:
    """Outcomes of cases with one true name by `size`, `kind` or `effect`."""
    return Table(f"One effect, by {what}", ["", "cases", "right", *CLASSES], rows(lines, alike, BY[what]))


def shares(lines: Sequence[Line], alike: Judged) -> Table:
    """What share of the cases with one true name is right, by several measures."""
    clean = [line for line in lines if line["left"] < 1.0]
    count = Counter(outcome(line, alike) for line in lines)
    table = [
        ["exact", share(count["exact"], len(lines))],
        ["exact or set", share(sum(count[c] for c in RIGHT), len(lines))],
        ["exact, set or twin", share(sum(count[c] for c in (*RIGHT, "twin")), len(lines))],
        ["truth contained (exact, set, wider)", share(sum(count[c] for c in (*RIGHT, "wider")), len(lines))],
        ["wrong name", share(count["wrong"], len(lines))],
        [
            "exact or set, where the true effect leaves less than a floor",
            share(sum(outcome(line, alike) in RIGHT for line in clean), len(clean)),
        ],
    ]
    return Table("One effect, shares", ["", f"of {len(lines)}"], table)


def where(lines: Sequence[Line]) -> Table:
    """How often the place of the gap is right, whatever is named."""
    located = [line for line in lines if "error" not in line and line["verdict"] != "none"]
    table = []
    for word, among in (("subsystem", places_of), ("coordinate", coordinates_of)):
        hits = sum(line[word] in among(line) for line in located)
        table.append([word, share(hits, len(located)), share(hits, len(lines))])
    return Table("One effect, where", ["", f"of {len(located)} that say where", "of all"], table)


def families(word: str, lines: Sequence[Line], alike: Judged) -> Table:
    """The family of the true name against that of the set named first, by `subsystem` or `coordinate`.

    It is right if the family is, or the set is as good as the truth; other names of another family are wrong.
    """
    family = {"subsystem": subsystem, "coordinate": coordinate}[word]

    def said(line: Line) -> str:
        offered = options(line)
        return " + ".join(sorted({family(name) for name in offered[0]})) if offered else line.get("verdict", "error")

    seen, silent = {said(line) for line in lines}, ("unknown", "none", "error")
    true = sorted({family(line["effect"]) for line in lines})
    names = [*sorted({*true, *seen} - {*silent}), *(one for one in silent if one in seen)]
    table = []
    for name in [*true, "all"]:
        among = [line for line in lines if name in (family(line["effect"]), "all")]
        named = [line for line in among if options(line)]
        right = sum(said(line) == family(line["effect"]) or as_good(options(line)[0], line, alike) for line in named)
        count = Counter(said(line) for line in among)
        counted = [len(named) - right, *(count[other] for other in names)]
        table.append([name, str(len(among)), share(right, len(among)), *map(str, counted)])
    title = f"One effect: true {word} (rows) and {word} named first (columns)"
    return Table(title, ["", "cases", "right or as good", "wrong", *names], table)


WORTH = {
    "right, or in part": ("right", "part"),
    "beside a false set, or as good": ("wider", "twin"),
    "false": ("wrong", "wrong, with a true name", "false"),
    "a cause is missed": ("unknown", "none"),
}
"""Columns of `worth`, and the judgements that each holds."""


def worth(lines: Sequence[Line], alike: Judged) -> Table:
    """How often each verdict is said, and what it is worth."""
    table = []
    for verdict in (*CLAIMS, "none", "unknown"):
        said = Counter(judgement(line, alike) for line in lines if line.get("verdict") == verdict)
        counts = [sum(said[one] for one in held) for held in WORTH.values()]
        table.append([f"`{verdict}`", str(said.total()), share(counts[0], said.total()), *map(str, counts[1:])])
    return Table("What a verdict is worth", ["verdict", "said", *WORTH], table)


def accepted(line: Line) -> list[str]:
    """The true names and those declared the same."""
    return [other for name in split(line["effect"]) for other in (name, *line["same_as"].get(name, ()))]


def places_of(line: Line) -> set[str]:
    """Subsystems that are right."""
    return {subsystem(name) for name in accepted(line)}


def subsystem(name: str) -> str:
    """The part of the rig that a name belongs to."""
    return name.removeprefix("parameter.").split(".")[0]


def coordinates_of(line: Line) -> set[str]:
    """Coordinates that are right."""
    return {coordinate(name) for name in accepted(line)}


def coordinate(name: str) -> str:
    """What a name's torque or error is a function of; not known of one that the library lacks."""
    try:
        return coordinate_of(name)
    except KeyError:
        return "not known"


def half(line: Line, alike: Judged) -> bool:
    """Whether a wrong answer holds a true name."""
    return outcome(line, alike) == "wrong" and any({*o} & {*accepted(line)} for o in options(line))


def pairs(lines: Sequence[Line], alike: Judged) -> Table:
    """Cases with two true names."""
    count = Counter(outcome(line, alike) for line in lines)
    table = [[c, share(count[c], len(lines))] for c in CLASSES]
    part = sum(half(line, alike) for line in lines)
    return Table("Two effects", ["", f"of {len(lines)}"], [*table, ["of the wrong: one true name", str(part)]])


def nothing(lines: Sequence[Line]) -> Table:
    """Cases that lack nothing."""
    table = []
    for kind in [*sorted({line["kind"] for line in lines}), "all"]:
        group = [line for line in lines if kind in (line["kind"], "all")]
        table.append([kind, str(len(group)), *verdicts(group, ("none", *CLAIMS, "unknown"))])
    return Table("Nothing missing: verdicts", ["", "cases", "none", *CLAIMS, "unknown", "error"], table)


def messy(title: str, lines: Sequence[Line]) -> Table:
    """Cases with small causes, by kind and by how many large ones there are."""
    groups: dict[str, list[Line]] = {}
    for line in lines:
        count = len(split(line["effect"]))
        for name in (line["kind"], f"{count} large" if count else "", "all"):
            groups.setdefault(name, []).append(line)
    table = []
    for name in [*sorted(groups.keys() - {"", "all"}), "all"]:
        count = Counter(among_small(line) for line in groups[name])
        right = sum(count[c] for c in RIGHT_OF[lines[0]["group"]])
        said = count["unknown"] + (count["none"] if lines[0]["group"] == "messy" else 0)
        shares = (share(hits, len(groups[name])) for hits in (right, count["false"], said))
        table.append([name, str(len(groups[name])), *shares, *(str(count[c]) for c in OF_MESSY)])
    return Table(title, ["", "cases", "right", "false", "nothing said", *OF_MESSY], table)


def verdicts(lines: Sequence[Line], names: Sequence[str]) -> list[str]:
    """Share of each verdict, and of errors."""
    count = Counter("error" if "error" in line else line["verdict"] for line in lines)
    return [share(count[name], len(lines)) for name in names] + [str(count["error"])]


def excess(line: Line) -> bool:
    """Whether the library's best hypothesis leaves more than the floor."""
    return "error" in line or line["after"] > AT_FLOOR * line["floor"]


def outside(lines: Sequence[Line], alike: Judged) -> Table:
    """Causes outside the library's list."""
    groups = [(name, [x for x in lines if x["effect"] == name]) for name in sorted({x["effect"] for x in lines})]
    groups.append(("all", list(lines)))
    groups.append((f"more than {AT_FLOOR} floors left", [x for x in lines if excess(x)]))
    told = [x for x in lines if not any(o in alike.get(x["index"], ()) for o in options(x))]
    groups.append(("told apart by the oracle from what is named", told))
    names = ("unknown", *CLAIMS, "none")
    table = [[name, str(len(group)), *verdicts(group, names)] for name, group in groups]
    return Table("Causes outside the list: verdicts", ["", "cases", *names, "error"], table)


def in_part(lines: Sequence[Line], alike: Judged) -> Table:
    """How often names under `partial` are right, by how many causes there are."""
    found = [line for line in lines if line.get("verdict") == "partial"]
    table = []
    for group in [*dict.fromkeys(line["group"] for line in found), "all"]:
        among = [line for line in found if group in (line["group"], "all")]
        table.append([group, str(len(among)), share(sum(outcome(x, alike) == "part" for x in among), len(among))])
    return Table("Names under `partial`", ["", "cases", "right"], table)


def calibration(title: str, lines: Sequence[Line]) -> Table:
    """What the first name's probability says against how often that name is right."""
    said, right = [], []
    for line in lines:
        if line.get("top"):
            name, probability = line["top"][0]
            named = frozenset(split(name.replace(" ", "")))
            said.append(probability)
            right.append(matches(named, line))
    p, hit = np.array(said), np.array(right, bool)
    table, off = [], 0.0
    for low, high in zip(SAID[:-1], SAID[1:], strict=True):
        inside = (p >= low) & ((p < high) | (high == SAID[-1]))
        if inside.any():
            off += abs(float(np.sum(p[inside]) - np.sum(hit[inside]))) / len(p)
            mean = f"{100 * np.mean(p[inside]):.1f} %"
            table.append(
                [f"{low} to {high}", str(inside.sum()), mean, share(int(hit[inside].sum()), int(inside.sum()))]
            )
    return Table(f"{title}; mean distance {100 * off:.1f} %", ["said", "cases", "said, mean", "right"], table)


def risk(lines: Sequence[Line], alike: Judged, by_floors: bool = False) -> Table:
    """What is named, and what of it is not right, if only some names are believed.

    Those are believed whose first name has at least a probability or, `by_floors`, that leave at most so many floors.
    """

    def believed(line: Line, limit: float) -> bool:
        if line.get("verdict") not in CLAIMS:
            return False
        return line["after"] <= limit * line["floor"] if by_floors else line["top"][0][1] >= limit

    group = {name: [x for x in lines if x["group"] == name] for name in ("single", "outside", "none")}
    title = (
        f"What is named and what is wrong, by {'the floors left' if by_floors else 'the probability of the first name'}"
    )
    head = ["at most" if by_floors else "at least", "one cause: named", "of these not right", "of these wrong"]
    head += ["outside the list: named", "nothing missing: named"]
    table = []
    for limit in AT_MOST if by_floors else AT_LEAST:
        named = {name: [x for x in among if believed(x, limit)] for name, among in group.items()}
        count = Counter(outcome(line, alike) for line in named["single"])
        off = len(named["single"]) - sum(count[c] for c in (*RIGHT, "part"))
        answered = [share(len(named[name]), len(group[name])) for name in ("single", "outside", "none")]
        misses = [share(n, len(named["single"])) for n in (off, count["wrong"])]
        table.append([f"{limit:g}".replace("inf", "any"), answered[0], *misses, *answered[1:]])
    return Table(title, head, table)


def times(lines: Sequence[Line]) -> Table:
    """Seconds of a diagnosis."""
    table = []
    for kind in [*sorted({line["kind"] for line in lines}), "all"]:
        took = [line["seconds"] for line in lines if kind in (line["kind"], "all")]
        table.append([kind, str(len(took)), *(f"{np.quantile(took, q):.1f}" for q in (0.5, 0.9, 1.0))])
    return Table("Seconds of a diagnosis", ["", "cases", "median", "90 %", "most"], table)


def fine(line: Line, alike: Judged) -> bool:
    """Whether a case needs no second look."""
    if line["group"] in MESSY:
        return among_small(line) in RIGHT_OF[line["group"]]
    if line["group"] in ("none", "outside"):
        return line.get("verdict") == ("none" if line["group"] == "none" else "unknown")
    return outcome(line, alike) in (*RIGHT, "part")


def confusions(lines: Sequence[Line], alike: Judged) -> Table:
    """Every case that is not right."""
    table = []
    for line in sorted(lines, key=lambda x: (x["group"], x["effect"], x["kind"])):
        if fine(line, alike):
            continue
        names = [" + ".join(sorted(o)) for o in options(line)] or line.get("effects", [])
        left = [f"{line[k] / line['floor']:.2f}" for k in ("before", "after")] if "error" not in line else ["", ""]
        top = f"{line['top'][0][0]} {line['top'][0][1]:.2f}" if line.get("top") else ""
        size = f"{line['size']:.1f}" if "size" in line else ""
        case = f"{line['kind']} {line['effect']} {line['seed']} {line['amplitude']}"
        said = line.get("error") or f"{line['verdict']}: {' | '.join(names)}"
        found = among_small(line) if line["group"] in MESSY else outcome(line, alike)
        table.append([case, size, found, said, top, *left])
    head = ["case (kind, effect, seed, amplitude)", "size", "", "said", "first", "before", "after"]
    return Table("Not right", head, table)


def calibrations(lines: Sequence[Line]) -> list[Table]:
    """Probabilities of the first name, causes outside the list left out: of every answer, and of those that name one set."""
    known = [x for x in lines if x["group"] not in ("outside", *MESSY)]
    alone = [x for x in known if x.get("verdict") == "effect"]
    return [
        calibration("Probability of the first name, every case with an answer", known),
        calibration("The same where the verdict is `effect`", alone),
    ]


def tables(lines: Sequence[Line], alike: Judged) -> list[Table]:
    """Every table that there are cases for."""
    single, pair, none, beyond = (
        [x for x in lines if x["group"] == name] for name in ("single", "pair", "none", "outside")
    )
    clear = [x for x in lines if x["group"] not in MESSY]
    found = [worth(lines, alike)]
    if single:
        found += [*(by(what, single, alike) for what in BY), shares(single, alike), where(single)]
        found += [families(word, single, alike) for word in ("subsystem", "coordinate")]
    found += [pairs(pair, alike)] if pair else []
    found += [nothing(none)] if none else []
    found += [outside(beyond, alike)] if beyond else []
    for name, title in (("messy", "Large causes among small ones"), ("small", "Small causes alone")):
        group = [x for x in lines if x["group"] == name]
        found += [messy(title, group)] if group else []
    found += [in_part(clear, alike)] if any(x.get("verdict") == "partial" for x in clear) else []
    return [*found, *calibrations(lines), risk(clear, alike), risk(clear, alike, by_floors=True), times(lines)]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", type=Path)
    parser.add_argument("--confusions", action="store_true")
    a = parser.parse_args()
    lines, alike = read(a.path), judged(a.path)
    if not lines:
        parser.error(f"{a.path} holds no results")
    for table in tables(lines, alike):
        show(*table)
    if a.confusions:
        show(*confusions(lines, alike))


if __name__ == "__main__":
    main()
