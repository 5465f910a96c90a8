"""Truth: rigs simulated with exact stick and slip in steps of 0.1 ms, sharing no code and no time stepping with `rwjax`.

Order within a step: command maps, delay, motor, torques. A body at rest stays at rest while the torque on it is below
breakaway; where its speed would change sign the step is cut at the zero crossing (regula falsi on the step's length)
and the rest of the step decides anew. Midpoint steps of fixed direction in between.
"""

from dataclasses import dataclass, fields

import numpy as np
from numba import njit

STEP = 1e-4  # s


@dataclass
class Truth:
    """Numbers of the real rig in SI. Every effect is off at its default."""

    kind: int = 0  # 0 wheel, 1 platform, 2 reaction
    K: float = 0.0182
    R: float = 0.83
    L: float = 0.0641
    b: float = 4.07e-6
    J: float = 1.24e-4
    gain: float = 0.428
    I: float = 0.228
    viscous: float = 0.0
    coulomb: float = 0.0
    excess: float = 0.0  # breakaway above sliding friction
    v_s: float = 0.1
    form: float = 0.0  # of the fall with speed: 0 exp(-(w/v_s)**exponent), 1 Lorentzian
    exponent: float = 2.0
    asymmetry: float = 0.0
    bias_torque: float = 0.0
    wheel_coulomb: float = 0.0
    wheel_breakaway: float = 0.0  # share by which the wheel's breakaway exceeds its sliding friction
    deadzone: float = 0.0
    deadzone_form: float = 0.0  # 0 hard corner, 1 threshold, 2 soft corner
    bias_command: float = 0.0
    delay: float = 0.0

    def array(self) -> np.ndarray:
        """Values in the order of the fields."""
        return np.array([float(getattr(self, f.name)) for f in fields(self)])


NAMES = {f.name: k for k, f in enumerate(fields(Truth))}
(
    KIND, K, R, L, B, J, GAIN, I, VISCOUS, COULOMB, EXCESS, V_S, FORM, EXPONENT, ASYMMETRY, BIAS_TORQUE,
    WHEEL_COULOMB, WHEEL_BREAKAWAY, DEADZONE, DEADZONE_FORM, BIAS_COMMAND, DELAY,
) = range(len(NAMES))  # fmt: skip


@njit
def act(u, p):
    """Voltage for a command: offset, then dead zone."""
    u = u + p[BIAS_COMMAND]
    d = p[DEADZONE]
    if d <= 0.0:
        return u
    size = abs(u)
    if p[DEADZONE_FORM] == 1.0:
        return u if size > d else 0.0
    if p[DEADZONE_FORM] == 2.0:
        width = 0.15 * d
        return np.sign(u) * width * np.log1p(np.exp(min((size - d) / width, 500.0))) if size > 0.0 else 0.0
    return np.sign(u) * max(size - d, 0.0)


@njit
def axis_level(w, s, p):
    """Dry friction of the axis sliding towards `s`."""
    fall = 1.0 / (1.0 + (w / p[V_S]) ** 2) if p[FORM] == 1.0 else np.exp(-((abs(w) / p[V_S]) ** p[EXPONENT]))
    return max(p[COULOMB] + p[EXCESS] * fall + s * p[ASYMMETRY], 0.0)


@njit
def wheel_level(omega, p):
    """Dry friction of the wheel's bearing."""
    return p[WHEEL_COULOMB] * (1.0 + p[WHEEL_BREAKAWAY] * np.exp(-((omega / 3.0) ** 2)))


@njit
def friction(rate, torque, level_forward, level_backward):
    """Dry friction that opposes `rate`, or holds against `torque` at rest."""
    if rate > 0.0:
        return level_forward
    if rate < 0.0:
        return -level_backward
    return min(max(torque, -level_backward), level_forward)


@njit
def rates(x, s_axis, s_wheel, u, p, out):
    """Rates of (psi, w, theta, omega, i); the directions of sliding are given, 0 is at rest."""
    w, omega, i = x[1], x[3], x[4]
    shaft = 0.0
    if p[KIND] != 1.0:
        i_now = (u - p[K] * omega) / p[R] if p[L] == 0.0 else i
        free = p[K] * i_now - p[B] * omega
        level = wheel_level(omega, p)
        shaft = free - friction(s_wheel, free, level, level)
        out[2], out[3] = omega, shaft / p[J]
        out[4] = 0.0 if p[L] == 0.0 else (u - p[R] * i - p[K] * omega) / p[L]
    if p[KIND] != 0.0:
        drive = p[GAIN] * u if p[KIND] == 1.0 else -shaft
        free = drive + p[BIAS_TORQUE] - p[VISCOUS] * w
        out[0] = w
        out[1] = (free - friction(s_axis, free, axis_level(w, 1.0, p), axis_level(w, -1.0, p))) / p[I]


@njit
def advance(x, u, h, p, depth):
    """One midpoint step, cut where the axis or the wheel passes through rest."""
    s_axis, s_wheel = np.sign(x[1]), np.sign(x[3])
    k = np.zeros(5)
    rates(x, s_axis, s_wheel, u, p, k)
    sa = s_axis if s_axis != 0.0 else np.sign(k[1])
    sw = s_wheel if s_wheel != 0.0 else np.sign(k[3])
    half = x + 0.5 * h * k
    rates(half, sa, sw, u, p, k)
    if sa == 0.0:
        k[0] = k[1] = 0.0
    if sw == 0.0:
        k[2] = k[3] = 0.0
    y = x + h * k
    if depth < 4:
        cut = 1.0
        if x[1] * y[1] < 0.0:
            cut = min(cut, x[1] / (x[1] - y[1]))
        if x[3] * y[3] < 0.0 and p[WHEEL_COULOMB] > 0.0:
            cut = min(cut, x[3] / (x[3] - y[3]))
        if cut < 1.0:
            y = x + cut * h * k
            if x[1] != 0.0 and abs(y[1]) < 1e-12 + 1e-9 * abs(x[1]):
                y[1] = 0.0
            if x[3] != 0.0 and p[WHEEL_COULOMB] > 0.0 and abs(y[3]) < 1e-12 + 1e-9 * abs(x[3]):
                y[3] = 0.0
            return advance(y, u, (1.0 - cut) * h, p, depth + 1)
    return y


@njit
def simulate(t_command, u_command, t_sample, x0, p, step):
    """States at `t_sample` (sorted) under the command held from each `t_command` on; the first holds before it."""
    n = len(t_command)
    v = np.empty(n)
    for k in range(n):
        v[k] = act(u_command[k], p)
    out = np.zeros((len(t_sample), 6))
    x, t = x0.copy(), t_sample[0]
    k = 0
    for j in range(len(t_sample)):
        while t < t_sample[j] - 1e-12:
            while k + 1 < n and t_command[k + 1] + p[DELAY] <= t + 1e-12:
                k += 1
            end = t_sample[j]
            if k + 1 < n:
                end = min(end, t_command[k + 1] + p[DELAY])
            h = min(step, end - t)
            x = advance(x, v[k], h, p, 0)
            t += h
        while k + 1 < n and t_command[k + 1] + p[DELAY] <= t + 1e-12:
            k += 1
        out[j, :5] = x
        out[j, 5] = (v[k] - p[K] * x[3]) / p[R] if p[L] == 0.0 else x[4]
    return out
