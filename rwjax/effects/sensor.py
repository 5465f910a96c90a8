"""Effects between the motion and what the log says of it."""

from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.ports import Clock, Encoder
from rwjax.param import param
from rwjax.types import Scalar


class Scale(Encoder):
    r"""Counts per revolution off, $y = (1 + s)\,\psi$."""

    name: ClassVar[str] = "sensor.scale"
    label: ClassVar[str] = "scale of the encoder"
    coordinate: ClassVar[str] = "load"
    s: Scalar = param("1", bounds=(-0.9, 9.0), starts=(0.03, -0.03), tex="s")

    def read(self, angle: Scalar, rate: Scalar) -> tuple[Scalar, Scalar]:
        return (1.0 + self.s) * angle, (1.0 + self.s) * rate


class Eccentricity(Encoder):
    r"""Once-per-revolution error of the encoder, $y = \psi + s\sin\psi + c\cos\psi$."""

    name: ClassVar[str] = "sensor.eccentricity"
    label: ClassVar[str] = "eccentric encoder"
    coordinate: ClassVar[str] = "yaw"
    apart: ClassVar[bool] = True
    s: Scalar = param("rad", bounds=(-0.9, 0.9), starts=(0.03, 0.0), tex="s")
    c: Scalar = param("rad", bounds=(-0.9, 0.9), starts=(0.0, 0.03), tex="c")

    def read(self, angle: Scalar, rate: Scalar) -> tuple[Scalar, Scalar]:
        sine, cosine = jnp.sin(angle), jnp.cos(angle)
        return angle + self.s * sine + self.c * cosine, rate * (1.0 + self.s * cosine - self.c * sine)


class LoggerClock(Clock):
    r"""The logger's clock runs fast or slow: $t = (1 - e)\,t_\mathrm{log}$, fast where $e > 0$."""

    name: ClassVar[str] = "sensor.clock"
    label: ClassVar[str] = "clock of the logger"
    coordinate: ClassVar[str] = "time"
    e: Scalar = param("1", bounds=(-0.5, 0.5), starts=(0.02, -0.02), tex="e")

    def pace(self) -> Scalar:
        return 1.0 - self.e
