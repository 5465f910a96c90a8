"""The plan of a fleet: which rigs, which logs of each, and the command for all of them."""

import glob
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rwjax.effects.library import listed
from rwjax.effects.parameter import parameters
from rwjax.errors import InputError, nearest, printable
from rwjax.kinds import NUMBERS
from rwjax.text_files import parse_toml, read_text

SECONDS, SWITCH, NAMES = "a positive number of seconds", "true or false", "a list of effects"
OPTIONS = {
    "fit": {"segments": SECONDS, "force": SWITCH},
    "check": {},
    "diagnose": {"segments": SECONDS, "force": SWITCH, "budget": SECONDS, "only": NAMES, "without": NAMES},
    "compare": {"segments": SECONDS, "force": SWITCH},
}
"""The commands for a rig, each with its options."""
KEYS = ("command", "rig", "logs", "table", "shared", "options")
PLACES = ("rig", "when")
"""What a pattern or a table says of a log: whose it is, and of which session; sessions follow one another as their names sort."""
COLUMNS = ("rig", "rig_file", "log")
"""Columns that a table has; `when` is optional."""


class Job(NamedTuple):
    """The logs of one rig, or of one session of it.

    Attributes:
        rig: Name of the rig.
        when: Name of the session, "" where there is one alone.
        rig_file: Path of the rig file.
        logs: Paths of the logs.
    """

    rig: str
    when: str
    rig_file: str
    logs: tuple[str, ...]

    def inputs(self) -> str:
        """What tells that a file has changed since: size and time of each.

        Returns:
            A text of them; "" of a file that is not there.
        """
        return " ".join(map(_stamp, (self.rig_file, *self.logs)))


class FleetPlan(NamedTuple):
    """A plan.

    Attributes:
        command: A key of `OPTIONS`.
        options: Options of the command.
        jobs: The jobs, sorted by rig and session.
        shared: Names of numbers that are one and the same in all rigs.
        unlogged: Names of rigs whose rig files are there, and whose logs are not.
    """

    command: str
    options: dict[str, Any]
    jobs: tuple[Job, ...]
    shared: tuple[str, ...] = ()
    unlogged: tuple[str, ...] = ()


def read_plan(path: str | os.PathLike[str]) -> FleetPlan:
    """Reads the plan of a fleet. Paths in it begin where the file lies.

    Args:
        path: A TOML file with `command`; `rig` and `logs`, two patterns, or `table`; `shared` and `[options]`.

    Returns:
        The plan.

    Raises:
        InputError: The file is no plan, or no log is there.
    """
    text, own = read_text(path, InputError), Path(os.path.abspath(path))
    try:
        given = parse_toml(text)
    except ValueError as bad:
        raise InputError(f"{path}: is no TOML: {bad}") from None
    try:
        command, options = _command(given)
        shared = _shared(command, given)
        jobs = _jobs(given, own.parent)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return FleetPlan(command, options, tuple(sorted(jobs)), shared, _unlogged(given, jobs, own))


def _stamp(path: str) -> str:
    try:
        found = os.stat(path)
    except (OSError, ValueError):  # no such file, or a name that none has
        return ""
    return f"{found.st_size}.{found.st_mtime_ns}"


def _command(given: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """The command and its options."""
    if "kind" in given and "command" not in given:
        raise InputError("is a rig file, not a plan; write a plan that names it, with `command`, `rig` and `logs`")
    for key in given:
        if key not in KEYS:
            raise InputError(f"unknown key `{printable(key)}`; the nearest valid one is `{nearest(key, KEYS)}`")
    command = given.get("command")
    if not isinstance(command, str) or command not in OPTIONS:
        raise InputError(f'`command` is {command!r}; write command = "fit", "check", "diagnose" or "compare"')
    options = given.get("options", {})
    if not isinstance(options, dict):
        raise InputError("`options` is not a table; write it as a section [options]")
    known = OPTIONS[command]
    for name, value in options.items():
        if name not in known:
            right = ", ".join(known) or "none"
            raise InputError(f"`{command}` has no option `{printable(name)}`; it has {right}")
        if known[name] == NAMES and isinstance(value, list):
            _check_names(name, value)
        elif not _fits(value, known[name]):
            raise InputError(f"`options.{name}` is {printable(repr(value))}; write {known[name]}")
    return command, dict(options)


def _shared(command: str, given: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the numbers that all rigs share."""
    if "shared" in given and command not in ("fit", "diagnose"):
        raise InputError(f"`{command}` estimates no numbers that rigs could share; leave out `shared`")
    names = given.get("shared", [])
    if not (isinstance(names, list) and all(isinstance(name, str) for name in names)):
        raise InputError(f'`shared` is {printable(repr(names))}; write a list of numbers, as ["axis.inertia"]')
    effects = listed()
    for name in names:
        effect, _, number = name.rpartition(".")
        if name not in NUMBERS and not (effect in effects and number in parameters(effects[effect])):
            near = nearest(name, [*NUMBERS, *(f"{e}.{n}" for e in effects for n in parameters(effects[e]))])
            raise InputError(f"`shared` holds {printable(repr(name))}, which is no number; nearest `{near}`")
    return tuple(dict.fromkeys(names))


def _check_names(option: str, names: list) -> None:
    """Raises `InputError` for a name that is no effect's and no number's."""
    for one in names:
        if not isinstance(one, str) or not (one in listed() or one.startswith("parameter.")):
            near = nearest(str(one), listed())
            raise InputError(f"`options.{option}` holds {printable(repr(one))}, which is no effect; nearest `{near}`")


def _fits(value: Any, wanted: str) -> bool:
    """Whether an option's value is what is wanted."""
    return isinstance(value, bool) if wanted == SWITCH else type(value) in (int, float) and value > 0.0


def _jobs(given: Mapping[str, Any], folder: Path) -> list[Job]:
    """The jobs of a plan in a folder."""
    if "table" in given:
        if "logs" in given or "rig" in given:
            raise InputError("`table` stands beside `rig` or `logs`; a table says both, leave them out")
        return _of_table(folder / str(given["table"]), folder)
    for key in ("rig", "logs"):
        if key in given and not isinstance(given[key], str):
            raise InputError(f"`{key}` is {printable(repr(given[key]))}; write one pattern as a text")
        if key not in given:
            raise InputError(
                f'`{key}` is missing; write rig = "rigs/{{rig}}.toml" and logs = "logs/{{rig}}/*.csv", or table = "fleet.csv"'
            )
    return _of_patterns(given["rig"], given["logs"], folder)


def _of_patterns(rig: str, logs: str, folder: Path) -> list[Job]:
    """Jobs by the places that a pattern of logs names."""
    if "{rig}" not in logs:
        raise InputError(f'`logs` is "{printable(logs)}"; it has to hold {{rig}}, which stands for the name of a rig')
    found: dict[tuple[str, str], list[str]] = {}
    for path, of in _matches(logs, folder):
        found.setdefault((of["rig"], of.get("when", "")), []).append(path)
    if not found:
        raise InputError(f'no file is as `logs` says, "{printable(logs)}"')
    return [
        Job(
            printable(name),
            printable(when),
            str(folder / rig.replace("{rig}", name).replace("{when}", when)),
            tuple(paths),
        )
        for (name, when), paths in found.items()
    ]


def _unlogged(given: Mapping[str, Any], jobs: Sequence[Job], plan: Path) -> tuple[str, ...]:
    """Names of rigs that have a file by the pattern of rig files, and no job; the plan itself is no rig's."""
    rig = given.get("rig", "")
    if "{rig}" not in rig:
        return ()
    there = {printable(of["rig"]) for path, of in _matches(rig, plan.parent) if path != str(plan)}
    return tuple(sorted(there - {job.rig for job in jobs}))


def _matches(pattern: str, folder: Path) -> Iterator[tuple[str, dict[str, str]]]:
    """Paths of the files that are as a pattern says, sorted, each with what stands at its places."""
    before = "" if Path(pattern).is_absolute() else f"{folder}/"
    regular = re.compile(re.escape(before) + _regular(pattern))
    for path in sorted(glob.glob(glob.escape(before) + _globbed(pattern))):
        if match := regular.fullmatch(path):
            yield path, match.groupdict()


def _parts(pattern: str) -> list[str]:
    """A pattern cut at its places, its stars and its question marks, which are parts themselves."""
    return re.split("(" + "|".join(rf"\{{{place}\}}" for place in PLACES) + r"|\*|\?)", pattern)


def _globbed(pattern: str) -> str:
    return "".join(
        "*" if part in ("{rig}", "{when}", "*") else "?" if part == "?" else glob.escape(part)
        for part in _parts(pattern)
    )


def _regular(pattern: str) -> str:
    """A regular expression of the pattern, with a group for each place; a place that comes again is the same text."""
    found, seen = [], set()
    for part in _parts(pattern):
        place = part[1:-1]
        if part in ("*", "?"):
            found.append("[^/]*" if part == "*" else "[^/]")
        elif part.startswith("{") and place in PLACES:
            found.append(f"(?P={place})" if place in seen else f"(?P<{place}>[^/]+?)")
            seen.add(place)
        else:
            found.append(re.escape(part))
    return "".join(found)


def _of_table(path: Path, folder: Path) -> list[Job]:
    """Jobs of a table, one line a log."""
    import polars as pl

    try:
        table = pl.read_parquet(path) if path.suffix == ".parquet" else pl.read_csv(path, infer_schema=False)
    except (OSError, pl.exceptions.PolarsError) as bad:
        raise InputError(f"{path}: cannot be read as a table: {printable(str(bad).split(chr(10))[0])}") from None
    if lacking := [name for name in COLUMNS if name not in table.columns]:
        raise InputError(f"{path}: has no column `{lacking[0]}`; it needs {', '.join(COLUMNS)}, and may have `when`")
    if "when" not in table.columns:
        table = table.with_columns(when=pl.lit(""))
    found: dict[tuple[str, str], tuple[str, list[str]]] = {}
    rows = table.select("rig", "when", "rig_file", "log").cast(pl.String).fill_null("").iter_rows()
    for line, (name, when, rig_file, log) in enumerate(rows, start=2):
        if not (name and rig_file and log):
            raise InputError(f"{path}:{line}: a field is empty; `when` alone may be")
        first, logs = found.setdefault((name, when), (rig_file, []))
        if first != rig_file:
            raise InputError(f"{path}:{line}: rig `{printable(name)}` has two rig files; give each its own name")
        logs.append(str(folder / log))
    if not found:
        raise InputError(f"{path}: has no line; write one for each log")
    return [
        Job(printable(name), printable(when), str(folder / rig_file), tuple(logs))
        for (name, when), (rig_file, logs) in found.items()
    ]
