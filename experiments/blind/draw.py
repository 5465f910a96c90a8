"""Draws a set of cases of known size, one JSON line each, and what their logs carry by the simulator's own fits.

`python -m experiments.blind.draw calibrate [--processes 1 | --scheduler ADDRESS] [--group single …] [--limit 20]` appends to
`experiments/blind/sets/calibrate.jsonl` what is not there yet, with a limit at most so many places of each group. Look at `calibrate`, `explore`, `partial` and `messy` as often as you like. `test` and `second` have been looked at. Of `final` a part
has been drawn and diagnosed once, all of its messy places among it. `fourth` is drawn whole; it was drawn before the search was frozen that was asked about it,
and no case of it had been diagnosed. Its cases, and the places that `final`, `fresh` and `third` leave, are for the next claim, each on a search that is frozen
before the case is diagnosed.

A line holds the place in the set and group, kind, effect, the size wanted, seed and amplitude. By fits from the truth it also holds:

* the size, and what the true effect leaves (`left`, as a size);
* the size where initial states follow the start rule (`by_rule`): a run that moves within its first 0.5 s may hide in them what is missing;
* misfits of the runs fitted without and with the effect, and relative errors of its numbers;
* `repeatable` (see the oracle), and of a pair the size without either name (`needed`);
* why seeds before this one were `dropped`, all of them where the line has no seed.

Of the groups `messy` (large causes among small ones) and `small` (small ones alone) `effect` has the large causes, `amplitude` is that of
each, and `sizes` says how large each is by itself. `small`, `mess` and `mess_size` hold the rest (see `messy`). `size` is then what the rig
file leaves of the whole, and `left` what it leaves with the large causes added: the small ones.
"""

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TextIO, TypeVar

import numpy as np

from experiments.blind.cases import KINDS, Case, kinds_of, make_case, split
from experiments.blind.draws import EFFECTS
from experiments.blind.messy import case_of, small_parts
from experiments.blind.oracle import STEP, Fit, by_rule, judge, perfect, refit, size
from experiments.blind.outside import OUTSIDE
from experiments.blind.rigs import FIELD
from experiments.blind.sizes import COARSE, LARGEST, SMALLEST, WITHIN, OutOfReach, sized, sized_by
from experiments.workers import Workers, pool

T = TypeVar("T")
SETS = Path(__file__).parent / "sets"
GROUPS = ("single", "outside", "pair", "none", "messy", "small")
TRIES = 8  # seeds of one place in a set
APART = 2000  # between the seeds of two tries, more than a set has places
OUTSIDE_FROM = 5.0  # smallest size of a cause outside the list
LARGE_FROM = 8.0  # smallest size of a large cause among small ones
LEAVES = 0.5  # largest share of the size that the true effect may leave
SEEN = 1.05  # least factor by which the effect must raise the misfit of the runs that are fitted
OF_PAIR = 2.0  # size that must be left where a pair lacks either name


@dataclass(frozen=True)
class Plan:
    """How many cases a set has, and its first seed."""

    first: int
    each: int  # of every effect
    wrong: int  # of every number of the rig file
    outside: int  # of every cause outside the list
    pairs: int
    none: int
    messy: int = 0
    small: int = 0


PLANS = {
    "calibrate": Plan(30_000, each=4, wrong=2, outside=5, pairs=20, none=100),
    "explore": Plan(50_000, each=8, wrong=3, outside=10, pairs=40, none=200),
    "test": Plan(70_000, each=8, wrong=3, outside=10, pairs=40, none=200),
    "second": Plan(110_000, each=8, wrong=3, outside=10, pairs=40, none=200),
    "partial": Plan(150_000, each=1, wrong=0, outside=2, pairs=20, none=10),
    "messy": Plan(190_000, each=0, wrong=0, outside=0, pairs=0, none=0, messy=60, small=30),
    # of 40 pairs 31 to 37 were found, and 98 % of the single causes; the rest is always found
    "final": Plan(230_000, each=10, wrong=5, outside=20, pairs=240, none=200, messy=200, small=200),
    "fresh": Plan(270_000, each=0, wrong=0, outside=3, pairs=0, none=0, messy=120, small=60),
    "third": Plan(310_000, each=1, wrong=0, outside=3, pairs=20, none=20, messy=60, small=0),
    "fourth": Plan(350_000, each=2, wrong=1, outside=3, pairs=20, none=20, messy=60, small=0),
}


@dataclass(frozen=True)
class Place:
    """One case to be drawn."""

    index: int
    group: str  # one of GROUPS
    kind: str
    effect: str
    wanted: float | None  # size


def places(name: str) -> list[Place]:
    """What a set is to hold; single effects in turn in every kind of rig that can show them."""
    plan = PLANS[name]
    rng = np.random.default_rng(plan.first)

    def between(low: float) -> float:
        return float(f"{np.exp(rng.uniform(np.log(low), np.log(LARGEST))):.3g}")

    found: list[tuple[str, str, str, float | None]] = []
    singles = [(e, plan.each) for e in EFFECTS] + [(f"parameter.{n}", plan.wrong) for n in FIELD]
    for group, names, low in (
        ("single", singles, SMALLEST),
        ("outside", [(e, plan.outside) for e in OUTSIDE], OUTSIDE_FROM),
    ):
        for effect, count in names:
            kinds = rng.permutation(kinds_of(effect))
            found += [(group, str(kinds[k % len(kinds)]), effect, between(low)) for k in range(count)]
    found += [("pair", KINDS[k % 3], pair(KINDS[k % 3], rng), between(OUTSIDE_FROM)) for k in range(plan.pairs)]
    found += [("none", KINDS[k % 3], "none", None) for k in range(plan.none)]
    found += [("messy", KINDS[k % 3], large(KINDS[k % 3], 1 + k // 3 % 2, rng), None) for k in range(plan.messy)]
    found += [("small", KINDS[k % 3], "none", None) for k in range(plan.small)]
    return [Place(k, *one) for k, one in enumerate(found)]


def pair(kind: str, rng: np.random.Generator) -> str:
    """Two effects that a rig of a kind can have at the same time."""
    together = ({"axis.backlash", "axis.flexible_coupling"}, {"drive.delay", "sensor.delay"})
    able = [name for name in EFFECTS if kind in kinds_of(name)]
    while True:
        names = sorted(str(n) for n in rng.choice(able, 2, replace=False))
        if {*names} not in together:
            return "+".join(names)


def large(kind: str, count: int, rng: np.random.Generator) -> str:
    """One effect, or two."""
    return pair(kind, rng) if count > 1 else str(rng.choice([name for name in EFFECTS if kind in kinds_of(name)]))


def carried(case: Case, base: Fit | None = None) -> dict:
    """The oracle's judgement, in the simulator's own step where a coarser one leaves something."""
    if base is None:
        return judge(case, step=COARSE)
    base = refit(case, None, step=COARSE, first=base.numbers)  # nearer to its end
    found = judge(case, base, COARSE)
    found = judge(case, base, STEP) if found["left"] > 0.5 else found
    if not SMALLEST / WITHIN < found["size"] < LARGEST * WITHIN:
        raise OutOfReach(f"size {found['size']:.3g} at the end of the refit, in the simulator's own step")
    if found["repeatable"] > 1.0:
        raise OutOfReach(f"no run can be repeated: they spread by {found['repeatable']:.3g} floors")
    if found["left"] > LEAVES * found["size"]:
        raise OutOfReach(f"the true effect leaves {found['left']:.3g} of {found['size']:.3g}")
    if found["misfit_without"] < SEEN * found["misfit_with"]:
        raise OutOfReach(f"only the runs held out show it: misfit {found['misfit_without']:.3g}")
    ruled = refit(case, None, step=COARSE, first=base.numbers, begin=by_rule)
    found["by_rule"] = size(ruled.gap, perfect(case, COARSE, by_rule))
    if found["by_rule"] < SMALLEST / WITHIN:
        raise OutOfReach(f"first states hide it: size {found['by_rule']:.3g} by the start rule")
    return found


def needed(case: Case) -> dict[str, float]:
    """Size that is left of a pair without either name."""
    noise = perfect(case, COARSE)
    first, second = split(case.truth["effect"])
    left = {}
    for name, other in ((first, second), (second, first)):
        left[name] = size(refit(case, other, step=COARSE).gap, noise)
        if left[name] < OF_PAIR:
            raise OutOfReach(f"{name} hardly matters: size {left[name]:.3g} without it")
    return left


def draw(name: str, place: Place) -> dict:
    """The case at a place, or why there is none."""
    row = {"set": name, "index": place.index, "group": place.group, "kind": place.kind, "effect": place.effect}
    seed = PLANS[name].first + place.index
    if place.group in ("messy", "small"):
        return row | among_small(place, seed)
    if place.wanted is None:
        case = make_case(place.kind, "none", seed)
        return row | {"seed": seed, "amplitude": 1.0} | rounded(carried(case))
    row["wanted"], dropped = place.wanted, []
    for trial in range(TRIES):
        try:
            found = sized(place.kind, place.effect, seed + APART * trial, place.wanted)
            more = carried(found.case, found.base)
            if place.group == "pair":
                more["needed"] = needed(found.case)
        except OutOfReach as reason:
            dropped.append(str(reason))
            continue
        row |= {"seed": seed + APART * trial, "amplitude": found.case.truth["amplitude"]}
        row |= rounded(more)
        break
    return row | ({"dropped": dropped} if dropped else {})


def among_small(place: Place, seed: int) -> dict:
    """A rig with small causes: its large ones sized one by one and looked at together, then what is small."""
    dropped = []
    for one in range(seed, seed + APART * TRIES, APART):
        try:
            found = {"seed": one, **sized_alone(place, one)}
            found |= small_parts(place.kind, place.effect, one, found["amplitude"])
            found |= rounded(whole(case_of({"kind": place.kind, "effect": place.effect, **found})))
        except OutOfReach as reason:
            dropped.append(str(reason))
            continue
        return found | ({"dropped": dropped} if dropped else {})
    return {"dropped": dropped}


def sized_alone(place: Place, seed: int) -> dict:
    """Amplitude and size of each large cause by itself, where the causes together can be seen and none hides another."""
    names, rng = split(place.effect), np.random.default_rng([seed, KINDS.index(place.kind), 100])
    amplitude, sizes = dict.fromkeys(names, 0.0), {}
    base: Fit | None = None
    for name in names:
        wanted = float(np.exp(rng.uniform(np.log(LARGE_FROM), np.log(LARGEST / WITHIN))))

        def alone(strength: float, raw: bool, name: str = name) -> Case:
            return make_case(place.kind, place.effect, seed, dict.fromkeys(names, 0.0) | {name: strength}, raw)

        found = sized_by(alone, wanted)
        amplitude[name], sizes[name], base = found.case.truth["amplitude"][name], found.size, found.base
    if base is not None:
        case = make_case(place.kind, place.effect, seed, amplitude, raw=False)
        carried(case, base)
        if len(names) > 1:
            needed(case)
    return {"amplitude": amplitude, "sizes": rounded(sizes)}


def whole(case: Case) -> dict:
    """Size of everything in a messy case, and of what its large causes leave; their floor holds what varies."""
    noise, without = perfect(case, COARSE), refit(case, None, step=COARSE)
    found = size(without.gap, noise)
    if not case.truth["effects"]:
        return {"size": found, "left": found}
    if found < SMALLEST:
        raise OutOfReach(f"what varies hides it: size {found:.3g} of the whole")
    return {"size": found, "left": size(refit(case, case.truth["effect"], step=COARSE).gap, noise)}


def rounded(values: dict) -> dict:
    """Numbers to four digits."""
    return {k: rounded(v) if isinstance(v, dict) else float(f"{v:.4g}") for k, v in values.items()}


def read(path: Path) -> list[dict]:
    """The lines of a file of JSON lines, if there is any; what was cut off while it was written is left out."""
    lines = path.read_text().splitlines(keepends=True) if path.exists() else []
    return [json.loads(line) for line in lines if line.endswith("\n")]


def appending(path: Path) -> TextIO:
    """The file at its end, without what was cut off while it was written."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = path.read_text() if path.exists() else ""
    if not text.endswith("\n"):
        path.write_text(text[: text.rfind("\n") + 1])
    return path.open("a")


def some(rows: Sequence[T], limit: int | None) -> list[T]:
    """At most `limit` of some rows, drawn at random: an even step may fall in step with the kinds of rigs."""
    chosen = np.random.default_rng(len(rows)).permutation(len(rows))[:limit]
    return [rows[k] for k in sorted(chosen)]


def cases(name: str) -> Iterator[dict]:
    """The cases of a set that were found."""
    return iter({row["index"]: row for row in read(SETS / f"{name}.jsonl") if "seed" in row}.values())


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=PLANS)
    Workers.options(parser, processes=1)
    parser.add_argument("--group", nargs="+", choices=GROUPS, default=GROUPS)
    parser.add_argument("--limit", type=int, help="places of each group, drawn at random among its own")
    a = parser.parse_args()
    path = SETS / f"{a.name}.jsonl"
    done = {row["index"] for row in read(path)}
    wanted = [p for name in a.group for p in some([p for p in places(a.name) if p.group == name], a.limit)]
    todo = [place for place in wanted if place.index not in done]
    with pool(Workers.of(a)) as executor, appending(path) as file:
        for k, row in enumerate(executor.map(partial(draw, a.name), todo), 1):
            file.write(json.dumps(row) + "\n")
            file.flush()
            print(f"\r{k} of {len(todo)}", end="", flush=True)
    print()


if __name__ == "__main__":
    main()
