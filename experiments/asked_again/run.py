"""Does the same question get the same answer? `python -m experiments.asked_again.run [-o build/asked_again.jsonl] [--processes 2 | --scheduler ADDRESS]`

Simulated cases, spread over a set (`--set`, `--cases`), and two measured rigs are asked as they are and in eight other ways that say the same
(`experiments.asked_again.otherwise`). A line is appended for each answer; those that the file holds are skipped. The table counts the
ways that give another verdict or other names.
"""

import argparse
import json
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from experiments.asked_again.otherwise import WAYS, Question, read_question, write_question
from experiments.blind.campaign import spread
from experiments.blind.cases import write_case
from experiments.blind.draw import PLANS, appending, cases, read
from experiments.blind.messy import case_of
from experiments.blind.score import share
from experiments.commit import commit
from experiments.realdata import ROOT, dcmotor, emps, folder
from experiments.speed.table import Table, show
from experiments.workers import Workers, done
from rwjax import read_logs, read_rig
from rwjax.diagnosis.diagnosis import diagnose

AS_IT_IS = "as it is"


def simulated(name: str, count: int) -> Iterator[tuple[str, Question]]:
    """Simulated cases of a set, of all its groups."""
    for row in spread([*cases(name)], count):
        with tempfile.TemporaryDirectory() as place:
            write_case(case_of(row), Path(place))
            yield f"{name} {row['index']}", read_question(Path(place) / "rig.toml", sorted(Path(place).glob("*.csv")))


def measured() -> Iterator[tuple[str, Question]]:
    """Measured rigs with plain rig files; none where their logs are not there."""
    if folder() is None:
        return
    here = Path(__file__).parents[1]
    with tempfile.TemporaryDirectory() as place:
        for name, logs in (("emps", emps(Path(place))), ("dcmotor", [dcmotor(Path(place))])):
            yield name, read_question(here / name / "rig.toml", logs)


def asked(name: str, way: str, question: Question) -> dict:
    """The answer to a question."""
    with tempfile.TemporaryDirectory() as place:
        rig_file, paths = write_question(question, Path(place))
        rig = read_rig(rig_file)
        found = diagnose(rig, read_logs(paths, rig)).json()
    kept = {key: found[key] for key in ("verdict", "effects", "alternatives")}
    return {
        "case": name,
        "way": way,
        "commit": commit(),
        **kept,
        **{key: found["gap"][key] for key in ("before", "after", "floor")},
    }


def alike(one: dict, other: dict) -> bool:
    """Whether two answers have the same verdict and claim the same sets; what `unknown` lists is no claim."""
    sets = [{frozenset(names) for names in (a["effects"], *a["alternatives"])} for a in (one, other)]
    return one["verdict"] == other["verdict"] and (sets[0] == sets[1] or one["verdict"] in ("unknown", "none"))


def tables(lines: Sequence[dict]) -> tuple[Table, Table]:
    """For each way, how many cases it answers otherwise; and these cases."""
    first = {line["case"]: line for line in lines if line["way"] == AS_IT_IS}
    rows, differ, count = [], [], 0
    for way in WAYS:
        these = [line for line in lines if line["way"] == way and line["case"] in first]
        other = [line for line in these if not alike(first[line["case"]], line)]
        rows.append([way, f"{len(these)}", f"{len(other)}"])
        count += len(these)
        differ += [[line["case"], way, _said(first[line["case"]]), _said(line)] for line in other]
    rows.append(["all", f"{count}", share(len(differ), count)])
    return (
        Table("The same question asked otherwise", ["way", "cases", "answered otherwise"], rows),
        Table("What is answered otherwise", ["case", "way", AS_IT_IS, "so asked"], differ),
    )


def _said(line: dict) -> str:
    sets = [" + ".join(sorted(names)) for names in (line["effects"], *line["alternatives"])]
    return f"{line['verdict']}: {' or '.join(sorted(sets)) or '-'}"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="path", type=Path, default=ROOT / "build" / "asked_again.jsonl")
    parser.add_argument("--set", dest="name", choices=PLANS, default="fourth")
    parser.add_argument("--cases", type=int, default=12)
    Workers.options(parser)
    a = parser.parse_args()
    known = {(line["case"], line["way"]) for line in read(a.path)}
    every = [*measured(), *simulated(a.name, a.cases)]
    ways = {AS_IT_IS: lambda question: question} | WAYS
    todo = [(name, way, ways[way](q)) for name, q in every for way in ways if (name, way) not in known]
    with appending(a.path) as file:
        for line in done(asked, todo, Workers.of(a)):
            file.write(json.dumps(line) + "\n")
            file.flush()
    for table in tables([*read(a.path)]):
        show(*table)


if __name__ == "__main__":
    main()
