r"""One hinge of a MuJoCo model, with its actuator, as the numbers of a rig of kind `joint`.

MuJoCo compiles the model. All other joints are held as they stand at `qpos0`. What turns about the hinge is then one body with the inertia
$M_{jj}$ less the armature, and the torque of its weight at the angle $q$ is $-s\sin q - c\cos q$, which two angles tell. An actuator of
fixed gain $g$ and bias $b_0 + b_1 l + b_2\dot l$ with $l = Gq$ makes the torque $G(g a + b_0 + b_1 l + b_2\dot l)$ of its control $a$. With
$b_1 = -g$ that is a servo of torque, $k_p = G^2 g$ and $k_d = -G^2 b_2$; with $b_1 = 0$ and $b_2 < 0$ a motor at a voltage, $K = -b_2 G/g$
and $R = K/(Gg)$; with neither the control is the torque. A `dcmotor` of the constant $K_m$ and the resistance $R$ makes
$G K_m (a - K_m \dot l)/R$ of the voltage $a$, so that $K = G K_m$.
"""

from os import PathLike, fspath
from typing import Any, NamedTuple

import numpy as np

from rwjax.errors import InputError, nearest
from rwjax.methods.known import Known

LEAST = 1e-9
"""Share of the weight of all that turns, at the model's size, below which a torque counts as rounding [1]."""
SLOW = 1e-3
"""Rate at which the damping is read off [rad/s]."""
DIGITS = 6
"""Digits of a number that is worked out from the model."""
OF_MODEL = "of the model"
VOLTAGE = 8
"""What MuJoCo says of an actuator whose one control is a voltage."""


class MujocoJoint(NamedTuple):
    """A hinge of a MuJoCo model.

    Attributes:
        name: Its name.
        numbers: The numbers of the rig file.
        servo: Whether the control is the goal of a servo.
        effects: Effects of the hinge with their numbers [SI].
        notes: What a rig file does not hold or takes otherwise, in sentences.
    """

    name: str
    numbers: dict[str, Known]
    servo: bool
    effects: dict[str, dict[str, float]]
    notes: tuple[str, ...]


def mujoco_joint(path: str | PathLike[str], joint: str | None = None) -> MujocoJoint:
    """A hinge of a MuJoCo model, as a rig file says it.

    Args:
        path: The model, MJCF.
        joint: Name of the hinge; the only one with an actuator where none is given.

    Returns:
        The hinge. Free are its armature, friction and damping, and of a servo whose scale its weight tells also the gains.

    Raises:
        InputError: MuJoCo is not installed or does not read the model, there is no such hinge, or its actuator is of another kind.
    """
    mujoco, where = _mujoco(), fspath(path)
    try:
        model = mujoco.MjModel.from_xml_path(where)
        j = _joint(where, model, joint)
        body = _body(model, j)
    except (ValueError, mujoco.FatalError) as why:  # also for a file that is not there
        raise InputError(f"{where}: MuJoCo does not read it: {' '.join(str(why).split())}") from why
    name = model.joint(j).name
    numbers = {
        "motor.inertia": Known(_rounded(body.armature), f"armature {OF_MODEL}", free=True),
        "axis.inertia": Known(_rounded(body.inertia), f"about the hinge, {OF_MODEL}"),
        "axis.friction.viscous": Known(_rounded(body.damping), f"damping {OF_MODEL}", free=True),
        "axis.friction.coulomb": Known(body.frictionloss, f"frictionloss {OF_MODEL}", free=True),
    }
    weighs = float(np.hypot(body.sine, body.cosine))
    if weighs:
        angle = _rounded(np.arctan2(body.cosine, body.sine))
        numbers["axis.gravity.torque"] = Known(_rounded(weighs), f"weight {OF_MODEL}")
        numbers["axis.gravity.angle"] = Known(angle, f"{OF_MODEL}; 0 hangs down at angle 0")
    driven = _actuator(where, model, j, name, weighs > 0.0)
    springref = float(model.qpos_spring[model.jnt_qposadr[j]])
    fields = {"stiffness": float(model.jnt_stiffness[j]), "springref": springref} | driven.fields
    notes = (*_left_out(model, j, name), *driven.notes)
    return MujocoJoint(name, numbers | driven.numbers, driven.servo, _effects(fields), notes)


def _left_out(model: Any, j: int, name: str) -> list[str]:
    """What of a hinge a rig file does not hold, in sentences."""
    dof, notes = int(model.jnt_dofadr[j]), []
    if model.njnt > 1:
        notes.append(f"what turns about `{name}` is taken with all other joints held as the model begins")
    if model.jnt_limited[j]:
        low, high = model.jnt_range[j]
        notes.append(f"the stops at {low:.4g} and {high:.4g} rad are left out: give logs that do not touch them")
    if model.neq or model.ntendon:
        notes.append("equalities and tendons are left out")
    if model.dof_dampingpoly[dof].any() or model.jnt_stiffnesspoly[j].any():
        notes.append("of damping and stiffness that change with rate or angle the linear part is taken")
    return notes


def _effects(fields: dict[str, float]) -> dict[str, dict[str, float]]:
    """The effects of a hinge and its actuator."""
    from rwjax.effects.library import of_kind  # imports JAX

    found = {name: effect.from_mujoco(fields) for name, effect in of_kind("joint").items()}
    return {name: {key: _rounded(value) for key, value in given.items()} for name, given in found.items() if given}


def _mujoco() -> Any:
    """The package, which only those have who read a model."""
    try:
        import mujoco
    except ImportError as why:
        raise InputError("reading a MuJoCo model needs MuJoCo: pip install mujoco") from why
    return mujoco


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _joint(where: str, model: Any, wanted: str | None) -> int:
    """Number of the hinge."""
    mujoco = _mujoco()
    hinge = int(mujoco.mjtJoint.mjJNT_HINGE)
    hinges = {model.joint(j).name: j for j in range(model.njnt) if model.jnt_type[j] == hinge}
    if wanted in hinges:
        return hinges[wanted]
    if wanted is not None:
        said = f"the nearest is `{nearest(wanted, hinges)}`" if hinges else "it has none"
        raise InputError(f"{where}: no hinge `{wanted}`; {said}")
    driven = [name for name, j in hinges.items() if _of_joint(model, j)[0]]
    if len(driven) != 1:
        names = ", ".join(f"`{name}`" for name in driven or hinges) or "none"
        raise InputError(f"{where}: give --joint, one of its hinges: {names}")
    return hinges[driven[0]]


def _of_joint(model: Any, j: int) -> tuple[list[int], list[int]]:
    """Actuators that act on a joint: those that a control moves, and those of a constant force."""
    mujoco = _mujoco()
    kinds = [int(kind) for kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)]
    of = np.flatnonzero(np.isin(model.actuator_trntype, kinds) & (model.actuator_trnid[:, 0] == j))
    fixed = model.actuator_gaintype == int(mujoco.mjtGain.mjGAIN_FIXED)
    constant = [int(a) for a in of if fixed[a] and model.actuator_gainprm[a, 0] == 0.0]
    return [int(a) for a in of if a not in constant], constant


class _Body(NamedTuple):
    """What turns about a hinge: inertias [kg m²], damping [N m s/rad], dry friction [N m], its weight's sine and cosine [N m]."""

    inertia: float
    armature: float
    damping: float
    frictionloss: float
    sine: float
    cosine: float


def _body(model: Any, j: int) -> _Body:
    """What turns about a hinge, all other joints held. Actuators may add to the armature and the damping; so both are read off the motion."""
    mujoco = _mujoco()
    data, dof, at = mujoco.MjData(model), int(model.jnt_dofadr[j]), int(model.jnt_qposadr[j])

    def torque(angle: float, rate: float = 0.0) -> tuple[float, float]:
        data.qpos[:], data.qvel[:] = model.qpos0, 0.0
        data.qpos[at], data.qvel[dof] = angle, rate
        mujoco.mj_forward(model, data)
        return float(data.qfrc_bias[dof] - data.qfrc_gravcomp[dof]), float(data.qfrc_passive[dof])

    def inertia() -> float:
        mujoco.mj_forward(model, data)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        return float(full[dof, dof])

    still = torque(float(model.qpos0[at]))[1]
    damping = (still - torque(float(model.qpos0[at]), SLOW)[1]) / SLOW
    weight = (torque(0.0)[0], torque(0.5 * np.pi)[0])
    mass = float(model.body_subtreemass[model.jnt_bodyid[j]])
    least = LEAST * mass * float(np.linalg.norm(model.opt.gravity)) * float(model.stat.extent)
    cosine, sine = (0.0 if abs(t) <= least else t for t in weight)
    torque(float(model.qpos0[at]))
    whole, armature = inertia(), (model.dof_armature.copy(), model.actuator_armature.copy())
    model.dof_armature[dof], model.actuator_armature[:] = 0.0, 0.0
    bare = inertia()
    model.dof_armature[:], model.actuator_armature[:] = armature
    return _Body(bare, whole - bare, damping, float(model.dof_frictionloss[dof]), sine, cosine)


class _Driven(NamedTuple):
    """What an actuator adds to a rig file; `fields` are those of `rwjax.export.mujoco_model`."""

    numbers: dict[str, Known]
    servo: bool
    fields: dict[str, float]
    notes: tuple[str, ...]


class _Gains(NamedTuple):
    """A `general` actuator: its torque is `G (g a + b_0 + b_1 l + b_2 l')` with the control `a` and `l = G q`."""

    G: float
    g: float
    b0: float
    b1: float
    b2: float


def _actuator(where: str, model: Any, j: int, name: str, weighs: bool) -> _Driven:
    """The actuator of a hinge."""
    of, constant = _of_joint(model, j)
    if len(of) != 1:
        raise InputError(f"{where}: `{name}` has {len(of) or 'no'} actuators; one hinge with one actuator can be read")
    a = of[0]
    called = f"{where}: the actuator `{model.actuator(a).name}`"
    if _is_dc_motor(model, a):
        found = _dc_motor(called, model, a)
    else:
        gains = _gains(called, model, a)
        found = _servo(called, model, a, gains, weighs) if gains.b1 else _motor(called, model, a, gains)
    torque, notes = 0.0, []
    for other in constant:
        one = _gains(f"{where}: the actuator `{model.actuator(other).name}`", model, other)
        torque += one.G * one.b0
        notes += ["what a constant actuator adds by angle or rate is left out"] if one.b1 or one.b2 else []
    fields = found.fields | {"constant": torque + found.fields.get("constant", 0.0)}
    return found._replace(fields={key: value for key, value in fields.items() if value}, notes=(*found.notes, *notes))


def _gains(called: str, model: Any, a: int) -> _Gains:
    """Gain and bias of an actuator of a kind that a rig file describes."""
    mujoco = _mujoco()
    bias, dynamics = mujoco.mjtBias, mujoco.mjtDyn
    plain = (
        model.actuator_gaintype[a] == int(mujoco.mjtGain.mjGAIN_FIXED)
        and model.actuator_biastype[a] in (int(bias.mjBIAS_NONE), int(bias.mjBIAS_AFFINE))
        and model.actuator_dyntype[a]
        in (int(dynamics.mjDYN_NONE), int(dynamics.mjDYN_FILTER), int(dynamics.mjDYN_FILTEREXACT))
    )
    if not plain:
        raise InputError(
            f"{called} is of a kind that is not read; motor, position, dcmotor at a voltage and general ones with a fixed gain are"
        )
    G, g = _gear(called, model, a), float(model.actuator_gainprm[a, 0])
    affine = bool(model.actuator_biastype[a])
    return _Gains(G, g, *(float(b) if affine else 0.0 for b in model.actuator_biasprm[a, :3]))


def _gear(called: str, model: Any, a: int) -> float:
    """The gear of an actuator."""
    G = float(model.actuator_gear[model.actuator_outadr[a], 0])
    if G == 0.0:
        raise InputError(f"{called} has a gear of 0")
    return G


def _is_dc_motor(model: Any, a: int) -> bool:
    """Whether an actuator is a `dcmotor` whose control is its voltage."""
    mujoco = _mujoco()
    kinds = (model.actuator_gaintype[a], model.actuator_biastype[a], model.actuator_dyntype[a])
    of_one = (mujoco.mjtGain.mjGAIN_DCMOTOR, mujoco.mjtBias.mjBIAS_DCMOTOR, mujoco.mjtDyn.mjDYN_DCMOTOR)
    return kinds == tuple(map(int, of_one)) and int(model.actuator_ctrlspec[a]) == VOLTAGE


def _dc_motor(called: str, model: Any, a: int) -> _Driven:
    """A `dcmotor`, whose control is a voltage."""
    G, (R, K), electrical = _gear(called, model, a), model.actuator_gainprm[a, :2], float(model.actuator_dynprm[a, 0])
    more = (model.actuator_gainprm[a, 2:], model.actuator_biasprm[a], model.actuator_dynprm[a, 1:])
    if any(part.any() for part in more):
        raise InputError(
            f"{called} has more than motorconst, resistance and inductance: heat, cogging, friction of its own, limits or a "
            "controller of a `dcmotor` are not read; leave them out of the model, and name what is missing by `rwjax diagnose`"
        )
    numbers = {
        "motor.torque_constant": Known(_rounded(abs(G) * K), f"motorconst by the gear {OF_MODEL}"),
        "motor.resistance": Known(_rounded(R), f"resistance {OF_MODEL}"),
    }
    if electrical:
        numbers["motor.inductance"] = Known(_rounded(electrical * R), f"inductance {OF_MODEL}")
    control, notes = _range(
        model.actuator_ctrllimited, model.actuator_ctrlrange, int(model.actuator_ctrladr[a]), "control"
    )
    force, of_force = _force_limit(model, a, G)
    notes += of_force + (["the limit of the motor's force is left out"] if force < np.inf else [])
    notes += (
        ["the gear turns the joint against the motor: give the column of the voltage the scale -1"] if G < 0.0 else []
    )
    return _Driven(numbers, False, _late(model, a) | _limit(control), tuple(notes))


def _motor(called: str, model: Any, a: int, of: _Gains) -> _Driven:
    """An actuator whose control is a torque, or with a bias by the rate a voltage."""
    if of.b2 > 0.0 or (of.b2 and of.G * of.g < 0.0):
        raise InputError(f"{called} has a gain and a bias by the rate of signs that no motor has")
    fields, (force, notes) = _late(model, a), _force_limit(model, a, of.G)
    control, more = _range(
        model.actuator_ctrllimited, model.actuator_ctrlrange, int(model.actuator_ctrladr[a]), "control"
    )
    notes += more
    if not of.b2:
        scale = of.G * of.g
        if not np.isclose(scale, 1.0):
            notes.append(
                f"one unit of the control is {scale:.6g} N m: give the column of the command that scale in [columns]"
            )
        limit = min(abs(scale) * control, force)
        return _Driven({}, False, fields | _limit(limit) | {"offset": of.G * of.b0}, tuple(notes))
    K = -of.b2 * of.G / of.g
    notes.append("the control is taken for a voltage: gain and bias are those of a motor at one")
    notes += ["where it is a rate to follow, take that rate for the voltage"] if np.isclose(of.g, -of.b2) else []
    notes += ["the limit of the motor's force is left out"] if force < np.inf else []
    numbers = {
        "motor.torque_constant": Known(_rounded(K), f"gain and bias {OF_MODEL}"),
        "motor.resistance": Known(_rounded(K / (of.G * of.g)), f"gain and bias {OF_MODEL}"),
    }
    return _Driven(numbers, False, fields | _limit(control) | {"offset": of.b0 / of.g}, tuple(notes))


def _servo(called: str, model: Any, a: int, of: _Gains, weighs: bool) -> _Driven:
    """A `position` actuator: a servo that makes torque."""
    if not np.isclose(of.g, -of.b1):
        raise InputError(
            f"{called} has the gain {of.g:g} and the bias {of.b1:g} by the angle; of a servo one is minus the other"
        )
    if of.g < 0.0:
        raise InputError(f"{called} has a negative gain, with which no servo holds its goal")
    known = "known, as without a weight logs tell gains and inertias only by their ratios"
    why = OF_MODEL if weighs else f"{OF_MODEL}; {known}"
    numbers = {
        "drive.servo.kp": Known(_rounded(of.G**2 * of.g), f"kp {why}", free=weighs),
        "drive.servo.kd": Known(_rounded(-(of.G**2) * of.b2) + 0.0, f"kv {why}", free=weighs),
        "drive.servo.period": Known(float(model.opt.timestep), "the model's time step"),
    }
    (force, notes), late = _force_limit(model, a, of.G), _late(model, a)
    if force < np.inf:
        numbers["drive.servo.limit"] = Known(_rounded(force), f"limit of the force {OF_MODEL}")
    if not np.isclose(of.G, 1.0):
        notes.append(
            f"the goal is the control over the gear, {of.G:g}: give the column of the goal that scale in [columns]"
        )
    if model.actuator_ctrllimited[model.actuator_ctrladr[a]]:
        notes.append("the range of the servo's goal is left out: give logs of goals within it")
    if "lag" in late:
        notes.append(f"the actuator's time constant of {late['lag']:g} s is left out: a servo's goal has none")
    fields = {"goal_delay": late.get("delay", 0.0), "constant": of.G * of.b0}
    return _Driven(numbers, True, fields, tuple(notes))


def _limit(value: float) -> dict[str, float]:
    return {"limit": value} if value < np.inf else {}


def _range(limited: Any, bounds: Any, k: int, what: str) -> tuple[float, list[str]]:
    """The larger bound of a range, infinite where there is none, and a note where the other one is smaller."""
    if not limited[k]:
        return np.inf, []
    low, high = (float(bound) for bound in bounds[k])
    note = f"the {what} is limited to {low:g} … {high:g}; the larger bound is taken on both sides"
    return max(-low, high), [] if np.isclose(-low, high) else [note]


def _force_limit(model: Any, a: int, G: float) -> tuple[float, list[str]]:
    """Largest torque of an actuator [N m], by its own range and by its joint's."""
    own, notes = _range(model.actuator_forcelimited, model.actuator_forcerange, a, "force")
    of_joint, more = _range(
        model.jnt_actfrclimited, model.jnt_actfrcrange, int(model.actuator_trnid[a, 0]), "joint's torque"
    )
    return min(abs(G) * own, of_joint), notes + more


def _late(model: Any, a: int) -> dict[str, float]:
    """Delay and time constant of an actuator."""
    dynamics = _mujoco().mjtDyn
    filtered = (int(dynamics.mjDYN_FILTER), int(dynamics.mjDYN_FILTEREXACT))
    lag = float(model.actuator_dynprm[a, 0]) if model.actuator_dyntype[a] in filtered else 0.0
    return {name: value for name, value in (("delay", float(model.actuator_delay[a])), ("lag", lag)) if value}
