"""Motion along a log at equal steps, smoothed from the readings: what regression takes for the true motion."""

from dataclasses import replace

import numpy as np
from scipy.signal import lfilter, savgol_filter

from rwjax.errors import LogError
from rwjax.fitting.predict import predict
from rwjax.logs.log import Log
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig

WIDTH_S = 0.2
"""Length of the smoothing filter [s]."""
SLOW = 4.0
"""Speed, in units of the smoothed speed's noise, below which its sign counts as unknown [1]."""
BODIES = (("psi", "w", "yaw_rad", "yaw_rad_s"), ("theta", "Omega", "wheel_rad", "wheel_rad_s"))
"""Angle, rate and their columns for each body."""


class MeasuredMotion:
    """States along one log at equal steps, and the measured accelerations.

    Attributes:
        time: Equally spaced times `(time,)` [s].
        h: Their step [s].
        command: Mean command around each time `(time,)` [V].
        on: Whether current can flow at each time `(time,)`; None where it always can.
        states: Each state `(time,)` [SI].
        known: Times at which the sign of every measured rate is known `(time,)`.
        acceleration: Measured acceleration `(time,)` [rad/s²] by the name of the rate.
        source: For each of these rates, whether an "angle" or a "rate" was measured, and its readings `(time,)` [SI].
    """

    def __init__(self, rig: Rig, structure: Structure, log: Log) -> None:
        """Smooths a log's readings.

        Args:
            rig: The rig, whose free run gives a rate that is not measured.
            structure: Its structure.
            log: The log.

        Raises:
            LogError: The current is neither logged nor given by the voltage equation.
        """
        n = len(log.time)
        self.time = np.linspace(log.time[0], log.time[-1], n)
        self.h = float(self.time[1] - self.time[0])
        held = np.clip(np.searchsorted(log.time, self.time + 1e-9, side="right") - 1, 0, n - 1)
        before = np.clip(held - 1, 0, None)
        self.command = 0.5 * (log.command[before] + log.command[held])  # what acts around a sample, not after it
        self.on = log.enabled[held] if structure.switched and log.enabled is not None else None
        self.states = {name: np.zeros(n) for name in structure.states}
        self.known = np.ones(n, bool)
        self.acceleration: dict[str, np.ndarray] = {}
        self.source: dict[str, tuple[str, np.ndarray]] = {}
        for angle, rate, angle_name, rate_name in BODIES:
            if angle not in self.states:
                continue
            if angle_name in log.outputs:
                self._from_angle(angle, rate, self._at(log, log.outputs[angle_name]))
            elif rate_name in log.outputs:
                self._from_rate(angle, rate, self._at(log, log.outputs[rate_name]))
            else:
                self.states[rate] = self._at(log, predict(rig, replace(log, outputs={}, resolution={}))[rate_name])
        self._leave_out_switching()
        if "i" in self.states:
            if "current_A" in log.outputs:
                self.states["i"] = self._at(log, log.outputs["current_A"])
            elif through := next((name for name in rig.effects if name.startswith("drive.")), None):
                raise LogError(f"{log.name}: no `current_A`, which regression needs to estimate {through} (L > 0)")
            else:
                self.states["i"] = self._current(rig, log.input, log.command[held])

    @property
    def _width(self) -> int:
        """Samples of the smoothing filter, an odd number."""
        return max(5, 2 * int(WIDTH_S / self.h / 2) + 1)

    def _from_angle(self, angle: str, rate: str, y: np.ndarray) -> None:
        """States and acceleration of a body whose angle is measured."""
        width = self._width
        for order, name in enumerate((angle, rate)):
            self.states[name] = _smoothed(y, width, 3, deriv=order, delta=self.h)
        self.acceleration[rate] = _smoothed(y, width, 3, deriv=2, delta=self.h)
        self.source[rate] = ("angle", y)
        self._leave_out_slow(rate, np.std(y - self.states[angle]) / (self.h * width) * 4.0)

    def _from_rate(self, angle: str, rate: str, y: np.ndarray) -> None:
        """States and acceleration of a body whose rate is measured."""
        width = self._width
        self.states[rate] = _smoothed(y, width, 2, delta=self.h)
        self.states[angle] = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * self.h)])
        self.acceleration[rate] = _smoothed(y, width, 2, deriv=1, delta=self.h)
        self.source[rate] = ("rate", y)
        self._leave_out_slow(rate, np.std(y - self.states[rate]) / np.sqrt(width))

    def _leave_out_slow(self, rate: str, noise: float | np.floating) -> None:
        """Marks the samples as unknown at which a body is slower than its noise [rad/s], and their neighbours."""
        slow = np.abs(self.states[rate]) < SLOW * noise
        self.known &= np.convolve(slow, np.ones(self._width), mode="same") == 0.0

    def _leave_out_switching(self) -> None:
        """Marks the samples as unknown that smoothing takes together with one at which torque went on or off."""
        if self.on is not None:
            switches = np.diff(self.on, prepend=self.on[:1])
            self.known &= np.convolve(switches, np.ones(self._width), mode="same") == 0.0

    def _current(self, rig: Rig, given: str, command: np.ndarray) -> np.ndarray:
        """Current [A] that the motor's voltage equation gives along a known motion, exact for held inputs; none without torque.

        A joint's rate changes so much within a step that it counts as straight there, and its current as the mean around a sample;
        where torque goes on and off a wheel's does, too.
        """
        n = rig.numbers
        K, R, L = n["motor.torque_constant"], n["motor.resistance"], n["motor.inductance"]
        volts = command * n["drive.supply"] if given == "duty" else command
        keep = np.exp(-self.h * R / L)
        if "Omega" in self.states and self.on is None:
            return np.asarray(lfilter([0.0, 1.0 - keep], [1.0, -keep], (volts - K * self.states["Omega"]) / R))
        lost = K * (self.states["Omega"] if "Omega" in self.states else n.get("gear.ratio", 1.0) * self.states["w"])
        late = (1.0 - keep) * L / (R * self.h)
        found = np.zeros(len(lost))
        on = np.ones(len(lost), bool) if self.on is None else self.on
        edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]])))
        for part in (
            slice(first, last) for first, last in zip(edges[::2], edges[1::2], strict=True) if last > first + 1
        ):
            V, emf = volts[part], lost[part]
            i = np.asarray(lfilter([0.0, 1.0 - keep], [1.0, -keep], V / R))
            i -= np.asarray(lfilter([1.0 - late, late - keep], [1.0, -keep], emf / R))
            mean = (V[:-1] - 0.5 * (emf[1:] + emf[:-1]) - L * np.diff(i) / self.h) / R
            found[part] = 0.5 * (np.append(mean[0], mean) + np.append(mean, mean[-1]))
        return found

    def _at(self, log: Log, values: np.ndarray) -> np.ndarray:
        """Values of a log at the equal times."""
        seen = np.isfinite(values)
        return np.interp(self.time, log.time[seen], values[seen])


def _smoothed(y: np.ndarray, width: int, order: int, *, deriv: int = 0, delta: float) -> np.ndarray:
    """Savitzky-Golay filter, or a derivative of it; `LogError` for a log that is shorter than the filter."""
    if len(y) < width:
        raise LogError(f"{len(y)} samples are too few for a regression, which smooths over {width}; give a longer log")
    return np.asarray(savgol_filter(y, width, order, deriv=deriv, delta=delta))
