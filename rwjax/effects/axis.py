"""Effects on the axis: the friction that a rig file models and the friction that may be missing, written once."""

from typing import ClassVar

import jax.numpy as jnp

from rwjax.effects.harmonics import two_harmonics, with_overtone
from rwjax.effects.parameter import param
from rwjax.effects.ports import AxisDry, AxisElastic, AxisTorque, Coupling, Motion
from rwjax.effects.powers import power
from rwjax.types import Scalar

SLOWEST = 1e-9  # of the Stribeck speed: below it a power's derivative has no finite value


class Viscous(AxisTorque):
    r"""Friction proportional to speed, $M = b\,w$ (thesis eq. 3.4)."""

    name: ClassVar[str] = "axis.viscous"
    group: ClassVar[str] = "friction"
    label: ClassVar[str] = "viscous friction"
    coordinate: ClassVar[str] = "yaw_rate"
    b: Scalar = param("N m s/rad", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque_per_rate", tex="b")

    def torque(self, motion: Motion) -> Scalar:
        return -self.b * motion.w


class Coulomb(AxisDry):
    r"""Dry friction, constant with direction, $M = M_c\,\mathrm{sgn}\,w$ (thesis eq. 3.7)."""

    name: ClassVar[str] = "axis.coulomb"
    label: ClassVar[str] = "dry friction"
    coordinate: ClassVar[str] = "yaw_rate"
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.05, 0.3), scale="torque", tex="M_c")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c


class Stribeck(AxisDry):
    r"""Breakaway friction above sliding friction, $M = [M_c + M_e\,e^{-|w/v_s|^n}]\,\mathrm{sgn}\,w$; a rig file's has $n = 2$.

    $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise; the breakaway level is $M_c + M_e$.
    Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), eq. 8.
    """

    name: ClassVar[str] = "axis.stribeck"
    label: ClassVar[str] = "Stribeck friction"
    coordinate: ClassVar[str] = "yaw_rate"
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    M_e: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_s - M_c")
    v_s: Scalar = param("rad/s", bounds=(1e-3, 1e2), null=1.0, starts=(0.03, 0.1, 0.3), scale="rate", tex="v_s")
    n: Scalar | float = param("1", bounds=(0.5, 4.0), null=2.0, starts=(2.0, 1.0, 2.0), tex="n", optional=True)

    def level(self, motion: Motion, direction: float) -> Scalar:
        fall = power(jnp.maximum(jnp.abs(motion.w) / self.v_s, SLOWEST), self.n)
        return self.M_c + self.M_e * jnp.exp(-fall)


class AsymmetricFriction(AxisDry):
    r"""Dry friction that differs with direction, $M = (M_c + d\,\mathrm{sgn}\,w)\,\mathrm{sgn}\,w$.

    $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise.
    """

    name: ClassVar[str] = "axis.asymmetric_friction"
    label: ClassVar[str] = "direction-dependent dry friction"
    coordinate: ClassVar[str] = "yaw_rate"
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    d: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, -0.03), scale="torque", tex="d")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c + direction * self.d


class PolynomialFriction(AxisDry):
    r"""Friction polynomial of a rig file, $M = (b_3 + b_2|w| + b_1 w^2 + b_0 |w|^3)\,\mathrm{sgn}\,w$ (thesis eq. 4.7)."""

    name: ClassVar[str] = "axis.polynomial"
    label: ClassVar[str] = "polynomial friction"
    coordinate: ClassVar[str] = "yaw_rate"
    b3: Scalar
    b2: Scalar
    b1: Scalar
    b0: Scalar

    def level(self, motion: Motion, direction: float) -> Scalar:
        w = direction * motion.w
        return self.b3 + w * (self.b2 + w * (self.b1 + w * self.b0))


class Gravity(AxisTorque):
    r"""Known load of an off-centre mass, $M_g = m g l \sin(\psi + \varphi)$, subtracted from the driving torque."""

    name: ClassVar[str] = "axis.gravity"
    label: ClassVar[str] = "gravity"
    coordinate: ClassVar[str] = "yaw"
    mgl: Scalar
    angle: Scalar

    def torque(self, motion: Motion) -> Scalar:
        return -self.mgl * jnp.sin(motion.psi + self.angle)


class BiasTorque(AxisTorque):
    r"""Constant torque $T$ on the axis; positive turns it forward."""

    name: ClassVar[str] = "axis.bias_torque"
    label: ClassVar[str] = "constant torque"
    coordinate: ClassVar[str] = "load"
    T: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, -0.03), scale="torque", tex="T")

    def torque(self, motion: Motion) -> Scalar:
        return self.T


class QuadraticDrag(AxisTorque):
    r"""Drag with speed squared, or nearly, $M = c\,w\,|w|^{p - 1}$; $p = 2$ where the flow is turbulent, less in transition."""

    name: ClassVar[str] = "axis.quadratic_drag"
    group: ClassVar[str] = "friction"
    label: ClassVar[str] = "drag with speed squared"
    coordinate: ClassVar[str] = "yaw_rate"
    c: Scalar = param("N m s2/rad2", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque_per_rate2", tex="c")
    p: Scalar = param("1", bounds=(1.3, 3.0), null=2.0, starts=(2.0,), tex="p", optional=True)

    def torque(self, motion: Motion) -> Scalar:
        size = jnp.abs(motion.w)
        rises = jnp.where(size > SLOWEST, power(jnp.maximum(size, SLOWEST), self.p - 1.0), 0.0)  # level at standstill
        return -self.c * motion.w * rises


class AngleFriction(AxisDry):
    r"""Dry friction that varies with the angle: a level $1 + s_1\sin\psi + c_1\cos\psi + s_2\sin 2\psi + c_2\cos 2\psi$ times what
    the rig has at large."""

    name: ClassVar[str] = "axis.angle_friction"
    group: ClassVar[str] = "angle_friction"
    label: ClassVar[str] = "angle-dependent dry friction"
    coordinate: ClassVar[str] = "yaw"
    at_angle: ClassVar[bool] = True
    s_1: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.3, 0.0, 0.0, 0.0), tex="s_1")
    c_1: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.3, 0.0, 0.0), tex="c_1")
    s_2: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.0, 0.3, 0.0), tex="s_2")
    c_2: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.0, 0.0, 0.3), tex="c_2")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return jnp.zeros_like(motion.t)

    def share(self, motion: Motion) -> Scalar:
        return two_harmonics(motion.psi, self.s_1, self.c_1, self.s_2, self.c_2)


class LoadFriction(AxisDry):
    r"""Dry friction that grows with the transmitted torque, $M = \mu\,|M_d|\,\mathrm{sgn}\,w$."""

    name: ClassVar[str] = "axis.load_friction"
    label: ClassVar[str] = "load-dependent dry friction"
    coordinate: ClassVar[str] = "load"
    mu: Scalar = param("1", bounds=(0.0, 0.99), starts=(0.1,), tex="\\mu")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.mu * jnp.abs(motion.load)


STRAIGHT = 1e-3
"""Exponent below which a power is as good as the exponential that it tends to."""


def worn(y: Scalar | float, x: Scalar, s: Scalar) -> Scalar:
    """What is left of `y` after a way `x` along which it falls at the rate `y^(1 - s)`."""
    straight = s > STRAIGHT
    s, known = jnp.where(straight, s, 1.0), jnp.maximum(y, 1e-9)
    return jnp.where(straight, power(jnp.maximum(power(known, s) - s * x, 1e-9), 1.0 / s), y * jnp.exp(-x))


class FrictionDrift(AxisDry):
    r"""Friction that changes over the run: a level of dry friction $(1 + d\,f(t))$ times what the rig has warm, and $B\,w\,f(t)$
    besides, with $f = \max(1 - s t/\tau, 0)^{1/s}$: a straight line to an end for $s = 1$, $e^{-t/\tau}$ for $s = 0$."""

    name: ClassVar[str] = "axis.friction_drift"
    label: ClassVar[str] = "friction that warms up"
    coordinate: ClassVar[str] = "time"
    d: Scalar = param("1", bounds=(-1.0, jnp.inf), starts=(0.3,), tex="d")
    B: Scalar = param(
        "N m s/rad", bounds=(-jnp.inf, jnp.inf), starts=(0.0,), scale="torque_per_rate", tex="B", optional=True
    )
    tau: Scalar = param("s", bounds=(0.1, 1e4), null=5.0, starts=(3.0, 10.0, 10.0), tex="\\tau")
    s: Scalar = param("1", bounds=(0.0, 1.0), starts=(0.0, 0.0, 1.0), tex="s", optional=True)

    def _cold(self, motion: Motion) -> Scalar:
        return worn(1.0, motion.t / self.tau, self.s)

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.B * jnp.abs(motion.w) * self._cold(motion)

    def share(self, motion: Motion) -> Scalar:
        return self.d * self._cold(motion)


class Imbalance(AxisTorque):
    r"""Gravity torque of an off-centre mass, $M = s\sin\psi + c\cos\psi$, subtracted from the driving torque."""

    name: ClassVar[str] = "axis.imbalance"
    label: ClassVar[str] = "imbalance"
    coordinate: ClassVar[str] = "yaw"
    at_angle: ClassVar[bool] = True
    s: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.05, 0.0), scale="torque", tex="s")
    c: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.05), scale="torque", tex="c")

    def torque(self, motion: Motion) -> Scalar:
        return -self.s * jnp.sin(motion.psi) - self.c * jnp.cos(motion.psi)


class Spring(AxisTorque):
    r"""Restoring torque of a cable or hose, $M = k x + k_3 x^3$ with $x = \psi - T_0/k$, subtracted from the driving torque."""

    name: ClassVar[str] = "axis.spring"
    label: ClassVar[str] = "spring"
    coordinate: ClassVar[str] = "yaw"
    at_angle: ClassVar[bool] = True
    k: Scalar = param("N m/rad", bounds=(0.0, jnp.inf), starts=(0.05, 0.0), scale="torque", tex="k")
    T_0: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.02), scale="torque", tex="T_0")
    k_3: Scalar = param("N m/rad3", bounds=(0.0, jnp.inf), starts=(0.0,), scale="torque", tex="k_3", optional=True)

    def torque(self, motion: Motion) -> Scalar:
        rest = jnp.where(self.k > 0.0, self.T_0 / jnp.where(self.k > 0.0, self.k, 1.0), 0.0)
        hard = jnp.where(self.k_3 > 0.0, self.k_3 * (motion.psi - rest) ** 3, 0.0)
        return self.T_0 - self.k * motion.psi - hard


INWARD = (0.003, 0.01, 0.03, 0.1)
"""Shares of the travel by which stops are looked for inside the furthest angles: a model without them runs wide of both."""


class EndStop(AxisTorque):
    r"""Stiff contact at travel limits, $M = k\,\max(\psi - \psi_+, 0)$ and the like at $\psi_-$, with a damper that never pulls."""

    name: ClassVar[str] = "axis.end_stop"
    label: ClassVar[str] = "end stop"
    coordinate: ClassVar[str] = "yaw"
    at_angle: ClassVar[bool] = True
    high: Scalar = param(
        "rad",
        bounds=(-1e6, 1e6),
        null=1e6,
        starts=tuple(s for share in INWARD for s in (-share, None, -share)),
        scale="span",
        origin="highest",
        tex="\\psi_+",
    )
    low: Scalar = param(
        "rad",
        bounds=(-1e6, 1e6),
        null=-1e6,
        starts=tuple(s for share in INWARD for s in (None, share, share)),
        scale="span",
        origin="lowest",
        tex="\\psi_-",
    )
    k: Scalar = param("N m/rad", bounds=(1e-9, jnp.inf), null=1.0, starts=(30.0,), scale="inertial", tex="k")
    d: Scalar = param("N m s/rad", bounds=(0.0, jnp.inf), null=1.0, starts=(4.0,), scale="inertial", tex="d")

    def torque(self, motion: Motion) -> Scalar:
        over, under = motion.psi - self.high, motion.psi - self.low
        push = jnp.where(over > 0.0, jnp.maximum(self.k * over + self.d * motion.w, 0.0), 0.0)
        pull = jnp.where(under < 0.0, jnp.minimum(self.k * under + self.d * motion.w, 0.0), 0.0)
        return -push - pull


RATES = tuple(0.6 + 0.35 * k for k in range(29))  # rad/s
"""Rates at which a periodic torque is searched: over 12 s, one between two of them still looks like either."""


class PeriodicTorque(AxisTorque):
    r"""Periodic torque in time, $M = s\sin\omega t + c\cos\omega t$ and its overtone, t from each run's first sample; the overtone:
    $(p s - q c)\sin 2\omega t + (p c + q s)\cos 2\omega t$."""

    name: ClassVar[str] = "axis.periodic_torque"
    label: ClassVar[str] = "periodic torque"
    coordinate: ClassVar[str] = "time"
    s: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, 0.0) * len(RATES), scale="torque", tex="s")
    c: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.03) * len(RATES), scale="torque", tex="c")
    omega: Scalar = param(
        "rad/s", bounds=(0.05, 200.0), null=6.0, starts=tuple(w for rate in RATES for w in (rate, rate)), tex="\\omega"
    )

    p: Scalar = param("1", bounds=(-1.0, 1.0), starts=(0.0,), tex="p", optional=True)
    q: Scalar = param("1", bounds=(-1.0, 1.0), starts=(0.0,), tex="q", optional=True)

    def torque(self, motion: Motion) -> Scalar:
        return with_overtone(self.omega * motion.t, self.s, self.c, self.p, self.q)


STIFF = (20.0, 50.0, 100.0, 200.0, 400.0, 900.0, 2000.0, 50.0, 200.0, 800.0, 50.0, 200.0)
"""Stiffnesses in inertias [1/s²] from which a search begins: between resonances that differ by more than √2 lie hills."""


class FlexibleCoupling(Coupling):
    r"""Elastic shaft between drive and axis: a share $s$ of the inertia before it, torque $k\,\delta + c\,\dot\delta$ through it."""

    name: ClassVar[str] = "axis.flexible_coupling"
    group: ClassVar[str] = "flexible_coupling"
    label: ClassVar[str] = "elastic coupling"
    coordinate: ClassVar[str] = "load"
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


class Backlash(Coupling):
    r"""Play between drive and axis: no torque within the gap $g$, elastic contact beyond it."""

    name: ClassVar[str] = "axis.backlash"
    group: ClassVar[str] = "backlash"
    label: ClassVar[str] = "backlash"
    coordinate: ClassVar[str] = "load"
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


class Presliding(AxisElastic):
    r"""Elastic, hysteretic displacement before sliding, $\frac{dz}{d\psi} = (1 - z\,\mathrm{sgn}\,w)^{1-s}/x_s$ with the friction $z$ times its
    level (Dahl 1968; with $s = 0$ thesis eq. 3.8, with $s > 0$ it slides after a finite way; exact in the angle, whatever the
    step), and damping of the displacement, $d\,x_s\dot z$ for $s = 0$ (Canudas de Wit et al. 1995, eq. 3).

    $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise.
    """

    name: ClassVar[str] = "axis.presliding"
    group: ClassVar[str] = "presliding"
    label: ClassVar[str] = "elastic displacement before sliding"
    coordinate: ClassVar[str] = "yaw"
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    x_s: Scalar = param(
        "rad",
        bounds=(1e-5, 10.0),
        null=1e-5,
        starts=(3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 1e-3, 0.01, 0.1),
        tex="x_s",
    )
    s: Scalar = param("1", bounds=(0.0, 1.0), starts=(*(0.0,) * 6, *(0.5,) * 3), tex="s", optional=True)
    d: Scalar = param(
        "N m s/rad", bounds=(0.0, jnp.inf), starts=(0.0,), scale="torque_per_rate", tex="d", optional=True
    )

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c

    def damping(self, motion: Motion) -> Scalar:
        return self.d * motion.w * (1.0 - self.mine(motion)[0] * jnp.sign(motion.w))

    def after(self, z: Scalar, travel: Scalar) -> Scalar:
        toward, way = jnp.sign(travel), jnp.abs(travel) / self.x_s
        return toward + jnp.sign(z - toward) * worn(jnp.abs(z - toward), way, self.s)
