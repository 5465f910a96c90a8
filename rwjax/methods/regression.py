r"""Regression on the equations of motion: smoothed motion in, no simulation.

The plant's rates $f(x, u; \theta)$ along the measured motion are compared with the measured accelerations. There are
two forms:

* Equation error takes the acceleration $a$ from a Savitzky-Golay filter, and compares $a$ with $f$.
* The weak form never differentiates a rate, nor an angle twice. With smooth test functions $\varphi$ that vanish with
  their derivatives at the ends of short windows, $\int\varphi\,\dot w = -\int\dot\varphi\,w = \int\ddot\varphi\,\psi$.
  It compares $\int\ddot\varphi\,\psi$ with $\int\varphi f$ (Preisig and Rippin, Comput. Chem. Eng. 17, 1993).

Samples at which a body is slower than its noise are left out, since the sign of dry friction is unknown there. A current
that is not logged follows from the voltage equation, a wheel's rate from a free run of the rig.
"""

from collections.abc import Callable, Sequence
from functools import partial

import jax
import numpy as np
from scipy.optimize import least_squares

from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import AxisAgeing, AxisElastic
from rwjax.errors import LogError, RigError
from rwjax.fitting.fit import to_fit
from rwjax.fitting.sandwich import meat, undetermined
from rwjax.fitting.scales import sizes_of
from rwjax.logs.log import Log
from rwjax.methods.identified import Identified, at_the_drive, estimated, left_out, undelayed
from rwjax.methods.measured_motion import MeasuredMotion
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.rates import rates_along

WINDOW_S, STRIDE_S = 0.5, 0.1
"""Length of the test functions and the time from one to the next [s]."""
NUDGE = 1e-3
"""How far the free numbers are moved to see what acts beside them, in units of their size [1]."""

Form = Callable[[MeasuredMotion, str, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""From a motion, a rate's name and the plant's derivative of it to what is measured and what the model says."""


@partial(jax.jit, static_argnums=0)
def _slopes(structure: Structure, theta, t, states, u, on=None):
    """Derivative of `rates_along` by the numbers `(n, s, p)`."""
    return jax.jacfwd(rates_along, argnums=1)(structure, theta, t, states, u, on)


def _bump(h: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Test function $(1 - s^2)^4$ on one window and its first two derivatives in time."""
    n = max(8, round(WINDOW_S / h))
    s = np.linspace(-1.0, 1.0, n + 1)
    scale = 2.0 / (n * h)
    return (
        (1 - s**2) ** 4,
        -8 * s * (1 - s**2) ** 3 * scale,
        (-8 * (1 - s**2) ** 3 + 48 * s**2 * (1 - s**2) ** 2) * scale**2,
    )


def _strong(m: MeasuredMotion, rate: str, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration and what the model says, at the samples whose signs are known."""
    return m.acceleration[rate][m.known], f[m.known]


def _weak(m: MeasuredMotion, rate: str, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration and model averaged by the test functions, in the windows whose signs are known."""
    bump, first, second = _bump(m.h)
    stride = max(1, round(STRIDE_S / m.h))
    kind, y = m.source[rate]
    n = len(bump)
    starts = np.arange(0, len(m.time) - n + 1, stride)
    starts = starts[[bool(m.known[s : s + n].all()) for s in starts]]
    index = starts[:, None] + np.arange(n)
    area = bump.sum()
    if kind == "angle":
        line = y[index[:, :1]] + (y[index[:, -1:]] - y[index[:, :1]]) * np.linspace(0.0, 1.0, n)
        measured = (y[index] - line) @ second / area
    else:
        measured = -y[index] @ first / area
    return measured, np.tensordot(f[index], bump, axes=(1, 0)) / area


def _as_run(rig: Rig, log: Log) -> Rig:
    """The rig with what is known to have been added to its numbers in this run."""
    return rig.with_values({name: rig.values[name] + more for name, more in log.added.items()})


class _Regression:
    """Residuals of all logs by the free numbers `z` `(k,)`, in units of their size."""

    def __init__(self, rig: Rig, logs: Sequence[Log], form: Form) -> None:
        structure = structure_of(rig)
        self.structure, self.form, self.theta = structure, form, theta_of(rig, structure)
        self.free = np.flatnonzero([name in rig.free for name in structure.names])
        self.size = sizes_of(rig, structure, self.theta, logs)[self.free]
        self.motions = [MeasuredMotion(_as_run(rig, log), structure, log) for log in logs]
        self.shown = [
            [*m.acceleration, *(["i"] if "i" in structure.states and "current_A" not in log.outputs else [])]
            for m, log in zip(self.motions, logs, strict=True)
        ]  # rates that the numbers have to agree with; a current that is not logged is worked out without these states
        longest = max(len(m.time) for m in self.motions)

        def padded(values: np.ndarray) -> np.ndarray:  # one length, so that one program serves all logs
            return np.pad(values, [(0, longest - len(values))] + [(0, 0)] * (values.ndim - 1), mode="edge")

        self.along = [
            (
                padded(m.time - m.time[0]),
                padded(np.stack([m.states[name] for name in structure.states], axis=1)),
                padded(m.command),
                *(() if m.on is None else (padded(m.on),)),
            )
            for m in self.motions
        ]
        self.added = [np.array(structure.vector(log.added)) for log in logs]

    def acting(self) -> list[str]:
        """Effects whose own states bend what is compared, at the rig's numbers or where the free ones differ a little."""
        theta = self.theta.copy()
        theta[self.free] += NUDGE * self.size
        names = self.structure.states
        effects = dict.fromkeys(name.partition(":")[0] for name in names if ":" in name)
        runs = [*zip(self.shown, self.motions, self.along, strict=True)]
        return [effect for effect in effects if any(self._bends(effect, theta, *run) for run in runs)]

    def _bends(
        self, effect: str, theta: np.ndarray, shown: Sequence[str], m: MeasuredMotion, along: tuple[np.ndarray, ...]
    ) -> bool:
        """Whether what is shown of a log changes with an effect's own states, and these do not stay 0 along it."""
        t, states, *driven = along
        names = self.structure.states
        own = [k for k, name in enumerate(names) if name.startswith(f"{effect}:")]
        rates = [names.index(name) for name in shown]
        at_zero = np.asarray(rates_along(self.structure, theta, t, states, *driven))[: len(m.time)]
        if not issubclass(BY_NAME[effect], AxisElastic | AxisAgeing) and not np.any(at_zero[:, own]):
            return False
        for k in own:
            moved = states + np.eye(len(names))[k]
            at_one = np.asarray(rates_along(self.structure, theta, t, moved, *driven))[: len(m.time)]
            if not np.array_equal(at_zero[m.known][:, rates], at_one[m.known][:, rates], equal_nan=True):
                return True
        return False

    def __call__(self, z: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Residual and its derivative `(…, k)` of each measured body in each log."""
        theta = self.theta.copy()
        theta[self.free] = z * self.size
        found = []
        for m, motion, added in zip(self.motions, self.along, self.added, strict=True):
            f = np.asarray(rates_along(self.structure, theta + added, *motion))[: len(m.time)]
            df = np.asarray(_slopes(self.structure, theta + added, *motion))[: len(m.time), :, self.free] * self.size
            for rate in m.acceleration:
                k = self.structure.states.index(rate)
                a, model = self.form(m, rate, f[:, k])
                _, slope = self.form(m, rate, df[:, k])
                found.append((a - model, -slope))
        return found


def _regress(rig: Rig, logs: Sequence[Log], form: Form) -> Identified:
    """Least squares, every body of every log in units of its first residual, with standard errors by the sandwich."""
    undelayed(rig, "regression")
    opened, logs, about = at_the_drive(rig, logs, "regression")
    train = to_fit(opened, logs)
    pieces = _Regression(opened, train, form)
    structure, free, size = pieces.structure, pieces.free, pieces.size
    if acting := pieces.acting():
        raise RigError(
            f"rig `{rig.name}`: has {acting[0]}, whose own state bends the motion and is in no reading; the regression takes "
            "such states as 0: take it out, or fit end to end"
        )
    bounds = bounds_of(opened, structure)[free].T / size
    equal = bounds[0] >= bounds[1]
    bounds[1][equal] = np.nextafter(bounds[0][equal], np.inf)
    z0 = np.clip(pieces.theta[free] / size, bounds[0] + 1e-9, bounds[1] - 1e-9)
    first = pieces(z0)
    if sum(len(r) for r, _ in first) <= len(free):
        raise LogError(f"{train[0].name}: nowhere is the motion fast enough against its noise for regression")
    weight = [1.0 / max(float(np.std(r)), 1e-300) if len(r) else 1.0 for r, _ in first]
    best = least_squares(
        lambda z: np.concatenate([w * r for (r, _), w in zip(pieces(z), weight, strict=True)]),
        z0,
        jac=lambda z: np.concatenate([w * J for (_, J), w in zip(pieces(z), weight, strict=True)]),  # pyright: ignore[reportArgumentType]
        bounds=(bounds[0], bounds[1]),
        x_scale="jac",
    )
    last = [(w * r, w * J) for (r, J), w in zip(pieces(best.x), weight, strict=True) if len(r) > 1]
    H = sum(J.T @ J for _, J in last)
    inverse = np.linalg.pinv(H)
    covariance = inverse @ meat([J[:, None] for _, J in last], [r[:, None] for r, _ in last]) @ inverse
    variance = np.diag(covariance)
    told = ~undetermined(np.asarray(H)) & (variance >= 0.0)  # rounding may leave a variance below 0
    errors = np.where(told, np.sqrt(np.where(told, variance, 1.0)) * size, np.inf)
    names = [structure.names[k] for k in free]
    return Identified(estimated(rig, names, best.x * size, errors), left_out(rig, prior=False) + about)


def equation_error(rig: Rig, logs: Sequence[Log]) -> Identified:
    """Least squares on filtered accelerations.

    Args:
        rig: The rig with its free numbers, without delays.
        logs: The logs; those marked for validation are left out.

    Returns:
        The estimates.

    Raises:
        RigError: Nothing is free, or the rig has a delay, or an effect whose own state bends the motion.
        LogError: No log may be fitted, nothing moves fast enough, or a current is missing.
    """
    return _regress(rig, logs, _strong)


def weak_form(rig: Rig, logs: Sequence[Log]) -> Identified:
    """Least squares on integrals against test functions.

    Args:
        rig: The rig with its free numbers, without delays.
        logs: The logs; those marked for validation are left out.

    Returns:
        The estimates.

    Raises:
        RigError: Nothing is free, or the rig has a delay, or an effect whose own state bends the motion.
        LogError: No log may be fitted, nothing moves fast enough, or a current is missing.
    """
    return _regress(rig, logs, _weak)
