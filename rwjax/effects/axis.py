"""Loads on the axis, its coupling to the drive and its stops."""

from collections.abc import Mapping
from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.effect import FittedRig, Motion
from rwjax.effects.harmonics import with_overtone
from rwjax.effects.parameter import param
from rwjax.effects.ports import AxisTorque, Coupling
from rwjax.effects.shown import DWELLING, FAST, SLOW
from rwjax.types import Scalar


class Imbalance(AxisTorque):
    r"""Gravity torque of an off-centre mass, $M = s\sin\psi + c\cos\psi$, subtracted from the driving torque.

    Attributes:
        s: Torque where the angle is a quarter of a turn [N m].
        c: Torque at angle 0 [N m].
    """

    name: ClassVar[str] = "axis.imbalance"
    label: ClassVar[str] = "imbalance"
    coordinate: ClassVar[str] = "yaw"
    at_angle: ClassVar[bool] = True
    meaning: ClassVar[str] = "gravity torque of an off-centre mass"
    equation: ClassVar[str] = "s sin ψ + c cos ψ"
    covers: ClassVar[tuple[str, ...]] = ("axis.gravity.torque", "axis.gravity.angle")
    shown_by: ClassVar[Mapping[str, int]] = {SLOW: 0}
    s: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.05, 0.0), scale="torque", tex="s")
    c: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.05), scale="torque", tex="c")

    def torque(self, motion: Motion) -> Scalar:
        return -self.s * jnp.sin(motion.psi) - self.c * jnp.cos(motion.psi)

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"sine": given["s"], "cosine": given["c"]}


class Spring(AxisTorque):
    r"""Restoring torque of a cable or hose, $M = k x + k_3 x^3$ with $x = \psi - T_0/k$, subtracted from the driving torque.

    Attributes:
        k: Stiffness [N m/rad].
        T_0: Torque at angle 0 [N m].
        k_3: Stiffness that grows with the displacement squared [N m/rad³].
    """

    name: ClassVar[str] = "axis.spring"
    label: ClassVar[str] = "spring"
    coordinate: ClassVar[str] = "yaw"
    light: ClassVar[bool] = True
    at_angle: ClassVar[bool] = True
    meaning: ClassVar[str] = "restoring torque of a cable or hose, at rest at ψ_0 = T_0/k"
    equation: ClassVar[str] = "k ψ − T_0 + k_3 (ψ − ψ_0)³"
    mujoco_drops: ClassVar[Mapping[str, str]] = {"k_3": "its cube; the slope is there"}
    limits: ClassVar[tuple[str, ...]] = ("axis.bias_torque",)
    k: Scalar = param("N m/rad", bounds=(0.0, jnp.inf), starts=(0.05, 0.0), scale="torque", tex="k")
    T_0: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.02), scale="torque", tex="T_0")
    k_3: Scalar = param("N m/rad3", bounds=(0.0, jnp.inf), starts=(0.0,), scale="torque", tex="k_3", role="form")

    def torque(self, motion: Motion) -> Scalar:
        rest = jnp.where(self.k > 0.0, self.T_0 / jnp.where(self.k > 0.0, self.k, 1.0), 0.0)
        hard = jnp.where(self.k_3 > 0.0, self.k_3 * (motion.psi - rest) ** 3, 0.0)
        return self.T_0 - self.k * motion.psi - hard

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        k, T_0 = given["k"], given["T_0"]
        return {"stiffness": k, "springref": T_0 / k} if k else {"constant": T_0}

    @classmethod
    def from_mujoco(cls, fields: Mapping[str, float]) -> Mapping[str, float]:
        k = fields.get("stiffness", 0.0)
        return {"k": k, "T_0": k * fields.get("springref", 0.0), "k_3": 0.0} if k else {}


class BiasTorque(AxisTorque):
    r"""Constant torque $T$ on the axis; positive turns it forward.

    Attributes:
        T: Torque, positive forward [N m].
    """

    name: ClassVar[str] = "axis.bias_torque"
    label: ClassVar[str] = "constant torque"
    coordinate: ClassVar[str] = "load"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "constant torque, positive forward"
    equation: ClassVar[str] = "drives with T"
    T: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, -0.03), scale="torque", tex="T")

    def torque(self, motion: Motion) -> Scalar:
        return self.T

    @classmethod
    def same_as(cls, fitted: FittedRig) -> tuple[str, ...]:
        return ("drive.bias",) if fitted.kind == "platform" and "drive.deadzone" not in fitted.names else ()

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"constant": given["T"]}

    @classmethod
    def from_mujoco(cls, fields: Mapping[str, float]) -> Mapping[str, float]:
        return {"T": fields["constant"]} if "constant" in fields else {}


def _mean_above_zero(first: Scalar, last: Scalar) -> Scalar:
    """Mean of what changes evenly from `first` to `last` and counts as 0 below 0."""
    way = jnp.abs(last - first)
    part = jnp.maximum(first, last) ** 2 / (2.0 * jnp.where(way > 0.0, way, 1.0))
    return jnp.where(first * last < 0.0, part, jnp.maximum(0.5 * (first + last), 0.0))


class Backlash(Coupling):
    r"""Play between drive and axis: no torque within the gap $g$, elastic contact beyond it.

    Attributes:
        g: Gap, from contact to contact [rad].
        s: Share of the inertia on the drive's side [1].
        k: Stiffness of the contact [N m/rad].
        c: Damping of the contact [N m s/rad].
    """

    name: ClassVar[str] = "axis.backlash"
    label: ClassVar[str] = "backlash"
    coordinate: ClassVar[str] = "load"
    meaning: ClassVar[str] = "play between drive and axis"
    equation: ClassVar[str] = "no torque within ± g/2 of twist, k and c beyond; a share s of the inertia before it"
    limits: ClassVar[tuple[str, ...]] = ("axis.flexible_coupling",)
    shown_by: ClassVar[Mapping[str, int]] = {DWELLING: 0}
    linear_as: ClassVar[str | None] = "axis.flexible_coupling"
    longest_step: ClassVar[float] = 1.25e-3  # a contact lasts some 10 ms, and its damper presses at once
    g: Scalar = param("rad", bounds=(0.0, 10.0), starts=(0.02, 0.05, 0.15, 0.5, 0.05, 0.15, 0.05, 0.15, 0.5), tex="g")
    s: Scalar = param("1", bounds=(0.02, 0.98), null=0.3, starts=(0.3, 0.3, 0.3, 0.3, 0.6, 0.6, 0.3, 0.3, 0.3), tex="s")
    k: Scalar = param("N m/rad", bounds=(1e-9, 1e6), null=1e3, starts=(4000.0,), scale="inertial", tex="k")
    c: Scalar = param(
        "N m s/rad", bounds=(0.0, jnp.inf), null=1.0, starts=(*(20.0,) * 6, *(100.0,) * 3), scale="inertial", tex="c"
    )

    def share(self) -> Scalar:
        return self.s

    def torque(self, motion: Motion) -> Scalar:
        twist, slip = self.mine(motion)
        over = twist - jnp.clip(twist, -0.5 * self.g, 0.5 * self.g)
        pressed = self.k * over + self.c * slip
        return jnp.where(over > 0.0, jnp.maximum(pressed, 0.0), jnp.where(over < 0.0, jnp.minimum(pressed, 0.0), 0.0))

    def mean_torque(self, before: Motion, after: Motion) -> Scalar:
        (twist, slip), (twist_1, slip_1) = self.mine(before), self.mine(after)
        found = jnp.zeros_like(twist)
        for side in (1.0, -1.0):
            over, over_1 = side * twist - 0.5 * self.g, side * twist_1 - 0.5 * self.g
            way = over_1 - over
            meets = jnp.where(over * over_1 <= 0.0, -over / jnp.where(way == 0.0, 1.0, way), 0.0)  # part of the step
            begin = jnp.where(over > 0.0, 0.0, meets)
            end = jnp.where(over_1 > 0.0, 1.0, meets)
            first, last = (
                self.k * (over + part * way) + self.c * side * (slip + part * (slip_1 - slip)) for part in (begin, end)
            )
            found += side * (end - begin) * _mean_above_zero(first, last)
        return found

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "the play is closed"


STIFF = (20.0, 50.0, 100.0, 200.0, 400.0, 900.0, 2000.0, 50.0, 200.0, 800.0, 50.0, 200.0)
"""Stiffnesses in inertias [1/s²] from which a search begins: between resonances that differ by more than √2 lie hills."""


class FlexibleCoupling(Coupling):
    r"""Elastic shaft between drive and axis: a share $s$ of the inertia before it, torque $k\,\delta + c\,\dot\delta$ through it.

    Attributes:
        s: Share of the inertia on the drive's side [1].
        k: Stiffness [N m/rad].
        c: Damping [N m s/rad].
    """

    name: ClassVar[str] = "axis.flexible_coupling"
    label: ClassVar[str] = "elastic coupling"
    coordinate: ClassVar[str] = "load"
    meaning: ClassVar[str] = "elastic shaft between drive and axis"
    equation: ClassVar[str] = "k δ + c δ' on the axis; a share s of the inertia before it"
    shown_by: ClassVar[Mapping[str, int]] = {FAST: 1}
    s: Scalar = param("1", bounds=(0.02, 0.98), null=0.5, starts=(*(0.5,) * 7, 0.25, 0.25, 0.25, 0.75, 0.75), tex="s")
    k: Scalar = param("N m/rad", bounds=(1e-9, 1e6), null=1e3, starts=STIFF, scale="inertial", tex="k")
    c: Scalar = param(
        "N m s/rad",
        bounds=(0.0, jnp.inf),
        null=1.0,
        starts=tuple(0.07 * k**0.5 for k in STIFF),
        scale="inertial",
        tex="c",
    )

    def share(self) -> Scalar:
        return self.s

    def torque(self, motion: Motion) -> Scalar:
        twist, slip = self.mine(motion)
        return self.k * twist + self.c * slip


FAR = 1e6
"""Angle of a stop that is none [rad]."""
INWARD = (0.003, 0.01, 0.03, 0.1)
"""Shares of the travel by which stops are looked for inside the furthest angles: a model without them runs wide of both."""


class EndStop(AxisTorque):
    r"""Stiff contact at travel limits, $M = k\,\max(\psi - \psi_+, 0)$ and the like at $\psi_-$, with a damper that never pulls; a stop at ±1e6 rad is none.

    Attributes:
        high: Angle of the upper stop [rad].
        low: Angle of the lower stop [rad].
        k: Stiffness of the contact [N m/rad].
        d: Damping of the contact [N m s/rad].
    """

    name: ClassVar[str] = "axis.end_stop"
    label: ClassVar[str] = "end stop"
    coordinate: ClassVar[str] = "yaw"
    at_angle: ClassVar[bool] = True
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "stiff contact at travel limits"
    equation: ClassVar[str] = "k (ψ − high) + d w beyond `high`, never below 0; likewise at `low`"
    ends_travel: ClassVar[bool] = True
    high: Scalar = param(
        "rad",
        bounds=(-FAR, FAR),
        null=FAR,
        starts=tuple(s for share in INWARD for s in (-share, None, -share)),
        scale="span",
        origin="highest",
        tex="\\psi_+",
    )
    low: Scalar = param(
        "rad",
        bounds=(-FAR, FAR),
        null=-FAR,
        starts=tuple(s for share in INWARD for s in (None, share, share)),
        scale="span",
        origin="lowest",
        tex="\\psi_-",
    )
    k: Scalar = param("N m/rad", bounds=(1e-9, jnp.inf), null=1.0, starts=(30.0,), scale="inertial", tex="k")
    d: Scalar = param("N m s/rad", bounds=(0.0, jnp.inf), null=1.0, starts=(4.0,), scale="inertial", tex="d")

    def torque(self, motion: Motion) -> Scalar:
        over = jnp.where(self.high < FAR, motion.psi - self.high, -1.0)
        under = jnp.where(self.low > -FAR, motion.psi - self.low, 1.0)
        push = jnp.where(over > 0.0, jnp.maximum(self.k * over + self.d * motion.w, 0.0), 0.0)
        pull = jnp.where(under < 0.0, jnp.minimum(self.k * under + self.d * motion.w, 0.0), 0.0)
        return -push - pull

    @classmethod
    def travel(cls, given: Mapping[str, float]) -> float:
        return max(min(given["high"], -given["low"]), 0.0)


RATES = tuple(0.6 + 0.35 * k for k in range(29))  # rad/s
"""Rates at which a periodic torque is searched: over 12 s, one between two of them still looks like either."""


class PeriodicTorque(AxisTorque):
    r"""Periodic torque in time, $M = s\sin\omega t + c\cos\omega t$ and its overtone, t from each run's first sample.

    The overtone is $(p s - q c)\sin 2\omega t + (p c + q s)\cos 2\omega t$.

    Attributes:
        s: Amplitude of the sine [N m].
        c: Amplitude of the cosine [N m].
        omega: Angular frequency [rad/s].
        p: Overtone in phase, over the first harmonic [1].
        q: Overtone a quarter of a turn apart, over the first harmonic [1].
    """

    name: ClassVar[str] = "axis.periodic_torque"
    label: ClassVar[str] = "periodic torque"
    coordinate: ClassVar[str] = "time"
    meaning: ClassVar[str] = "periodic torque in time"
    equation: ClassVar[str] = (
        "drives with s sin ωt + c cos ωt and an overtone, (p s − q c) sin 2ωt + (p c + q s) cos 2ωt"
    )
    changes_over_time: ClassVar[bool] = True
    comes_and_goes: ClassVar[bool] = True
    shown_above: ClassVar[Mapping[str, str]] = {"omega": "turn_per_run"}
    s: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, 0.0) * len(RATES), scale="torque", tex="s")
    c: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.03) * len(RATES), scale="torque", tex="c")
    omega: Scalar = param(
        "rad/s", bounds=(0.05, 200.0), null=6.0, starts=tuple(w for rate in RATES for w in (rate, rate)), tex="\\omega"
    )
    p: Scalar = param("1", bounds=(-1.0, 1.0), starts=(0.0,), tex="p", role="form")
    q: Scalar = param("1", bounds=(-1.0, 1.0), starts=(0.0,), tex="q", role="form")

    def torque(self, motion: Motion) -> Scalar:
        return with_overtone(self.omega * motion.t, self.s, self.c, self.p, self.q)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "a load that no gain moves, left out"
