"""House rules that no linter holds, counted for any checkout: `python -m experiments.house [FOLDER] [--list] [--room ROOM]`."""

import argparse
from pathlib import Path
from statistics import median

from experiments.house.circles import cycles, module_edges, room_edges
from experiments.house.code import (
    LONGEST_FUNCTION,
    code_length,
    effect_mentions,
    long_functions,
    root_modules,
    stray_limits,
)
from experiments.house.docstrings import lacks_of, public_functions
from experiments.house.mirror import private_in_tests, untested_modules
from experiments.house.prose import WIDEST_CELL, sentences, wide_cells
from experiments.house.rules import RULES
from experiments.house.tree import Tree, functions


def counts(tree: Tree) -> dict[str, str | int]:
    """What is counted, in the order of the table."""
    longest = max(((code_length(m, n), f"{m.path} {name}") for m, name, n in functions(tree)), default=(0, ""))
    lacks = [{kind for kind, _ in lacks_of(tree, public)} for public in public_functions(tree)]
    rings, rooms = cycles(module_edges(tree)), cycles(room_edges(tree))
    mentions, limits, private = effect_mentions(tree), stray_limits(tree), private_in_tests(tree)
    length = [len(one.split()) for page in tree.pages.values() for one in sentences(page)]
    return {
        "modules of the package": len(tree.package),
        "modules in the root": len(root_modules(tree)),
        "effects named outside effects/": f"{len(mentions)} in {len({f.path for f in mentions})} modules",
        "limits outside the diagnosis settings": f"{len(limits)} in {len({f.path for f in limits})} modules",
        "circles of modules": f"{len(rings)}, {sum(map(len, rings))} modules in them",
        "circles of rooms and root modules": f"{len(rooms)}, {sum(map(len, rooms))} rooms and modules in them",
        "longest function": f"{longest[0]} lines, {longest[1]}",
        f"functions of more than {LONGEST_FUNCTION} lines": len(long_functions(tree)),
        "public functions": len(lacks),
        "… without all arguments under Args": sum("Args" in kinds for kinds in lacks),
        "… without Returns": sum("Returns" in kinds for kinds in lacks),
        "… without a number's unit": sum("unit of" in kinds for kinds in lacks),
        "modules without a mirrored test": len(untested_modules(tree)),
        "tests' touches of private members": f"{len(private)} in {len({f.path for f in private})} files",
        "sentences of README and docs": len(length),
        "… median length": f"{median(length):g} words" if length else "–",
        "… longest": f"{max(length)} words" if length else "–",
        "… of more than 20 words": sum(n > 20 for n in length),
        f"table cells over {WIDEST_CELL} characters": sum(map(wide_cells, tree.pages.values())),
        "README": f"{len(tree.pages.get('README.md', '').splitlines())} lines",
    }


def main() -> None:
    """Prints the counts of a checkout, and with `--list` every breach."""
    parser = argparse.ArgumentParser(prog="python -m experiments.house", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parents[2])
    parser.add_argument("--list", action="store_true", help="every breach with its file and line")
    parser.add_argument("--room", help="only breaches in this room")
    asked = parser.parse_args()
    tree = Tree(asked.folder)
    if not (asked.list or asked.room):
        table = counts(tree)
        width = max(map(len, table))
        print("\n".join(f"{name:{width}s}  {value}" for name, value in table.items()))
        return
    for rule, breaches in RULES.items():
        found = [f for f in breaches(tree) if asked.room in (None, f.room)]
        print(f"{rule}: {len(found)}", *(f"  {f.path}:{f.line}: {f.what}" for f in sorted(found)), sep="\n")


if __name__ == "__main__":
    main()
