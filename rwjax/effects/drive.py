"""Effects on the command, before it becomes voltage or torque."""

from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.ports import CommandDelay, CommandMap
from rwjax.param import param
from rwjax.types import Scalar


class DeadZone(CommandMap):
    r"""Small commands give nothing, $u_e = \mathrm{sgn}(u)\,\max(|u| - u_0, 0)$."""

    name: ClassVar[str] = "drive.deadzone"
    label: ClassVar[str] = "dead zone of the drive"
    coordinate: ClassVar[str] = "voltage"
    u_0: Scalar = param("V", bounds=(0.0, jnp.inf), starts=(0.03, 0.1, 0.3), scale="command", tex="u_0")

    def command(self, u: Scalar) -> Scalar:
        return jnp.sign(u) * jnp.maximum(jnp.abs(u) - self.u_0, 0.0)


class DriveBias(CommandMap):
    r"""Constant offset on the command, $u_e = u + u_b$."""

    name: ClassVar[str] = "drive.bias"
    label: ClassVar[str] = "offset of the command"
    coordinate: ClassVar[str] = "voltage"
    u_b: Scalar = param("V", bounds=(-jnp.inf, jnp.inf), starts=(0.03, -0.03), scale="command", tex="u_b")

    def command(self, u: Scalar) -> Scalar:
        return u + self.u_b


class DriveDelay(CommandDelay):
    r"""The command acts late, $u_e(t) = u(t - \tau)$."""

    name: ClassVar[str] = "drive.delay"
    label: ClassVar[str] = "delay of the command"
    coordinate: ClassVar[str] = "voltage"
    tau: Scalar = param("s", bounds=(0.0, 0.5), starts=(0.01, 0.04, 0.12), tex="\\tau")

    def delay(self) -> Scalar:
        return self.tau
