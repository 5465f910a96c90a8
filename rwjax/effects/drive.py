"""Effects on the command, before it becomes voltage or torque."""

from collections.abc import Mapping
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np

from rwjax.effects.c_code import literal
from rwjax.effects.effect import FittedRig, Motion
from rwjax.effects.parameter import param
from rwjax.effects.ports import Advance, CommandDelay, CommandFilter, CommandMap, GoalDelay, Supply
from rwjax.effects.shown import DWELLING, FAST, LEVELS
from rwjax.types import Scalar

SHARP = 5000.0
"""Exponent of a saturation whose corner is as good as sharp: 0.014 % below it."""
BEYOND = 1.001
"""Times the command with which a drive starts, from which on a command in single precision surely starts it."""
SMALLEST = 1e-9
"""Command, in that at which a curve's power is 1, below which the power changes no more."""
SHORTEST = 1e-3
"""Share of a drive's first lag that its second one has at least, where some plants have a second one."""
JUMPS = (0.015, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3)
"""A jump shows only by the samples that it keeps at 0: no slope leads from one to the next."""


class DeadZone(CommandMap):
    r"""Small commands give nothing, $u_e = u - u_0\,\mathrm{sgn}(u)$ where $|u| > u_0 + j$; with $j > 0$ the drive starts with a jump.

    Attributes:
        u_0: Command that is lost [V].
        j: Jump with which the drive starts [V].
    """

    name: ClassVar[str] = "drive.deadzone"
    label: ClassVar[str] = "dead zone of the drive"
    coordinate: ClassVar[str] = "voltage"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = (
        "small commands give nothing, larger ones lose u_0; with j > 0 the drive starts with a jump"
    )
    equation: ClassVar[str] = "0 up to u_0 + j, then u − u_0 sgn(u)"
    shown_by: ClassVar[Mapping[str, int]] = {LEVELS: 0, DWELLING: 0}
    threshold: ClassVar[str] = "u_0"
    u_0: Scalar = param(
        "V", bounds=(0.0, jnp.inf), starts=(0.03, 0.1, 0.3, *(0.0,) * len(JUMPS)), scale="command", tex="u_0"
    )
    j: Scalar = param("V", bounds=(0.0, jnp.inf), starts=(0.0, 0.0, 0.0, *JUMPS), scale="command", tex="j", role="form")

    def command(self, u: Scalar) -> Scalar:
        return jnp.where(jnp.abs(u) > self.u_0 + self.j, u - self.u_0 * jnp.sign(u), 0.0)

    @classmethod
    def c_command(cls, given: Mapping[str, float]) -> str:
        add = f"if (u != 0.0f) u += copysignf({literal(given['u_0'])}, u);"
        if not (j := given["j"]):
            return add
        least = literal(BEYOND * j)
        start = f"if (fabsf(u) < {least}) u = fabsf(u) < {literal(0.5 * j)} ? 0.0f : copysignf({least}, u);"
        return f"{start} /* less than it starts with */\n{add}"


class DriveDelay(CommandDelay):
    r"""The command acts late, $u_e(t) = u(t - \tau)$.

    Attributes:
        tau: Delay [s].
    """

    name: ClassVar[str] = "drive.delay"
    label: ClassVar[str] = "delay of the command"
    coordinate: ClassVar[str] = "voltage"
    meaning: ClassVar[str] = "the command acts late"
    equation: ClassVar[str] = "u(t − τ)"
    shown_by: ClassVar[Mapping[str, int]] = {FAST: 0}
    tau: Scalar = param("s", bounds=(0.0, 0.5), starts=(0.01, 0.04, 0.12), tex="\\tau")

    def delay(self) -> Scalar:
        return self.tau

    @classmethod
    def same_as(cls, fitted: FittedRig) -> tuple[str, ...]:
        return ("sensor.delay",) if fitted.kind == "platform" else ()

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"delay": given["tau"]}

    @classmethod
    def from_mujoco(cls, fields: Mapping[str, float]) -> Mapping[str, float]:
        return {"tau": fields["delay"]} if "delay" in fields else {}


class DriveLag(CommandFilter):
    r"""The command acts through a lag, $T\dot u_e + u_e = u$, and a second one of $q T$ behind it.

    Attributes:
        T: Time constant [s].
        q: Time constant of a second lag, over that of the first [1].
    """

    name: ClassVar[str] = "drive.lag"
    label: ClassVar[str] = "lag of the drive"
    coordinate: ClassVar[str] = "voltage"
    meaning: ClassVar[str] = "the command acts through a lag"
    equation: ClassVar[str] = "T u_e' + u_e = u, and a second lag of q T behind it"
    mujoco_drops: ClassVar[Mapping[str, str]] = {"q": "its second lag; the first one is there"}
    shown_by: ClassVar[Mapping[str, int]] = {FAST: 0}
    linear: ClassVar[bool] = True
    filter_states: ClassVar[tuple[str, ...]] = ("first", "second")
    T: Scalar = param("s", bounds=(0.0, 5.0), starts=(0.03, 0.1, 0.03, 0.1), tex="T")
    q: Scalar = param("1", bounds=(0.0, 1.0), starts=(0.0, 0.0, 0.5, 0.5), tex="q", role="form")

    def over(self, h: Scalar) -> Advance:
        lags = [_kept(T, h) for T in (self.T, self.q * self.T)]

        def step(now: tuple[Scalar, ...], wanted: Scalar) -> tuple[tuple[Scalar, ...], Scalar]:
            end = []
            for x, (keep, mean) in zip(now, lags, strict=True):
                end.append(wanted + keep * (x - wanted))
                wanted = wanted + mean * (x - wanted)
            return tuple(end), wanted

        return step

    @classmethod
    def order(cls, given: Mapping[str, Any]) -> int:
        return 1 + bool(np.any(given["q"])) if np.any(given["T"]) else 0

    def lags(self, order: int) -> tuple[Scalar, ...]:
        return (self.T * jnp.maximum(self.q, SHORTEST), self.T)[2 - order :]

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"lag": given["T"]}

    @classmethod
    def from_mujoco(cls, fields: Mapping[str, float]) -> Mapping[str, float]:
        return {"T": fields["lag"], "q": 0.0} if "lag" in fields else {}


def _kept(T: Scalar, h: Scalar) -> tuple[Scalar, Scalar]:
    """Share of its distance from a constant command that a lag keeps over a step of `h`, at its end and in the mean."""
    on = T > 0.0
    some = jnp.where(on, T, 1.0)
    keep = jnp.where(on, jnp.exp(-h / some), 0.0)
    return keep, -jnp.expm1(-h / some) * T / h


class RateLimit(CommandFilter):
    r"""The command slews at a limited rate, $|\dot u_e| \le r$.

    Attributes:
        r: Largest rate of the command [V/s].
    """

    name: ClassVar[str] = "drive.rate_limit"
    label: ClassVar[str] = "rate limit of the drive"
    coordinate: ClassVar[str] = "voltage"
    meaning: ClassVar[str] = "the command slews at a limited rate"
    equation: ClassVar[str] = "abs(u_e') ≤ r"
    shown_by: ClassVar[Mapping[str, int]] = {FAST: 0}
    filter_states: ClassVar[tuple[str, ...]] = ("slewed",)
    r: Scalar = param(
        "V/s", bounds=(1e-3, 1e12), null=1e12, starts=(1e4, 1e3, 100.0, 10.0, 3.0), scale="command", tex="r"
    )

    def over(self, h: Scalar) -> Advance:
        def step(now: tuple[Scalar, ...], wanted: Scalar) -> tuple[tuple[Scalar, ...], Scalar]:
            way = wanted - now[0]
            end = now[0] + jnp.clip(way, -self.r * h, self.r * h)
            part = jnp.clip(jnp.abs(way) / (self.r * h), 0.0, 1.0)  # of the step until it is there
            return (end,), end - 0.5 * part * (end - now[0])

        return step


class DriveSaturation(CommandMap):
    r"""The command bends towards its limit, $u_e = u\,(1 + |u/u_m|^n)^{-1/n}$; with $n = 5000$ it is clipped.

    Attributes:
        u_m: Limit of the command [V].
        n: Sharpness of the bend [1].
    """

    name: ClassVar[str] = "drive.saturation"
    label: ClassVar[str] = "saturation of the drive"
    coordinate: ClassVar[str] = "voltage"
    meaning: ClassVar[str] = "the command is clipped, or bends towards a limit"
    equation: ClassVar[str] = "u (1 + abs(u/u_m)ⁿ)^(−1/n); n = 5000 clips"
    shown_by: ClassVar[Mapping[str, int]] = {LEVELS: 0}
    u_m: Scalar = param(
        "V", bounds=(1e-3, 1e6), null=1e6, starts=(0.98, 0.9, 0.7, 0.4, 1.2, 4.0, 12.0), scale="peak", tex="u_m"
    )
    n: Scalar = param(
        "1", bounds=(1.5, SHARP), null=SHARP, starts=(SHARP, SHARP, SHARP, SHARP, 3.0, 2.0, 2.0), tex="n", role="form"
    )

    def command(self, u: Scalar) -> Scalar:
        size = jnp.abs(u)
        lower, upper = jnp.minimum(size, self.u_m), jnp.maximum(size, self.u_m)
        return jnp.sign(u) * lower * (1.0 + (lower / upper) ** self.n) ** (-1.0 / self.n)

    @classmethod
    def largest_command(cls, given: Mapping[str, float]) -> float:
        return given["u_m"]

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "the gain is that of small commands" if given.get("n", SHARP) < SHARP else ""

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"limit": given["u_m"]} if given.get("n", SHARP) >= SHARP else None

    @classmethod
    def from_mujoco(cls, fields: Mapping[str, float]) -> Mapping[str, float]:
        return {"u_m": fields["limit"], "n": SHARP} if "limit" in fields else {}


class DriveBias(CommandMap):
    r"""Constant offset on the command, $u_e = u + u_b$.

    Attributes:
        u_b: Offset [V].
    """

    name: ClassVar[str] = "drive.bias"
    label: ClassVar[str] = "offset of the command"
    coordinate: ClassVar[str] = "voltage"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "constant offset on the command"
    equation: ClassVar[str] = "u + u_b"
    u_b: Scalar = param("V", bounds=(-jnp.inf, jnp.inf), starts=(0.03, -0.03), scale="command", tex="u_b")

    def command(self, u: Scalar) -> Scalar:
        return u + self.u_b

    @classmethod
    def c_command(cls, given: Mapping[str, float]) -> str:
        return f"u -= {literal(given['u_b'])};"

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"offset": given["u_b"]}

    @classmethod
    def from_mujoco(cls, fields: Mapping[str, float]) -> Mapping[str, float]:
        return {"u_b": fields["offset"]} if "offset" in fields else {}


class AsymmetricGain(CommandMap):
    r"""Gain that differs forward and reverse, $u_e = (1 + a\,\mathrm{sgn}\,u)\,u$.

    Attributes:
        a: Half the difference of the gains, forward less reverse, over their mean [1].
    """

    name: ClassVar[str] = "drive.asymmetric_gain"
    label: ClassVar[str] = "direction-dependent gain of the drive"
    coordinate: ClassVar[str] = "voltage"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "gain that differs forward and reverse"
    equation: ClassVar[str] = "(1 + a sgn u) u"
    shown_by: ClassVar[Mapping[str, int]] = {LEVELS: 2}
    a: Scalar = param("1", bounds=(-0.9, 0.9), starts=(0.05, -0.05), tex="a")

    def command(self, u: Scalar) -> Scalar:
        return u + self.a * jnp.abs(u)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "the gain is the mean of both directions"

    @classmethod
    def c_command(cls, given: Mapping[str, float]) -> str:
        a = literal(given["a"])
        return f"u /= u > 0.0f ? 1.0f + {a} : 1.0f - {a};"


LAGS = 0.1
"""Share of a supply's drop that lags above which a curve of the drive is another thing [1]. Set by hand: what was fitted to simulated supplies
that lag is 0.95 and above."""


class SupplySag(Supply):
    r"""Supply voltage that drops with load, $u_e = u\,(1 - \rho p)$, $p = (1 - m) P + m v$ with $\tau\dot v = P - v$.

    $P = |u i|$ is the power taken from a source with resistance. A share $m$ of the drop comes and goes with a lag, as that of a
    battery does (first-order equivalent circuit: Plett, Battery Management Systems I (2015), section 2.3). Where no current is known,
    it is taken to be in proportion to the size of the command: $P = |u| \cdot 1\,$A.

    Attributes:
        rho: Share of the voltage that is lost per power [1/W].
        m: Share of the drop that lags [1].
        tau: Time constant of that share [s].
    """

    name: ClassVar[str] = "drive.supply_sag"
    label: ClassVar[str] = "sagging supply"
    coordinate: ClassVar[str] = "current"
    states: ClassVar[tuple[str, ...]] = ("v",)
    meaning: ClassVar[str] = "supply voltage that drops with load (`platform`: 1 A for i)"
    equation: ClassVar[str] = "u (1 − ρ p), p = (1 − m) abs(u i) + m v, τ v' = abs(u i) − v"
    like_larger: ClassVar[tuple[str, ...]] = ("motor.resistance",)
    shown_by: ClassVar[Mapping[str, int]] = {LEVELS: 2}
    rho: Scalar = param("1/W", bounds=(0.0, jnp.inf), starts=(0.1,), scale="per_watt", tex="\\rho")
    m: Scalar = param("1", bounds=(0.0, 1.0), starts=(0.0, 1.0, 1.0), tex="m", role="form")
    tau: Scalar = param("s", bounds=(0.02, 1e3), null=1.0, starts=(1.0, 0.3, 2.0), tex="\\tau", role="form")

    def drift(self, motion: Motion) -> tuple[Scalar, ...]:
        return ((motion.drawn - self.mine(motion)[0]) / self.tau,)

    def voltage(self, u: Scalar, motion: Motion) -> Scalar:
        drop = motion.drawn + self.m * (self.mine(motion)[0] - motion.drawn)
        return u * jnp.maximum(1.0 - self.rho * drop, 0.0)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "the gain is that of small commands"


class Curvature(CommandMap):
    r"""Gain that varies smoothly with the command's size.

    $u_e = u\,(1 + c|u|)\,|u/u_1|^p$ for $c > 0$, $u\,|u/u_1|^p/(1 - c|u|)$ for $c < 0$. With $p = 0$ it is straight at
    small commands. In a search $u_1$ is the largest command of the logs.

    Attributes:
        c: Change of the gain per volt of command [1/V].
        p: Exponent of the command in the gain [1].
        u_1: Command at which the power is 1 [V].
    """

    name: ClassVar[str] = "drive.curvature"
    label: ClassVar[str] = "curved characteristic of the drive"
    coordinate: ClassVar[str] = "voltage"
    meaning: ClassVar[str] = "gain that varies smoothly with the command's size"
    equation: ClassVar[str] = "u (1 + c abs(u)) for c > 0, u/(1 − c abs(u)) for c < 0, times abs(u/u_1)^p"
    shown_by: ClassVar[Mapping[str, int]] = {LEVELS: 1}
    limits: ClassVar[tuple[str, ...]] = ("drive.square_law",)
    linear_numbers: ClassVar[Mapping[str, float]] = {"p": 0.0}
    c: Scalar = param("1/V", bounds=(-jnp.inf, jnp.inf), starts=(0.1, -0.1, 0.0, 0.0), scale="per_command", tex="c")
    p: Scalar = param("1", bounds=(-0.8, 3.0), starts=(0.0, 0.0, 0.1, -0.1), tex="p", role="form")
    u_1: Scalar = param("V", bounds=(1e-6, 1e6), null=1.0, starts=(1.0,), scale="peak", tex="u_1", role="reference")

    def command(self, u: Scalar) -> Scalar:
        size, rises = jnp.abs(u), self.c > 0.0
        power = jnp.maximum(size / self.u_1, SMALLEST) ** self.p
        return jnp.where(rises, u * (1.0 + self.c * size), u / (1.0 - jnp.where(rises, 0.0, self.c) * size)) * power

    @classmethod
    def same_as(cls, fitted: FittedRig) -> tuple[str, ...]:
        """A sagging supply on a `platform`, where no current is known and the command alone says how much it is loaded.

        The gain has to fall with the command's size, most of all where that is large, as that of a sagging supply does. A supply
        whose drop lags is no curve.
        """
        if fitted.kind != "platform" or fitted.numbers.get(f"{SupplySag.name}.m", 0.0) > LAGS:
            return ()
        if cls.name in fitted.names:
            if f"{cls.name}.c" not in fitted.numbers:
                return ()
            c, p, u_1 = (fitted.numbers[f"{cls.name}.{number}"] for number in ("c", "p", "u_1"))
            bend = np.log1p(abs(c) * u_1) - np.log1p(0.5 * abs(c) * u_1)  # from half the largest command to all of it
            if not (c < 0.0 and bend > abs(p) * np.log(2.0)):
                return ()
        return ("drive.supply_sag",)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        if given.get("p", 0.0):
            return "its power is left out, the gain is that of small commands without it"
        return "the gain is that of small commands"


class SquareLaw(CommandMap):
    r"""Torque or thrust with the square of the command, as of a propeller: $u_e = (1 - s)\,u + s\,u|u|/u_1$ with $s = 1$.

    With $s = 0$ it is absent. A search tries $s = 1$ alone: what lies between is `drive.curvature`, of which the square is the
    special case $p = 1$, $c = 0$.

    Attributes:
        s: Share of the square [1].
        u_1: Command at which the square is as large as the command [V].
    """

    name: ClassVar[str] = "drive.square_law"
    label: ClassVar[str] = "square law of the drive"
    coordinate: ClassVar[str] = "voltage"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "torque or thrust with the square of the command, as of a propeller (s = 1)"
    equation: ClassVar[str] = "(1 − s) u + s u abs(u)/u_1"
    shown_by: ClassVar[Mapping[str, int]] = {LEVELS: 1}
    linear_numbers: ClassVar[Mapping[str, float]] = {"s": 0.0}
    s: Scalar = param("1", bounds=(0.0, 1.0), starts=(1.0, 1.0), tex="s", role="choice")
    u_1: Scalar = param("V", bounds=(1e-6, 1e6), null=1.0, starts=(1.0, 0.4), scale="peak", tex="u_1", role="form")

    def command(self, u: Scalar) -> Scalar:
        return u + self.s * (u * jnp.abs(u) / self.u_1 - u)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "the gain is the mean one of a command of u_1"


class OneSided(CommandMap):
    r"""Commands of one sign give nothing: $u_e = (1 - s)\,u$ for $u < 0$ where $s > 0$, $(1 + s)\,u$ for $u > 0$ where $s < 0$.

    With $s = 1$ only positive commands act, with $s = -1$ only negative ones, with $s = 0$ it is absent. A search tries both
    signs and nothing between: a drive that turns both ways, with gains that differ, is `drive.asymmetric_gain`. That one ends
    at gains of 1.9 and 0.1.

    Attributes:
        s: Share of the command that is lost, of negative ones where it is positive, of positive ones where it is negative [1].
    """

    name: ClassVar[str] = "drive.one_sided"
    label: ClassVar[str] = "drive that acts one way only"
    coordinate: ClassVar[str] = "voltage"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "commands of one sign give nothing: negative ones with s = 1, positive ones with s = −1"
    equation: ClassVar[str] = "(1 − s) u for u < 0 and s > 0, (1 + s) u for u > 0 and s < 0, else u"
    shown_by: ClassVar[Mapping[str, int]] = {LEVELS: 2}
    linear_numbers: ClassVar[Mapping[str, float]] = {"s": 0.0}
    s: Scalar = param("1", bounds=(-1.0, 1.0), starts=(1.0, -1.0), tex="s", role="choice")

    def command(self, u: Scalar) -> Scalar:
        return u - jnp.maximum(self.s, 0.0) * jnp.minimum(u, 0.0) + jnp.minimum(self.s, 0.0) * jnp.maximum(u, 0.0)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "the gain is that of the commands that act"


class LateGoal(GoalDelay):
    r"""The goal of a servo acts late, $g_e(t) = g(t - \tau)$.

    It lies outside the loop, which `drive.delay` and `sensor.delay` lie within: it shifts the motion and cannot make it swing.

    Attributes:
        tau: Delay [s].
    """

    name: ClassVar[str] = "drive.goal_delay"
    label: ClassVar[str] = "delay of the servo's goal"
    coordinate: ClassVar[str] = "time"
    meaning: ClassVar[str] = "the goal of a servo acts late (only on a rig with a servo)"
    equation: ClassVar[str] = "goal(t − τ)"
    shown_by: ClassVar[Mapping[str, int]] = {FAST: 0}
    tau: Scalar = param("s", bounds=(0.0, 0.5), starts=(0.01, 0.04, 0.12), tex="\\tau")

    def delay(self) -> Scalar:
        return self.tau

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"goal_delay": given["tau"]}

    @classmethod
    def from_mujoco(cls, fields: Mapping[str, float]) -> Mapping[str, float]:
        return {"tau": fields["goal_delay"]} if "goal_delay" in fields else {}
