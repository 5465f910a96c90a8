"""The tools that a rig may be written for, and how large what each cannot express is."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rwjax.errors import InputError, refuses_other_types
from rwjax.export import Exported
from rwjax.export.c_header import c_header
from rwjax.export.mjcf import mjcf
from rwjax.export.numbers import numbers
from rwjax.export.python_control import python_control
from rwjax.fitting.predict import predict
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

TARGETS: dict[str, Callable[[Rig], Exported]] = {
    "mjcf": mjcf,
    "c": c_header,
    "python-control": python_control,
    "json": numbers,
}
"""What writes a rig, by the tool's name."""
OF_DUTY = {"mjcf": ("joint", "platform"), "c": ("joint",)}
"""Kinds of rig whose servo's duty has to be a voltage, by the tool's name."""


@refuses_other_types
def export(rig: Rig, to: str, answer: Path | None = None) -> Exported:
    """A rig in the words of another tool.

    Args:
        rig: The rig, with its effects.
        to: A key of `TARGETS`.
        answer: What `rwjax fit --json` or a diagnosis said of the rig, whose covariance JSON alone takes.

    Returns:
        The file, and what it leaves out.

    Raises:
        RigError: For a rig that the tool cannot hold.
        InputError: For an unknown tool, for an answer that is not of this rig or that the tool does not take, and for an argument of another type.
    """
    if not isinstance(to, str) or to not in TARGETS:
        raise InputError(f"to `{to}`: is no tool; it has to be one of {', '.join(TARGETS)}")
    if answer is None:
        return TARGETS[to](rig)
    if TARGETS[to] is not numbers:
        raise InputError(f"{answer}: covariance and noise go into JSON alone, not into {to}")
    return numbers(rig, answer)


def with_logged_supply(rig: Rig, to: str, logs: Sequence[Log]) -> tuple[Rig, str]:
    """A rig with the supply's voltage, by the logs where its file lacks it and the tool needs it.

    Args:
        rig: The rig.
        to: A key of `TARGETS`.
        logs: Logs, of which some may hold the voltage [V].

    Returns:
        The rig, with the mean of the logged voltage [V] as its supply, and a sentence on that; the rig as it is and "" where nothing
        is lacking, or the logs do not tell it.
    """
    logged = [log.supply for log in logs if log.supply is not None]
    lacks = rig.servo is not None and rig.servo.acts_on == "duty" and "drive.supply" not in rig.numbers
    if rig.kind not in OF_DUTY.get(to, ()) or not lacks or not logged:
        return rig, ""
    volts = float(f"{np.mean(np.concatenate(logged)):.6g}")
    said = f"drive.supply is missing in the rig file: {volts:.4g} V is taken for it, the mean of the logged `supply_V`"
    return replace(rig, numbers=rig.numbers | {"drive.supply": volts}), said


def moved_by(rig: Rig, held: Rig, logs: Sequence[Log]) -> dict[str, float]:
    """How far what an export leaves out moves free runs.

    Args:
        rig: The rig.
        held: The same without what is left out.
        logs: Logs whose commands both follow.

    Returns:
        Root mean square by output over all logs [the output's unit].

    Raises:
        RigError: Where either rig cannot be run.
    """
    squares: dict[str, list[np.ndarray]] = {}
    for log in logs:
        with_it, without = (predict(r, log).columns for r in (rig, held))
        for name in log.outputs:
            squares.setdefault(name, []).append((with_it[name] - without[name]) ** 2)
    return {name: float(np.sqrt(np.mean(np.concatenate(s)))) for name, s in squares.items()}
