"""From the command to the voltage or torque: static map, then slew limit, lags and supply."""

import numpy as np
from numba import njit

from experiments.blind.truth import GATE, LAG_1, LAG_2, LOAD, PLAY, SLEW

BUS = 12.0  # V, supply without load
SLOT = 0.4  # s, random events begin at multiples of this


@njit
def dead_zone(u, p):
    """Small commands give nothing."""
    size, d = abs(u), p.deadzone
    if d <= 0.0:
        return u
    if p.deadzone_form == 1.0:
        return u if size > d else 0.0
    if p.deadzone_form == 2.0:
        width = 0.15 * d
        return np.sign(u) * width * np.log1p(np.exp(min((size - d) / width, 500.0))) if size > 0.0 else 0.0
    return np.sign(u) * max(size - d, 0.0)


@njit
def curve(u, p):
    """Gain that varies smoothly with the command's size and never changes its sign."""
    c, x = p.curvature, abs(u) / p.curvature_volts
    if c == 0.0 or u == 0.0:
        return u
    if p.curvature_form == 2.0:
        return u * x**c
    bend = abs(c) * (x if p.curvature_form == 0.0 else x * x)
    return u * (1.0 + bend) if c > 0.0 else u / (1.0 + bend)


@njit
def shape(u, p):
    """Voltage for a command: offset, dead zone, curvature, direction, saturation."""
    u = curve(dead_zone(u + p.bias_command, p), p)
    if p.gain_asymmetry != 0.0:
        u *= np.exp(p.gain_asymmetry if u > 0.0 else -p.gain_asymmetry)
    level = p.saturation
    if level > 0.0:
        u = level * np.tanh(u / level) if p.drive_saturation_form == 1.0 else min(max(u, -level), level)
    return u


@njit
def chance(slot, salt, which):
    """A number between 0 and 1 that looks random, the same for the same arguments."""
    value = np.sin(12.9898 * slot + 78.233 * salt + 37.719 * which) * 43758.5453
    return value - np.floor(value)


@njit
def remembering(x, u, t, p):
    """Maps outside the list of effects: hysteresis, a gate with two thresholds, a loose contact."""
    if p.hysteresis > 0.0:
        x[PLAY] = min(max(x[PLAY], u - p.hysteresis_volts), u + p.hysteresis_volts)
        u += (1.0 - np.exp(-p.hysteresis)) * (x[PLAY] - u)
    if p.gate_on > 0.0:
        x[GATE] = 1.0 if abs(u) > p.gate_on else (0.0 if abs(u) < p.gate_off else x[GATE])
        u *= x[GATE]
    if p.loose > 0.0 and chance(np.floor(t / SLOT), p.salt, 1.0) < 0.25:
        u *= np.exp(-p.loose)
    return u


@njit
def follow(x, u, t, h, p):
    """Voltage at the middle of a step of `h` under the held map output `u`; moves the drive's states to its end."""
    u = remembering(x, u, t, p)
    if p.rate_limit > 0.0:
        reach = p.rate_limit * h
        old, u_end = x[SLEW], u
        x[SLEW] = old + min(max(u_end - old, -reach), reach)
        u = old + min(max(u_end - old, -0.5 * reach), 0.5 * reach)
    if p.lag > 0.0:
        half = np.exp(-0.5 * h / p.lag)
        middle = u + (x[LAG_1] - u) * half
        x[LAG_1] = u + (x[LAG_1] - u) * half * half
        u = middle
        if p.lag_2 > 0.0:
            half = np.exp(-0.5 * h / (p.lag * p.lag_2))
            middle = u + (x[LAG_2] - u) * half
            x[LAG_2] = u + (x[LAG_2] - u) * half * half
            u = middle
    if p.kind == 1.0 and p.sag > 0.0:
        load = abs(u)
        if p.sag_form == 1.0:
            x[LOAD] += (load - x[LOAD]) * (1.0 - np.exp(-h / p.sag_time))
            load = x[LOAD]
        u /= 1.0 + p.sag * load
    return u


@njit
def on_supply(v, i, p):
    """Voltage at the motor, of the `v` that the bridge gives without load, while `i` flows."""
    if p.sag == 0.0:
        return v
    if p.sag_form == 0.0:
        return v - p.sag * i
    return v * max(1.0 - p.sag * abs(v * i) / BUS**2, 0.0)
