"""Is what was changed on a measured rig named? `python -m experiments.real.run [--set develop] [--limit N] [--most SECONDS] [-o build/real.jsonl]`

Each pair of `manifest.toml` takes two set-ups of one rig: another payload, arm, gain or motor, or the same with other runs. The rig is
fitted to the logs of the first one. With all its numbers fixed, it is then given to `rwjax diagnose` with the logs of the second one. With
`--friction` the rig file leaves the axis's friction free. The diagnosis sees the rig file and the logs alone. A line is appended for each
pair, with the commit; pairs that the file holds are skipped. The table counts what is claimed: all that was changed, a part of it, or a name
that is wrong. `--fair` prints instead what the fitted rig leaves of its own logs and of the given ones (`fair.py`).
"""

import argparse
import json
from collections.abc import Collection, Sequence
from pathlib import Path
from time import perf_counter

from experiments.blind.draw import some
from experiments.commit import commit
from experiments.real import fair
from experiments.real.pairs import Pair, given, pairs, rig_of, with_friction_free
from experiments.real.published import PUBLISHED
from experiments.realdata import ROOT
from experiments.speed.table import machine, show
from rwjax.diagnosis.diagnosis import Diagnosis, diagnose
from rwjax.diagnosis.verdict import CLAIMS
from rwjax.fitting.processes import Team

SAME = {
    "parameter.axis.inertia": "parameter.motor.inertia",
}
"""Names of what the library says is the same thing, by one of them."""


def diagnosed(pair: Pair, most: float) -> Diagnosis:
    """What the second set-up's logs are said to lack."""
    rig, logs = given(pair, rig_of(pair))
    with Team() as team:
        return diagnose(rig, logs, budget=most, team=team)


def outcome(
    verdict: str, sets: Sequence[Sequence[str]], changed: Sequence[str], published: Collection[str] = ()
) -> str:
    """What an answer is worth.

    Args:
        verdict: the verdict.
        sets: the named set and its alternatives.
        changed: what was changed, none of it where nothing was.
        published: effects that the rig has in every set-up, as its authors say.

    Returns:
        Where something was changed: `named`, `in part`, `wrong` or the verdict that claims nothing; `named with others` where sets stand
        beside the changed names that hold others; `beside published` where no set is of changed names alone, and one is of some of them
        and of published effects, which the rig file lacks. Where nothing was: `nothing` for such a verdict, `published` where one of the sets
        is of published effects alone, which are no change, and else `wrong`.
    """
    if not changed:
        if verdict not in CLAIMS:
            return "nothing"
        return "published" if any({*one} <= {*published} for one in sets) else "wrong"
    if verdict not in CLAIMS:
        return verdict
    true = [frozenset(SAME.get(name, name) for name in e) for e in sets]  # a thing by one of its names
    wanted = frozenset(SAME.get(name, name) for name in changed)
    inside = [len(e) == len(said) and e <= wanted for e, said in zip(true, sets, strict=True)]
    if wanted in (e for e, right in zip(true, inside, strict=True) if right):
        return "named" if all(inside) else "named with others"
    if any(inside):
        return "in part"
    beside = any(
        len(e) == len(said) and e & wanted and e <= wanted | {*published} for e, said in zip(true, sets, strict=True)
    )
    return "beside published" if beside else "wrong"


def line(pair: Pair, most: float) -> dict:
    """The result of a pair."""
    begin = perf_counter()
    found = diagnosed(pair, most).json()
    sets = [found["effects"], *found["alternatives"]]
    return {
        "name": pair.name,
        **pair._asdict(),
        "commit": commit(),
        "outcome": outcome(found["verdict"], sets, pair.changed, PUBLISHED[pair.data].present),
        **{key: found[key] for key in ("verdict", "complete", "effects", "alternatives", "refused", "remarks")},
        **{key: found["gap"][key] for key in ("signal", "before", "after", "floor", "closed", "ci95")},
        "ranking": found["ranking"][:10],
        "seconds": round(perf_counter() - begin, 1),
    }


def name_of(one: dict) -> str:
    """Name of a line's pair; lines written before there were other sets hold none."""
    return one.get("name") or f"{one['data']}: {one['fitted']} to {one['given']}"


def report(lines: Sequence[dict]) -> None:
    """Prints the table."""
    rows = [
        [
            name_of(one),
            " + ".join(one["changed"]) or "nothing",
            one["outcome"],
            f"{one['verdict']}: {' + '.join(one['effects']) or '-'}",
            *(f"{1e3 * one[key]:.1f}" for key in ("before", "after", "floor")),
            f"{one['seconds']:.0f}",
        ]
        for one in lines
    ]
    head = ["rig", "changed", "outcome", "answer", "before [10⁻³ SI]", "after [10⁻³ SI]", "floor [10⁻³ SI]", "time [s]"]
    show(f"Measured rigs with a withheld label; {machine()}", head, rows)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="path", type=Path, default=ROOT / "build" / "real.jsonl")
    parser.add_argument("--set", dest="name", choices=("develop", "frozen", "repeated"), default="develop")
    parser.add_argument("--most", type=float, default=float("inf"), metavar="SECONDS", help="of a diagnosis")
    parser.add_argument(
        "--fair", action="store_true", help="print what fitted rigs leave of all pairs, and diagnose nothing"
    )
    parser.add_argument(
        "--friction", action="store_true", help="pairs whose friction was not changed, their rig files leaving it free"
    )
    parser.add_argument("--only", default="", metavar="WORDS", help="pairs whose name holds this")
    parser.add_argument("--limit", type=int, help="pairs at most, drawn at random, always the same")
    a = parser.parse_args()
    asked = [pair for pair in pairs() if a.only in pair.name]
    asked = asked if a.limit is None else some([pair for pair in asked if pair.set == a.name], a.limit)
    if a.friction:
        asked = [freed for pair in asked if (freed := with_friction_free(pair)).free]
    if a.fair:
        return fair.report(asked)
    a.path.parent.mkdir(parents=True, exist_ok=True)
    held = a.path.read_text().splitlines() if a.path.exists() else []
    known = {name_of(json.loads(text)) for text in held}
    for pair in asked:
        if pair.set == a.name and pair.name not in known:
            with a.path.open("a") as file:
                file.write(json.dumps(line(pair, a.most)) + "\n")
    return report([json.loads(text) for text in a.path.read_text().splitlines()])


if __name__ == "__main__":
    main()
