"""Reading of rig files (TOML): `read_rig`, `parse_rig`."""

import math
import os
import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

from rwjax.errors import RigError, read_text
from rwjax.rig import parse as read
from rwjax.rig.model import Rig, with_one_axis


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
