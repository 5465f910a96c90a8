"""Winding and wheel: current, torque per ampere, heat, friction and ripple of the wheel."""

import numpy as np
from numba import njit

from experiments.blind.drive import on_supply
from experiments.blind.truth import AMPERE, HEAT, MEMORY, OMEGA, THETA


@njit
def current(x, v, p):
    """Current: a state, or where there is no inductance what the voltage drives at once."""
    if p.L > 0.0:
        return x[AMPERE]
    series = p.R * (1.0 + x[HEAT]) + (p.sag if p.sag_form == 0.0 else 0.0)
    i = (v - p.K * x[OMEGA]) / series
    if p.current_limit > 0.0:
        i = min(max(i, -p.current_limit), p.current_limit)
    return i


@njit
def current_rate(x, v, p):
    """Rate of the current; above a soft limit the driver takes voltage away (a hard one is in `simulator`)."""
    i, limit = x[AMPERE], p.current_limit
    v = on_supply(v, i, p)
    if limit > 0.0 and p.foldback > 0.0 and abs(i) > limit:
        v -= np.sign(i) * p.foldback * (abs(i) - limit)
    return (v - p.R * (1.0 + x[HEAT]) * i - p.K * x[OMEGA]) / p.L


@njit
def heat_rate(x, i, p):
    """Rate of the winding's relative rise in resistance."""
    if p.heat == 0.0:
        return 0.0
    return p.heat * i * i * p.R * (1.0 + x[HEAT]) - x[HEAT] / p.heat_time


@njit
def motor_torque(i, p):
    """Torque of the motor."""
    if p.saturation_current == 0.0:
        return p.K * i
    x = i / p.saturation_current
    if p.saturation_form == 1.0:
        return p.K * p.saturation_current * np.tanh(x)
    if p.saturation_form == 2.0:
        return p.K * i / np.sqrt(1.0 + x * x)
    return p.K * i / (1.0 + x * x)


@njit
def wheel_losses(x, p):
    """Smooth torques between motor and wheel: viscous, drag, cogging."""
    omega = x[OMEGA]
    torque = p.b * omega
    if p.kind == 0.0 and p.memory > 0.0:
        torque *= 1.0 + p.memory * x[MEMORY]
    if p.wheel_drag != 0.0:
        torque += p.wheel_drag * omega * abs(omega)
    if p.cogging != 0.0:
        angle = p.cogging_order * x[THETA] + p.cogging_phase
        torque += p.cogging * (np.sin(angle) + p.cogging_2 * np.sin(2.0 * angle))
    return torque


@njit
def wheel_level(omega, p):
    """Dry friction of the wheel's bearing."""
    if p.wheel_coulomb == 0.0:
        return 0.0
    return p.wheel_coulomb * (1.0 + p.wheel_breakaway * np.exp(-((omega / 3.0) ** 2)))
