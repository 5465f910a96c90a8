"""A rig as JSON: every number with its unit and its standard error, and every effect with its equation."""

import json
from math import isfinite
from typing import Any

from rwjax.effects.library import BY_NAME, unit_of_number
from rwjax.export import Exported
from rwjax.rig.model import Rig

SCHEMA = "rwjax.rig/1"


def numbers(rig: Rig) -> Exported:
    """A rig as JSON. It leaves nothing out of the plant.

    Args:
        rig: Any rig.

    Returns:
        The text.
    """
    effects = {
        name: {
            "meaning": BY_NAME[name].meaning or BY_NAME[name].label,
            "equation": BY_NAME[name].equation,
            "numbers": {number: _number(rig, f"{name}.{number}", value) for number, value in given.items()},
        }
        for name, given in rig.effects.items()
    }
    found = {
        "schema": SCHEMA,
        "kind": rig.kind,
        "name": rig.name,
        "numbers": {name: _number(rig, name, value) for name, value in rig.numbers.items()},
        "effects": effects,
        "servo": rig.servo._asdict() if rig.servo is not None else None,
        "tied": rig.tied,
        "counts_per_rev": rig.counts_per_rev,
    }
    return Exported(json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False) + "\n", {})


def _number(rig: Rig, name: str, value: float) -> dict[str, Any]:
    """A number with its unit; with its standard error where an estimate has one, null where the logs say nothing of it."""
    error = {"standard_error": _finite(rig.standard_error[name])} if name in rig.standard_error else {}
    return {"value": value, "unit": unit_of_number(name) or "1"} | error


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
