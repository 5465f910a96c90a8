"""MuJoCo's own `sysid`: one joint whose inertia, damping, frictionloss and offset or gain are parameters, by its least squares."""

import mujoco
import numpy as np
from mujoco import sysid
from mujoco.rollout import rollout

from experiments.peers.problems import Log, Problem

SAYS = "nothing: the four terms were put in by hand"
GRAVITY, ARM = 9.81, 0.1  # m/s², m of the load's mass
XML = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -{gravity}" integrator="implicitfast"><flag contact="disable"/></option>
  <worldbody><body name="body">
    <joint name="x" type="{joint}" axis="{axis}" damping="{c}" frictionloss="{f}"
      solreffriction="{soft} 1" solimpfriction="0.9999 0.9999 0.001 0.5 2"/>
    <inertial pos="0 0 {at}" mass="{mass}" diaginertia="1e-9 1e-9 1e-9"/>
  </body></worldbody>
  <actuator><general name="drive" joint="x" gainprm="{gain}" biastype="affine"/></actuator>
</mujoco>
"""


def spec_of(p: Problem, step: float) -> mujoco.MjSpec:
    """The model before any fit; a pendulum hangs below the hinge and has an armature besides, other rigs are a mass on a slide."""
    joint, axis = ("hinge", "0 1 0") if p.load else ("slide", "1 0 0")
    J, c, f, _ = p.scale
    mass = p.load / (GRAVITY * ARM) if p.load else J
    at = -ARM if p.load else 0.0
    given = dict(step=step, gravity=GRAVITY, joint=joint, axis=axis, c=c, f=f, soft=4.0 * step, at=at, mass=mass)
    return mujoco.MjSpec.from_string(XML.format(gain=p.gain or p.scale[3], **given))


def parameters(p: Problem) -> sysid.ParameterDict:
    """The four numbers, their bounds and how each changes the model."""
    own = p.load / GRAVITY * ARM  # inertia of the load's mass

    def inertia(spec: mujoco.MjSpec, q: sysid.Parameter) -> None:
        if p.load:
            spec.joint("x").armature = max(q.value[0] - own, 0.0)
        else:
            spec.body("body").mass = q.value[0]

    def damping(spec: mujoco.MjSpec, q: sysid.Parameter) -> None:
        spec.joint("x").damping[0] = q.value[0]  # then those of higher powers of the rate

    def frictionloss(spec: mujoco.MjSpec, q: sysid.Parameter) -> None:
        spec.joint("x").frictionloss = q.value[0]

    def last(spec: mujoco.MjSpec, q: sysid.Parameter) -> None:
        if p.gain:
            spec.actuator("drive").biasprm[0] = -q.value[0]
        else:
            spec.actuator("drive").gainprm[0] = q.value[0]

    changes = (inertia, damping, frictionloss, last)
    begin = (1.0, 1.0, 1.0, 0.0 if p.gain else 1.0)
    return sysid.ParameterDict(
        {
            change.__name__: sysid.Parameter(change.__name__, b * size, low * size, high * size, modifier=change)
            for change, b, size, (low, high) in zip(changes, begin, p.scale, p.bounds, strict=True)
        }
    )


def played(p: Problem, spec: mujoco.MjSpec, log: Log) -> np.ndarray:
    """Readings under a command; a servo's voltage is worked out step by step."""
    model = spec.compile()
    data = mujoco.MjData(model)
    x, v = p.start(log)
    if p.kp is None:
        start = sysid.create_initial_state(model, np.array([x]), np.array([v]), np.zeros(0))
        state, _ = rollout(model, data, start, log.u[:-1, :1])
        return np.concatenate([[(x, v)[p.reads]], state[0, :, 1 + p.reads]])  # time, then position and rate
    data.qpos[0], data.qvel[0], found = x, v, [x]
    for u in log.u[:-1]:
        data.ctrl[0] = p.effort(np, data.qpos[0], u)
        mujoco.mj_step(model, data)
        found.append(data.qpos[0])
    return np.array(found)


def fit(p: Problem) -> np.ndarray:
    """The four numbers, in coarser steps."""
    log = p.train.coarser(max(p.every // 5, 1))

    def residual(z: np.ndarray, params: sysid.ParameterDict, **_: object) -> tuple:
        params.update_from_vector(z)
        spec = sysid.apply_param_modifiers_spec(params, spec_of(p, log.t[1] - log.t[0]))
        return [played(p, spec, log) - log.y], None, None

    found, _ = sysid.optimize(parameters(p), residual, optimizer="scipy", verbose=False)
    return found.as_vector()


def run(p: Problem, z: np.ndarray, log: Log) -> np.ndarray:
    """A free run."""
    params = parameters(p)
    params.update_from_vector(z)
    return played(p, sysid.apply_param_modifiers_spec(params, spec_of(p, log.t[1] - log.t[0])), log)
