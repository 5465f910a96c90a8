"""A rig as its file describes it: every number with its name, which are free, and how much is known of them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from rwjax.errors import RigError
from rwjax.kinds import COEFFICIENTS, NUMBERS, POLYNOMIAL, TWO_AXIS
from rwjax.rig.columns_section import Source
from rwjax.rig.effect_section import effect_parameters
from rwjax.rig.tied import completed


class Pwm(NamedTuple):
    """The map from pulse width to voltage of an ESC: `(pulse - neutral_us) volts_per_us` [V].

    Attributes:
        neutral_us: Pulse width at 0 V [us].
        volts_per_us: Voltage per pulse width [V/us], negative where longer pulses drive backwards.
    """

    neutral_us: float
    volts_per_us: float


class Servo(NamedTuple):
    """What `[drive.servo]` says in words; its gains and times are among the rig's numbers (`kinds.SERVO`).

    Attributes:
        acts_on: What its output is: "voltage" [V], "duty" [1], "current" [A] or "torque" [N m].
        damping_on: What its gain `kd` multiplies: the rate of the "error", or the "speed".
        encoder_side: Side of a backlash or a coupling on which the axis's encoder sits: "link" or "motor".
    """

    acts_on: str
    damping_on: str = "error"
    encoder_side: str = "link"


class Driven(NamedTuple):
    """How a rig was driven in a set of logs (`rwjax.logs.driven`).

    Attributes:
        by: Column of the command, as `voltage_V` or `goal_rad`.
        switched: Whether the logs say when torque was on.
        supplied: Whether the logs hold the voltage of the supply.
    """

    by: str = "voltage_V"
    switched: bool = False
    supplied: bool = False


CAUTION = "caution: "
"""Begins a comment of a rig file that says what a diagnosis was not sure of."""
GUESS = "a guess"
"""Stands in the comment behind a key of a rig file that nobody knows."""


@dataclass(frozen=True)
class Rig:
    """A rig file, checked. Every value is in SI; names are dotted, as in `fit.free` of the file.

    Attributes:
        kind: One of `kinds.KINDS`.
        name: The rig's name, by default the file's.
        numbers: The plant numbers that the file holds, by the names and units of `kinds.NUMBERS`.
        free: Names of `values` that a fit estimates.
        bounds: Lowest and highest value of a number by name.
        prior: Mean and standard deviation of a free number by name, from elsewhere than the logs.
        per_run: Names of `free` of which every log has a value of its own.
        standard_error: Standard error of an earlier estimate by name; infinite where the logs say nothing about it.
        effects: Effect name -> parameter name -> value.
        counts_per_rev: Counted edges per turn [1] of the encoders, by what they sit on (`kinds.ENCODERS`).
        pwm: Map from pulse width to volts, None where the file holds none.
        columns: "position" and "pulse" -> column of a log of the thesis's layout.
        servo: The loop between a goal and what the drive is given, None where the file describes none.
        tied: Formulas of numbers that follow from others, by name, each behind those on which it depends (`rwjax.rig.tied`).
        driven: How it was driven; no part of the file. A rig as read is driven by a voltage.
        sources: Columns of a log file by the columns of rwjax's that they become.
        cautions: What the diagnosis that wrote it was not sure of; the first comments of the file, kept by what is made from it.
        guessed: Keys whose comments in the file call them a guess, as a first rig file has them; kept by what is made from it until they have a standard error. Two rigs
            that differ by them alone are equal.
    """

    kind: str
    name: str
    numbers: dict[str, float]
    free: tuple[str, ...] = ()
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    prior: dict[str, tuple[float, float]] = field(default_factory=dict)
    per_run: tuple[str, ...] = ()
    standard_error: dict[str, float] = field(default_factory=dict)
    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    counts_per_rev: dict[str, float] = field(default_factory=dict)
    pwm: Pwm | None = None
    columns: dict[str, str] = field(default_factory=dict)
    servo: Servo | None = None
    tied: dict[str, str] = field(default_factory=dict)
    driven: Driven = field(default_factory=Driven)
    sources: dict[str, Source] = field(default_factory=dict)
    cautions: tuple[str, ...] = ()
    guessed: tuple[str, ...] = field(default=(), compare=False)

    @property
    def values(self) -> dict[str, float]:
        """Every number and effect parameter [SI] by its name ("axis.inertia", "axis.stribeck.v_s")."""
        return self.numbers | {f"{e}.{p}": value for e, given in self.effects.items() for p, value in given.items()}

    def with_values(self, values: Mapping[str, float]) -> "Rig":
        """This rig with other values of some numbers.

        Args:
            values: New values [SI] by name, of numbers that the rig holds.

        Returns:
            The rig with these values and those that follow from them, everything else as it is.

        Raises:
            KeyError: For a name that the rig does not hold.
        """
        if unknown := sorted(values.keys() - self.values.keys()):
            raise KeyError(f"the rig `{self.name}` holds no {unknown}")
        new = completed(self.tied, {name: float(values.get(name, old)) for name, old in self.values.items()})
        effects = {e: {p: new[f"{e}.{p}"] for p in given} for e, given in self.effects.items()}
        return replace(self, numbers={name: new[name] for name in self.numbers}, effects=effects)

    def with_standard_errors(self, errors: Mapping[str, float]) -> "Rig":
        """This rig with the standard errors of estimates.

        Args:
            errors: Standard errors [SI] by name, of what the logs tell.

        Returns:
            The rig with these errors alone; what has one is a guess no more.
        """
        told = {*errors} | ({POLYNOMIAL} if {*COEFFICIENTS} & {*errors} else set())
        guessed = tuple(name for name in self.guessed if name not in told)
        return replace(self, standard_error=dict(errors), guessed=guessed)

    def __str__(self) -> str:
        """Kind and name, then a line for every part: its numbers with units, and which of them are free."""
        lines: dict[str, list[str]] = {}
        for name, value, unit in self._numbers_with_units():
            part, _, rest = name.partition(".") if name in self.numbers else name.rpartition(".")
            lines.setdefault(part, []).append(f"{rest} = {self._in_words(name, value, unit)}")
        return "\n".join(
            [f"{self.kind} rig `{self.name}`", *(f"  {part}: {', '.join(of)}" for part, of in lines.items())]
        )

    def _numbers_with_units(self) -> Iterator[tuple[str, float, str]]:
        """Name, value and unit of every number and effect parameter."""
        for name in (name for name in NUMBERS if name in self.numbers):
            yield name, self.numbers[name], NUMBERS[name].unit
        known = effect_parameters() if self.effects else {}
        for effect, given in self.effects.items():
            for parameter, value in given.items():
                yield f"{effect}.{parameter}", value, known[effect][parameter].unit

    def _in_words(self, name: str, value: float, unit: str) -> str:
        error = f" ± {self.standard_error[name]:.2g}" if name in self.standard_error else ""
        if name in self.tied:
            return f"{value:.6g}{error}{'' if unit == '1' else f' {unit}'} (= {self.tied[name]})"
        free = " (free, per run)" if name in self.per_run else " (free)" if name in self.free else ""
        return f"{value:.6g}{error}{'' if unit == '1' else f' {unit}'}{free}"


def with_one_axis(rig: Rig) -> Rig:
    """A rig that has to have one axis.

    Args:
        rig: Any rig.

    Returns:
        The rig itself.

    Raises:
        RigError: If it has two axes.
    """
    if rig.kind in TWO_AXIS:
        raise RigError(f"kind `{rig.kind}` has two axes, and this is for one; describe that axis by a `reaction` rig")
    return rig
