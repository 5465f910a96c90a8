"""MuJoCo's own `sysid`: a slide joint whose mass, damping, frictionloss and constant force are parameters, by its least squares."""

import mujoco
import numpy as np
from mujoco import sysid
from mujoco.rollout import rollout

from experiments.peers.logs import coarser

GAIN = 35.15065  # N/V
SAYS = "nothing: the four terms were put in by hand"
XML = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="implicitfast"><flag contact="disable"/></option>
  <worldbody><body name="carriage">
    <joint name="x" type="slide" axis="1 0 0" damping="250" frictionloss="10" solreffriction="{soft} 1"
      solimpfriction="0.9999 0.9999 0.001 0.5 2"/>
    <inertial pos="0 0 0" mass="80" diaginertia="1 1 1"/>
  </body></worldbody>
  <actuator><general name="drive" joint="x" gainprm="{gain}" biastype="affine"/></actuator>
</mujoco>
"""


def spec_of(step: float) -> mujoco.MjSpec:
    """The model before any fit."""
    return mujoco.MjSpec.from_string(XML.format(step=step, soft=4.0 * step, gain=GAIN))


def parameters() -> sysid.ParameterDict:
    """The four terms, their bounds and how each changes the model."""

    def damping(spec: mujoco.MjSpec, p: sysid.Parameter) -> None:
        spec.joint("x").damping[0] = p.value[0]  # then those of higher powers of the rate

    def frictionloss(spec: mujoco.MjSpec, p: sysid.Parameter) -> None:
        spec.joint("x").frictionloss = p.value[0]

    def mass(spec: mujoco.MjSpec, p: sysid.Parameter) -> None:
        spec.body("carriage").mass = p.value[0]

    def offset(spec: mujoco.MjSpec, p: sysid.Parameter) -> None:
        spec.actuator("drive").biasprm[0] = p.value[0]

    given = {"mass": (80.0, 20.0, 300.0, mass), "damping": (250.0, 0.0, 1e3, damping)}
    given |= {"frictionloss": (10.0, 0.0, 100.0, frictionloss), "offset": (0.0, -20.0, 20.0, offset)}
    return sysid.ParameterDict(
        {n: sysid.Parameter(n, v, low, high, modifier=change) for n, (v, low, high, change) in given.items()}
    )


def played(spec: mujoco.MjSpec, u: np.ndarray, first: float) -> np.ndarray:
    """Positions under a command."""
    model = spec.compile()
    data = mujoco.MjData(model)
    start = sysid.create_initial_state(model, np.array([first]), np.zeros(1), np.zeros(0))
    state, _ = rollout(model, data, start, u[:-1, None])
    return np.concatenate([[first], state[0, :, 1]])  # time, then the position


def fit(t: np.ndarray, u: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The four terms, in steps of two samples."""
    t, u, x = coarser(2, t, u, x)
    step = t[1] - t[0]

    def residual(z: np.ndarray, params: sysid.ParameterDict, **_: object) -> tuple:
        params.update_from_vector(z)
        spec = sysid.apply_param_modifiers_spec(params, spec_of(step))
        return [played(spec, u, x[0]) - x], None, None

    found, _ = sysid.optimize(parameters(), residual, optimizer="scipy", verbose=False)
    return found.as_vector()


def run(numbers: np.ndarray, t: np.ndarray, u: np.ndarray, first: float) -> np.ndarray:
    """A free run."""
    params = parameters()
    params.update_from_vector(numbers)
    return played(sysid.apply_param_modifiers_spec(params, spec_of(t[1] - t[0])), u, first)
