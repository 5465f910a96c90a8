"""A newcomer's fit after the tutorials of diffrax ("Forcing terms") and optimistix ("Optimising a parameterised ODE").

Nothing of this library is in it. `python newcomer.py demo|emps FIT.csv … -- HELD_OUT.csv …` fits twice and prints JSON.
"""

import json
import sys
import time

import diffrax as dfx
import jax
import jax.numpy as jnp
import numpy as np
import optimistix as optx

jax.config.update("jax_enable_x64", True)

WIDTH = {"demo": 0.003, "emps": 0.001}  # of the smoothed sign: rad/s (a count a second), m/s
START = {  # what is believed
    "demo": dict(inertia=0.228, viscous=0.082, coulomb=0.3, excess=0.1, v_s=0.2),
    "emps": dict(mass=80.0, viscous=250.0, dry=10.0, bias=0.0),
}


def demo(t, y, args):
    """Platform with Stribeck friction: angle [rad] and rate under a voltage."""
    p, voltage = args
    _, w = y
    level = p["coulomb"] + p["excess"] * jnp.exp(-((jnp.abs(w) / p["v_s"] + 1e-9) ** 1.5))
    friction = level * jnp.tanh(w / WIDTH["demo"]) + p["viscous"] * w
    return jnp.stack([w, (0.428 * voltage(t) - friction) / p["inertia"]])


def emps(t, y, args):
    """Linear axis: position [m] and speed under a motor's force."""
    p, voltage = args
    _, v = y
    friction = p["dry"] * jnp.tanh(v / WIDTH["emps"]) + p["viscous"] * v
    return jnp.stack([v, (35.15065 * voltage(t) + p["bias"] - friction) / p["mass"]])


FIELDS = {"demo": demo, "emps": emps}
SCALE = {"demo": 2.0 * np.pi / 2048, "emps": 1.0}  # of the third column: rad a count, m


def load(case, paths):
    """Times (n,), commands (logs, n) and readings (logs, n) of logs of one length."""
    rows = []
    for path in paths:
        with open(path) as file:
            rows.append(np.loadtxt([line for line in file if line[0].isdigit()], delimiter=",").T)
    t, u, y = np.stack(rows, axis=1)
    return jnp.asarray(t[0] - t[0, 0]), jnp.asarray(u), jnp.asarray(SCALE[case] * y)


def solve(case, p, ts, u, first):
    """Simulated readings of one log that begins at rest; the command is held between samples."""

    def voltage(t):
        return u[jnp.clip(jnp.floor(t / ts[1] + 1e-9).astype(int), 0, len(u) - 1)]

    sol = dfx.diffeqsolve(
        dfx.ODETerm(FIELDS[case]),
        dfx.Tsit5(),
        t0=ts[0],
        t1=ts[-1],
        dt0=None,
        y0=jnp.stack([first, jnp.zeros_like(first)]),
        args=(p, voltage),
        saveat=dfx.SaveAt(ts=ts),
        stepsize_controller=dfx.PIDController(rtol=1e-6, atol=1e-8),
        adjoint=dfx.ForwardMode(),  # Levenberg-Marquardt takes forward-mode derivatives
        max_steps=1_000_000,
    )
    return sol.ys[:, 0]


def residuals(p, args):
    case, ts, u, y = args
    return jax.vmap(lambda u, y: solve(case, p, ts, u, y[0]))(u, y) - y


def fit(case, data):
    """Parameters and their standard errors, as if residuals were white."""
    start = {name: jnp.asarray(v) if name == "bias" else jnp.log(v) for name, v in START[case].items()}

    def numbers(q):  # all but a bias are positive
        return {name: v if name == "bias" else jnp.exp(v) for name, v in q.items()}

    def residual(q, _):
        return residuals(numbers(q), (case, *data))

    sol = optx.least_squares(residual, optx.LevenbergMarquardt(rtol=1e-6, atol=1e-6), start, max_steps=200)
    p = numbers(sol.value)
    columns = jax.jacfwd(lambda p: residuals(p, (case, *data)))(p)
    J = jnp.stack([c.ravel() for c in columns.values()], axis=1)
    errors = jnp.sqrt(jnp.diag(jnp.linalg.inv(J.T @ J)) * jnp.mean(residual(sol.value, None) ** 2))
    return p, dict(zip(columns, errors, strict=True))


def main(case, fitted, held_out):
    fit_jit = jax.jit(lambda data: fit(case, data))
    data, seconds = load(case, fitted), []
    for _ in range(2):  # the first time with compilation
        begin = time.perf_counter()
        p, errors = jax.block_until_ready(fit_jit(data))
        seconds.append(time.perf_counter() - begin)
    answer = {
        "first": seconds[0],
        "warm": seconds[1],
        "numbers": {name: [float(p[name]), float(errors[name])] for name in START[case]},
        "rms": float(jnp.sqrt(jnp.mean(residuals(p, (case, *data)) ** 2))),
        "held_out": float(jnp.sqrt(jnp.mean(residuals(p, (case, *load(case, held_out))) ** 2))),
    }
    print(json.dumps(answer))


if __name__ == "__main__":
    split = sys.argv.index("--")
    main(sys.argv[1], sys.argv[2:split], sys.argv[split + 1 :])
