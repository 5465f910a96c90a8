r"""One hinge of a MuJoCo model, with its actuator, as the numbers of a rig of kind `joint`.

MuJoCo compiles the model. All other joints are held as they stand at `qpos0`. What turns about the hinge is then one body with the inertia
$M_{jj}$ less the armature, and the torque of its weight at the angle $q$ is $-s\sin q - c\cos q$, which two angles tell. An actuator of
fixed gain $g$ and bias $b_0 + b_1 l + b_2\dot l$ with $l = Gq$ makes the torque $G(g a + b_0 + b_1 l + b_2\dot l)$ of its control $a$. With
$b_1 = -g$ that is a servo of torque, $k_p = G^2 g$ and $k_d = -G^2 b_2$; with $b_1 = 0$ and $b_2 < 0$ a motor at a voltage, $K = -b_2 G/g$
and $R = K/(Gg)$; with neither the control is the torque.
"""

from os import PathLike, fspath
from typing import Any, NamedTuple

import numpy as np

from rwjax.errors import InputError, nearest
from rwjax.methods.known import Known

LEAST = 1e-9
"""Share of the largest torque below which one counts as rounding [1]."""
DIGITS = 6
"""Digits of a number that is worked out from the model."""
OF_MODEL = "of the model"


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
        path: The model, MJCF or URDF.
        joint: Name of the hinge; the only one with an actuator where none is given.

    Returns:
        The hinge. Free are its armature, friction and damping, and of a servo whose scale its weight tells also the gains.

    Raises:
        InputError: MuJoCo is not installed or does not read the model, there is no such hinge, or its actuator is of another kind.
    """
    mujoco, where = _mujoco(), fspath(path)
    try:
        model = mujoco.MjModel.from_xml_path(where)
    except ValueError as why:  # also for a file that is not there
        raise InputError(f"{where}: MuJoCo does not read it: {' '.join(str(why).split())}") from why
    j = _joint(where, model, joint)
    name = model.joint(j).name
    dof = int(model.jnt_dofadr[j])
    inertia, sine, cosine = _body(model, j)
    notes = (
        [f"what turns about `{name}` is taken with all other joints held as the model begins"] if model.njnt > 1 else []
    )
    numbers = {
        "motor.inertia": Known(float(model.dof_armature[dof]), f"armature {OF_MODEL}", free=True),
        "axis.inertia": Known(_rounded(inertia), f"about the hinge, {OF_MODEL}"),
        "axis.friction.viscous": Known(_first(model.dof_damping[dof]), f"damping {OF_MODEL}", free=True),
        "axis.friction.coulomb": Known(float(model.dof_frictionloss[dof]), f"frictionloss {OF_MODEL}", free=True),
    }
    weighs = float(np.hypot(sine, cosine))
    if weighs:
        numbers["axis.gravity.torque"] = Known(_rounded(weighs), f"weight {OF_MODEL}")
        numbers["axis.gravity.angle"] = Known(
            _rounded(np.arctan2(cosine, sine)), f"{OF_MODEL}; 0 hangs down at angle 0"
        )
    driven = _actuator(where, model, j, name, weighs > 0.0)
    springref = float(model.qpos_spring[model.jnt_qposadr[j]])
    fields = {"stiffness": _first(model.jnt_stiffness[j]), "springref": springref} | driven.fields
    if model.jnt_limited[j]:
        low, high = model.jnt_range[j]
        notes.append(f"the stops at {low:.4g} and {high:.4g} rad are left out: give logs that do not touch them")
    return MujocoJoint(name, numbers | driven.numbers, driven.servo, _effects(fields), (*notes, *driven.notes))


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


def _first(value: Any) -> float:
    """A coefficient; of a polynomial its slope at 0."""
    return float(np.ravel(value)[0])


def _joint(where: str, model: Any, wanted: str | None) -> int:
    """Number of the hinge."""
    mujoco = _mujoco()
    hinges = {
        model.joint(j).name: j for j in range(model.njnt) if model.jnt_type[j] == int(mujoco.mjtJoint.mjJNT_HINGE)
    }
    if wanted is not None:
        if wanted not in hinges:
            near = nearest(wanted, hinges)
            said = f"the nearest is `{near}`" if near else "it has none"
            raise InputError(f"{where}: no hinge `{wanted}`; {said}")
        return hinges[wanted]
    driven = {model.joint(j).name: j for j in map(int, _driven(model)) if j in hinges.values()}
    if len(driven) != 1:
        names = ", ".join(f"`{name}`" for name in driven or hinges) or "none"
        raise InputError(f"{where}: give --joint, one of its hinges: {names}")
    return next(iter(driven.values()))


def _driven(model: Any) -> np.ndarray:
    """Joints with an actuator of their own that its control moves."""
    return np.unique(model.actuator_trnid[_at_joints(model) & (model.actuator_gainprm != 0.0).any(axis=1), 0])


def _at_joints(model: Any) -> np.ndarray:
    """Which actuators act on a joint."""
    mujoco = _mujoco()
    kinds = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    return np.isin(model.actuator_trntype, [int(kind) for kind in kinds])


def _body(model: Any, j: int) -> tuple[float, float, float]:
    """Inertia about a hinge [kg m²] without the armature, and its weight's torque against sine and cosine of the angle [N m]."""
    mujoco = _mujoco()
    data, dof, at = mujoco.MjData(model), int(model.jnt_dofadr[j]), int(model.jnt_qposadr[j])
    torque = []
    for angle in (0.0, 0.5 * np.pi):
        data.qpos[:] = model.qpos0
        data.qpos[at] = angle
        mujoco.mj_forward(model, data)
        torque.append(float(data.qfrc_bias[dof] - data.qfrc_gravcomp[dof]))
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    cosine, sine = (0.0 if abs(t) <= LEAST * max(map(abs, torque)) else t for t in torque)
    return float(full[dof, dof] - model.dof_armature[dof]), sine, cosine


class _Driven(NamedTuple):
    """What an actuator adds to a rig file; `fields` are those of `rwjax.export.mujoco_model`."""

    numbers: dict[str, Known]
    servo: bool
    fields: dict[str, float]
    notes: tuple[str, ...]


def _actuator(where: str, model: Any, j: int, name: str, weighs: bool) -> _Driven:
    """The actuator of a hinge."""
    mujoco = _mujoco()
    of = [int(a) for a in np.flatnonzero(_at_joints(model) & (model.actuator_trnid[:, 0] == j))]
    constant = [a for a in of if not model.actuator_gainprm[a].any()]
    of = [a for a in of if a not in constant]
    if len(of) != 1:
        raise InputError(f"{where}: `{name}` has {len(of) or 'no'} actuators; one hinge with one actuator can be read")
    a = of[0]
    called = f"{where}: the actuator `{model.actuator(a).name}`"
    plain = (int(mujoco.mjtBias.mjBIAS_NONE), int(mujoco.mjtBias.mjBIAS_AFFINE))
    if model.actuator_gaintype[a] != int(mujoco.mjtGain.mjGAIN_FIXED) or model.actuator_biastype[a] not in plain:
        raise InputError(f"{called} is of a kind that no rig file describes; motor, position and general ones are read")
    G, g = float(model.actuator_gear[a, 0]), float(model.actuator_gainprm[a, 0])
    b0, b1, b2 = (float(b) for b in model.actuator_biasprm[a, :3]) if model.actuator_biastype[a] else (0.0, 0.0, 0.0)
    if b1 and not np.isclose(g, -b1):
        raise InputError(
            f"{called} has the gain {g:g} and the bias {b1:g} by the angle; of a servo one is minus the other"
        )
    if not b1 and (b2 > 0.0 or (b2 and G * g < 0.0)):
        raise InputError(f"{called} has a gain and a bias by the rate of signs that no motor has")
    found = _servo(model, a, G, weighs) if b1 else _motor(model, a, g, G, b2)
    torque = sum(float(model.actuator_gear[c, 0] * model.actuator_biasprm[c, 0]) for c in constant)
    always = {"constant": torque + (G * b0 if b1 else 0.0), "offset": 0.0 if b1 else b0 / g}
    return found._replace(fields={key: value for key, value in (found.fields | always).items() if value})


def _motor(model: Any, a: int, g: float, G: float, b2: float) -> _Driven:
    """An actuator whose control is a torque, or with a bias `b2` by the rate a voltage."""
    fields = _late(model, a)
    if model.actuator_ctrllimited[a]:
        fields["limit"] = float(np.max(np.abs(model.actuator_ctrlrange[a])))
    if not b2:
        scale = f"one unit of the control is {G * g:.6g} N m: give the column of the command that scale in [columns]"
        return _Driven({}, False, fields, () if np.isclose(G * g, 1.0) else (scale,))
    K = -b2 * G / g
    notes = ["the control is taken for a voltage: gain and bias are those of a motor at one"]
    notes += ["where it is a rate to follow, take that rate for the voltage"] if np.isclose(K, 1.0) else []
    numbers = {
        "motor.torque_constant": Known(_rounded(K), f"gain and bias {OF_MODEL}"),
        "motor.resistance": Known(_rounded(K / (G * g)), f"gain and bias {OF_MODEL}"),
    }
    return _Driven(numbers, False, fields, tuple(notes))


def _servo(model: Any, a: int, G: float, weighs: bool) -> _Driven:
    """A `position` actuator: a servo that makes torque."""
    kp, kd = -(G**2) * float(model.actuator_biasprm[a, 1]), -(G**2) * float(model.actuator_biasprm[a, 2])
    why = (
        OF_MODEL
        if weighs
        else f"{OF_MODEL}; known, as without a weight logs tell gains and inertias only by their ratios"
    )
    numbers = {
        "drive.servo.kp": Known(kp, f"kp {why}", free=weighs),
        "drive.servo.kd": Known(kd, f"kv {why}", free=weighs),
        "drive.servo.period": Known(float(model.opt.timestep), "the model's time step"),
    }
    notes, late = [], _late(model, a)
    if not np.isclose(G, 1.0):
        notes.append(
            f"the goal is the control over the gear, {G:g}: give the column of the goal that scale in [columns]"
        )
    if model.actuator_forcelimited[a]:
        low, high = (float(f) for f in model.actuator_forcerange[a])
        numbers["drive.servo.limit"] = Known(abs(G) * max(-low, high), f"forcerange {OF_MODEL}")
        if not np.isclose(-low, high):
            notes.append(f"the force is limited to {low:g} … {high:g}; the larger bound is taken on both sides")
    if "lag" in late:
        notes.append(f"the actuator's time constant of {late['lag']:g} s is left out: a servo's goal has none")
    return _Driven(numbers, True, {"goal_delay": late.get("delay", 0.0)}, tuple(notes))


def _late(model: Any, a: int) -> dict[str, float]:
    """Delay and time constant of an actuator."""
    mujoco = _mujoco()
    filtered = (int(mujoco.mjtDyn.mjDYN_FILTER), int(mujoco.mjtDyn.mjDYN_FILTEREXACT))
    lag = float(model.actuator_dynprm[a, 0]) if model.actuator_dyntype[a] in filtered else 0.0
    return {name: value for name, value in (("delay", float(model.actuator_delay[a])), ("lag", lag)) if value}
