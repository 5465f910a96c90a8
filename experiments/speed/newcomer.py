"""The way of a newcomer to JAX: diffrax with an adaptive step, optimistix, a smoothed sign, the whole log in one solve.

`python -m experiments.speed.newcomer ADJOINT` tries one of diffrax's adjoints (`default`, `forward`) and prints JSON; it runs
in a process of its own under a time limit.
"""

import json
import sys
import time

import rwjax.setup_jax  # noqa: F401  (float64)

import diffrax as dfx  # isort: skip
import jax
import jax.numpy as jnp
import optimistix as optx

from experiments.speed.problem import TICK, TRUTH, arrays, log

WIDTH = 0.03  # rad/s, of the smoothed sign
ADJOINTS = {"default": {}, "forward": {"adjoint": dfx.ForwardMode()}}


def main(adjoint: str) -> None:
    """Fits once, compilation included, and prints what came of it."""
    a = arrays(log())
    t = jnp.arange(len(a.command)) * TICK
    command, reading, weight = (jnp.asarray(v) for v in (a.command, a.reading, a.weight))

    def rates(time, x, p):
        u = command[jnp.clip((time / TICK).astype(int), 0, len(command) - 1)]
        return jnp.stack([x[1], (TRUTH.gain * u - p[1] * x[1] - p[2] * jnp.tanh(x[1] / WIDTH)) / p[0]])

    def residual(z, _):
        run = dfx.diffeqsolve(
            dfx.ODETerm(rates), dfx.Tsit5(), t[0], t[-1], None, z[3:], args=jnp.exp(z[:3]), saveat=dfx.SaveAt(ts=t),
            stepsize_controller=dfx.PIDController(rtol=1e-6, atol=1e-8), max_steps=16**4, **ADJOINTS[adjoint],
        )  # fmt: skip
        return weight * (run.ys[:, 0] - reading)

    z0 = jnp.concatenate([jnp.log(jnp.asarray(a.believed)), jnp.asarray(a.first)])
    solver = optx.LevenbergMarquardt(rtol=1e-6, atol=1e-6)
    begin = time.perf_counter()
    found = optx.least_squares(residual, solver, z0, max_steps=60, throw=False)
    z = jax.block_until_ready(found.value)
    spent = time.perf_counter() - begin
    cost = 0.5 * float(jnp.sum(residual(z, None) ** 2))
    answer = {"time": spent, "numbers": jnp.exp(z[:3]).tolist(), "cost": cost, "steps": int(found.stats["num_steps"])}
    print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
