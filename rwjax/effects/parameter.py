"""A parameter's unit, bounds and null value, kept on the field that holds it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

Role = Literal["effect", "reading", "choice", "form", "reference"]
"""What a number is for: `effect`, it makes the effect; `reading`, like that, but it acts on one output alone (`Effect.output_of`), and a rig
file may leave it out; `choice`, like `effect`, but a search tries its starts and nothing between them; `form`, it belongs to the effect's form,
and a rig file may leave it out; `reference`, like that, and no search estimates it."""


@dataclass(frozen=True)
class Parameter:
    """What is known about a number of an effect before any log is seen.

    Attributes:
        name: Name of the field.
        unit: SI unit as text, "1" where it has none.
        bounds: Lowest and highest value that is physically possible [unit].
        null: Value at which the effect is absent, or that says nothing where it is [unit].
        starts: Values from which a search begins, counted from `origin` in units of `scale`; None is the null.
        scale: Name of the size in which the starts are given, such as `one`, `command`, `torque` or `rate`;
            `rwjax.fitting.scales.scales` lists them.
        origin: Name of the size from which the starts are counted; None for 0.
        tex: Symbol in LaTeX.
        role: What it is for.
    """

    name: str
    unit: str
    bounds: tuple[float, float]
    null: float
    starts: tuple[float | None, ...]
    scale: str
    origin: str | None
    tex: str
    role: Role

    @property
    def of_form(self) -> bool:
        """Whether it says in which form the effect comes, and not that there is one."""
        return self.role in ("form", "reference")

    @property
    def optional(self) -> bool:
        """Whether a rig file may leave it out and then has it at its null."""
        return self.of_form or self.role == "reading"

    @property
    def fitted(self) -> bool:
        """Whether a search estimates it; else it stays where the search begins."""
        return self.role in ("effect", "reading", "form")

    def begin(self, sizes: Mapping[str, float]) -> tuple[float, ...]:
        """Values from which a search begins, within the bounds.

        Args:
            sizes: Sizes by the names that `scale` and `origin` may have [unit].

        Returns:
            The values [unit].
        """
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
    role: Role = "effect",
) -> Any:
    """Field of an effect with its meaning attached. The arguments are the attributes of `Parameter`.

    Args:
        unit: SI unit as text, "1" where it has none.
        bounds: Lowest and highest value that is physically possible [unit].
        null: Value at which the effect is absent [unit].
        starts: Values from which a search begins [`scale`].
        scale: Name of the size in which the starts are given.
        origin: Name of the size from which the starts are counted; None for 0.
        tex: Symbol in LaTeX.
        role: What it is for.

    Returns:
        The field.
    """
    meta = dict(unit=unit, bounds=bounds, null=null, starts=starts, scale=scale, origin=origin, tex=tex, role=role)
    return field(metadata={"param": meta})


def parameters(cls: type) -> dict[str, Parameter]:
    """Parameters of an effect by name.

    Args:
        cls: Class of the effect.

    Returns:
        The parameters in the order in which they are declared.
    """
    return {f.name: Parameter(name=f.name, **f.metadata["param"]) for f in fields(cls) if "param" in f.metadata}
