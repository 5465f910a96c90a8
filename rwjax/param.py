"""A parameter's unit, bounds and null value, kept on the field that holds it."""

from dataclasses import dataclass, fields
from typing import Any

import equinox as eqx


@dataclass(frozen=True)
class Parameter:
    """What is known about a number before any log is seen.

    `unit`: SI unit as text. `bounds`: physically possible values. `null`: the value at which the effect is absent.
    `starts`: values from which a search begins, in units of the scale named by `scale` (see `rwjax.fit.scales`).
    `optional`: a rig file may leave it out and has it at its null.
    """

    name: str
    unit: str
    bounds: tuple[float, float]
    null: float
    starts: tuple[float, ...]
    scale: str
    tex: str
    optional: bool


def param(
    unit: str,
    *,
    bounds: tuple[float, float],
    null: float = 0.0,
    starts: tuple[float, ...] = (),
    scale: str = "one",
    tex: str = "",
    optional: bool = False,
) -> Any:
    """Field of an effect with its meaning attached."""
    meta = dict(unit=unit, bounds=bounds, null=null, starts=starts, scale=scale, tex=tex, optional=optional)
    return eqx.field(metadata={"param": meta})


def parameters(cls: type) -> dict[str, Parameter]:
    """Parameters of an effect class by name, in the order in which they are declared."""
    return {f.name: Parameter(name=f.name, **f.metadata["param"]) for f in fields(cls) if "param" in f.metadata}
