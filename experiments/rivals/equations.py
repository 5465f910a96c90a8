"""What a fitted rig leaves unexplained along the measured motion: accelerations and, where it is read, the current.

A row is one equation of one run under one test function, so that no reading is differentiated twice and the smoothing acts on both sides
alike (weak SINDy: Messenger and Bortz, Multiscale Model. Simul. 19 (2021)). The equations are those of the measured bodies and of the
winding. The current in the equations of motion is the one that the command drives, so that faults of drive and motor show in them; a measured
current stands in an equation of its own. Test functions under which a body rests are left out: what holds it there is not known.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from rwjax import predict
from rwjax.diagnosis.localise.smoother import smoother
from rwjax.diagnosis.localise.weak_form import bump
from rwjax.diagnosis.settings import SmootherSettings
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.methods.measured_motion import BODIES
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.rates import rates_along

LENGTHS_S = (0.4, 0.8, 1.6)
"""Lengths of test functions [s] that are tried: short ones show what is fast, long ones what drowns in the noise of an acceleration."""
OVERLAP = 4
"""Test functions that begin within the length of one [1]."""
SLOW = 3.0
"""Speed, in deviations of the smoothed speed, below which a body may rest [1]."""
REST_S = 0.1
"""Time [s] for which a body has to be slower than its noise to count as resting: less is a reversal."""
STEP = 1e-4
"""Relative step of the differences by which rates are differentiated by numbers."""
LENGTH = 2048
"""Samples to which a run is padded, so that one compiled program serves all."""
Blocks = dict[str, np.ndarray]
"""A value at every sample by equation: the name of a rate [rad/s²], or `i` for the current [A]."""


@dataclass(frozen=True)
class Motion:
    """One run: what moves, what is left, and what a change of each number would do to it.

    Attributes:
        t: Time since the run began `(time,)` [s].
        V: Mean command around each sample `(time,)` [V].
        i: Current that the command drives along the motion `(time,)` [A]; the command itself for a rig without a motor.
        states: States of the plant by name `(time,)` [SI].
        numbers: The fitted rig's numbers [SI].
        kind: Kind of the rig.
        rests: Samples at which the body of an equation rests, by equation `(time,)`.
        source: For each measured rate, whether an "angle" or a "rate" was read, and its readings `(time,)` [SI].
        model: What the rig says of each equation: rates, and the current.
        by_number: Its change with each of the plant's numbers, by name.
        scaled: Its change where the body's reading is too large by a factor, over that factor less 1.
        h: Step [s].
        length: Length of the test functions [s].
    """

    t: np.ndarray
    V: np.ndarray
    i: np.ndarray
    states: Blocks
    numbers: dict[str, float]
    kind: str
    rests: Blocks
    source: dict[str, tuple[str, np.ndarray]]
    model: Blocks
    by_number: dict[str, Blocks]
    scaled: Blocks
    h: float
    length: float = LENGTHS_S[0]

    def _windows(self, equation: str) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the samples under each test function (windows, n), and the places of these in the support (n,) [1]."""
        n = max(5, round(self.length / self.h))
        starts = np.arange(0, len(self.t) - n + 1, max(1, n // OVERLAP))
        index = starts[:, None] + np.arange(n)
        return index[~self.rests[equation][index].any(axis=1)], np.linspace(-1.0, 1.0, n)

    def rows(self, equation: str, value: np.ndarray) -> np.ndarray:
        """Means of a value under the test functions.

        Args:
            equation: The equation.
            value: The value `(time,)`.

        Returns:
            The means (windows,), in the value's unit.
        """
        index, s = self._windows(equation)
        weight = bump(s, (len(s) - 1) * self.h)[0]
        return value[index] @ weight / weight.sum()

    def left(self, equation: str) -> np.ndarray:
        """What the rig leaves of an equation under the test functions.

        Args:
            equation: The equation.

        Returns:
            What is left (windows,) [rad/s²], of the current [A].
        """
        kind, y = self.source[equation]
        index, s = self._windows(equation)
        weight, first, second = bump(s, (len(s) - 1) * self.h)
        if kind == "angle":
            ends = np.linspace(0.0, 1.0, len(s))
            straight = y[index[:, :1]] + (y[index[:, -1:]] - y[index[:, :1]]) * ends
            measured = (y[index] - straight) @ second / weight.sum()
        elif kind == "rate":
            measured = -(y[index] - y[index].mean(axis=1, keepdims=True)) @ first / weight.sum()
        else:
            measured = y[index] @ weight / weight.sum()
        return measured - self.rows(equation, self.model[equation])


def _driven(states: Blocks, V: np.ndarray, held: np.ndarray, numbers: dict[str, float], h: float) -> np.ndarray:
    """Current [A] that a command drives along a motion, by the winding's equation; the command [V] itself without a winding."""
    if "motor.resistance" not in numbers:
        return V
    K, R = numbers["motor.torque_constant"], numbers["motor.resistance"]
    if "i" not in states:
        return (V - K * states["Omega"]) / R
    keep = np.exp(-h * R / numbers["motor.inductance"])
    middle = 0.5 * (states["Omega"] + np.append(states["Omega"][1:], states["Omega"][-1]))
    return np.asarray(lfilter([0.0, 1.0 - keep], [1.0, -keep], (held - K * middle) / R))


def _lasting(slow: np.ndarray, least: int) -> np.ndarray:
    """Samples of a stretch of at least so many."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slow, [False]])))
    found = np.zeros(len(slow), bool)
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        found[begin:end] = end - begin >= least
    return found


@dataclass
class _Read:
    """Smoothed readings of one run."""

    states: Blocks
    source: dict[str, tuple[str, np.ndarray]]
    rests: Blocks


def _read(rig: Rig, structure: Structure, log: Log, h: float) -> _Read:
    """States of the bodies: smoothed where they are read, of the rig's free run from rest where not."""
    noise, found = pooled_noise((log,)), _Read({name: np.zeros(len(log.time)) for name in structure.states}, {}, {})
    for angle, rate, of_angle, of_rate in BODIES:
        if angle not in found.states:
            continue
        name = of_angle if of_angle in log.outputs else of_rate
        if name not in log.outputs:
            found.states[rate] = predict(rig, replace(log, outputs={}))[of_rate]
            continue
        y = log.outputs[name]
        smooth = smoother(y, np.diff(log.time), noise[name], 3 if name == of_angle else 2, SmootherSettings())
        told, seen = smooth(y), np.isfinite(y)
        k = 1 if name == of_angle else 0
        found.states[angle] = told[:, 0] if k else np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * h)])
        found.source[rate] = ("angle" if k else "rate", np.interp(log.time, log.time[seen], y[seen]))
        slow = np.abs(told[:, k]) < SLOW * np.median(smooth.deviation[:, k])
        found.states[rate] = np.where(slow, 0.0, told[:, k])  # where dry friction may hold it
        found.rests[rate] = _lasting(slow, round(REST_S / h))
    return found


class _Rates:
    """Rates of the plant along one motion, padded."""

    def __init__(self, structure: Structure, time: np.ndarray, command: np.ndarray, bodies: tuple[str, ...]) -> None:
        self.structure, self.time, self.command, self.bodies = structure, time, command, bodies

    def __call__(self, theta: np.ndarray, states: Blocks) -> Blocks:
        X = np.stack([states[name] for name in self.structure.states], axis=1)
        n = len(X)
        more = max(LENGTH - n, 0)
        t, X, u = (np.pad(v, [(0, more)] + [(0, 0)] * (v.ndim - 1), mode="edge") for v in (self.time, X, self.command))
        found = np.asarray(rates_along(self.structure, theta, t, X, u))[:n]
        return {name: found[:, self.structure.states.index(name)] for name in self.bodies}


def motion_of(rig: Rig, log: Log) -> Motion:
    """What a fitted rig leaves of one run.

    Args:
        rig: The fitted rig, of one axis and driven by a voltage.
        log: The run, at equal steps.

    Returns:
        The motion with what is left of every equation.
    """
    structure = structure_of(rig)
    theta = theta_of(rig, structure)
    numbers = dict(zip(structure.names, theta, strict=True))
    time, h = log.time - log.time[0], float(np.median(np.diff(log.time)))
    held = log.at_drive
    V = 0.5 * (held + np.append(held[:1], held[:-1]))
    read = _read(rig, structure, log, h)
    states, source, rests = read.states, read.source, read.rests
    i = _driven(states, V, held, numbers, h)
    if "i" in states:
        states["i"] = i
    rates = _Rates(structure, time, V, tuple(source))
    model = rates(theta, states)
    by_number: dict[str, Blocks] = {}
    for k, name in enumerate(structure.names):
        moved = theta.copy()
        step = STEP * max(abs(theta[k]), 1e-3)
        moved[k] += step
        changed = rates(moved, states)
        by_number[name] = {e: (changed[e] - model[e]) / step for e in model}
    body = {"wheel": ("theta", "Omega")}.get(rig.kind, ("psi", "w"))
    larger = rates(theta, {s: x * (1.0 + STEP) if s in body else x for s, x in states.items()})
    # the model's acceleration in place of the measured one, which would be what is left itself
    scaled = {e: model[e] - (larger[e] - model[e]) / STEP for e in model if e in body}
    if "current_A" in log.outputs:
        seen = np.isfinite(log.outputs["current_A"])
        source["i"] = ("value", np.interp(log.time, log.time[seen], log.outputs["current_A"][seen]))
        R = numbers["motor.resistance"]
        # without inductance the current jumps with the command, and a reading tells the current after it
        model["i"] = i if "i" in states else i + (held - V) / R
        rests["i"] = np.zeros(len(i), bool)
        by_number["motor.torque_constant"]["i"] = -states["Omega"] / R
        by_number["motor.resistance"]["i"] = -i / R
    return Motion(time, V, i, states, numbers, rig.kind, rests, source, model, by_number, scaled, h)
