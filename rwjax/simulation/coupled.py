r"""Dry friction with exact stick on bodies that all push one another.

With the inverse $G$ of the mass matrix, the accelerations are $a = a_0 - G f$. The friction $f$ of a sliding body is its level;
that of a resting body is what keeps it at rest where its level allows that, else the level against the acceleration: a linear
complementarity problem in a box, which has one solution since $G$ is positive definite (Cottle, Pang and Stone, The Linear
Complementarity Problem (1992), section 3.3). An active set looks for it: bodies are taken to be held or not, the torques that hold the
former are solved for, and whoever needs more than its level, or less than it has, changes sides: all of them at once in the first
rounds, which settles most cases and runs in circles in some; then only the first of them, which ends for every positive definite
matrix (Murty, Linear Algebra Appl. 9, 1974).
"""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from rwjax.plant.one_axis import State, friction_level
from rwjax.plant.two_axis import ANGLES, RATES, TwoAxis
from rwjax.simulation.stick import stopped
from rwjax.types import Scalar

Bodies = Float[Array, " b"]
"""One number for each body with dry friction, in the order of `TwoAxis.dry`."""


AT_ONCE = 5
"""Rounds in which all bodies change sides that want to."""
ROUNDS = 60
"""Most rounds: of 100 000 systems drawn at random, none takes more than 20."""


def solve_within(G: Float[Array, "b b"], b: Bodies, inside: Bool[Array, " b"]) -> Bodies:
    """Solution of $G f = b$ for the bodies marked `inside`, 0 for the others; elimination without pivots, unrolled."""
    n = len(b)
    M = jnp.where(inside[:, None] & inside[None], G, jnp.eye(n))
    rows = jnp.concatenate([M, jnp.where(inside, b, 0.0)[:, None]], axis=1)
    for k in range(n):
        pivot = rows[k : k + 1] / rows[k, k]
        rows = jnp.where(np.arange(n)[:, None] == k, pivot, rows - rows[:, k : k + 1] * pivot)
    return rows[:, n]


def mobility_beside(G: Float[Array, "b b"], held: Bool[Array, " b"]) -> Bodies:
    r"""Acceleration of each body by a torque of 1 N m on it while the bodies marked `held` stay at rest:
    $G_{ii} - G_{iH} G_{HH}^{-1} G_{Hi}$; of a held one $G_{ii}$."""
    own = jax.vmap(lambda row: row @ solve_within(G, row, held))(G)
    return jnp.diagonal(G) - jnp.where(held, 0.0, own)


def levels_kept(
    G: Float[Array, "b b"], free: Bodies, f: Bodies, resting: Bool[Array, " b"], ahead: Bodies, back: Bodies
) -> tuple[Bodies, Bool[Array, " b"]]:
    """Friction `f` of all bodies, of those that are not `resting` as given, and which of the others it holds.

    `free`: accelerations without friction; `ahead`, `back`: its levels.
    """
    fixed = jax.lax.stop_gradient((G, free, f, resting, ahead, back))  # which bodies are held is a choice, not a number

    def change(found: tuple) -> tuple:
        k, side, _ = found
        f, held = _balanced(side, *fixed)
        over = jnp.where(f > fixed[4], 1, jnp.where(f < -fixed[5], -1, 0))
        a = fixed[1] - fixed[0] @ f
        pulled_off = ((side > 0) & (a < 0.0)) | ((side < 0) & (a > 0.0))
        wanted = jnp.where(held, over, jnp.where(pulled_off, 0, side))
        moving = wanted != side
        first = np.arange(len(f)) == jnp.argmax(moving)
        return k + 1, jnp.where(moving & ((k < AT_ONCE) | first), wanted, side), jnp.any(moving)

    begin = jnp.asarray(0), jnp.zeros(len(f), int), jnp.asarray(True)
    _, side, _ = jax.lax.while_loop(lambda found: found[2] & (found[0] < ROUNDS), change, begin)
    found, held = _balanced(side, G, free, f, resting, ahead, back)
    within = (-back <= found) & (found <= ahead)  # all of them, unless the rounds have not sufficed
    return jnp.where(resting, jnp.clip(found, -back, ahead), found), held & within


def _balanced(
    side: Int[Array, " b"],
    G: Float[Array, "b b"],
    free: Bodies,
    f: Bodies,
    resting: Bool[Array, " b"],
    ahead: Bodies,
    back: Bodies,
) -> tuple[Bodies, Bool[Array, " b"]]:
    """Friction where the resting bodies are held (`side` 0) or at their level ahead (1) or back (-1), and who is held."""
    held = resting & (side == 0)
    f = jnp.where(resting, jnp.where(side > 0, ahead, jnp.where(side < 0, -back, 0.0)), f)
    return jnp.where(held, solve_within(G, free - G @ f, held), f), held


def with_coupled_friction(
    plant: TwoAxis, t: Scalar, x: State, u: Float[Array, " 2"], start: State
) -> tuple[State, list[tuple[Scalar, Scalar]]]:
    """`rwjax.simulation.step.with_friction` of bodies that push one another."""
    rates, states, dry = plant.field(t, x, u), plant.structure.states, plant.dry()
    if not dry:
        return rates, []
    at, bodies = [states.index(name) for name in RATES], [body for body, _ in dry]
    columns = plant.mobility(x)
    G, levels = _among(columns, bodies), _levels(plant, t, x, u)
    ahead, back = (jnp.stack(each) for each in zip(*levels, strict=True))
    w, free = (jnp.stack([of[at[body]] for body in bodies]) for of in (start, rates))
    resting = (w == 0.0) & (ahead + back > 0.0)
    f = jnp.where(w > 0.0, ahead, jnp.where(w < 0.0, -back, 0.0))
    f, held = levels_kept(G, free, f, resting, ahead, back)
    a = jnp.where(held, 0.0, free - G @ f)  # exactly at rest, not to rounding
    alone = f + a / mobility_beside(G, held)  # the torque on each body but for its own friction
    bound = jnp.clip(alone, -back, ahead)
    found = [
        rate - sum(columns[body][k] * f[j] for j, body in enumerate(bodies)) for k, rate in enumerate(_of(rates, at))
    ]
    changed = dict(zip(at, found, strict=True)) | {at[body]: a[j] for j, body in enumerate(bodies)}
    excess = alone - bound
    return tuple(changed.get(k, rate) for k, rate in enumerate(rates)), [(alone[j], excess[j]) for j in range(len(dry))]


def _of(x: State, places: list[int]) -> State:
    return tuple(x[k] for k in places)


def _among(columns: list, bodies: list[int]) -> Float[Array, "b b"]:
    """The mobility of these bodies."""
    return jnp.stack([jnp.stack([columns[j][i] for j in bodies]) for i in bodies])


def _levels(plant: TwoAxis, t: Scalar, x: State, u: Float[Array, " 2"]) -> list[tuple[Scalar, Scalar]]:
    """Dry friction forward and backward of each body that has any [N m]."""
    motions = plant.motions(t, x, u)
    return [
        (friction_level(effects, motions[body % 2], 1.0), friction_level(effects, motions[body % 2], -1.0))
        for body, effects in plant.dry()
    ]


def stop_or_turn_together(
    plant: TwoAxis, t: Scalar, x: State, x1: State, u: Float[Array, " 2"], h: Scalar, rates0: State, torques: list
) -> State:
    """Mend the end of a step for all bodies that rested or whose speed changed sign: each gets the speed that it ends with, by
    impulses that push the others, too."""
    states, bodies = plant.structure.states, [body for body, _ in plant.dry()]
    if not bodies:
        return x1
    columns = plant.mobility(x)
    G = _among(columns, bodies)
    resting = jnp.stack([x[states.index(RATES[body])] == 0.0 for body in bodies])
    beside = mobility_beside(G, resting & jnp.stack([(a[1] == 0.0) & (b[1] == 0.0) for a, b in torques]))
    stops = []
    for k, body in enumerate(bodies):
        rate, angle = states.index(RATES[body]), states.index(ANGLES[body])
        rest = tuple(jnp.zeros_like(v) if j == rate else v for j, v in enumerate(x))
        levels = _levels(plant, t, rest, u)[k]
        rates, angles = (x[rate], x1[rate]), (x[angle], x1[angle])
        stops.append(stopped(rates, angles, rates0[rate], h, 1.0 / beside[k], levels, torques[k]))
    end, mended = jnp.stack([stop.rate for stop in stops]), jnp.stack([stop.mended for stop in stops])
    before = jnp.stack([x1[states.index(RATES[body])] for body in bodies])
    impulse = solve_within(G, end - before, mended)
    found = list(x1)
    for k, name in enumerate(RATES):
        found[states.index(name)] += sum(columns[body][k] * impulse[j] for j, body in enumerate(bodies))
    for stop, body in zip(stops, bodies, strict=True):
        rate, angle = states.index(RATES[body]), states.index(ANGLES[body])
        found[rate], found[angle] = jnp.where(stop.mended, stop.rate, found[rate]), stop.angle
    return tuple(found)
