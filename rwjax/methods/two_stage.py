r"""The thesis's two-stage method: a polynomial in time through the speed of a coast-down, then one in speed.

Stage 1 lays a polynomial in time through the speed (thesis eq. 3.12); its derivative is the acceleration (3.13). Stage 2
is linear least squares of $-\psi''$ on the friction's terms (3.14), $I\psi'' + b_0\psi'^3 + b_1\psi'^2 + b_2\psi' + b_3 = 0$
for a forward motion; the inertia is taken as known. A rig file with a Stribeck curve gets the curve that lies closest
to the polynomial over the measured speeds. The encoder's angle goes through a derivative filter first.
"""

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import least_squares

from rwjax.errors import LogError, RigError
from rwjax.fitting.fit import to_fit
from rwjax.fitting.ran_away import negative_friction
from rwjax.logs.driven import without_servo
from rwjax.logs.log import Log
from rwjax.methods.coast_down import SHORTEST_S, CoastDown, coast_downs, coasting_inertia
from rwjax.methods.identified import Identified, estimated, left_out, within_bounds
from rwjax.rig.model import Rig

ORDERS = range(1, 9)
"""Orders of the polynomial in time among which cross-validation chooses."""
FOLDS = 5
"""Parts that cross-validation leaves out in turn."""
BLOCK_S = 0.25
"""Residuals of stage 1 closer than this are resampled together [s]."""
RESAMPLES = 200
"""Resamples for the standard errors."""
POLYNOMIAL = ("axis.friction.b3", "axis.friction.b2", "axis.friction.b1", "axis.friction.b0")
"""Friction as a polynomial in speed, powers 0 to 3."""
CURVE = (
    "axis.friction.coulomb",
    "axis.friction.static",
    "axis.friction.stribeck_velocity",
    "axis.friction.viscous",
)
"""Friction as a Stribeck curve."""


def cross_validated_order(stretch: CoastDown) -> int:
    """Order of the polynomial in time that predicts left-out parts best; every part is scattered over the whole run.

    Args:
        stretch: The coast-down.

    Returns:
        One of `ORDERS` [1].
    """
    n = len(stretch.time)
    fold = (np.arange(n) * 4 * FOLDS // n) % FOLDS
    error = []
    for order in ORDERS:
        square = 0.0
        for k in range(FOLDS):
            fitted = Polynomial.fit(stretch.time[fold != k], stretch.speed[fold != k], order)
            square += float(np.sum((fitted(stretch.time[fold == k]) - stretch.speed[fold == k]) ** 2))
        error.append(square)
    return ORDERS[int(np.argmin(error))]


def _curve(values: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Stribeck curve [N m] over the speed [rad/s]."""
    coulomb, static, velocity, viscous = values
    return coulomb + (static - coulomb) * np.exp(-((w / velocity) ** 2)) + viscous * w


def to_stribeck(friction: Polynomial, speeds: np.ndarray, rig: Rig, free: Sequence[str]) -> np.ndarray:
    """Numbers of the Stribeck curve closest to a friction polynomial.

    Args:
        friction: Friction [N m] as a polynomial in speed [rad/s].
        speeds: Measured speeds, whose range counts `(time,)` [rad/s].
        rig: The rig, for the numbers of the curve that are not free.
        free: Names of the numbers to find, among `CURVE`.

    Returns:
        Their values `(free,)` [SI].
    """
    w = np.linspace(np.min(speeds), np.max(speeds), 200)
    wanted = friction(w)
    index = [CURVE.index(name) for name in free]
    start = np.array([wanted.min(), wanted[0], 0.3 * w[-1], max((wanted[-1] - wanted.min()) / w[-1], 1e-9)])
    fixed = np.array([rig.numbers.get(name, 0.0) for name in CURVE])

    def values(z: np.ndarray) -> np.ndarray:
        full = fixed.copy()
        full[index] = np.exp(z)
        return full

    z0 = np.log(np.maximum(start[index], 1e-9))
    best = least_squares(lambda z: (_curve(values(z), w) - wanted) / np.max(np.abs(wanted)), z0, x_scale=1.0)
    return values(best.x)[index]


class _Stages:
    """Both stages on some coast-downs, for the free numbers of a rig's friction."""

    def __init__(self, rig: Rig, free: Sequence[str], stretches: Sequence[CoastDown], order: int | None) -> None:
        self.rig, self.free, self.stretches = rig, free, stretches
        self.inertia = coasting_inertia(rig)
        power = {name: 3 - k for k, name in enumerate(reversed(POLYNOMIAL))} | {CURVE[0]: 0, CURVE[3]: 1}
        self.stribeck = "axis.friction.static" in rig.numbers
        self.powers = [0, 1, 2, 3] if self.stribeck else [power[name] for name in free]
        self.known = np.zeros(4)
        if not self.stribeck:
            for name, p in power.items():
                if name in rig.numbers and name not in free:
                    self.known[p] += rig.numbers[name] / self.inertia
        self.orders = [cross_validated_order(s) if order is None else order for s in stretches]
        self.fitted = [Polynomial.fit(s.time, s.speed, n) for s, n in zip(stretches, self.orders, strict=True)]
        self.speeds = np.concatenate([p(s.time) for p, s in zip(self.fitted, stretches, strict=True)])

    def second(self, speeds: Sequence[Polynomial]) -> np.ndarray:
        """Friction's coefficients per unit inertia, for the powers of speed that are sought."""
        known, rows, target = Polynomial(self.known), [], []
        for stretch, speed in zip(self.stretches, speeds, strict=True):
            w = speed(stretch.time)
            rows.append(np.stack([w**p for p in self.powers], axis=1))
            target.append(stretch.pushed - speed.deriv()(stretch.time) - known(w))
        A = np.concatenate(rows)
        scale = np.linalg.norm(A, axis=0)
        return np.linalg.lstsq(A / scale, np.concatenate(target), rcond=None)[0] / scale

    def estimate(self, speeds: Sequence[Polynomial]) -> np.ndarray:
        """The free numbers [SI], given the speeds as polynomials in time."""
        found = self.inertia * self.second(speeds)
        return to_stribeck(Polynomial(found), self.speeds, self.rig, self.free) if self.stribeck else found

    def standard_errors(self) -> np.ndarray:
        """Scatter of the estimates over resampled residuals of stage 1 [SI]."""
        rng = np.random.default_rng(0)
        drawn = []
        for _ in range(RESAMPLES):
            again = [
                Polynomial.fit(s.time, p(s.time) + _resampled(rng, s.time, s.speed - p(s.time)), n)
                for s, p, n in zip(self.stretches, self.fitted, self.orders, strict=True)
            ]
            drawn.append(self.estimate(again))
        return np.std(drawn, axis=0, ddof=1)


def _usable(rig: Rig, train: Sequence[Log]) -> tuple[list[str], list[CoastDown]]:
    """The free numbers of the axis's friction, and all coast-downs; raises as `two_stage`."""
    if rig.kind == "wheel":
        raise RigError(f"rig `{rig.name}`: a `wheel` has no axis that coasts; the two-stage method needs one")
    free = [name for name in rig.free if name in (*POLYNOMIAL, *CURVE)]
    if not free:
        raise RigError(
            f"rig `{rig.name}`: [fit] free names no number of [axis.friction]; the two-stage method estimates only those"
        )
    stretches = [stretch for log in train for stretch in coast_downs(rig, log)]
    if not stretches:
        names = ", ".join(log.name for log in train)
        raise LogError(
            f"{names}: no stretch of {SHORTEST_S:.0f} s in which the axis turns at 0 V or with torque off; the two-stage method needs a coast-down"
        )
    if loaded := next((log for log in train if log.added), None):
        raise LogError(
            f"{loaded.name}: has an `# add` note; the two-stage method takes one rig for all runs: leave it out"
        )
    return free, stretches


def two_stage(rig: Rig, logs: Sequence[Log], *, order: int | None = None) -> Identified:
    """Friction of the axis from coast-downs.

    Args:
        rig: The rig with its free numbers.
        logs: The logs; those marked for validation are left out.
        order: Order of the polynomial in time [1]; cross-validated without it.

    Returns:
        The estimates.

    Raises:
        RigError: The rig is a `wheel`, no friction number is free, or an estimate lies outside its bounds.
        LogError: No log may be fitted, none coasts, or one has numbers of its own added.
    """
    opened, logs = without_servo(rig, logs)
    train = to_fit(opened, logs)
    free, stretches = _usable(opened, train)
    stages = _Stages(opened, free, stretches, order)
    values = stages.estimate(stages.fitted)
    within_bounds(rig, "two-stage method", free, values)
    errors = stages.standard_errors()
    notes = [*left_out(rig, prior=False)]
    notes += [f"{name} is not estimated by the two-stage method" for name in rig.free if name not in free]
    notes.append(
        f"{len(stretches)} coast-downs, polynomials in time of order {', '.join(map(str, sorted({*stages.orders})))}, "
        f"speeds from {np.min(stages.speeds):.3g} to {np.max(stages.speeds):.3g} rad/s"
    )
    found = estimated(rig, free, values, errors)
    return Identified(found, (*notes, *negative_friction(free, found.values)))


def _resampled(rng: np.random.Generator, time: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Residual with blocks drawn anew (moving blocks; Kuensch, Ann. Stat. 17, 1989)."""
    n = len(residual)
    length = max(1, min(n - 1, int(np.searchsorted(time, time[0] + BLOCK_S))))
    starts = rng.integers(0, n - length + 1, -(-n // length))
    return np.concatenate([residual[s : s + length] for s in starts])[:n]
