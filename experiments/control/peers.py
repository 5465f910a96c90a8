"""How the same questions are answered today: loops of roots and of python-control, batched eigenvalues, scipy and numba loops."""

import math

import control
import numpy as np
from numba import njit, prange
from scipy.integrate import solve_ivp

from experiments.control.problem import COULOMB, LIMIT, PERIOD, SMOOTH, STATIC, STEPS, V_S, VISCOUS, I, J, K, L, R, b
from rwjax.control.transfer import Transfer

WIDTH = 1e-3  # rad/s, of the smooth sign where a solver needs one
SMOOTH_SIGN, FINE = 3e-3, 1e-3  # rad/s, s: the same for Runge-Kutta steps, which a narrower one makes unstable


def roots_loop(plant: Transfer, kp: np.ndarray, kd: np.ndarray, sigma: float) -> np.ndarray:
    """The thesis's way (listing A.4): `roots` for one pair after the other."""
    den, (gain,) = plant.den, plant.restoring
    found = np.empty(len(kp), bool)
    for k in range(len(kp)):
        found[k] = np.all(np.roots([den[0], den[1], den[2] + gain * kd[k], den[3] + gain * kp[k]]).real < -sigma)
    return found


def control_loop(plant: Transfer, kp: np.ndarray, kd: np.ndarray, sigma: float) -> np.ndarray:
    """python-control: feedback of transfer functions, then its poles."""
    system = control.tf(plant.restoring, plant.den)
    return np.array(
        [
            bool(np.all(control.poles(control.feedback(control.tf([d, p], [1.0]) * system)).real < -sigma))
            for p, d in zip(kp, kd, strict=True)
        ]
    )


def eigenvalues(plant: Transfer, kp: np.ndarray, kd: np.ndarray, sigma: float) -> np.ndarray:
    """numpy's eigenvalues of all companion matrices at once."""
    den, (gain,) = plant.den, plant.restoring
    A = np.zeros((len(kp), 3, 3))
    A[:, 0, 0], A[:, 0, 1], A[:, 0, 2] = -den[1], -(den[2] + gain * kd), -(den[3] + gain * kp)
    A[:, 1, 0] = A[:, 2, 1] = 1.0
    return np.all(np.linalg.eigvals(A).real < -sigma, axis=1)


def scipy_loop(reference: np.ndarray, kp: float, kd: float) -> float:
    """Squared error of one closed loop: `solve_ivp` over every period, the sign of the speed smoothed."""
    x, before, slope, cost = np.zeros(4), reference[0], 0.0, 0.0

    def rates(t: float, x: np.ndarray, u: float) -> list[float]:
        _, w, Omega, i = x
        dry = (COULOMB + (STATIC - COULOMB) * math.exp(-((w / V_S) ** 2))) * math.tanh(w / WIDTH)
        shaft = K * i - b * Omega
        return [w, (-shaft - VISCOUS * w - dry) / I, shaft / J, (u - R * i - K * Omega) / L]

    for wanted in reference:
        error = wanted - x[0]
        slope = (SMOOTH * slope + error - before) / (SMOOTH + PERIOD)
        before = error
        u = -min(max(kp * error + kd * slope, -LIMIT), LIMIT)
        cost += error**2 * PERIOD
        x = solve_ivp(rates, (0.0, PERIOD), x, args=(u,), method="LSODA", rtol=1e-6, atol=1e-9).y[:, -1]
    return cost


@njit(inline="always")
def _level(w: float) -> float:
    return COULOMB + (STATIC - COULOMB) * math.exp(-((w / V_S) ** 2))


@njit(fastmath=True)
def _step(psi, w0, O, i, V, E, P, Q, h):
    l0 = _level(w0)
    f0 = -VISCOUS * w0 + b * O - K * i
    held = min(max(f0, -l0), l0)
    fr0 = l0 if w0 > 0.0 else (-l0 if w0 < 0.0 else held)
    ex0, n0, ni = f0 - held, -fr0 / I, V / L
    ap = psi + E[0, 1] * w0 + E[0, 2] * O + E[0, 3] * i + P[0, 1] * n0 + P[0, 3] * ni
    aw = E[1, 1] * w0 + E[1, 2] * O + E[1, 3] * i + P[1, 1] * n0 + P[1, 3] * ni
    aO = E[2, 2] * O + E[2, 3] * i + P[2, 3] * ni
    ai = E[3, 2] * O + E[3, 3] * i + P[3, 3] * ni
    l1 = _level(aw)
    f1 = -VISCOUS * aw + b * aO - K * ai
    held = min(max(f1, -l1), l1)
    fr1 = l1 if w0 > 0.0 else (-l1 if w0 < 0.0 else held)
    ex1, dn = f1 - held, -(fr1 - fr0) / I
    p1, w1 = ap + Q[0, 1] * dn, aw + Q[1, 1] * dn
    if w0 == 0.0 and ex0 == 0.0:
        if ex1 == 0.0:
            return psi, 0.0, aO, ai
        spare = STATIC - f0 if ex1 > 0.0 else STATIC + f0
        late = spare / (spare + abs(ex1))
        end = (1.0 - late) * w1
        return psi + (1.0 - late) * h * end / 3.0, end, aO, ai
    if w0 * w1 < 0.0:
        swift = h * (f0 - fr0) / I
        bend = w1 - w0 - swift
        sign = 1.0 if w0 > 0.0 else -1.0
        share = 2.0 * w0 / (sign * math.sqrt(swift * swift - 4.0 * bend * w0) - swift)
        f = f0 + share * (f1 - f0)
        middle, net, left = 0.5 * (f + f1), 0.0, (1.0 - share) * h
        if abs(f) > STATIC:
            net = middle - min(max(middle, -STATIC), STATIC)
        turned = left * net / I
        until = share * h * (w0 + share * (swift / 2.0 + share * bend / 3.0))
        return psi + until + 0.5 * left * turned, turned, aO, ai
    return p1, w1, aO, ai


@njit(parallel=True, fastmath=True)
def numba_sweep(reference, kp, kd, E, P, Q):
    """Squared error of every pair: the library's own step, compiled by numba, one loop after the other on all cores."""
    cost = np.empty(len(kp))
    for g in prange(len(kp)):
        psi = w = O = i = total = slope = 0.0
        before = reference[0]
        for k in range(len(reference)):
            error = reference[k] - psi
            slope = (SMOOTH * slope + error - before) / (SMOOTH + PERIOD)
            before = error
            u = -min(max(kp[g] * error + kd[g] * slope, -LIMIT), LIMIT)
            total += error * error * PERIOD
            for _ in range(STEPS):
                psi, w, O, i = _step(psi, w, O, i, u, E, P, Q, PERIOD / STEPS)
        cost[g] = total
    return cost


@njit(inline="always")
def _smooth_rates(w, O, i, u):
    dry = _level(w) * math.tanh(w / SMOOTH_SIGN)
    shaft = K * i - b * O
    return (-shaft - VISCOUS * w - dry) / I, shaft / J, (u - R * i - K * O) / L


@njit(parallel=True, fastmath=True)
def numba_runge_kutta(reference, kp, kd):
    """The same loops as one would write them: Runge-Kutta steps of 1 ms, the sign of the speed smoothed."""
    cost = np.empty(len(kp))
    inner = round(PERIOD / FINE)
    for g in prange(len(kp)):
        psi = w = O = i = total = slope = 0.0
        before, h = reference[0], FINE
        for k in range(len(reference)):
            error = reference[k] - psi
            slope = (SMOOTH * slope + error - before) / (SMOOTH + PERIOD)
            before = error
            u = -min(max(kp[g] * error + kd[g] * slope, -LIMIT), LIMIT)
            total += error * error * PERIOD
            for _ in range(inner):
                a1, b1, c1 = _smooth_rates(w, O, i, u)
                a2, b2, c2 = _smooth_rates(w + 0.5 * h * a1, O + 0.5 * h * b1, i + 0.5 * h * c1, u)
                a3, b3, c3 = _smooth_rates(w + 0.5 * h * a2, O + 0.5 * h * b2, i + 0.5 * h * c2, u)
                a4, b4, c4 = _smooth_rates(w + h * a3, O + h * b3, i + h * c3, u)
                psi += h * (w + h / 6.0 * (a1 + a2 + a3))
                w += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
                O += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
                i += h / 6.0 * (c1 + 2.0 * c2 + 2.0 * c3 + c4)
        cost[g] = total
    return cost
