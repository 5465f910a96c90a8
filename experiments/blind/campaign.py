"""Diagnoses every case of a set through the library's own readers, one JSON line each.

`python -m experiments.blind.campaign calibrate -o build/calibrate.jsonl [--processes 2 | --scheduler ADDRESS] [--limit N] [--group single …]
[--index 17 …] [--of RESULTS.jsonl] [--told large|all]` skips what the file holds already. With a limit the cases are drawn at random from the set, or from
the groups asked for. `--of` takes the cases of earlier results, which `experiments.blind.changed` then compares. With `--told` the true names are the only
candidates: of a messy case the large ones, or all that the library has, and then up to five of them in a set. What is not named even then
is refused by the tests of a claim, not missed by the search. A file holds the lines of one way of telling.
"""

import argparse
import tempfile
import traceback
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from json import dumps
from pathlib import Path
from time import perf_counter

from experiments.blind.cases import KINDS, split, write_case
from experiments.blind.draw import GROUPS, PLANS, appending, cases, read, some
from experiments.blind.messy import case_of
from experiments.commit import commit
from experiments.workers import Workers, done
from rwjax import read_logs, read_rig
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.diagnosis.settings import Settings
from rwjax.fitting.processes import ALONE, Team

LISTED = 5  # names of the ranking that are kept
NO_LIMIT = nullcontext()
_USUAL = Settings()
UP_TO_FIVE = replace(
    _USUAL,
    partial=replace(_USUAL.partial, further_removes=0.15),
    search=replace(
        _USUAL.search,
        most_names_further=5,
        removed_so_far=(*_USUAL.search.removed_so_far, 0.5, 0.6),
        from_all_places=(*_USUAL.search.from_all_places, 1, 1),
        exactly=(*_USUAL.search.exactly, 2, 2),
    ),
)
"""Limits of a search that goes on to up to five names, each of which removes 15 % of what the others leave."""
COPIED = (
    *("set", "index", "group", "kind", "effect", "seed", "amplitude", "size", "left", "repeatable"),
    *("sizes", "small", "mess"),
)


def answer(
    row: dict,
    within: AbstractContextManager = NO_LIMIT,
    team: Team = ALONE,
    only: Sequence[str] = (),
    settings: Settings | None = None,
) -> dict:
    """One case's line: what it is, and what the diagnosis, inside a context and by a team, says of it or how it failed."""
    case = case_of(row)
    line = {key: row[key] for key in COPIED if key in row} | {"same_as": case.truth["same_as"], "commit": commit()}
    with tempfile.TemporaryDirectory() as folder:
        write_case(case, Path(folder))
        begin = perf_counter()
        try:
            with within:
                rig = read_rig(Path(folder) / "rig.toml")
                logs = read_logs(sorted(Path(folder).glob("*.csv")), rig)
                diagnosis = diagnose(rig, logs, team=team, only=only, settings=settings)
                found = diagnosis.json()
        except Exception as error:  # whatever it is, it belongs to this case and not to the campaign
            place = traceback.extract_tb(error.__traceback__)[-1]
            text = f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"
            return line | {"seconds": round(perf_counter() - begin, 2), "error": text}
    gap, where = found["gap"], found["where"] or {}
    return line | {
        "verdict": found["verdict"],
        "effects": found["effects"],
        "alternatives": found["alternatives"],
        "subsystem": where.get("subsystem"),
        "coordinate": where.get("coordinate"),
        **{key: gap[key] for key in ("signal", "before", "after", "floor", "closed", "ci95")},
        "at_most": diagnosis.gaps[gap["signal"]].at_most,
        "refused": found["refused"],
        "top": [[one["effect"], one["probability"]] for one in found["ranking"][:LISTED]],
        "seconds": round(perf_counter() - begin, 2),
    }


def true_names(row: dict, told: str) -> list[str]:
    """The true names of a case that the library has, "large" ones or "all"."""
    names = split(row["effect"]) + [*row.get("small", ())] * (told == "all")
    return [name for name in names if not name.startswith("outside.")]


def told_large(row: dict) -> dict:
    """The line of a case whose true names are the only candidates, of a messy case the large ones."""
    return answer(row, only=true_names(row, "large")) | {"told": "large"}


def told_all(row: dict) -> dict:
    """The line of a case whose true names, large and small, are the only candidates, of which a set may hold five."""
    return answer(row, only=true_names(row, "all"), settings=UP_TO_FIVE) | {"told": "all"}


TOLD = {"large": told_large, "all": told_all}


def spread(rows: Sequence[dict], limit: int | None) -> list[dict]:
    """At most `limit` of the cases, drawn at random; those of one kind of rig, which share programs, together."""
    return sorted(some(rows, limit), key=lambda row: KINDS.index(row["kind"]))


def run(rows: Sequence[dict], path: Path, workers: Workers, work: Callable[[dict], dict] = answer) -> None:
    """Appends the line of every case that `path` does not hold; a worker that dies loses its case for this time only."""
    known = {line["index"] for line in read(path)}
    rest = [(row,) for row in rows if row["index"] not in known]
    with appending(path) as file:
        for count, line in enumerate(done(work, rest, workers), 1):
            file.write(dumps(line) + "\n")
            file.flush()
            print(f"\r{count} of {len(rest)}", end="", flush=True)
    print()


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=PLANS)
    parser.add_argument("-o", dest="path", type=Path, required=True)
    Workers.options(parser)
    parser.add_argument("--limit", type=int)
    parser.add_argument("--group", nargs="+", choices=GROUPS, default=GROUPS)
    parser.add_argument("--index", nargs="+", type=int, help="these cases alone")
    parser.add_argument("--of", type=Path, help="the cases of these results alone")
    parser.add_argument("--told", choices=TOLD, help="the true names are the only candidates")
    a = parser.parse_args()
    wanted = [row for row in cases(a.name) if row["group"] in a.group]
    for alone in (a.index, a.of and [line["index"] for line in read(a.of)]):
        wanted = [row for row in wanted if alone is None or row["index"] in alone]
    wanted = [row for row in wanted if not a.told or true_names(row, a.told)]
    run(spread(wanted, a.limit), a.path, Workers.of(a), TOLD[a.told] if a.told else answer)


if __name__ == "__main__":
    main()
