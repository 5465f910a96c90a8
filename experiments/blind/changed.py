"""What a later run of some cases says otherwise: `python -m experiments.blind.changed EARLIER.jsonl LATER.jsonl`.

Cases with one true name, a cause outside the list or nothing missing that both files hold, by their outcome (see `score`) in each.
"""

import argparse
from collections import Counter
from pathlib import Path

from experiments.blind.draw import read
from experiments.blind.score import RIGHT, Judged, Line, judged, outcome
from experiments.speed.table import show


def judgement(line: Line, alike: Judged) -> str:
    """`right`, or what it is instead; of a cause outside the list `unknown` is right, where nothing is missing `none`."""
    if line["group"] in ("outside", "none"):
        right = "unknown" if line["group"] == "outside" else "none"
        said = line.get("verdict", "error")
        return "right" if said == right else said if said in ("none", "unknown", "error") else "wrong"
    found = outcome(line, alike)
    return "right" if found in RIGHT else found


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("earlier", type=Path)
    parser.add_argument("later", type=Path)
    a = parser.parse_args()
    first, alike = {line["index"]: line for line in read(a.earlier)}, judged(a.earlier)
    now = judged(a.later)
    for index, same in alike.items():  # what the oracle has said of the same logs still holds
        now.setdefault(index, set()).update(same)
    both = [(first[line["index"]], line) for line in read(a.later) if line["index"] in first]
    for group, title in (("single", "One cause"), ("outside", "A cause outside the list"), ("none", "Nothing missing")):
        pairs = [(judgement(old, alike), judgement(new, now)) for old, new in both if new["group"] == group]
        count = Counter(pairs)
        table = [[old, new, str(count[old, new])] for old, new in sorted(count, key=lambda p: (p[0] != "right", p))]
        show(f"{title}: {len(pairs)} cases", ["earlier", "later", "cases"], table)


if __name__ == "__main__":
    main()
