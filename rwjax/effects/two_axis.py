"""Effects on a rig with two axes: those of one axis on each half, and what only the two together can have."""

from abc import abstractmethod
from collections.abc import Iterable
from typing import ClassVar

from rwjax.effects.effect import Effect, FittedRig
from rwjax.effects.parameter import param
from rwjax.effects.ports import Clock, Coupling, EncoderDelay, GoalDelay, Inertia
from rwjax.kinds import HALVES, of_half, on_half
from rwjax.types import Scalar

OF_THE_LOG = (EncoderDelay, Clock)
"""Ports that belong to the logger: a rig with two axes has one of them, under its own name."""
NOT_HERE = (*OF_THE_LOG, Coupling, GoalDelay, Inertia)
"""Ports that no half has: nothing lies between a wheel's motor and the body that carries it, no servo moves two axes, and the inertias of
two axes depend on the pitch alone."""


def on_each_half(effects: Iterable[type[Effect]]) -> list[type[Effect]]:
    """The same effects on yaw and its wheel, then on pitch and its wheel: `yaw.stribeck`, `wheel_2.coulomb`.

    Args:
        effects: Effects of rigs with one axis.

    Returns:
        A class for each half of each effect that a half may have, in the order of `effects`, those of yaw first.
    """
    every = [effect for effect in effects if not issubclass(effect, NOT_HERE)]
    return [_placed(effect, half) for half in range(len(HALVES)) for effect in every]


def _placed(effect: type[Effect], half: int) -> type[Effect]:
    """An effect under its name on one half. A plant holds the effect itself: this says where it sits."""
    name = on_half(effect.name, half)
    part = name.partition(".")[0]
    coordinate = effect.coordinate
    if half == 1:
        coordinate = {"yaw": "pitch", "yaw_rate": "pitch_rate"}.get(coordinate, coordinate)

    def same_as(cls: type[Effect], fitted: FittedRig) -> tuple[str, ...]:
        return tuple(on_half(other, half) for other in effect.same_as(_of_half(fitted, half)))

    said: dict[str, object] = {
        "name": name,
        "label": f"{effect.label} ({part.replace('_', ' ')})",
        "coordinate": coordinate,
        "same_as": classmethod(same_as),
        "includes": effect.includes and on_half(effect.includes, half),
        "__doc__": effect.__doc__,
        "__module__": __name__,
    }
    for names in ("limits", "covers", "modelled_by", "like_larger", "passes_for"):
        said[names] = tuple(on_half(other, half) for other in getattr(effect, names))
    return type(f"{effect.__name__}{half + 1}", (effect,), said)


def _of_half(fitted: FittedRig, half: int) -> FittedRig:
    """What belongs to one half of a fitted rig, under the names that it has on a rig with one axis."""

    def own(names: Iterable[str]) -> dict[str, str]:
        return {at[1]: name for name in names if (at := of_half(name)) is not None and at[0] == half}

    numbers = {here: fitted.numbers[name] for here, name in own(fitted.numbers).items()}
    return FittedRig(fitted.kind, frozenset(own(fitted.names)), numbers)


class Tilt(Effect):
    """Port: how far the axis of wheel 1 leans where the pitch body tilts."""

    @abstractmethod
    def share(self) -> Scalar:
        """Share of the pitch by which it leans [1].

        Returns:
            The share [1].
        """


class YawReading(Effect):
    """Port: what the encoder of the yaw axis reads of both axes."""

    @abstractmethod
    def read(self, yaw: Scalar, pitch: Scalar) -> Scalar:
        """What the encoder of the yaw axis makes of both angles [rad], or of both rates [rad/s].

        Args:
            yaw: Angle or rate of yaw [rad or rad/s].
            pitch: Angle or rate of pitch [rad or rad/s].

        Returns:
            The reading [rad or rad/s].
        """


class Gyroscopic(Tilt):
    r"""Gyroscopic coupling: wheel 1 leans by $s\theta$ at a pitch of $\theta$, and its momentum $H$ turns with the bodies.

    Torques: $s\sin(s\theta)\,H\,\dot\theta$ on yaw and $-s\sin(s\theta)\,H\,\dot\psi$ on pitch; the motor's torque on yaw falls
    by $\cos(s\theta)$ (`rwjax.plant.two_axis`). With $s = 1$ the pitch body carries the wheel, with $s = 0$ the yaw body
    does. All of it begins with $s^2$, so a fit of $s$ has to begin beside 0.

    Attributes:
        s: Share of the pitch by which wheel 1 leans [1].
    """

    name: ClassVar[str] = "wheel_1.gyroscopic"
    label: ClassVar[str] = "gyroscopic coupling by a wheel 1 that tilts with the pitch"
    coordinate: ClassVar[str] = "pitch"
    meaning: ClassVar[str] = "wheel 1 tilts with the pitch body, its momentum H₁ turns with it"
    equation: ClassVar[str] = (
        "its axis leans by s θ (0: the yaw body carries it, 1: the pitch body): s sin(sθ) H₁ θ' on yaw, −s sin(sθ) H₁ ψ' on "
        "pitch, cos(sθ) of its torque on yaw"
    )
    s: Scalar = param("1", bounds=(0.0, 2.0), starts=(1.0, 0.3), tex="s")

    def share(self) -> Scalar:
        return self.s


class Misalignment(YawReading):
    r"""Misaligned encoder of the yaw axis: it reads a part of the pitch, $y = \psi + e\,\theta$.

    Attributes:
        e: Share of the pitch that is read [1].
    """

    name: ClassVar[str] = "sensor_1.misalignment"
    label: ClassVar[str] = "yaw encoder that reads a part of the pitch"
    coordinate: ClassVar[str] = "pitch"
    meaning: ClassVar[str] = "the yaw encoder reads a part of the pitch"
    equation: ClassVar[str] = "ψ + e θ"
    e: Scalar = param("1", bounds=(-0.9, 0.9), starts=(0.03, -0.03), tex="e")

    def read(self, yaw: Scalar, pitch: Scalar) -> Scalar:
        return yaw + self.e * pitch
