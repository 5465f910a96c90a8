"""A parameter's unit, bounds and null value, kept on the field that holds it."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import equinox as eqx


@dataclass(frozen=True)
class Parameter:
    """What is known about a number before any log is seen.

    `unit`: SI unit as text. `bounds`: physically possible values. `null`: the value at which the effect is absent.
    `starts`: values from which a search begins, in units of the scale named by `scale` (see `rwjax.fitting.scales`) and from
    the one named by `origin` on; `None` is the null value.
    `optional`: a rig file may leave it out and has it at its null; it belongs to the effect's form.
    `fitted`: a search estimates it; else it stays where the search begins.
    """

    name: str
    unit: str
    bounds: tuple[float, float]
    null: float
    starts: tuple[float | None, ...]
    scale: str
    origin: str | None
    tex: str
    optional: bool
    fitted: bool

    def begin(self, sizes: Mapping[str, float]) -> tuple[float, ...]:
        """Values from which a search begins, for these sizes of the scales."""
        origin = sizes[self.origin] if self.origin else 0.0
        values = (self.null if s is None else origin + s * sizes[self.scale] for s in self.starts)
        low, high = self.bounds
        return tuple(min(max(value, low), high) for value in values)


def param(
    unit: str,
    *,
    bounds: tuple[float, float],
    null: float = 0.0,
    starts: tuple[float | None, ...] = (),
    scale: str = "one",
    origin: str | None = None,
    tex: str = "",
    optional: bool = False,
    fitted: bool = True,
) -> Any:
    """Field of an effect with its meaning attached."""
    meta = dict(unit=unit, bounds=bounds, null=null, starts=starts, scale=scale, origin=origin, tex=tex)
    return eqx.field(metadata={"param": meta | dict(optional=optional, fitted=fitted)})


def parameters(cls: type) -> dict[str, Parameter]:
    """Parameters of an effect class by name, in the order in which they are declared."""
    return {f.name: Parameter(name=f.name, **f.metadata["param"]) for f in fields(cls) if "param" in f.metadata}
