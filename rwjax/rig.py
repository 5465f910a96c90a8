"""The rig file (TOML), what the user believes about the hardware: `read_rig`, `write_rig`, `Rig`."""

import math
import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import tomlkit

from rwjax import rig_read as read
from rwjax.errors import RigError, read_text
from rwjax.rig_names import COEFFICIENTS, ENCODERS, HALVES, NUMBERS, POLYNOMIAL, TWO_AXIS, encoder_section


@dataclass(frozen=True)
class Rig:
    """A rig file, checked. Every value is in SI; names are dotted, as in `fit.free`."""

    kind: str  # "wheel", "platform", "reaction" or "two_axis"
    name: str
    numbers: dict[str, float]  # the plant numbers that the file holds, of `rig_names.NUMBERS`
    free: tuple[str, ...] = ()  # the names, of `values`, that a fit estimates
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    prior: dict[str, tuple[float, float]] = field(default_factory=dict)  # mean and standard deviation besides the logs
    per_run: tuple[str, ...] = ()  # the names, of `free`, of which every log has a value of its own
    standard_error: dict[str, float] = field(default_factory=dict)  # inf: the logs say nothing about it
    effects: dict[str, dict[str, float]] = field(default_factory=dict)  # effect name -> its parameters
    counts_per_rev: dict[str, float] = field(default_factory=dict)  # of the encoders, by `rig_names.ENCODERS`
    pwm: read.Pwm | None = None
    columns: dict[str, str] = field(default_factory=dict)  # "position", "pulse" -> column of the thesis layout

    @property
    def values(self) -> dict[str, float]:
        """Every number and effect parameter by its name ("axis.inertia", "axis.stribeck.velocity")."""
        return self.numbers | {f"{e}.{p}": value for e, given in self.effects.items() for p, value in given.items()}

    def with_values(self, values: Mapping[str, float]) -> "Rig":
        """This rig with `values` in place; raises `KeyError` for a name that it does not hold yet."""
        if unknown := sorted(values.keys() - self.values.keys()):
            raise KeyError(f"the rig `{self.name}` holds no {unknown}")
        new = {name: float(values.get(name, old)) for name, old in self.values.items()}
        effects = {e: {p: new[f"{e}.{p}"] for p in given} for e, given in self.effects.items()}
        return replace(self, numbers={name: new[name] for name in self.numbers}, effects=effects)


def read_rig(path: str | os.PathLike[str]) -> Rig:
    """The rig that a TOML file describes. Raises `RigError` (file, key, what would be right)."""
    return parse_rig(read_text(path, RigError), path)


def read_one_axis_rig(path: str | os.PathLike[str]) -> Rig:
    """`read_rig` for what knows one command and one axis. Raises `RigError` for a rig with two axes, too."""
    rig = read_rig(path)
    try:
        return with_one_axis(rig)
    except RigError as error:
        raise RigError(f"{path}: {error}") from None


def with_one_axis(rig: Rig) -> Rig:
    """The rig itself. Raises `RigError` if it has two axes."""
    if rig.kind in TWO_AXIS:
        raise RigError(f"kind `{rig.kind}` has two axes, and this is for one; describe that axis by a `reaction` rig")
    return rig


def parse_rig(text: str, path: str | os.PathLike[str] = "rig.toml") -> Rig:
    """The rig that a TOML text describes; `path` stands in the messages. Raises `RigError`."""
    try:
        return _rig(tomllib.loads(text), Path(path).stem)
    except RigError as error:
        raise RigError(f"{path}: {error}") from None
    except (ValueError, RecursionError) as error:
        line = re.search(r"at line (\d+)", str(error))
        where = f"{path}:{line[1]}" if line else f"{path}"
        remedy = _remedy(
            text.splitlines()[int(line[1]) - 1] if line and "after a statement" in str(error) else "", path
        )
        raise RigError(f"{where}: not valid TOML: {error}; {remedy}") from None


def _remedy(line: str, path: str | os.PathLike[str]) -> str:
    """What would be right instead of a line that is no TOML."""
    if Path(path).suffix.lower() == ".csv":
        return "the rig file comes first, then the logs"
    if re.search(r"=\s*[-+]?\d+,\d", line):
        return "a number has no comma: decimals take a point (0.06), thousands nothing (4096)"
    if re.search(r"=\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(?![\deE.])\s*[a-zA-Z%°µΩ\[]", line):
        return "a unit does not stand in the file, all numbers are in SI (0.06 # kg m2); a text stands in quotes"
    return "write `key = value` under `[section]` headers"


def _rig(document: dict[str, Any], stem: str) -> Rig:
    leaves = read.leaves(document)
    kind = read.kind(leaves)
    standard_error, bounds, prior, effects = (
        read.take(leaves, section) for section in ("fit.standard_error", "fit.bounds", "fit.prior", "effects")
    )
    read.check_keys(leaves, kind)
    rig = Rig(
        kind=kind,
        name=read.text(leaves, "name", stem),
        numbers=read.numbers(leaves, kind),
        effects=read.effects(effects, kind),
        counts_per_rev=read.counts_per_rev(leaves),
        pwm=read.pwm(leaves),
        columns=read.columns(leaves),
    )
    free = read.names(leaves, "fit.free", rig.values, kind)
    limits = {name: read.bound(name, pair, rig.values, kind) for name, pair in bounds.items()}
    anything = (-math.inf, math.inf)
    return replace(
        rig,
        free=free,
        per_run=read.per_run(leaves, free, rig.values, kind),
        prior={name: read.prior(name, pair, free, limits.get(name, anything)) for name, pair in prior.items()},
        bounds=limits,
        standard_error={
            name: read.standard_error(name, value, rig.values, kind) for name, value in standard_error.items()
        },
    )


ORDER = (
    "kind",
    "name",
    "motor",
    "wheel",
    "drive",
    "axis",
    *(own for half in HALVES for own in half.values()),
    "gimbal",
    *ENCODERS,
    "columns",
    "fit",
    "effects",
)


def write_rig(rig: Rig) -> str:
    """TOML text that reads back as an equal `Rig`; sections as in the interface, units in comments."""
    document = tomlkit.document()
    for path, value, comment in sorted(_entries(rig), key=lambda entry: ORDER.index(entry[0][0])):
        table: Any = document
        for section in path[:-1]:
            table = table.setdefault(section, tomlkit.table())
        item = tomlkit.item(value)
        table.add(path[-1], item.comment(comment) if comment else item)
    return tomlkit.dumps(document)


def _entries(rig: Rig) -> Iterator[tuple[tuple[str, ...], Any, str]]:
    """Path, value and comment of everything in the file; inside a section in the order of the file."""
    yield ("kind",), rig.kind, ""
    yield ("name",), rig.name, ""
    for name in (n for n in NUMBERS if n in rig.numbers and n not in COEFFICIENTS):
        yield tuple(name.split(".")), rig.numbers[name], f"{NUMBERS[name].symbol}, {NUMBERS[name].unit}"
    if COEFFICIENTS[0] in rig.numbers:
        coefficients = [rig.numbers[name] for name in COEFFICIENTS]
        yield (
            tuple(POLYNOMIAL.split(".")),
            coefficients,
            "b3, b2, b1, b0; N m over |w|^0 to |w|^3, w in rad/s",
        )
    if rig.pwm is not None:
        pwm = tomlkit.inline_table()
        pwm.update(rig.pwm._asdict())
        yield ("drive", "pwm"), pwm, "us, V/us"
    for who, counts in rig.counts_per_rev.items():
        whole = int(counts) if counts.is_integer() else counts
        yield (encoder_section(who, rig.kind), "counts_per_rev"), whole, "edges per turn"
    for key, column in rig.columns.items():
        yield ("columns", key), column, ""
    if rig.free:
        yield ("fit", "free"), _folded(rig.free), ""
    if rig.per_run:
        yield ("fit", "per_run"), _folded(rig.per_run), "a value for each log"
    for name, (mean, spread) in rig.prior.items():
        yield ("fit", "prior", name), [mean, spread], "mean, standard deviation"
    for name, error in rig.standard_error.items():
        yield ("fit", "standard_error", name), error, ""
    for name, bounds in rig.bounds.items():
        yield ("fit", "bounds", name), list(bounds), ""
    units = read.effect_parameters() if rig.effects else {}
    for effect, parameters in rig.effects.items():
        for parameter, value in parameters.items():
            yield ("effects", effect, parameter), value, units[effect][parameter].unit


def _folded(free: tuple[str, ...]) -> list[str]:
    """`free` with the four coefficients, where they stand in a row, under their one name in the file."""
    n = len(COEFFICIENTS)
    rows = (i for i in range(len(free)) if free[i : i + n] == COEFFICIENTS)
    i = next(rows, None)
    return list(free) if i is None else [*free[:i], POLYNOMIAL, *free[i + n :]]
