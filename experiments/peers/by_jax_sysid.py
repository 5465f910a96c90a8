"""jax-sysid: a state-space model with the four terms as its parameters, by Adam and then L-BFGS through the whole run."""

import jax
import jax.numpy as jnp
import numpy as np
from jax_sysid.models import Model

from experiments.peers.problems import Log, Problem

jax.config.update("jax_enable_x64", True)

SAYS = "nothing: the four terms were put in by hand"


def model(p: Problem, h: float) -> Model:
    """The model, stepped by half-implicit Euler."""

    def state(s: jnp.ndarray, u: jnp.ndarray, params: list) -> jnp.ndarray:
        v = s[1] + h * p.acceleration(jnp, s[0], s[1], u, params[0])
        return jnp.array([s[0] + h * v, v])

    found = Model(2, 1, 2, state_fcn=state, output_fcn=lambda s, u, params: s[p.reads : p.reads + 1], Ts=h)
    found.loss(rho_x0=0.0, rho_th=0.0, train_x0=False)
    found.optimization(adam_epochs=200, lbfgs_epochs=500, iprint=-1)
    return found


def fit(p: Problem) -> np.ndarray:
    """The four numbers, in coarser steps."""
    log = p.train.coarser(p.every)
    one = model(p, log.t[1] - log.t[0])
    one.init(params=[np.array([1.0, 1.0, 1.0, 0.0 if p.gain else 1.0])], x0=np.array(p.start(log)))
    one.fit(log.y[:, None], log.u)
    return np.asarray(one.params[0])


def run(p: Problem, z: np.ndarray, log: Log) -> np.ndarray:
    """A free run."""
    one, first = model(p, log.t[1] - log.t[0]), np.array(p.start(log))
    one.init(params=[z], x0=first)
    return np.asarray(one.predict(first, log.u)[0])[:, 0]
