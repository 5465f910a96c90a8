"""Friction of the axis."""

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Bool

from rwjax.effects.c_code import bell, literal
from rwjax.effects.effect import FittedRig, Motion
from rwjax.effects.harmonics import two_harmonics
from rwjax.effects.parameter import param
from rwjax.effects.ports import SLIDING, AxisDry, AxisElastic, AxisTorque
from rwjax.effects.powers import fallen, power
from rwjax.effects.shown import COASTING, DWELLING, SLOW
from rwjax.types import Scalar

ELEMENTS = 4
"""Parallel elements of presliding friction."""
SLOWEST = 1e-9  # of the Stribeck speed: below it a power's derivative has no finite value


class Viscous(AxisTorque):
    r"""Friction proportional to speed, $M = b\,w$ (thesis eq. 3.4).

    Attributes:
        b: Torque per rate [N m s/rad].
    """

    name: ClassVar[str] = "axis.viscous"
    label: ClassVar[str] = "viscous friction"
    coordinate: ClassVar[str] = "yaw_rate"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "friction proportional to speed, where the rig has none"
    equation: ClassVar[str] = "b w"
    modelled_by: ClassVar[tuple[str, ...]] = ("axis.friction.viscous", "axis.friction.b2")
    shown_by: ClassVar[Mapping[str, int]] = {COASTING: 0}
    b: Scalar = param("N m s/rad", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque_per_rate", tex="b")

    def torque(self, motion: Motion) -> Scalar:
        return -self.b * motion.w

    @classmethod
    def c_level(cls, given: Mapping[str, float]) -> str:
        return f"{literal(given['b'])} * w"

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"damping": given["b"]}


class Coulomb(AxisDry):
    r"""Dry friction, constant with direction, $M = M_c\,\mathrm{sgn}\,w$ (thesis eq. 3.7).

    Attributes:
        M_c: Level of the friction [N m].
    """

    name: ClassVar[str] = "axis.coulomb"
    label: ClassVar[str] = "dry friction"
    coordinate: ClassVar[str] = "yaw_rate"
    light: ClassVar[bool] = True
    meaning: ClassVar[str] = "dry friction, where the rig has none"
    equation: ClassVar[str] = "M_c sgn w"
    modelled_by: ClassVar[tuple[str, ...]] = ("axis.friction.coulomb", "axis.friction.b3")
    shown_by: ClassVar[Mapping[str, int]] = {COASTING: 0, SLOW: 0}
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.05, 0.3), scale="torque", tex="M_c")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c

    @classmethod
    def c_level(cls, given: Mapping[str, float]) -> str:
        return literal(given["M_c"])

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"frictionloss": given["M_c"]}


class Stribeck(AxisDry):
    r"""Breakaway friction above sliding friction, $M = [M_c + M_e\,e^{-|w/v_s|^n}]\,\mathrm{sgn}\,w$; a rig file's has $n = 2$.

    $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise; the breakaway level is $M_c + M_e$.
    Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), eq. 8.

    Attributes:
        M_c: Level of sliding friction; 0 where dry friction is modelled elsewhere [N m].
        M_e: Breakaway level above that of sliding [N m].
        v_s: Stribeck speed: the excess has fallen to 1/e [rad/s].
        n: Exponent of the fall [1].
    """

    name: ClassVar[str] = "axis.stribeck"
    label: ClassVar[str] = "Stribeck friction"
    coordinate: ClassVar[str] = "yaw_rate"
    meaning: ClassVar[str] = "breakaway friction above sliding friction, falling with speed"
    equation: ClassVar[str] = "(M_c + M_e exp(−abs(w/v_s)ⁿ)) sgn w; n = 2 is the rig file's"
    mujoco_drops: ClassVar[Mapping[str, str]] = {"M_e": "what it has above sliding friction"}
    includes: ClassVar[str] = "axis.coulomb"
    modelled_by: ClassVar[tuple[str, ...]] = ("axis.friction.static",)
    shown_by: ClassVar[Mapping[str, int]] = {SLOW: 0, DWELLING: 0}
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    M_e: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_s - M_c")
    v_s: Scalar = param("rad/s", bounds=(1e-3, 1e2), null=1.0, starts=(0.03, 0.1, 0.3), scale="rate", tex="v_s")
    n: Scalar | float = param("1", bounds=(0.5, 4.0), null=2.0, starts=(2.0, 1.0, 2.0), tex="n", role="form")

    def level(self, motion: Motion, direction: float) -> Scalar:
        fall = power(jnp.maximum(jnp.abs(motion.w) / self.v_s, SLOWEST), self.n)
        return self.M_c + self.M_e * jnp.exp(-fall)

    def steep(self) -> Bool[Array, ""]:
        return jnp.asarray(self.n < 1.0)

    def beside_standstill(self) -> "Stribeck":
        """Friction with n = 2 for n > 1, whose slope tends to 0 as well, if more slowly; n < 1 has no limit."""
        return replace(self, n=jnp.where(self.n > 1.0, 2.0, self.n))

    @classmethod
    def slope_note(cls, given: Mapping[str, float]) -> str:
        n = given.get("n", 2.0) if given.get("M_e", 0.0) > 0.0 else 2.0
        if n < 1.0:
            return f"infinitely steep at standstill, taken at {SLIDING:g} rad/s"
        return "taken as constant at standstill, though its level falls at once beside it" if 1.0 < n < 2.0 else ""

    @classmethod
    def c_level(cls, given: Mapping[str, float]) -> str:
        return f"{literal(given['M_c'])} + {bell(given['M_e'], given['v_s'], given.get('n', 2.0))}"

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"frictionloss": given["M_c"]}


class QuadraticDrag(AxisTorque):
    r"""Drag with speed squared, or nearly, $M = c\,w\,|w|^{p - 1}$; $p = 2$ where the flow is turbulent, less in transition.

    Attributes:
        c: Torque per rate to the power p [N m s²/rad²].
        p: Exponent of the rate [1].
    """

    name: ClassVar[str] = "axis.quadratic_drag"
    label: ClassVar[str] = "drag with speed squared"
    coordinate: ClassVar[str] = "yaw_rate"
    meaning: ClassVar[str] = "drag with speed squared, or nearly"
    equation: ClassVar[str] = "c w abs(w)^(p − 1)"
    shown_by: ClassVar[Mapping[str, int]] = {COASTING: 0}
    c: Scalar = param("N m s2/rad2", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque_per_rate2", tex="c")
    p: Scalar = param("1", bounds=(1.3, 3.0), null=2.0, starts=(2.0,), tex="p", role="form")

    def torque(self, motion: Motion) -> Scalar:
        size = jnp.abs(motion.w)
        rises = jnp.where(size > SLOWEST, power(jnp.maximum(size, SLOWEST), self.p - 1.0), 0.0)  # level at standstill
        return -self.c * motion.w * rises

    @classmethod
    def c_level(cls, given: Mapping[str, float]) -> str:
        return f"{literal(given['c'])} * powf(w, {literal(given.get('p', 2.0))})"


class AsymmetricFriction(AxisDry):
    r"""Dry friction that differs with direction, $M = (M_c + d\,\mathrm{sgn}\,w)\,\mathrm{sgn}\,w$.

    $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise.

    Attributes:
        M_c: Mean level of both directions; 0 where dry friction is modelled elsewhere [N m].
        d: Half the difference of the levels, forward less backward [N m].
    """

    name: ClassVar[str] = "axis.asymmetric_friction"
    label: ClassVar[str] = "direction-dependent dry friction"
    coordinate: ClassVar[str] = "yaw_rate"
    light: ClassVar[bool] = True
    equation: ClassVar[str] = "(M_c + d sgn w) sgn w"
    includes: ClassVar[str] = "axis.coulomb"
    shown_by: ClassVar[Mapping[str, int]] = {COASTING: 0}
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    d: Scalar = param("N m", bounds=(-jnp.inf, jnp.inf), starts=(0.03, -0.03), scale="torque", tex="d")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c + direction * self.d

    @classmethod
    def same_as(cls, fitted: FittedRig) -> tuple[str, ...]:
        return ("axis.bias_torque",)

    @classmethod
    def c_level(cls, given: Mapping[str, float]) -> str:
        return f"{literal(given['M_c'])} + {literal(given['d'])} * s"

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"frictionloss": given["M_c"], "constant": -given["d"]}


class Presliding(AxisElastic):
    r"""Elastic, hysteretic displacement before sliding: friction $\bar z$ times its level, and damping.

    $\bar z$ is the mean of $N = 4$ parallel elements that carry the same level,
    $\frac{dz_k}{d\psi} = (1 - z_k\,\mathrm{sgn}\,w)^{1-s}/x_k$, $x_k = x_s\,(1 + r\,\frac{2k - 1 - N}{N})$. With $r = 0$ all are one
    (Dahl 1968; with $s = 0$ thesis eq. 3.8); with $s = 1$ they are slip elements (Iwan 1966; Al-Bender, Lampaert and Swevers
    2005), whose hysteresis keeps every turning point that no larger motion has wiped out. With $s > 0$ it slides after a
    finite way. It is exact in the angle, whatever the step. The damping is the mean of $d\,x_k\dot z_k$ for $s = 0$
    (Canudas de Wit et al. 1995, eq. 3). $M_c$ belongs to it where the rig models no dry friction and is 0 otherwise.

    Attributes:
        M_c: Level of the friction; 0 where dry friction is modelled elsewhere [N m].
        x_s: Displacement by which the friction builds up, the mean of the elements' [rad].
        s: Shape: 0 builds up exponentially, 1 along a straight line [1].
        d: Damping of the displacement [N m s/rad].
        r: Spread of the displacements over which the elements build up: 0 is one for all, 1 evenly from 0 to 2 x_s [1].
    """

    name: ClassVar[str] = "axis.presliding"
    label: ClassVar[str] = "elastic displacement before sliding"
    coordinate: ClassVar[str] = "yaw"
    meaning: ClassVar[str] = "elastic, hysteretic displacement before sliding"
    equation: ClassVar[str] = (
        "friction z times its level, z the mean of z_k, k = 1 to 4, dz_k/dψ = (1 − z_k sgn w)^(1 − s)/x_k, "
        "x_k = x_s (1 + r (2k − 5)/4), and damping d (1 − z sgn w) w"
    )
    states: ClassVar[tuple[str, ...]] = tuple(f"z_{k + 1}" for k in range(ELEMENTS))
    mujoco_drops: ClassVar[Mapping[str, str]] = {"x_s": "the angle over which it builds up"}
    includes: ClassVar[str] = "axis.coulomb"
    shown_by: ClassVar[Mapping[str, int]] = {SLOW: 0, DWELLING: 0}
    M_c: Scalar = param("N m", bounds=(0.0, jnp.inf), starts=(0.1,), scale="torque", tex="M_c")
    x_s: Scalar = param(
        "rad",
        bounds=(1e-5, 10.0),
        null=1e-5,
        starts=(3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 1e-3, 0.01, 0.1),
        tex="x_s",
    )
    s: Scalar = param("1", bounds=(0.0, 1.0), starts=(*(0.0,) * 6, *(1.0,) * 3), tex="s", role="form")
    d: Scalar = param("N m s/rad", bounds=(0.0, jnp.inf), starts=(0.0,), scale="torque_per_rate", tex="d", role="form")
    r: Scalar = param("1", bounds=(0.0, 1.0), starts=(*(0.0,) * 6, *(0.9,) * 3), tex="r", role="form")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.M_c

    def damping(self, motion: Motion) -> Scalar:
        return self.d * motion.w * (1.0 - self.built_up(self.mine(motion)) * jnp.sign(motion.w))

    def built_up(self, shares: tuple[Scalar, ...]) -> Scalar:
        return sum(shares[1:], start=shares[0]) / len(shares)

    def rates(self, shares: tuple[Scalar, ...], w: Scalar) -> tuple[Scalar, ...]:
        return tuple(self._rate(z, w / x) for z, x in zip(shares, self._displacements(), strict=True))

    def after(self, shares: tuple[Scalar, ...], travel: Scalar) -> tuple[Scalar, ...]:
        return tuple(self._after(z, travel / x) for z, x in zip(shares, self._displacements(), strict=True))

    def _displacements(self) -> tuple[Scalar, ...]:
        """Displacement over which each element builds up [rad]."""
        return tuple(self.x_s * (1.0 + self.r * (2 * k + 1 - ELEMENTS) / ELEMENTS) for k in range(ELEMENTS))

    def _rate(self, z: Scalar, speed: Scalar) -> Scalar:
        """Rate of an element's share [1/s] at a speed in units of its displacement [1/s]."""
        left = 1.0 - z * jnp.sign(speed)
        builds = left > 0.0
        return jnp.where(builds, jnp.where(builds, left, 1.0) ** (1.0 - self.s), left) * speed

    def _after(self, z: Scalar, travel: Scalar) -> Scalar:
        """An element's share after a travel in units of its displacement [1]."""
        toward = jnp.sign(travel)
        return toward + jnp.sign(z - toward) * fallen(jnp.abs(z - toward), jnp.abs(travel), self.s)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "sliding, all its friction built up"

    @classmethod
    def c_level(cls, given: Mapping[str, float]) -> str:
        return literal(given["M_c"])

    @classmethod
    def in_mujoco(cls, given: Mapping[str, float]) -> Mapping[str, float] | None:
        return {"frictionloss": given["M_c"]}


class AngleFriction(AxisDry):
    r"""Dry friction that varies with the angle.

    It raises all other dry friction of the rig by the factor $1 + s_1\sin\psi + c_1\cos\psi + s_2\sin 2\psi + c_2\cos 2\psi$.

    Attributes:
        s_1: Sine of the angle in the level, over its mean [1].
        c_1: Cosine of the angle [1].
        s_2: Sine of twice the angle [1].
        c_2: Cosine of twice the angle [1].
    """

    name: ClassVar[str] = "axis.angle_friction"
    label: ClassVar[str] = "angle-dependent dry friction"
    coordinate: ClassVar[str] = "yaw"
    at_angle: ClassVar[bool] = True
    meaning: ClassVar[str] = "dry friction that varies with the angle"
    equation: ClassVar[str] = "all dry friction of the rig times 1 + s_1 sin ψ + c_1 cos ψ + s_2 sin 2ψ + c_2 cos 2ψ"
    shown_by: ClassVar[Mapping[str, int]] = {SLOW: 0}
    s_1: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.3, 0.0, 0.0, 0.0), tex="s_1")
    c_1: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.3, 0.0, 0.0), tex="c_1")
    s_2: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.0, 0.3, 0.0), tex="s_2")
    c_2: Scalar = param("1", bounds=(-jnp.inf, jnp.inf), starts=(0.0, 0.0, 0.0, 0.3), tex="c_2")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return jnp.zeros_like(motion.t)

    def share(self, motion: Motion) -> Scalar:
        return two_harmonics(motion.psi, self.s_1, self.c_1, self.s_2, self.c_2)


class LoadFriction(AxisDry):
    r"""Dry friction that grows with the transmitted torque, $M = \mu\,|M_d|\,\mathrm{sgn}\,w$.

    Attributes:
        mu: Friction over the transmitted torque [1].
    """

    name: ClassVar[str] = "axis.load_friction"
    label: ClassVar[str] = "load-dependent dry friction"
    coordinate: ClassVar[str] = "load"
    meaning: ClassVar[str] = "dry friction that grows with the transmitted torque M_d"
    equation: ClassVar[str] = "μ abs(M_d) sgn w"
    mu: Scalar = param("1", bounds=(0.0, 0.99), starts=(0.1,), tex="\\mu")

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.mu * jnp.abs(motion.load)


class FrictionDrift(AxisDry):
    r"""Friction that changes over the run, by $f(t) = \max(1 - s t/\tau, 0)^{1/s}$.

    All other dry friction of the rig, that of the warm rig, is raised by the factor $1 + d\,f(t)$; $B\,w\,f(t)$ acts
    besides. For $s = 1$ the change is a straight line to an end, for $s = 0$ it is $e^{-t/\tau}$.

    Attributes:
        d: Share of dry friction that the cold rig has above the warm one [1].
        B: Viscous friction that the cold rig has besides [N m s/rad].
        tau: Time constant of the change [s].
        s: Shape: 0 decays exponentially, 1 along a straight line to an end [1].
    """

    name: ClassVar[str] = "axis.friction_drift"
    label: ClassVar[str] = "friction that warms up"
    coordinate: ClassVar[str] = "time"
    meaning: ClassVar[str] = "friction that changes over the run"
    equation: ClassVar[str] = (
        "all dry friction of the rig times 1 + d f(t), and B w f(t), f = max(1 − s t/τ, 0)^(1/s), exp(−t/τ) for s = 0"
    )
    limits: ClassVar[tuple[str, ...]] = ("axis.viscous",)
    changes_over_time: ClassVar[bool] = True
    d: Scalar = param("1", bounds=(-1.0, jnp.inf), starts=(0.3,), tex="d")
    B: Scalar = param(
        "N m s/rad", bounds=(-jnp.inf, jnp.inf), starts=(0.0,), scale="torque_per_rate", tex="B", role="form"
    )
    tau: Scalar = param("s", bounds=(0.1, 1e4), null=5.0, starts=(3.0, 10.0, 10.0), tex="\\tau")
    s: Scalar = param("1", bounds=(0.0, 1.0), starts=(0.0, 0.0, 1.0), tex="s", role="form")

    def _cold(self, motion: Motion) -> Scalar:
        return fallen(1.0, motion.t / self.tau, self.s)

    def level(self, motion: Motion, direction: float) -> Scalar:
        return self.B * jnp.abs(motion.w) * self._cold(motion)

    def share(self, motion: Motion) -> Scalar:
        return self.d * self._cold(motion)

    @classmethod
    def linear_note(cls, given: Mapping[str, float]) -> str:
        return "as at the first instant"
