r"""Regression on the equations of motion: smoothed motion in, no simulation.

The plant's rates $f(x, u; \theta)$ along the measured motion are compared with the measured accelerations. Equation
error takes those from a Savitzky-Golay filter: $a - f$. The weak form never differentiates a rate, nor an angle twice:
with smooth test functions $\varphi$ that vanish with their derivatives at the ends of short windows,
$\int\varphi\,\dot w = -\int\dot\varphi\,w = \int\ddot\varphi\,\psi$, so that $\int\ddot\varphi\,\psi - \int\varphi f$ is
compared with 0 (Preisig and Rippin, Comput. Chem. Eng. 17, 1993). Samples at which a body is slower than its noise,
where the sign of dry friction is unknown, are left out. A current that is not logged follows from the voltage equation,
a wheel's rate from a free run of the rig.
"""

from collections.abc import Callable, Sequence
from functools import partial

import rwjax.setup_jax  # noqa: F401  (float64 comes first)

import jax  # isort: skip
import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter, savgol_filter

from rwjax.errors import LogError
from rwjax.fitting.fit import to_fit
from rwjax.fitting.predict import predict
from rwjax.fitting.sandwich import meat, undetermined
from rwjax.fitting.scales import sizes_of
from rwjax.logs.log import Log
from rwjax.methods.identified import Identified, estimated, left_out, undelayed
from rwjax.plant.from_rig import bounds_of, structure_of, theta_of
from rwjax.plant.one_axis import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.shooting import rates_along

WIDTH_S = 0.2
"""Length of the smoothing filter [s]."""
WINDOW_S, STRIDE_S = 0.5, 0.1
"""Length of the test functions and the time from one to the next [s]."""
SLOW = 4.0
"""Speeds below this many times the noise of the smoothed speed count as unknown in sign."""

BODIES = (("psi", "w", "yaw_rad", "yaw_rad_s"), ("theta", "Omega", "wheel_rad", "wheel_rad_s"))


class _Motion:
    """States along one log at equal steps, the measured accelerations, and where the signs of motion are known."""

    def __init__(self, rig: Rig, structure: Structure, log: Log) -> None:
        n = len(log.time)
        self.time = np.linspace(log.time[0], log.time[-1], n)
        self.h = float(self.time[1] - self.time[0])
        held = np.clip(np.searchsorted(log.time, self.time + 1e-9, side="right") - 1, 0, n - 1)
        before = np.clip(held - 1, 0, None)
        self.command = 0.5 * (log.command[before] + log.command[held])  # what acts around a sample, not after it
        width = max(5, 2 * int(WIDTH_S / self.h / 2) + 1)
        simulated = predict(rig, log)
        self.states = {name: np.zeros(n) for name in structure.states}
        self.known = np.ones(n, bool)
        self.acceleration: dict[str, np.ndarray] = {}
        self.source: dict[str, tuple[str, np.ndarray]] = {}
        for angle, rate, angle_name, rate_name in BODIES:
            if angle not in self.states:
                continue
            if angle_name in log.outputs:
                y = self._at(log, log.outputs[angle_name])
                for order, name in enumerate((angle, rate)):
                    self.states[name] = _smoothed(y, width, 3, deriv=order, delta=self.h)
                self.acceleration[rate] = _smoothed(y, width, 3, deriv=2, delta=self.h)
                self.source[rate] = ("angle", y)
                noise = np.std(y - self.states[angle]) / (self.h * width) * 4.0
            elif rate_name in log.outputs:
                y = self._at(log, log.outputs[rate_name])
                self.states[rate] = _smoothed(y, width, 2, delta=self.h)
                self.states[angle] = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * self.h)])
                self.acceleration[rate] = _smoothed(y, width, 2, deriv=1, delta=self.h)
                self.source[rate] = ("rate", y)
                noise = np.std(y - self.states[rate]) / np.sqrt(width)
            else:
                if rate_name in simulated:
                    self.states[rate] = self._at(log, simulated[rate_name])
                continue
            slow = np.abs(self.states[rate]) < SLOW * noise
            self.known &= np.convolve(slow, np.ones(width), mode="same") == 0.0

        if "i" in self.states:
            if "current_A" in log.outputs:
                self.states["i"] = self._at(log, log.outputs["current_A"])
            elif through := next((name for name in rig.effects if name.startswith("drive.")), None):
                raise LogError(f"{log.name}: no `current_A`, which regression needs to estimate {through} (L > 0)")
            else:
                self.states["i"] = _current(rig, self.h, log.command[held], self.states["Omega"])

    def _at(self, log: Log, values: np.ndarray) -> np.ndarray:
        seen = np.isfinite(values)
        return np.interp(self.time, log.time[seen], values[seen])


@partial(jax.jit, static_argnums=0)
def _slopes(structure: Structure, theta, t, states, u):
    """Derivative of `rates_along` by the numbers `(n, s, p)`."""
    return jax.jacfwd(rates_along, argnums=1)(structure, theta, t, states, u)


def _current(rig: Rig, h: float, command: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Current [A] that the motor's voltage equation gives along a known wheel rate, exact for held inputs."""
    n = rig.numbers
    settled = (command - n["motor.torque_constant"] * rate) / n["motor.resistance"]
    keep = np.exp(-h * n["motor.resistance"] / n["motor.inductance"])
    return np.asarray(lfilter([0.0, 1.0 - keep], [1.0, -keep], settled))


def _smoothed(y: np.ndarray, width: int, order: int, *, deriv: int = 0, delta: float) -> np.ndarray:
    return np.asarray(savgol_filter(y, width, order, deriv=deriv, delta=delta))


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


def _strong(m: _Motion, rate: str, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration and what the model says, at the samples whose signs are known."""
    return m.acceleration[rate][m.known], f[m.known]


def _weak(m: _Motion, rate: str, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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


def _regress(rig: Rig, logs: Sequence[Log], form: Callable) -> Identified:
    undelayed(rig, "regression")
    train = to_fit(rig, logs)
    structure = structure_of(rig)
    theta = theta_of(rig, structure)
    free = np.flatnonzero([name in rig.free for name in structure.names])
    size = sizes_of(rig, structure, theta, train)[free]
    motions = [_Motion(_as_run(rig, log), structure, log) for log in train]
    bounds = bounds_of(rig, structure)[free].T / size
    equal = bounds[0] >= bounds[1]
    bounds[1][equal] = np.nextafter(bounds[0][equal], np.inf)
    longest = max(len(m.time) for m in motions)

    def padded(values: np.ndarray) -> np.ndarray:  # one length, so that one program serves all logs
        return np.pad(values, [(0, longest - len(values))] + [(0, 0)] * (values.ndim - 1), mode="edge")

    along = [
        (
            padded(m.time - m.time[0]),
            padded(np.stack([m.states[name] for name in structure.states], axis=1)),
            padded(m.command),
        )
        for m in motions
    ]
    added = [np.array(structure.vector(log.added)) for log in train]

    def full(z: np.ndarray) -> np.ndarray:
        out = theta.copy()
        out[free] = z * size
        return out

    def pieces(z: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        found = []
        for m, motion, plus in zip(motions, along, added, strict=True):
            f = np.asarray(rates_along(structure, full(z) + plus, *motion))[: len(m.time)]
            df = np.asarray(_slopes(structure, full(z) + plus, *motion))[: len(m.time), :, free] * size
            for rate in m.acceleration:
                k = structure.states.index(rate)
                a, model = form(m, rate, f[:, k])
                _, slope = form(m, rate, df[:, k])
                found.append((a - model, -slope))
        return found

    z0 = np.clip(theta[free] / size, bounds[0] + 1e-9, bounds[1] - 1e-9)
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
    spread = inverse @ meat([J[:, None] for _, J in last], [r[:, None] for r, _ in last]) @ inverse
    errors = np.where(undetermined(np.asarray(H)), np.inf, np.sqrt(np.diag(spread)) * size)
    names = [structure.names[k] for k in free]
    return Identified(estimated(rig, names, best.x * size, errors), left_out(rig, prior=False))


def equation_error(rig: Rig, logs: Sequence[Log]) -> Identified:
    """Least squares on filtered accelerations. Raises as `to_fit`, and `LogError` where nothing moves fast enough."""
    return _regress(rig, logs, _strong)


def weak_form(rig: Rig, logs: Sequence[Log]) -> Identified:
    """Least squares on integrals against test functions. Raises as `equation_error`."""
    return _regress(rig, logs, _weak)
