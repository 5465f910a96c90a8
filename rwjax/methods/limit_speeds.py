r"""The thesis's limit speeds: torque constant and friction of the motor from the steady speeds of its wheel.

At steady speed eq. 3.1 leaves $K i = b\,\Omega + M\,\mathrm{sgn}\,\Omega$ and $V = R i + K\Omega$. Without dry friction $M$ of
the wheel that is eq. 3.3, $V/\Omega = R b/K + K$: a line through the origin. Dry friction shifts it by $R M/K$. $R$ is
taken as known.

* Speeds alone determine one of $K$ and $b$ by the slope, and $M$ by the shift. Of the two torque constants that solve eq.
  3.3 for a known $b$ the larger one is taken; the other would lose more of the voltage in the winding than in the back-EMF.
* Where the current is measured, too, $K$ and $b$ separate.

The estimates are weighted least squares on the mean speeds and currents of plateaus, each with the standard error that its
correlated noise gives it. Where these scatter about the line by more than that, every plateau counts the same, and the
errors are by the scatter, with Student's factor.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from scipy.optimize import least_squares
from scipy.special import chdtri, ndtri

from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import (
    Clock,
    CurrentLimit,
    Encoder,
    MotorTorque,
    Reading,
    Supply,
    WheelDry,
    WheelTorque,
    Winding,
)
from rwjax.errors import LogError, RigError
from rwjax.fitting.fit import to_fit
from rwjax.kinds import WHEELED
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.methods.identified import NORMAL_95, Identified, estimated, left_out, student, within_bounds
from rwjax.methods.plateaus import FEWEST, Plateau, plateaus, without_standing
from rwjax.plant.assemble import one_axis_plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig

TORQUE_CONSTANT, RESISTANCE, FRICTION = "motor.torque_constant", "motor.resistance", "motor.friction"
BENDS = (Supply, MotorTorque, CurrentLimit, Winding, WheelTorque, Reading, Clock)
"""Ports whose effects change the steady speed otherwise than these equations know."""
RARE = 0.01
"""Probability of chance below which plateaus scatter by more than their noise, and a line misses the origin [1]."""
DEPENDS = 0.02
"""Share of an estimate that 1 % of a number taken as known moves it by, from which on a note says so [1]."""


class _Steady(NamedTuple):
    """Plateaus on which the wheel turns, as arrays `(n,)`; without a current its reading is NaN and its error infinite."""

    volts: np.ndarray
    speed: np.ndarray
    speed_error: np.ndarray
    current: np.ndarray
    current_error: np.ndarray

    def residuals(self, values: Mapping[str, float], level: float) -> np.ndarray:
        """Speeds and currents less those of the model, in units of their errors, for a level of dry friction [N m]."""
        K, R, b = values[TORQUE_CONSTANT], values[RESISTANCE], values.get(FRICTION, 0.0)
        dry = level * np.sign(self.speed)
        speed = (self.volts - R * dry / K) / (R * b / K + K)
        seen = np.isfinite(self.current)
        current = (b * speed + dry) / K
        return np.concatenate(
            [(self.speed - speed) / self.speed_error, ((self.current - current) / self.current_error)[seen]]
        )

    def alike(self) -> "_Steady":
        """The same with one error for all speeds and one for all currents, their root mean square."""
        seen = np.isfinite(self.current)
        errors = (
            np.sqrt(np.mean(self.speed_error**2)),
            np.sqrt(np.mean(self.current_error[seen] ** 2)) if seen.any() else 1.0,
        )
        return self._replace(speed_error=np.full(len(seen), errors[0]), current_error=np.where(seen, errors[1], np.inf))

    def lost(self) -> "_Solved":
        """Linear least squares of the speeds: slope, and the speed lost against the motion and, both ways alike, forward."""
        columns = [self.volts, -np.sign(self.speed), -np.ones(len(self.volts))]
        both = len({*np.sign(self.speed)}) == 2 and len(self.volts) > 3
        A = np.stack(columns if both else columns[:2], axis=1) / self.speed_error[:, None]
        y = self.speed / self.speed_error
        inverse = np.linalg.pinv(A.T @ A)
        found = inverse @ (A.T @ y)
        return _Solved(found, inverse, y - A @ found)


class _Solved(NamedTuple):
    """Least squares: the numbers sought `(k,)`, their covariance `(k, k)`, and what is left in units of errors `(n,)`."""

    found: np.ndarray
    covariance: np.ndarray
    left: np.ndarray


def _roots(covariance: np.ndarray) -> np.ndarray:
    """Standard errors of a covariance, whose diagonal rounding may put below 0."""
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _with_errors(solve: Callable[[_Steady], _Solved], steady: _Steady) -> tuple[np.ndarray, np.ndarray, bool]:
    """Numbers and their errors, and whether the plateaus scatter by more than their noise: then that counts, alike for all."""
    first = solve(steady)
    degrees = float(len(first.left) - len(first.found))
    if degrees < 1.0 or first.left @ first.left <= chdtri(degrees, RARE):
        return first.found, _roots(first.covariance), False
    again = solve(steady.alike())
    size = np.sqrt(again.left @ again.left / degrees) * student(degrees)
    return again.found, size * _roots(again.covariance), True


def limit_speeds(rig: Rig, logs: Sequence[Log]) -> Identified:
    """Torque constant, friction of the motor and dry friction of the wheel from steady speeds.

    Args:
        rig: The rig with its free numbers, of kind `wheel` or `reaction`.
        logs: The logs; those marked for validation are left out.

    Returns:
        The estimates.

    Raises:
        RigError: The rig has no motor with one wheel, has effects that bend the line, or its free numbers cannot be told
            from these logs, lie outside their bounds or have the wrong sign.
        LogError: No log may be fitted, none has a plateau on which the wheel turns, or one has numbers of its own added.
    """
    rig, logs = driven(rig, logs)
    train = to_fit(rig, logs)
    free = _free(rig)
    _check_logs(rig, train)
    moving, notes = _moving(rig, train)
    steady = _steady(rig, moving)
    _check_told(rig, free, steady)
    values, errors, scatter = _estimate(rig, free, steady)
    values, at_zero = _with_signs(rig, free, values, errors)
    within_bounds(rig, "limit-speed method", free, values)
    found = estimated(rig, free, values, errors)
    about = [f"{name} is not estimated by the limit-speed method" for name in rig.free if name not in free]
    about += [*_of_plateaus(steady, scatter), *notes, *at_zero, *_shifted(found, free, steady)]
    about += _dependence(found, free, steady)
    return Identified(found, (*left_out(rig, prior=False), *about))


def _dry(rig: Rig) -> list[str]:
    """Names of the rig's numbers that are the level of dry friction of the wheel."""
    return [f"{e}.{p}" for e, given in rig.effects.items() if issubclass(BY_NAME[e], WheelDry) for p in given]


def _level(rig: Rig, values: Mapping[str, float]) -> float:
    """Level of the wheel's dry friction [N m]."""
    return float(sum(values[name] for name in _dry(rig)))


def _free(rig: Rig) -> list[str]:
    """The free numbers that steady speeds may tell; raises `RigError` as `limit_speeds`."""
    if rig.kind not in WHEELED:
        raise RigError(
            f"rig `{rig.name}`: kind `{rig.kind}` has no motor with one wheel; the limit-speed method is for `wheel` and `reaction`"
        )
    bends = BENDS if rig.kind != "wheel" else (*BENDS, Encoder)  # with an axis, that encoder does not read the wheel
    if other := next((name for name in rig.effects if issubclass(BY_NAME[name], bends)), None):
        raise RigError(
            f"rig `{rig.name}`: has {other}, which the limit-speed method does not know; take it out, or fit end to end"
        )
    told = (TORQUE_CONSTANT, FRICTION, *_dry(rig))
    if not (free := [name for name in rig.free if name in told]):
        raise RigError(
            f"rig `{rig.name}`: [fit] free names none of {', '.join(told)}; the limit-speed method estimates only those"
        )
    return free


def _check_logs(rig: Rig, train: Sequence[Log]) -> None:
    """Raises `LogError` where no log has the wheel's speed, or one has numbers of its own that change it."""
    if not any({"wheel_rad_s", "wheel_rad"} & {*log.outputs} for log in train):
        names = ", ".join(log.name for log in train)
        raise LogError(
            f"{names}: no `wheel_rad_s`, `wheel_rad` or `wheel_counts`; the limit-speed method needs the wheel's speed"
        )
    for log in train:
        if own := next((name for name in log.added if not name.startswith("axis.") and name != "wheel.inertia"), None):
            raise LogError(
                f"{log.name}: has `# add {own}`; the limit-speed method takes one motor for all runs: leave it out"
            )


def _moving(rig: Rig, train: Sequence[Log]) -> tuple[list[Plateau], list[str]]:
    """The plateaus on which the wheel turns, with the voltage that acts, and what is said of the others."""
    structure = structure_of(rig)
    plant = one_axis_plant_of(structure, jnp.asarray(theta_of(rig, structure)))
    found, unsettled = [], []
    for log in train:
        settled, moves = plateaus(log)
        found += settled
        unsettled += [f"{log.name} at {begin:.4g} s" for begin in moves]
    acts = {p: float(plant.act(jnp.asarray(p.volts))) for p in found}
    names = ", ".join(log.name for log in train)
    if not found and not unsettled:
        raise LogError(
            f"{names}: no stretch with the same voltage over {FEWEST} readings; the limit-speed method needs such"
        )
    turning, standing = without_standing(found)
    moving = [replace(p, volts=acts[p]) for p in turning if acts[p] * p.speed.value > 0.0]
    if not moving:
        why = "its speed settles on none" if unsettled else "it stands on all"
        raise LogError(
            f"{names}: no stretch with the same voltage on which the wheel turns steadily ({why}); hold voltages longer"
        )
    notes = []
    if unsettled:
        notes.append(
            f"stretches whose speed does not settle are left out: {len(unsettled)}, the first in {unsettled[0]}"
        )
    if highest := max((abs(p.volts) for p in standing if acts[p]), default=0.0):
        notes.append(
            f"the wheel stands at up to {highest:.3g} V, which is left out: dry friction or a dead zone holds it"
        )
    return moving, notes


def _steady(rig: Rig, moving: Sequence[Plateau]) -> _Steady:
    """The plateaus as arrays."""
    current = [(p.current.value, p.current.error) if p.current else (np.nan, np.inf) for p in moving]
    speed = [(p.speed.value, p.speed.error) for p in moving]
    return _Steady(np.array([p.volts for p in moving]), *np.array(speed).T, *np.array(current).T)


def _check_told(rig: Rig, free: Sequence[str], steady: _Steady) -> None:
    """Raises `RigError` where these plateaus cannot tell the free numbers apart."""
    alone = not np.isfinite(steady.current).any()
    if alone and {TORQUE_CONSTANT, FRICTION} <= {*free}:
        raise RigError(
            f"rig `{rig.name}`: speed over voltage tells R b/K + K alone; take {TORQUE_CONSTANT} or {FRICTION} out of "
            "[fit] free, or log `current_A`"
        )
    sizes = np.unique(np.round(np.abs(steady.volts) / np.max(np.abs(steady.volts)), 3))
    if alone and len(sizes) < len(free):
        raise RigError(f"rig `{rig.name}`: {' and '.join(free)} need plateaus at two sizes of voltage at least")


def _start(rig: Rig, free: Sequence[str], steady: _Steady) -> dict[str, float]:
    """Values near the estimates: those of a line through the origin."""
    values = dict(rig.values)
    w = steady.speed / steady.speed_error**2
    slope = float(w @ steady.volts / (w @ steady.speed))
    R, i = values[RESISTANCE], np.nan_to_num(steady.current)
    if TORQUE_CONSTANT in free:
        root = slope**2 - 4.0 * R * values.get(FRICTION, 0.0)
        values[TORQUE_CONSTANT] = 0.5 * (slope + np.sqrt(max(root, 0.0)))
        if FRICTION in free:
            seen = np.isfinite(steady.current)
            values[TORQUE_CONSTANT] = float(
                (steady.volts - R * i)[seen] @ steady.speed[seen] / np.sum(steady.speed[seen] ** 2)
            )
            if values[TORQUE_CONSTANT] <= 0.0:
                raise RigError(
                    f"rig `{rig.name}`: the currents times {RESISTANCE} exceed the voltages: is that, or the unit of `current_A`, wrong?"
                )
        elif root < 0.0:
            raise RigError(
                f"rig `{rig.name}`: no {TORQUE_CONSTANT} gives {1.0 / slope:.4g} rad/s per volt with this {FRICTION} and {RESISTANCE}; "
                f"{FRICTION} is at most {slope**2 / (4.0 * R):.3g} N m s/rad"
            )
    if FRICTION in free:
        values[FRICTION] = (slope - values[TORQUE_CONSTANT]) * values[TORQUE_CONSTANT] / R
    return values


def _estimate(rig: Rig, free: Sequence[str], steady: _Steady) -> tuple[np.ndarray, np.ndarray, bool]:
    """The free numbers, their errors, and whether the plateaus scatter by more than their noise."""
    start = _start(rig, free, steady)
    K, R = start[TORQUE_CONSTANT], start[RESISTANCE]
    size = {TORQUE_CONSTANT: K, FRICTION: K**2 / R}
    sizes = np.array([size.get(name, K / R * float(np.max(np.abs(steady.volts)))) for name in free])
    z0 = np.array([start[name] for name in free]) / sizes
    least = np.where(np.array(free) == TORQUE_CONSTANT, 1e-3, -np.inf)  # it divides

    def solve(of: _Steady) -> _Solved:
        def residuals(z: np.ndarray) -> np.ndarray:
            values = start | dict(zip(free, z * sizes, strict=True))
            return of.residuals(values, _level(rig, values))

        best = least_squares(residuals, z0, jac="3-point", xtol=1e-12, ftol=1e-12, bounds=(least, np.inf))
        return _Solved(best.x, np.linalg.pinv(best.jac.T @ best.jac), best.fun)

    z, errors, scatter = _with_errors(solve, steady)
    return z * sizes, errors * sizes, scatter


def _with_signs(rig: Rig, free: Sequence[str], values: np.ndarray, errors: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Estimates with what lies below 0 by its error alone at 0, and what is said of it; raises `RigError` for one further below."""
    notes = []
    for k, name in enumerate(free):
        if values[k] >= 0.0:
            continue
        if values[k] < -NORMAL_95 * errors[k]:
            partner = (
                ""
                if name == TORQUE_CONSTANT
                else f": the wheel is faster than {TORQUE_CONSTANT} = {rig.values[TORQUE_CONSTANT]:.4g} lets it be"
            )
            raise RigError(
                f"rig `{rig.name}`: `{name}` comes out as {values[k]:.3g} ± {errors[k]:.2g}, below 0{partner}"
            )
        notes.append(f"{name} comes out as {values[k]:.3g}, below 0 by no more than its error: 0 is taken")
    return np.maximum(values, 0.0), notes


def _of_plateaus(steady: _Steady, scatter: bool) -> list[str]:
    """How many plateaus there are, over which range, and whether they scatter by more than their noise."""
    n, measured = len(steady.volts), int(np.isfinite(steady.current).sum())
    with_current = f", {measured} with a current" if measured else ""
    notes = [
        f"{n} steady speeds{with_current}, {np.min(steady.speed):.4g} to {np.max(steady.speed):.4g} rad/s at "
        f"{np.min(steady.volts):.4g} to {np.max(steady.volts):.4g} V"
    ]
    if scatter:
        notes.append("they scatter about the line by more than their noise; the errors are by that scatter")
    return notes


def _shifted(found: Rig, free: Sequence[str], steady: _Steady) -> list[str]:
    """What keeps the line from the origin, where nothing that is estimated does."""
    if {*_dry(found)} & {*free} or len(np.unique(np.round(np.abs(steady.volts), 6))) < 3:
        return []
    K, R = found.values[TORQUE_CONSTANT], found.values[RESISTANCE]
    lost, errors, _ = _with_errors(_Steady.lost, steady)
    # volts are a ratio with the slope, which is known far better
    (shift, error), *alike = zip(lost[1:] / lost[0], errors[1:] / lost[0], strict=True)
    shift -= R * _level(found, found.values) / K
    far, words = -ndtri(0.5 * RARE), []
    if shift > far * error:
        words.append(
            f"the wheel lacks {shift:.3g} ± {error:.2g} V against its motion, as by dry friction of {shift * K / R:.3g} N m or a "
            "dead zone of the drive"
        )
    elif shift < -far * error:
        words.append(f"the speed grows less than the voltage, as by air drag ({shift:.3g} ± {error:.2g} V at 0 rad/s)")
    words += [f"forward and back differ by an offset of {-x:.3g} ± {e:.2g} V" for x, e in alike if abs(x) > far * e]
    return [f"{text}; the rig file has no such thing, and it goes into {' and '.join(free)}" for text in words]


def _dependence(found: Rig, free: Sequence[str], steady: _Steady) -> list[str]:
    """How far 1 % of the number taken as known moves the one that the slope gives."""
    told = {TORQUE_CONSTANT, FRICTION} & {*free}
    if np.isfinite(steady.current).any() or len(told) != 1 or not found.values.get(FRICTION):
        return []
    (name,) = told
    K, R, b = (found.values[n] for n in (TORQUE_CONSTANT, RESISTANCE, FRICTION))
    slope = R * b / K + K
    if name == FRICTION:
        known, share = TORQUE_CONSTANT, (slope - 1.01 * K) * 1.01 * K / R / b - 1.0
    else:
        known, share = FRICTION, 0.5 * (slope + np.sqrt(max(slope**2 - 4.04 * R * b, 0.0))) / K - 1.0
    if abs(share) < DEPENDS:
        return []
    return [f"{name} rests on {known}: 1 % more of that changes it by {100.0 * share:+.2g} %"]
