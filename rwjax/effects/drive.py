"""Effects on the command, before it becomes voltage or torque."""

from typing import ClassVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from rwjax.effects.parameter import param
from rwjax.effects.ports import CommandDelay, CommandFilter, CommandMap, Supply
from rwjax.types import Scalar

SHARP = 5000.0
"""Exponent of a saturation whose corner is as good as sharp: 0.014 % below it."""
SMALLEST = 1e-9
"""Command, in that at which a curve's power is 1, below which the power changes no more."""
JUMPS = (0.015, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3)
"""A jump shows only by the samples that it keeps at 0: no slope leads from one to the next."""


class DeadZone(CommandMap):
    r"""Small commands give nothing, $u_e = u - u_0\,\mathrm{sgn}(u)$ where $|u| > u_0 + j$; with $j > 0$ the drive starts with a jump."""

    name: ClassVar[str] = "drive.deadzone"
    label: ClassVar[str] = "dead zone of the drive"
    coordinate: ClassVar[str] = "voltage"
    u_0: Scalar = param(
        "V", bounds=(0.0, jnp.inf), starts=(0.03, 0.1, 0.3, *(0.0,) * len(JUMPS)), scale="command", tex="u_0"
    )
    j: Scalar = param(
        "V", bounds=(0.0, jnp.inf), starts=(0.0, 0.0, 0.0, *JUMPS), scale="command", tex="j", optional=True
    )

    def command(self, u: Scalar) -> Scalar:
        return jnp.where(jnp.abs(u) > self.u_0 + self.j, u - self.u_0 * jnp.sign(u), 0.0)


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


class DriveSaturation(CommandMap):
    r"""The command bends towards its limit, $u_e = u\,(1 + |u/u_m|^n)^{-1/n}$; with $n = 5000$ it is clipped."""

    name: ClassVar[str] = "drive.saturation"
    label: ClassVar[str] = "saturation of the drive"
    coordinate: ClassVar[str] = "voltage"
    u_m: Scalar = param(
        "V", bounds=(1e-3, 1e6), null=1e6, starts=(0.98, 0.9, 0.7, 0.4, 1.2, 4.0, 12.0), scale="peak", tex="u_m"
    )
    n: Scalar = param(
        "1", bounds=(1.5, SHARP), null=SHARP, starts=(SHARP, SHARP, SHARP, SHARP, 3.0, 2.0, 2.0), tex="n", optional=True
    )

    def command(self, u: Scalar) -> Scalar:
        size = jnp.abs(u)
        lower, upper = jnp.minimum(size, self.u_m), jnp.maximum(size, self.u_m)
        return jnp.sign(u) * lower * (1.0 + (lower / upper) ** self.n) ** (-1.0 / self.n)


class AsymmetricGain(CommandMap):
    r"""Gain that differs forward and reverse, $u_e = (1 + a\,\mathrm{sgn}\,u)\,u$."""

    name: ClassVar[str] = "drive.asymmetric_gain"
    label: ClassVar[str] = "direction-dependent gain of the drive"
    coordinate: ClassVar[str] = "voltage"
    a: Scalar = param("1", bounds=(-0.9, 0.9), starts=(0.05, -0.05), tex="a")

    def command(self, u: Scalar) -> Scalar:
        return u + self.a * jnp.abs(u)


class Curvature(CommandMap):
    r"""Gain that varies smoothly with the command's size: $u_e = u\,(1 + c|u|)\,|u/u_1|^p$ for $c > 0$, $u\,|u/u_1|^p/(1 - c|u|)$
    for $c < 0$; $p$ is 0 where it is straight at small commands, and $u_1$ the largest command of the logs in a search."""

    name: ClassVar[str] = "drive.curvature"
    label: ClassVar[str] = "curved characteristic of the drive"
    coordinate: ClassVar[str] = "voltage"
    c: Scalar = param("1/V", bounds=(-jnp.inf, jnp.inf), starts=(0.1, -0.1, 0.0, 0.0), scale="per_command", tex="c")
    p: Scalar = param("1", bounds=(-0.8, 3.0), starts=(0.0, 0.0, 0.1, -0.1), tex="p", optional=True)
    u_1: Scalar = param(
        "V", bounds=(1e-6, 1e6), null=1.0, starts=(1.0,), scale="peak", tex="u_1", optional=True, fitted=False
    )

    def command(self, u: Scalar) -> Scalar:
        size, rises = jnp.abs(u), self.c > 0.0
        power = jnp.maximum(size / self.u_1, SMALLEST) ** self.p
        return jnp.where(rises, u * (1.0 + self.c * size), u / (1.0 - jnp.where(rises, 0.0, self.c) * size)) * power


class DriveLag(CommandFilter):
    r"""The command acts through a lag, $T\dot u_e + u_e = u$, and a second one of $q T$ behind it."""

    name: ClassVar[str] = "drive.lag"
    label: ClassVar[str] = "lag of the drive"
    coordinate: ClassVar[str] = "voltage"
    T: Scalar = param("s", bounds=(0.0, 5.0), starts=(0.03, 0.1, 0.03, 0.1), tex="T")
    q: Scalar = param("1", bounds=(0.0, 1.0), starts=(0.0, 0.0, 0.5, 0.5), tex="q", optional=True)

    def follow(self, command: Float[Array, " steps"], h: Scalar) -> Float[Array, " steps"]:
        lags = [_kept(T, h) for T in (self.T, self.q * self.T)]

        def step(now: tuple[Scalar, ...], wanted: Scalar) -> tuple[tuple[Scalar, ...], Scalar]:
            end = []
            for x, (keep, mean) in zip(now, lags, strict=True):
                end.append(wanted + keep * (x - wanted))
                wanted = wanted + mean * (x - wanted)
            return tuple(end), wanted

        return jax.lax.scan(step, (command[0], command[0]), command)[1]


def _kept(T: Scalar, h: Scalar) -> tuple[Scalar, Scalar]:
    """Share of its distance from a constant command that a lag keeps over a step of `h`, at its end and in the mean."""
    on = T > 0.0
    some = jnp.where(on, T, 1.0)
    keep = jnp.where(on, jnp.exp(-h / some), 0.0)
    return keep, (1.0 - keep) * T / h


class RateLimit(CommandFilter):
    r"""The command slews at a limited rate, $|\dot u_e| \le r$."""

    name: ClassVar[str] = "drive.rate_limit"
    label: ClassVar[str] = "rate limit of the drive"
    coordinate: ClassVar[str] = "voltage"
    r: Scalar = param(
        "V/s", bounds=(1e-3, 1e12), null=1e12, starts=(1e4, 1e3, 100.0, 10.0, 3.0), scale="command", tex="r"
    )

    def follow(self, command: Float[Array, " steps"], h: Scalar) -> Float[Array, " steps"]:
        def step(now: Scalar, wanted: Scalar) -> tuple[Scalar, Scalar]:
            way = wanted - now
            end = now + jnp.clip(way, -self.r * h, self.r * h)
            part = jnp.clip(jnp.abs(way) / (self.r * h), 0.0, 1.0)  # of the step until it is there
            return end, end - 0.5 * part * (end - now)

        return jax.lax.scan(step, command[0], command)[1]


class SupplySag(Supply):
    r"""Supply voltage that drops with load: power $u i$ taken from a source with resistance, $u_e = u\,(1 - \rho|u i|)$."""

    name: ClassVar[str] = "drive.supply_sag"
    label: ClassVar[str] = "sagging supply"
    coordinate: ClassVar[str] = "current"
    rho: Scalar = param("1/W", bounds=(0.0, jnp.inf), starts=(0.1,), scale="per_watt", tex="\\rho")

    def voltage(self, u: Scalar, i: Scalar) -> Scalar:
        return u * jnp.maximum(1.0 - self.rho * jnp.abs(u * i), 0.0)
