"""A rig as JSON: every number with its unit and its standard error, every effect with its equation, and what simulators draw from."""

import json
from math import isfinite
from pathlib import Path
from typing import Any

from rwjax.control.fit_estimate import read_fit_estimate, with_fit_estimate
from rwjax.effects.library import BY_NAME
from rwjax.errors import InputError
from rwjax.export import Exported
from rwjax.rig.model import Rig
from rwjax.rig.number_unit import unit_in_rig
from rwjax.text_files import read_text

SCHEMA = "rwjax.rig/1"


def numbers(rig: Rig, answer: Path | None = None) -> Exported:
    """A rig as JSON. It leaves nothing out of the plant.

    Args:
        rig: Any rig.
        answer: What `rwjax fit --json` printed of it, or the `diagnosis.json` beside it. With it come the covariance of the estimates,
            and of a diagnosis what is left as torque noise, so that a simulator can draw its rigs.

    Returns:
        The text.

    Raises:
        InputError: The answer is no such file, of another rig, or says nothing of a number.
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
        **(_spread(answer, rig) if answer else {}),
    }
    return Exported(json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False) + "\n", {})


def _spread(answer: Path, rig: Rig) -> dict[str, Any]:
    """What a simulator draws from: estimates with their covariance, and what is left as torque noise."""
    estimate = read_fit_estimate(answer, rig)
    try:
        with_fit_estimate(rig, estimate)  # refuses numbers that the rig lacks
    except InputError as error:
        raise InputError(f"{answer}: {error}") from None
    left = json.loads(read_text(answer, InputError), parse_constant=lambda name: None).get("left_torque")
    found = {"mean": estimate.mean.tolist(), "covariance": estimate.covariance.tolist(), "left_torque": left}
    return {"estimate": {"names": list(estimate.names), **found}}


def _number(rig: Rig, name: str, value: float) -> dict[str, Any]:
    """A number with its unit; with its standard error where an estimate has one, null where the logs say nothing of it."""
    error = {"standard_error": _finite(rig.standard_error[name])} if name in rig.standard_error else {}
    return {"value": value, "unit": unit_in_rig(rig, name) or "1"} | error


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None
