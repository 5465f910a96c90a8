"""jax-sysid: a state-space model with the four terms as its parameters, by Adam and then L-BFGS through the whole run."""

import jax
import jax.numpy as jnp
import numpy as np
from jax_sysid.models import Model

from experiments.peers.logs import coarser

jax.config.update("jax_enable_x64", True)

GAIN, WIDTH = 35.15065, 2e-3  # N/V, m/s of the smoothed sign
SCALE = np.array([80.0, 250.0, 10.0, 3.0])
SAYS = "nothing: the four terms were put in by hand"


def model(h: float) -> Model:
    """The model, stepped by half-implicit Euler."""

    def state(s: jnp.ndarray, u: jnp.ndarray, params: list) -> jnp.ndarray:
        M, viscous, dry, offset = params[0] * SCALE
        v = s[1] + h * (GAIN * u[0] - viscous * s[1] - dry * jnp.tanh(s[1] / WIDTH) - offset) / M
        return jnp.array([s[0] + h * v, v])

    found = Model(2, 1, 1, state_fcn=state, output_fcn=lambda s, u, params: s[:1], Ts=h)
    found.loss(rho_x0=0.0, rho_th=0.0, train_x0=False)
    found.optimization(adam_epochs=200, lbfgs_epochs=500, iprint=-1)
    return found


def fit(t: np.ndarray, u: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The four terms, in steps of ten samples."""
    t, u, x = coarser(10, t, u, x)
    one = model(t[1] - t[0])
    one.init(params=[np.array([1.0, 1.0, 1.0, 0.0])], x0=np.array([x[0], 0.0]))
    one.fit(x[:, None], u[:, None])
    return np.asarray(one.params[0]) * SCALE


def run(numbers: np.ndarray, t: np.ndarray, u: np.ndarray, first: float) -> np.ndarray:
    """A free run."""
    one = model(t[1] - t[0])
    one.init(params=[numbers / SCALE], x0=np.array([first, 0.0]))
    return np.asarray(one.predict(np.array([first, 0.0]), u[:, None])[0])[:, 0]
