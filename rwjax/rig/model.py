"""The rig file (TOML), what the user believes about the hardware: `read_rig`, `write_rig`, `Rig`."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from rwjax.errors import RigError
from rwjax.kinds import TWO_AXIS
from rwjax.rig import parse as read


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


def with_one_axis(rig: Rig) -> Rig:
    """The rig itself. Raises `RigError` if it has two axes."""
    if rig.kind in TWO_AXIS:
        raise RigError(f"kind `{rig.kind}` has two axes, and this is for one; describe that axis by a `reaction` rig")
    return rig
