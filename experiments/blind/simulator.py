"""Truth: rigs simulated with exact stick and slip in steps of 0.1 ms; shares no code with `rwjax`.

Order: command maps, delay, motor, torques; sensors are in `cases.py`. A body at rest stays at exactly 0 while the
torque on it is below breakaway; where its speed would change sign the step is cut at the zero crossing of its chord
and the rest of the step decides anew. Midpoint steps of fixed direction in between.
"""

from dataclasses import dataclass, fields

import numpy as np
from numba import njit

STEP = 1e-4  # s
CUTS = 4  # most zero crossings resolved within one step


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
def axis_level(w, p):
    """Dry friction of the axis, sliding either way."""
    if p[EXCESS] == 0.0:
        return p[COULOMB]
    v, n = abs(w) / p[V_S], p[EXPONENT]
    if p[FORM] == 1.0:
        return p[COULOMB] + p[EXCESS] / (1.0 + v * v)
    power = v * v if n == 2.0 else (v if n == 1.0 else v**n)
    return p[COULOMB] + p[EXCESS] * np.exp(-power)


@njit
def wheel_level(omega, p):
    """Dry friction of the wheel's bearing."""
    if p[WHEEL_COULOMB] == 0.0:
        return 0.0
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
        level, skew = axis_level(w, p), p[ASYMMETRY]
        out[1] = (free - friction(s_axis, free, max(level + skew, 0.0), max(level - skew, 0.0))) / p[I]


@njit
def advance(x, u, h, p, k, half):
    """Moves `x` by `h` in midpoint steps, cut where axis or wheel pass through rest; `k`, `half` are scratch."""
    for part in range(CUTS + 1):
        s_axis, s_wheel = np.sign(x[1]), np.sign(x[3])
        rates(x, s_axis, s_wheel, u, p, k)
        sa = s_axis if s_axis != 0.0 else np.sign(k[1])
        sw = s_wheel if s_wheel != 0.0 else np.sign(k[3])
        for j in range(5):
            half[j] = x[j] + 0.5 * h * k[j]
        rates(half, sa, sw, u, p, k)
        if sa == 0.0:
            k[0] = k[1] = 0.0
        if sw == 0.0:
            k[2] = k[3] = 0.0
        w, omega, dry_wheel = x[1], x[3], p[WHEEL_COULOMB] > 0.0
        w_end, omega_end = w + h * k[1], omega + h * k[3]
        cut = 1.0
        if part < CUTS and w * w_end < 0.0:
            cut = w / (w - w_end)
        if part < CUTS and dry_wheel and omega * omega_end < 0.0:
            cut = min(cut, omega / (omega - omega_end))
        for j in range(5):
            x[j] += cut * h * k[j]
        if cut == 1.0:
            return
        if w != 0.0 and abs(x[1]) < 1e-12 + 1e-9 * abs(w):
            x[1] = 0.0
        if omega != 0.0 and dry_wheel and abs(x[3]) < 1e-12 + 1e-9 * abs(omega):
            x[3] = 0.0
        h *= 1.0 - cut


@njit
def simulate(t_command, u_command, t_sample, x0, p, step):
    """(psi, w, theta, omega, i of `x0`, measured current) at `t_sample`; commands hold from their `t_command` on."""
    n = len(t_command)
    v = np.empty(n)
    for k in range(n):
        v[k] = act(u_command[k], p)
    out = np.zeros((len(t_sample), 6))
    slope, half = np.zeros(5), np.empty(5)
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
            advance(x, v[k], h, p, slope, half)
            t += h
        while k + 1 < n and t_command[k + 1] + p[DELAY] <= t + 1e-12:
            k += 1
        out[j, :5] = x
        out[j, 5] = (v[k] - p[K] * x[3]) / p[R] if p[L] == 0.0 else x[4]
    return out
