"""What a further run is worth: outcomes of the answers after it, and tables of them.

`python -m experiments.played.score build/played.jsonl`

An *option* is a set of names that an answer claims. It is true where it is what the rig lacks, up to names that the label declares to be
the same thing (`same_as`). The outcomes are:

* named: every option is true.
* open: some option is true and some is not.
* part: no option is true, but all their names are (of two causes one is named).
* wrong: no option is true otherwise. A name too many counts here.
* unknown, none, error: nothing is claimed.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.blind.draw import read
from experiments.blind.inseparable import options
from experiments.blind.score import Line, accepted, matches, share
from experiments.speed.table import Table, show

OUTCOMES = ("named", "open", "part", "wrong", "unknown", "none", "error")
RUNS = ("proposed", "random")
DRAWS = 10_000  # of the cases, for an interval
STATES = {
    "played": "played",
    "closed": "no longer left open by a diagnosis of today: nothing to play",
    "same": "no run proposed: the rivals are the same thing for this kind of rig, says the diagnosis",
    "no command": "no run proposed: no command as large as those of the logs separates the rivals, says the diagnosis",
    "no plan": "no run proposed, for other reasons",
    "error": "the first diagnosis failed",
}
"""What becomes of a case, with its words."""
SENTENCES = {"same": "for this kind of rig they are the same thing", "no command": "separate"}
"""Words of a diagnosis that proposes no run."""


def outcome(answer: dict, line: Line) -> str:
    """One of `OUTCOMES`, of an answer to the case of a line."""
    if "error" in answer:
        return "error"
    offered = options(answer)
    if not offered:
        return answer["verdict"]
    fits = [matches(option, line) for option in offered]
    if any(fits):
        return "named" if all(fits) else "open"
    return "part" if all(option <= {*accepted(line)} for option in offered) else "wrong"


def left_open(answer: dict, line: Line) -> bool:
    """Whether an answer has rivals that are not all the same thing as the truth."""
    return answer.get("verdict") == "ambiguous" and outcome(answer, line) != "named"


def state(line: Line) -> str:
    """What became of a case, one of `STATES`."""
    if "error" in line["before"]:
        return "error"
    if not left_open(line["before"], line):
        return "closed"
    if line["proposed"] is not None:
        return "played"
    return next((name for name, words in SENTENCES.items() if words in line["proposal"]), "no plan")


def ratio(proposed: Sequence[bool], random: Sequence[bool]) -> str:
    """How often the one happens over how often the other does, with a 95 % interval by drawing the cases again."""
    both = np.array([proposed, random], float)
    if not both[1].any():
        return "–"
    drawn = both[:, np.random.default_rng(0).integers(both.shape[1], size=(DRAWS, both.shape[1]))].sum(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = drawn[0] / drawn[1]
    low, high = np.quantile(np.nan_to_num(found, nan=1.0, posinf=np.inf), (0.025, 0.975), method="nearest")
    return f"{both[0].sum() / both[1].sum():.2f} ({low:.2f} to {high:.2f})"


def after(lines: Sequence[Line]) -> Table:
    """Outcomes after the proposed run and after the random one, of the cases that were played."""
    table = []
    for run in RUNS:
        found = [outcome(line[run], line) for line in lines]
        still = sum(left_open(line[run], line) for line in lines)
        count, n = Counter(found), len(lines)
        shares = (share(hits, n) for hits in (still, count["named"], count["wrong"]))
        table.append([run, str(n), *shares, *(str(count[name]) for name in OUTCOMES)])
    head = ["further run", "cases", "left open", "truth alone", "wrong", *OUTCOMES]
    return Table("After a further run", head, table)


def tables(lines: Sequence[Line]) -> list[Table]:
    """What became of the cases, outcomes after each run, the two runs against each other, and seconds."""
    states = Counter(state(line) for line in lines)
    found = [
        Table(
            "Cases", ["", "of", str(len(lines))], [[words, name, str(states[name])] for name, words in STATES.items()]
        )
    ]
    played = [line for line in lines if state(line) == "played"]
    if not played:
        return found
    proposed, random = ([left_open(line[run], line) for line in played] for run in RUNS)
    pairs = Counter(zip(proposed, random, strict=True))
    against = [
        ["left open after both", str(pairs[True, True])],
        ["after the proposed run alone", str(pairs[True, False])],
        ["after the random run alone", str(pairs[False, True])],
        ["after neither", str(pairs[False, False])],
        ["left open after the proposed run, over after the random one (wanted: 0.5)", ratio(proposed, random)],
    ]
    seconds = [line["seconds"] for line in lines]
    took = [f"{np.quantile(seconds, q):.0f}" for q in (0.5, 0.9, 1.0)]
    return [
        *(*found, after(played)),
        Table("One against the other", ["", "cases"], against),
        Table("Seconds of a case, up to three diagnoses", ["median", "90 %", "most"], [took]),
    ]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", type=Path)
    for table in tables(read(parser.parse_args().path)):
        show(*table)


if __name__ == "__main__":
    main()
