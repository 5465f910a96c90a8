"""What a later run of some cases says otherwise: `python -m experiments.blind.changed EARLIER.jsonl LATER.jsonl [--each]`.

Cases that both files hold, by their outcome (see `score`) in each. `--each` lists every case that is answered otherwise in any way: the
verdict, the names, the alternatives, the signal, or a gap by more than `--gap` floors.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from experiments.blind.draw import read
from experiments.blind.score import TITLES, Line, judged, judgement
from experiments.speed.table import Table, show

GAP = 0.01
"""Floors by which a gap may move without being listed."""


def differences(old: Line, new: Line, gap: float = GAP) -> list[str]:
    """What two answers to a case say otherwise, in words; the order of alternatives, and of names in them, is none."""
    found = [f"{key}: {old.get(key)} → {new.get(key)}" for key in ("error", "verdict") if old.get(key) != new.get(key)]
    if "error" in old or "error" in new:
        return found
    said, says = [" + ".join(line["effects"]) or "-" for line in (old, new)]
    found += [f"names: {said} → {says}"] if said != says else []
    beside, besides = ({frozenset(names) for names in line["alternatives"]} for line in (old, new))
    for sign, names in (("-", beside - besides), ("+", besides - beside)):
        found += [f"alternative {sign} {' + '.join(sorted(one))}" for one in sorted(names, key=sorted)]
    if old["signal"] != new["signal"]:  # whose gaps cannot be compared
        return [*found, f"signal: {old['signal']} → {new['signal']}"]
    off = {key: (new[key] - old[key]) / old["floor"] for key in ("before", "after", "floor")}
    return found + [f"{key}: {by:+.3g} floors" for key, by in off.items() if not abs(by) <= gap]


def both_of(earlier: Sequence[Line], later: Sequence[Line]) -> list[tuple[Line, Line]]:
    """The earlier and the later answer to each case that has both."""
    first = {line["index"]: line for line in earlier}
    return [(first[line["index"]], line) for line in later if line["index"] in first]


def each(both: Sequence[tuple[Line, Line]], gap: float) -> Table:
    """Every case that is answered otherwise."""
    table = []
    for old, new in both:
        if found := differences(old, new, gap):
            case = f"{new['index']}: {new['kind']} {new['effect']} {new['seed']}"
            table.append([case, "; ".join(found)])
    head = ["case (index: kind, effect, seed)", "earlier → later"]
    return Table(f"Answered otherwise: {len(table)} of {len(both)} cases", head, table)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("earlier", type=Path)
    parser.add_argument("later", type=Path)
    parser.add_argument("--each", action="store_true", help="list the cases that are answered otherwise")
    parser.add_argument(
        "--gap", type=float, default=GAP, metavar="FLOORS", help=f"that a gap may move by; {GAP:g} without"
    )
    a = parser.parse_args()
    first, alike = read(a.earlier), judged(a.earlier)
    now = judged(a.earlier, a.later)  # what the oracle has said of the same logs still holds
    both = both_of(first, read(a.later))
    print(f"{len(both)} cases in both files; {len(first) - len(both)} in the earlier one alone")
    for group, title in TITLES.items():
        if not any(new["group"] == group for _, new in both):
            continue
        pairs = [(judgement(old, alike), judgement(new, now)) for old, new in both if new["group"] == group]
        count = Counter(pairs)
        table = [[old, new, str(count[old, new])] for old, new in sorted(count, key=lambda p: (p[0] != "right", p))]
        show(f"{title}: {len(pairs)} cases", ["earlier", "later", "cases"], table)
    if a.each:
        show(*each(both, a.gap))


if __name__ == "__main__":
    main()
