"""Effects between the motion and what the log says of it."""

from collections.abc import Mapping
from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.effect import Motion
from rwjax.effects.harmonics import two_harmonics
from rwjax.effects.parameter import param
from rwjax.effects.ports import Clock, Encoder, EncoderDelay, Reading
from rwjax.effects.shown import COASTING, FAST
from rwjax.types import Scalar


class Scale(Encoder):
    r"""Counts per revolution off, $y = (1 + s)\,\psi$.

    Attributes:
        s: Error of the scale [1].
    """

    name: ClassVar[str] = "sensor.scale"
    label: ClassVar[str] = "scale of the encoder"
    coordinate: ClassVar[str] = "load"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "counts per revolution off"
    equation: ClassVar[str] = "(1 + s) ψ"
    s: Scalar = param("1", bounds=(-0.9, 9.0), starts=(0.03, -0.03), tex="s")

    def read(self, angle: Scalar, rate: Scalar, motion: Motion) -> tuple[Scalar, Scalar]:
        return (1.0 + self.s) * angle, (1.0 + self.s) * rate


class Eccentricity(Encoder):
    r"""Error that repeats with every turn, $y = \psi + s\sin\psi + c\cos\psi + s_2\sin 2\psi + c_2\cos 2\psi$.

    Attributes:
        s: Sine of the angle in the error [rad].
        c: Cosine of the angle [rad].
        s_2: Sine of twice the angle [rad].
        c_2: Cosine of twice the angle [rad].
    """

    name: ClassVar[str] = "sensor.eccentricity"
    label: ClassVar[str] = "eccentric encoder"
    coordinate: ClassVar[str] = "yaw"
    at_angle: ClassVar[bool] = True
    meaning: ClassVar[str] = "error of the encoder that repeats with every turn"
    equation: ClassVar[str] = "ψ + s sin ψ + c cos ψ + s_2 sin 2ψ + c_2 cos 2ψ"
    s: Scalar = param("rad", bounds=(-0.9, 0.9), starts=(0.03, 0.0), tex="s")
    c: Scalar = param("rad", bounds=(-0.9, 0.9), starts=(0.0, 0.03), tex="c")
    s_2: Scalar = param("rad", bounds=(-0.4, 0.4), starts=(0.0,), tex="s_2", role="form")
    c_2: Scalar = param("rad", bounds=(-0.4, 0.4), starts=(0.0,), tex="c_2", role="form")

    def read(self, angle: Scalar, rate: Scalar, motion: Motion) -> tuple[Scalar, Scalar]:
        error = two_harmonics(angle, self.s, self.c, self.s_2, self.c_2)
        slope = two_harmonics(angle, -self.c, self.s, -2.0 * self.c_2, 2.0 * self.s_2)
        return angle + error, rate * (1.0 + slope)


class SensorDelay(EncoderDelay):
    r"""The encoder's reading is late, $y(t) = \psi(t - \tau)$; before a run's first sample it went on at its first rate.

    Attributes:
        tau: Delay [s].
    """

    name: ClassVar[str] = "sensor.delay"
    label: ClassVar[str] = "late reading of the encoder"
    coordinate: ClassVar[str] = "time"
    longest: ClassVar[float] = 0.5
    meaning: ClassVar[str] = "the encoder's reading is late, other sensors' are not"
    equation: ClassVar[str] = "ψ(t − τ), up to 0.5 s"
    shown_by: ClassVar[Mapping[str, int]] = {FAST: 1}
    tau: Scalar = param("s", bounds=(0.0, longest), starts=(0.01, 0.04, 0.1, 0.25), tex="\\tau")

    def delay(self) -> Scalar:
        return self.tau


class MissedCounts(Encoder):
    r"""Counts lost above a speed: $\dot y = w - \mathrm{sgn}(w)\,(s\,(|w| - w_m) + j\,w_m)$ where $|w| > w_m$.

    With $j = s$ a share of all counts is lost there.

    Attributes:
        s: Share of the counts lost above the speed [1].
        w_m: Speed above which counts are lost [rad/s].
        j: Share lost at once where the speed is passed [1].
    """

    name: ClassVar[str] = "sensor.missed_counts"
    label: ClassVar[str] = "counts missed at speed"
    coordinate: ClassVar[str] = "yaw_rate"
    states: ClassVar[tuple[str, ...]] = ("lost",)
    meaning: ClassVar[str] = "counts lost at high speed"
    equation: ClassVar[str] = (
        "read rate w − sgn(w) (s (abs(w) − w_m) + j w_m) where abs(w) > w_m, the angle its integral"
    )
    s: Scalar = param("1", bounds=(0.0, 1.0), starts=(*(0.2,) * 4, *(0.1,) * 4), tex="s")
    w_m: Scalar = param(
        "rad/s", bounds=(0.0, 1e5), null=1.0, starts=(0.85, 0.7, 0.5, 0.35) * 2, scale="sensed_rate", tex="w_m"
    )
    j: Scalar = param("1", bounds=(0.0, 1.0), starts=(*(0.0,) * 4, *(0.1,) * 4), tex="j", role="form")

    def _behind(self, rate: Scalar) -> Scalar:
        over = jnp.abs(rate) - self.w_m
        return jnp.where(over > 0.0, jnp.sign(rate) * (self.s * over + self.j * self.w_m), 0.0)

    def drift(self, motion: Motion) -> tuple[Scalar, ...]:
        return (self._behind(motion.sensed),)

    def read(self, angle: Scalar, rate: Scalar, motion: Motion) -> tuple[Scalar, Scalar]:
        return angle - self.mine(motion)[0], rate - self._behind(rate)


class LoggerClock(Clock):
    r"""The logger's clock runs fast or slow: $t = (1 - e)\,t_\mathrm{log}$, fast where $e > 0$.

    Attributes:
        e: Share by which the clock runs fast [1].
    """

    name: ClassVar[str] = "sensor.clock"
    label: ClassVar[str] = "clock of the logger"
    coordinate: ClassVar[str] = "time"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "the logger's clock runs fast (e > 0) or slow"
    equation: ClassVar[str] = "t = (1 − e) t_log"
    shown_by: ClassVar[Mapping[str, int]] = {FAST: 1}
    e: Scalar = param("1", bounds=(-0.5, 0.5), starts=(0.02, -0.02), tex="e")

    def pace(self) -> Scalar:
        return 1.0 - self.e


class Offset(Reading):
    r"""Constant offset of a sensor that reads a rate or a current, $y = w + w_b$.

    That of an angle would be no error: a run may begin anywhere. In a search an output that no log holds has no offset.

    Attributes:
        w_b: Offset of the axis's rate [rad/s].
        Omega_b: Offset of the wheel's rate [rad/s].
        i_b: Offset of the current [A].
    """

    name: ClassVar[str] = "sensor.offset"
    label: ClassVar[str] = "offset of a rate or current sensor"
    coordinate: ClassVar[str] = "time"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "constant offset of a sensor that reads a rate or a current"
    equation: ClassVar[str] = "readings w + w_b of the axis, Ω + Omega_b of the wheel, i + i_b"
    shown_by: ClassVar[Mapping[str, int]] = {COASTING: 1}
    output_of: ClassVar[Mapping[str, str]] = {"w_b": "yaw_rad_s", "Omega_b": "wheel_rad_s", "i_b": "current_A"}
    w_b: Scalar = param(
        "rad/s", bounds=(-jnp.inf, jnp.inf), starts=(0.03, 0.0, 0.0), scale="rate", tex="w_b", role="reading"
    )
    Omega_b: Scalar = param(
        "rad/s", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.03, 0.0), scale="spin", tex="\\Omega_b", role="reading"
    )
    i_b: Scalar = param(
        "A", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.0, 0.03), scale="ampere", tex="i_b", role="reading"
    )

    def read(self, output: str, value: Scalar) -> Scalar:
        return value + sum(getattr(self, number) for number, on in self.output_of.items() if on == output)
