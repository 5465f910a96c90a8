"""Is what the library names instead of the truth as good as the truth? The simulator, refitted with both, answers.

`python -m experiments.blind.inseparable RESULTS.jsonl [--processes 2 | --scheduler ADDRESS]` appends to `RESULTS.inseparable.jsonl`, which `score` reads.
A hypothesis counts as inseparable where its refit leaves no more than that of the true effect, to `TOLERANCE` floors. This has to
hold of the runs fitted (all columns together) and of those held out (each column). A hypothesis with more names than the truth is
not asked about, except for causes outside the list. The refit may end in a local minimum, so this errs towards separable.
Where small causes stand beside the large ones, both refits have these too, and a hypothesis of true names alone is no question.
"""

import argparse
from functools import partial
from json import dumps
from pathlib import Path

from experiments.blind.cases import kinds_of, split
from experiments.blind.draw import appending, read
from experiments.blind.draws import EFFECTS
from experiments.blind.messy import case_of, prepared_of
from experiments.blind.oracle import Fit, perfect, refit
from experiments.blind.rigs import FIELD
from experiments.blind.sizes import COARSE
from experiments.workers import Workers, pool

TOLERANCE = 0.2  # floors
TRIES = 8  # random draws from which the other hypothesis is refitted
MOST = 4  # hypotheses of a case that are asked about
EVALUATIONS = 100  # at most, of a refit


def beside(path: Path) -> Path:
    """The file of the judgements on the results in `path`."""
    return path.with_suffix(".inseparable.jsonl")


def options(line: dict) -> list[frozenset[str]]:
    """The hypotheses that a diagnosis offers, the first one first."""
    if line.get("verdict") not in ("effect", "ambiguous", "partial"):
        return []
    return [frozenset(names) for names in [line["effects"], *line["alternatives"]]]


def questions(line: dict) -> list[frozenset[str]]:
    """Those of the hypotheses offered that the oracle should be asked about, and can be."""
    truth, small = frozenset(split(line["effect"])), {*line.get("small", ())}
    same = {other for others in line["same_as"].values() for other in others}
    found = []
    for option in options(line) if truth else []:
        longer = len(option - small) > len(truth) and line["group"] != "outside"
        known = all(
            name in EFFECTS or (name.removeprefix("parameter.") in FIELD and name.startswith("parameter."))
            for name in option
        )
        right = option <= truth | small if small else option == truth
        if not right and not longer and not option <= same and known:
            found += [option] * all(line["kind"] in kinds_of(name) for name in option)
    return found[:MOST]


def as_good(other: Fit, true: Fit, noise: dict[str, float]) -> bool:
    """Whether one refit leaves no more than another, of the runs fitted and of those held out."""
    near = TOLERANCE**2
    held_out = all(other.gap[c] ** 2 <= max(true.gap[c], noise[c]) ** 2 + near * noise[c] ** 2 for c in noise)
    return held_out and other.misfit**2 <= max(true.misfit, 1.0) ** 2 + near


def ask(line: dict, done: set[tuple[int, str]]) -> list[dict]:
    """A judgement for each open question of a case."""
    open_ones = [o for o in questions(line) if (line["index"], "+".join(sorted(o))) not in done]
    if not open_ones:
        return []
    case, small = case_of(line), line.get("small", {})
    again = partial(refit, case, evaluations=EVALUATIONS, step=COARSE, prepared=prepared_of(line))
    true, noise, found = again("+".join([*split(line["effect"]), *small])), perfect(case, COARSE), []
    for option in open_ones:
        name = "+".join(sorted(option))
        other = again("+".join(sorted(option | {*small})), tries=TRIES)
        judged = {"index": line["index"], "option": name, "inseparable": as_good(other, true, noise)}
        found.append(judged | {"misfit": round(other.misfit, 4), "misfit_true": round(true.misfit, 4)})
    return found


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    Workers.options(parser, processes=1)
    a = parser.parse_args()
    done = {(one["index"], one["option"]) for one in read(beside(a.path))}
    with pool(Workers.of(a)) as executor, appending(beside(a.path)) as file:
        for found in executor.map(partial(ask, done=done), read(a.path)):
            file.writelines(dumps(judged) + "\n" for judged in found)
            file.flush()


if __name__ == "__main__":
    main()
