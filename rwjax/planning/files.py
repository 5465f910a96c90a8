"""A plan as files: `plan.toml` with its runs, and beside it the command of each run as CSV, which any driver can play."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import Any
from zlib import crc32

import tomlkit

from rwjax.errors import LONGEST_NAME, InputError, RigError, nearest, no_name
from rwjax.kinds import GOAL, RANGES
from rwjax.logs.sheet import ROLES
from rwjax.logs.write import log_text
from rwjax.planning.experiment import SHAPES, Experiment
from rwjax.rig.columns import unit_of
from rwjax.rig.document import number, shown
from rwjax.text_files import parse_toml, read_text, write_text

SCHEMA, FILE = "rwjax.plan/1", "plan.toml"
"""First line of a plan's file, and the file's name."""
HEAD = """\
# Runs to record, in this order, each from rest: `rwjax run-experiment RIG PORT --plan` plays them on the testbed's board;
# the CSV of each run beside this file has its command for any other driver. reaches: peaks in a simulation of the rig.
"""
_TIMES = {"period_s": "period", "length_s": "length"}
NUMBERS = {
    "voltage_V": {"amplitude_V": "amplitude", "offset_V": "offset", **_TIMES},
    GOAL: {"amplitude_rad": "amplitude", "offset_rad": "offset", **_TIMES},
}
"""Keys of a run that are numbers of its experiment, by the column of its command."""
SHORTEST_S, LONGEST_S = 0.04, 3600.0
"""Shortest and longest period and length of an experiment [s]: four ticks of the board, and the longest run that it plays."""
MOST = RANGES["rad"].most
"""Largest size of a limit, a peak or an angle [SI]."""
KEYS = ("name", "kind", *NUMBERS["voltage_V"], *NUMBERS[GOAL], "role", "why", "tells_apart", "reaches", "way_rad")


@dataclass(frozen=True)
class Run:
    """A run of a plan.

    Attributes:
        name: Name of the run and of its log.
        experiment: The command.
        role: What its log is for (`ROLES`).
        why: What the run is for, in words.
        tells_apart: Names of the effects that it tells apart.
        reaches: Peaks of the simulated rig's outputs [SI] by name.
        angle_range: Lowest and highest angle of the axis [rad] from where the run begins; where it is None, the run goes
            either way as far as `reaches` has it.
    """

    name: str
    experiment: Experiment
    role: str
    why: str
    tells_apart: tuple[str, ...]
    reaches: dict[str, float]
    angle_range: tuple[float, float] | None = None

    @property
    def notes(self) -> dict[str, str]:
        """Notes of its log."""
        return {"run": self.name, "experiment": self.experiment.words(), "role": self.role, "why": self.why}


@dataclass(frozen=True)
class Plan:
    """Runs for a rig.

    Attributes:
        rig: Name of the rig.
        limits: Limits within which they stay [SI], by column of a log.
        runs: The runs, in the order in which they are played.
    """

    rig: str
    limits: dict[str, float]
    runs: tuple[Run, ...]

    @property
    def seconds(self) -> float:
        """Time that all runs take [s], without what lies between them."""
        return sum(run.experiment.command()[0][-1] for run in self.runs)

    def only(self, names: Sequence[str]) -> "Plan":
        """Some runs of the plan.

        Args:
            names: Names of the runs.

        Returns:
            A plan with these runs, in the order of this one.

        Raises:
            InputError: For a name that the plan does not hold.
        """
        known = [run.name for run in self.runs]
        if unknown := next((name for name in names if name not in known), None):
            raise InputError(f"the plan holds no run `{unknown}`; the nearest is `{nearest(unknown, known)}`")
        return Plan(self.rig, self.limits, tuple(run for run in self.runs if run.name in names))


def replaced(folder: Path, rig: str) -> str | None:
    """What a new plan for a rig replaces in a folder, besides an earlier one for the same rig.

    Args:
        folder: The folder.
        rig: Name of the rig.

    Returns:
        What is replaced, in words; None where nothing is.

    Raises:
        InputError: Where the plan that lies there is not as `write_plan` wrote it, but by hand or changed since.
    """
    other = _plan_to_replace(folder)
    return None if other is None or other.rig == rig else f"the plan of rig `{other.rig}` and its runs"


def write_plan(folder: Path, plan: Plan) -> Path:
    """Writes `plan.toml`, last, and a CSV for each run. No run of an earlier plan stays; what no plan wrote is never replaced.

    Args:
        folder: The folder.
        plan: The plan.

    Returns:
        Path of `plan.toml`.

    Raises:
        InputError: Where the plan that lies there is not as it was written, or a file has the name of a run's CSV and is neither
            this nor one of that plan, and nothing is changed then; where a file cannot be written.
    """
    other = _plan_to_replace(folder)
    earlier = () if other is None else other.runs
    for run in plan.runs:
        path = folder / f"{run.name}.csv"
        if path.exists() and not any(_is_csv_of(path, own) for own in (run, *earlier) if own.name == run.name):
            raise InputError(
                f"{path}: is not the CSV of a run that a plan here wrote, and would be replaced; write the plan into another "
                "folder, or move that file"
            )
    clear_plan(folder)
    for run in plan.runs:
        path = folder / f"{run.name}.csv"
        write_text(path, _csv_of(path, run), InputError)
    write_text(folder / FILE, _text_of(plan), InputError)
    return folder / FILE


def _text_of(plan: Plan) -> str:
    """The text of a plan's file, with a checksum: a file in which a number was changed is not the text of the plan that it holds."""
    plain = as_document(plan)
    for run in plain["runs"]:
        reaches = tomlkit.inline_table()
        reaches.update(run["reaches"])
        run["reaches"] = reaches
    text = HEAD + tomlkit.dumps(plain)
    return f"{text}\n# as written: {crc32(text.encode()):08x}; an edited plan is never replaced\n"


def clear_plan(folder: Path) -> None:
    """Removes an earlier plan from a folder, with its runs, which might be played for those of the next one.

    A plan that is not as it was written stays with all its runs. So does a file with the name of a run's CSV that is not what the
    plan's run makes, such as its log.

    Args:
        folder: The folder; it may hold no plan.
    """
    try:
        plan = _plan_to_replace(folder)
    except InputError:
        return
    if plan is None:
        return
    for run in plan.runs:
        if _is_csv_of(path := folder / f"{run.name}.csv", run):
            path.unlink(missing_ok=True)
    (folder / FILE).unlink()


def _plan_to_replace(folder: Path) -> Plan | None:
    """The plan that lies in a folder, if there is one; raises `InputError` where it is not to the letter as it was written."""
    path = folder / FILE
    if not path.exists():
        return None
    try:
        plan = read_plan(path)
        if read_text(path, InputError) == _text_of(plan):
            return plan
    except InputError:
        pass  # such as none that can be read
    raise InputError(
        f"{path}: is not as `rwjax plan` wrote it, and would be replaced; give another folder with -o, or move that file"
    )


def _csv_of(path: Path, run: Run) -> str:
    """The CSV of a run, as text."""
    time, given = run.experiment.command()
    columns = {"time_s": time, run.experiment.input: given}
    if run.experiment.switches:
        columns["enabled"] = run.experiment.enabled().astype(int)
    return log_text(columns, run.notes, path)


def _is_csv_of(path: Path, run: Run) -> bool:
    """Whether a file is the CSV of a run to the letter, and not a log, which has the run's name as well."""
    try:
        return read_text(path, InputError) == _csv_of(path, run)
    except InputError:
        return False  # what is not there, and what cannot be read, which is kept


def write_next(folder: Path, plan: Plan | None) -> Path | None:
    """Writes the plan of a diagnosis's next experiment into `next` in the diagnosis's folder.

    No plan of an earlier diagnosis stays, unless it was edited since: beside it, the folder gets a number, `next_2`. A run with the
    name of a file that stays gets a number as well.

    Args:
        folder: The diagnosis's folder.
        plan: The plan, where there is one.

    Returns:
        Path of its `plan.toml`, or None.

    Raises:
        InputError: Where a file cannot be written.
    """
    clear_next(folder)
    if plan is None:
        return None
    target = next(path for path in _numbered(folder / "next") if not path.is_symlink() and not (path / FILE).exists())
    target.mkdir(exist_ok=True)
    names = [run.name for run in plan.runs]
    for k, name in enumerate(names):
        names[k] = _free_name(target, name, {*names[:k], *names[k + 1 :]})
    runs = (replace(run, name=name) for run, name in zip(plan.runs, names, strict=True))
    return write_plan(target, replace(plan, runs=tuple(runs)))


def clear_next(folder: Path) -> None:
    """Removes the plan of an earlier diagnosis's next experiment, as `clear_plan` does, and its folder where nothing stays in it.

    Args:
        folder: The diagnosis's folder.
    """
    if (folder / "next").is_symlink():
        (folder / "next").unlink()
    for target in (folder / "next", *folder.glob("next_*")):
        if not target.is_symlink() and re.fullmatch(r"next(_\d+)?", target.name):
            clear_plan(target)
            with suppress(OSError):  # it holds something else, or there is none
                target.rmdir()


def _numbered(folder: Path) -> Iterator[Path]:
    """A folder, and those with a number behind its name."""
    return (folder.with_name(folder.name + end) for end in chain([""], (f"_{k}" for k in count(2))))


def _free_name(folder: Path, name: str, others: set[str]) -> str:
    """A run's name, with the first number behind it that makes it free where another run or a file of a log has it."""
    ends = chain([""], (f"_{k}" for k in count(2)))
    names = (name[: LONGEST_NAME - len(end)] + end for end in ends)
    taken = others | {path.stem for path in folder.iterdir() if path.suffix in (".csv", ".raw", ".notes")}
    return next(name for name in names if name not in taken)


def as_document(plan: Plan) -> dict[str, Any]:
    """What the plan's file says, as plain objects.

    Args:
        plan: The plan.

    Returns:
        Its tables, as JSON and TOML have them.
    """
    runs = [
        {"name": run.name, "kind": run.experiment.kind}
        | {key: getattr(run.experiment, field) for key, field in NUMBERS[run.experiment.input].items()}
        | {"role": run.role, "why": run.why, "tells_apart": list(run.tells_apart)}
        | {"reaches": {name: float(f"{value:.4g}") for name, value in run.reaches.items()}}
        | ({} if run.angle_range is None else {"way_rad": [float(f"{angle:.4g}") for angle in run.angle_range]})
        for run in plan.runs
    ]
    return {
        "schema": SCHEMA,
        "rig": plan.rig,
        "limits": {name: float(f"{value:.6g}") for name, value in plan.limits.items()},
        "runs": runs,
    }


def read_plan(path: Path) -> Plan:
    """Reads a plan.

    Args:
        path: The file, or the folder that holds it.

    Returns:
        The plan.

    Raises:
        InputError: Where it is none: file, run, key and what would be right.
    """
    path = path / FILE if path.is_dir() else path
    text = read_text(path, InputError)
    try:
        return _plan(parse_toml(text))
    except _Wrong as error:
        raise InputError(f"{path}: {error}") from None
    except ValueError as error:
        raise InputError(f"{path}: not valid TOML: {error}; `rwjax plan` writes such a file") from None


class _Wrong(Exception):
    """What is wrong with a plan."""


def _plan(document: dict[str, Any]) -> Plan:
    """The plan that a document holds."""
    if document.get("schema") != SCHEMA:
        raise _Wrong(f'no `schema = "{SCHEMA}"`; is this a plan that `rwjax plan` wrote?')
    rig, limits, runs = document.get("rig"), document.get("limits", {}), document.get("runs")
    if not isinstance(rig, str):
        raise _Wrong('no `rig`; write rig = "the name in the rig file"')
    _text(rig, "`rig`")
    if not isinstance(limits, dict):
        raise _Wrong("`limits` has to be a table `[limits]`")
    if not isinstance(runs, list) or not runs or not all(isinstance(run, dict) for run in runs):
        raise _Wrong("holds no runs; write each under a header [[runs]]")
    found = tuple(_run(run, f"run {number + 1}") for number, run in enumerate(runs))
    if twice := next((name for name, times in Counter(run.name for run in found).items() if times > 1), None):
        raise _Wrong(f"two runs are called `{twice}`; each needs a name of its own")
    for name in limits:
        _text(name, "a name in `limits`")
    return Plan(rig, {name: _size(value, "limits", name) for name, value in limits.items()}, found)


def _run(given: dict[str, Any], which: str) -> Run:
    """The run that a table of a document holds; `which` names it in messages."""
    name = given.get("name")
    if not isinstance(name, str) or not re.fullmatch(rf"[\w-]{{1,{LONGEST_NAME}}}", name):
        said = f'its log gets this name: letters, digits, "_" and "-", {LONGEST_NAME} at most'
        raise _Wrong(f"{which}: `name` is {shown(name)}; {said}")
    which = f"run `{name}`"
    if unknown := next((key for key in given if key not in KEYS), None):
        raise _Wrong(f"{which}: unknown key `{unknown}`; the nearest valid one is `{nearest(unknown, KEYS)}`")
    for key, valid in (("kind", tuple(SHAPES)), ("role", ROLES)):
        if (value := given.get(key, "train" if key == "role" else None)) not in valid:
            raise _Wrong(f"{which}: `{key}` is {shown(value)}; it has to be one of {', '.join(valid)}")
    column = GOAL if "amplitude_rad" in given else "voltage_V"
    unit, keys = unit_of(column), NUMBERS[column]
    given = {f"offset_{unit}": 0.0, "role": "train", "why": "", "tells_apart": [], "reaches": {}} | given
    numbers = {field: _number(given.get(key), which, key) for key, field in keys.items()}
    if other := next((key for of in NUMBERS.values() for key in of if key in given and key not in keys), None):
        raise _Wrong(f"{which}: `{other}` stands beside `amplitude_{unit}`; a command is in V, or a goal in rad")
    for key in (f"amplitude_{unit}", f"offset_{unit}"):
        _size(given[key], which, key, RANGES[unit].most, unit)
    for key in ("period_s", "length_s"):
        if not SHORTEST_S - 0.005 <= numbers[keys[key]] <= LONGEST_S:  # the board rounds to its ticks
            raise _Wrong(f"{which}: `{key}` is {given[key]}; it lies between {SHORTEST_S:g} and {LONGEST_S:g} s")
    if not isinstance(given["reaches"], dict) or not isinstance(given["tells_apart"], list):
        raise _Wrong(f"{which}: `reaches` has to be a table and `tells_apart` a list")
    return Run(
        name,
        Experiment(given["kind"], **numbers, input=column),
        given["role"],
        _text(given["why"], f"{which}: `why`"),
        tuple(_text(each, f"{which}: a name in `tells_apart`") for each in given["tells_apart"]),
        {
            _text(y, f"{which}: a name in `reaches`"): _size(v, which, f"reaches.{y}")
            for y, v in given["reaches"].items()
        },
        _angle_range(given.get("way_rad"), which),
    )


def _angle_range(given: Any, which: str) -> tuple[float, float] | None:
    """The lowest and the highest angle [rad] of a run, where they are given."""
    if given is None:
        return None
    if not isinstance(given, list) or len(given) != 2:
        raise _Wrong(
            f"{which}: `way_rad` is {shown(given)}; it has to be two numbers, the lowest angle and the highest"
        )
    low, high = (_size(value, which, "way_rad") for value in given)
    return low, high


def _number(value: Any, which: str, key: str) -> float:
    """A finite number."""
    if value is None:
        raise _Wrong(f"{which}: `{key}` is missing; it has to be a finite number")
    try:
        return number(key, value)
    except RigError as error:
        raise _Wrong(f"{which}: {error}") from None


def _size(value: Any, which: str, key: str, most: float = MOST, unit: str = "(SI)") -> float:
    """A number no larger than any rig's."""
    if abs(found := _number(value, which, key)) > most:
        raise _Wrong(f"{which}: `{key}` is {found!r}; it lies between {-most:g} and {most:g} {unit}")
    return found


def _text(value: Any, what: str) -> str:
    """A text that is printed, and that stands in notes of logs."""
    if not isinstance(value, str):
        raise _Wrong(f"{what} is {shown(value)}; it has to be a text in quotes")
    if wrong := no_name(value):
        raise _Wrong(f"{what} {wrong}")
    return value
