"""The rig seen by its controller: the plant linearised about a held angle, and its transfer function without hidden modes."""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from rwjax.effects import BY_NAME
from rwjax.effects.axis import Backlash, FlexibleCoupling, Stribeck
from rwjax.effects.drive import SHARP, Curvature, DriveLag
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import AxisElastic, CommandDelay, CommandFilter, EncoderDelay
from rwjax.effects.wheel import Cogging
from rwjax.errors import InputError
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.one_axis import Plant, Structure, friction_sum
from rwjax.rig.model import Rig, with_one_axis
from rwjax.simulation.shooting import one_axis_plant_of
from rwjax.types import Scalar

SLIDING = 1e-6
"""Rate [rad/s] from which the slope of dry friction is continued to standstill, where it has two, or taken, where it has none."""
CANCELS = 1e-13
"""Share of what a number is summed from, or of what it is one radian on, below which it is rounding."""
SHORTEST = 1e-3
"""Share of a drive's first lag that its second one has at least, where some plants have a second one."""


class Linear(NamedTuple):
    """One plant, or many of one rig: `A` (…, n, n), `B` (…, n) per V of command, `C` (…, n) of the encoder's angle [rad].
    States that the command does not reach or the encoder does not show are left out, and so are delays."""

    states: tuple[str, ...]
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray


class Transfer(NamedTuple):
    """Polynomials in s of the minimal realisation from command [V] to angle [rad], highest power first along the last axis:
    `num` (…, m), and `den` (…, n), monic.

    `hidden`: poles that no gain moves, a conserved momentum's at 0.
    """

    num: np.ndarray
    den: np.ndarray
    hidden: tuple[float, ...]

    @property
    def restoring(self) -> np.ndarray:
        """Numerator of the plant whose command turns forward (…, m): with it positive gains restore."""
        return self.num * np.sign(self.num[..., :1])

    def each(self) -> "list[Transfer]":
        """Many plants one by one."""
        return [Transfer(num, den, self.hidden) for num, den in zip(self.num, self.den, strict=True)]


def linearised(rig: Rig, angle: float = 0.0, thetas: Float[np.ndarray, "k p"] | None = None) -> Linear:
    """The rig at rest at an `angle` [rad], no current flowing; or one plant for each row of `thetas`, parameter vectors of its
    structure.

    Dry friction counts as fed forward; its slope beside 0 stays and may be negative, as viscous friction does. What the
    drive does to small commands (dead zone, offset) counts as fed forward, too; its lag stays. For play stands the coupling
    that is closed, and no ripple of the motor holds the wheel. Friction that builds up over a displacement is built up: the axis
    slides. What changes over a run is as it begins.
    Raises `InputError` for a rig without an axis and for one whose command does not turn it.
    """
    with_one_axis(rig)
    if rig.kind == "wheel":
        raise InputError("kind `wheel`: there is no axis to hold at an angle; take a `platform` or `reaction` rig")
    whole = structure_of(rig)
    structure, theta = _beside(whole, theta_of(rig, whole) if thetas is None else np.asarray(thetas))
    lags = _lags(structure, theta)
    A, B, C = (np.asarray(x) for x in _matrices(structure, lags, jnp.asarray(theta), jnp.asarray(angle)))
    elsewhere = np.asarray(_matrices(structure, lags, jnp.asarray(theta), jnp.asarray(angle + 1.0))[0])
    A = np.where(np.abs(A) > CANCELS * np.abs(elsewhere), A, 0.0)  # a load's slope at its summit is rounding
    states = (*structure.states, *(f"{DriveLag.name}:u_{k + 1}" for k in range(lags)))
    acts, moves, shows = (np.any(x, axis=tuple(range(theta.ndim - 1))) for x in (A, B, C))
    use = _reached(acts, moves) & _reached(acts.T, shows)
    if not use.any():
        raise InputError("the command does not turn the axis; check the rig file's gain")
    k = np.flatnonzero(use)
    return Linear(tuple(states[i] for i in k), A[..., k[:, None], k], B[..., k], C[..., k])


def _beside(structure: Structure, theta: np.ndarray) -> tuple[Structure, np.ndarray]:
    """Structure and numbers of what a loop feels beside its angle: no lag of 0 s, no ripple, nothing elastic before sliding, a
    coupling for closed play, no power of the command, whose slope at 0 is none or without limit."""
    names, renamed = structure.names, {Backlash.name: FlexibleCoupling.name}
    idle = f"{DriveLag.name}.T" in names and not np.any(theta[..., names.index(f"{DriveLag.name}.T")])
    elastic = {name for name in structure.effects if issubclass(BY_NAME[name], AxisElastic)}
    gone = {Cogging.name, *elastic} | ({DriveLag.name} if idle else set())
    kept = {renamed.get(name, name): name for name in structure.effects if name not in gone}
    found = structure._replace(effects=()).with_effects(*kept)
    of = {name: name for name in structure.numbers} | {
        f"{new}.{number}": f"{old}.{number}" for new, old in kept.items() for number in parameters(BY_NAME[new])
    }
    theta = theta[..., [names.index(of[name]) for name in found.names]]
    return found, np.where([name == f"{Curvature.name}.p" for name in found.names], 0.0, theta)


def _lags(structure: Structure, theta: np.ndarray) -> int:
    """Lags in a row between command and voltage."""
    if DriveLag.name not in structure.effects:
        return 0
    return 1 + bool(np.any(theta[..., structure.names.index(f"{DriveLag.name}.q")]))


@partial(jax.jit, static_argnums=(0, 1))
@partial(jnp.vectorize, excluded=(0, 1, 3), signature="(p)->(n,n),(n),(n)")
def _matrices(structure: Structure, lags: int, theta: Float[Array, " p"], angle: Scalar) -> tuple[Array, ...]:
    """Derivatives of the rates by state and command and of the encoder's angle by state."""
    plant, zero = one_axis_plant_of(structure, theta), jnp.zeros(())
    rest = jnp.zeros(len(structure.states)).at[structure.states.index("psi")].set(angle)

    def rates(x: Array, u: Array) -> Array:
        return jnp.stack(plant.field(zero, tuple(x), u))

    def read(x: Array) -> Array:
        return plant.outputs(zero, tuple(x), zero, tuple(x))[structure.outputs.index("yaw_rad")]

    A, B = jax.jacfwd(rates, argnums=(0, 1))(rest, zero)
    A, C = A + _slopes(plant, rest), jax.jacfwd(read)(rest)
    for lag in (effect for effect in plant.effects if isinstance(effect, DriveLag)):
        for T in (lag.T * jnp.maximum(lag.q, SHORTEST), lag.T)[2 - lags :]:  # the first one drives the plant
            fast = 1.0 / T
            A = jnp.block([[A, B[:, None]], [jnp.zeros((1, len(A))), -fast[None, None]]])
            B, C = jnp.append(jnp.zeros_like(B), fast), jnp.append(C, 0.0)
    return A, B, C


def _slopes(plant: Plant, rest: Array) -> Array:
    """What the slope of dry friction beside standstill adds to the rates' derivatives `(n, n)`."""
    found = jnp.zeros((len(rest), len(rest)))
    for body, dry in plant.bodies():
        falls = [effect for effect in dry if isinstance(effect, Stribeck)]
        # with n > 1 its slope tends to 0, as with n = 2, if more slowly; with n < 1 it has no limit
        flat = [replace(e, n=jnp.where(e.n > 1.0, 2.0, e.n)) if isinstance(e, Stribeck) else e for e in dry]
        steep = jnp.any(jnp.stack([jnp.zeros((), bool), *(e.n < 1.0 for e in falls)]))

        def level(w: Array, body=body, flat=flat) -> Array:
            x = rest.at[body.rate].set(w)
            return friction_sum(flat, plant.motion(jnp.zeros(()), tuple(x), jnp.zeros(())), 1.0)

        near, far = (jax.grad(level)(jnp.asarray(w)) for w in (SLIDING, 2.0 * SLIDING))
        slope = jnp.where(steep, near, 2.0 * near - far)
        found = found.at[:, body.rate].add(jnp.stack([jnp.asarray(r) for r in body.reaction]) * slope)
    return found


def _reached(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Which states an input reaches through what is not exactly 0."""
    found = B != 0.0
    for _ in range(len(B)):
        found = found | ((A != 0.0) @ found)
    return found


def transfer(linear: Linear) -> Transfer:
    r"""Transfer function of linearised plants: $\det(sI - A)$ and $C\,\mathrm{adj}(sI - A)\,B$, common powers of s left out.

    Raises `InputError` where nothing of the numerator stands out from rounding.
    """
    den, size = characteristic(linear.A)
    num = _adjugate(linear.A, linear.B, linear.C, den)
    most = _adjugate(np.abs(linear.A), np.abs(linear.B), np.abs(linear.C), size)
    num, den = (np.where(np.abs(p) > CANCELS * m, p, 0.0) for p, m in ((num, most), (den, size)))
    if not np.all(np.any(num, axis=-1)):
        raise InputError(
            "the rig's numbers are too far apart for a transfer function; leave the inductance, the lag or the coupling out"
        )
    hidden = 0
    while den.shape[-1] > 1 and not (num[..., -1].any() or den[..., -1].any()):
        num, den, hidden = num[..., :-1], den[..., :-1], hidden + 1
    first = int(np.argmax(np.any(num, axis=tuple(range(num.ndim - 1)))))
    return Transfer(num[..., first:], den, (0.0,) * hidden)


def characteristic(A: Float[np.ndarray, "... n n"]) -> tuple[np.ndarray, np.ndarray]:
    r"""Coefficients of $\det(sI - A)$ `(…, n + 1)`, highest power first, and the sum of the sizes of what each is summed from.

    Products and sums only (Samuelson 1942, Berkowitz 1984), so that numbers of many sizes do not spoil each other; slow states
    first.
    """
    slow = np.argsort(np.max(np.abs(np.diagonal(A, axis1=-2, axis2=-1)).reshape(-1, A.shape[-1]), axis=0))
    A = A[..., slow[:, None], slow]
    found = []
    for M, sign in ((A, -1.0), (np.abs(A), 1.0)):
        p = np.ones((*A.shape[:-2], 1))
        for r in range(A.shape[-1]):
            grown = np.concatenate([p, sign * M[..., r, r, None] * p[..., -1:]], -1)
            grown[..., 1:-1] += sign * M[..., r, r, None] * p[..., :-1]
            grown[..., 2:] += sign * _adjugate(M[..., :r, :r], M[..., :r, r], M[..., r, :r], p)
            p = grown
        found.append(p)
    return found[0], found[1]


def _adjugate(A: np.ndarray, B: np.ndarray, C: np.ndarray, den: np.ndarray) -> Float[np.ndarray, "... n"]:
    r"""Coefficients of $C\,\mathrm{adj}(sI - A)\,B$, from `den` $=\det(sI - A)$ and the Markov parameters $C A^k B$."""
    n, found = A.shape[-1], np.zeros_like(B)
    for k in range(n):
        found[..., k:] += np.sum(C * B, -1, keepdims=True) * den[..., : n - k]
        B = np.squeeze(A @ B[..., None], -1)
    return found


class Lateness(NamedTuple):
    """Times [s] by which `commands` act late and by which `readings` of the encoder are late, `(k,)`."""

    commands: np.ndarray
    readings: np.ndarray

    @property
    def loop(self) -> np.ndarray:
        """Both [s]: from one reading to the next a loop knows only their sum."""
        return self.commands + self.readings


def lateness(rig: Rig, thetas: Float[np.ndarray, "k p"] | None = None) -> Lateness:
    """Delays of the rig itself, or of one plant for each row of `thetas`."""
    structure = structure_of(rig)
    rows = theta_of(rig, structure)[None] if thetas is None else np.asarray(thetas)

    def of(theta: Float[Array, " p"]) -> tuple[Scalar, ...]:
        plant = one_axis_plant_of(structure, theta)
        return tuple(jnp.zeros(()) if time is None else time for time in (plant.delay(), plant.age()))

    commands, readings = jax.vmap(of)(jnp.asarray(rows))
    return Lateness(np.asarray(commands), np.asarray(readings))


def without_lateness(rig: Rig, sampled: bool = False) -> tuple[str, ...]:
    """Effects of a rig that no transfer function holds: the limit of the drive's rate and delays, which a sampled loop holds."""
    late = (CommandFilter,) if sampled else (CommandDelay, EncoderDelay, CommandFilter)
    return tuple(e for e in rig.effects if issubclass(BY_NAME[e], late) and BY_NAME[e] is not DriveLag)


TAKEN = {
    "axis.backlash": "the play is closed",
    "axis.friction_drift": "as at the first instant",
    "axis.periodic_torque": "a load that no gain moves, left out",
    "axis.presliding": "sliding, all its friction built up",
    "drive.asymmetric_gain": "the gain is the mean of both directions",
    "drive.curvature": "the gain is that of small commands",
    "drive.supply_sag": "the gain is that of small commands",
    "motor.heating": "as at the first instant, the winding cold",
    "motor.saturation": "the gain is that of small commands",
    "wheel.cogging": "no ripple holds the wheel",
}


def taken_as(rig: Rig) -> tuple[str, ...]:
    """What stands in the transfer function for effects of a rig that it cannot hold, a line each."""
    power = "its power is left out, the gain is that of small commands without it"
    taken = TAKEN | ({"drive.curvature": power} if rig.effects.get("drive.curvature", {}).get("p", 0.0) else {})
    lines = [f"{name}: {taken[name]}" for name in rig.effects if name in taken]
    if rig.effects.get("drive.saturation", {}).get("n", SHARP) < SHARP:
        lines.append("drive.saturation: the gain is that of small commands")
    fall = rig.effects.get("axis.stribeck", {})
    n = fall.get("n", 2.0) if fall.get("M_e", 0.0) > 0.0 else 2.0
    if n < 1.0:
        lines.append(f"axis.stribeck: infinitely steep at standstill, taken at {SLIDING:g} rad/s")
    elif 1.0 < n < 2.0:
        lines.append("axis.stribeck: level at standstill, though it falls at once beside it")
    return tuple(lines)
