"""A testbed with two axes as rigid bodies in MuJoCo, and the numbers of the rig file that describes the same thing.

MuJoCo (Todorov, Erez and Tassa, IROS 2012) knows nothing of the library's equations: it gets masses, places and tensors and works
out the motion by its own recursions. Dry friction and stops are left out, which MuJoCo softens.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from rwjax.rig.model import Rig

G = 9.81  # m/s2
K, R = 0.0182, 0.83  # of both motors [N m/A, ohm]


@dataclass(frozen=True)
class Lump:
    """A rigid body: mass [kg], place of its centre from where both axes meet [m], tensor about its centre [kg m2]."""

    mass: float
    at: tuple[float, float, float]
    tensor: np.ndarray

    def about_origin(self) -> np.ndarray:
        """Tensor about the point where both axes meet."""
        x = np.array(self.at)
        return self.tensor + self.mass * (x @ x * np.eye(3) - np.outer(x, x))


@dataclass(frozen=True)
class Testbed:
    """The bodies; `J`: inertia of the wheels about their axes, which their tensors hold, too; `tilts`: whether the pitch body
    carries wheel 1."""

    yaw: Lump
    pitch: Lump
    wheels: tuple[Lump, Lump]
    J: tuple[float, float]
    viscous: tuple[float, float]  # N m s/rad of yaw and of pitch
    tilts: bool

    def rig(self) -> Rig:
        """The rig file with the same masses."""
        own = [wheel.about_origin() for wheel in self.wheels]
        own[0][2, 2] -= self.J[0]
        own[1][1, 1] -= self.J[1]
        tilting = [self.pitch, self.wheels[1], *([self.wheels[0]] if self.tilts else [])]
        body = self.pitch.about_origin() + own[1] + (own[0] if self.tilts else 0.0)
        level = self.yaw.about_origin()[2, 2] + (0.0 if self.tilts else own[0][2, 2])
        centre = sum(lump.mass * np.array(lump.at) for lump in tilting)
        n = {
            "yaw.inertia": level + body[2, 2],
            "pitch.inertia": body[1, 1],
            "pitch.gravity.torque": G * np.hypot(centre[0], centre[2]),
            "pitch.gravity.angle": np.arctan2(-centre[0], -centre[2]),
            "gimbal.difference": body[0, 0] - body[2, 2],
            "gimbal.product_xy": -body[0, 1],
            "gimbal.product_xz": -body[0, 2],
            "gimbal.product_yz": -body[1, 2],
            "yaw.friction.viscous": self.viscous[0],
            "pitch.friction.viscous": self.viscous[1],
        }
        for k in (1, 2):
            n |= {f"wheel_{k}.inertia": self.J[k - 1], f"motor_{k}.torque_constant": K, f"motor_{k}.resistance": R}
        numbers = {name: float(value) for name, value in n.items()}
        return Rig("two_axis", "rigid", numbers, effects={"wheel_1.gyroscopic": {"s": float(self.tilts)}})

    def model(self, step: float) -> mujoco.MjModel:
        """The same bodies in MuJoCo."""
        first, second = (
            f'<body name="wheel_{k + 1}" pos="{_written(self.wheels[k].at)}">{_joint(f"wheel_{k + 1}", axis, K * K / R)}'
            f"{_inertial(replace(self.wheels[k], at=(0.0, 0.0, 0.0)))}</body>"
            for k, axis in enumerate(("0 0 1", "0 1 0"))
        )
        pitch = f'<body name="pitch">{_joint("pitch", "0 1 0", self.viscous[1])}{_inertial(self.pitch)}'
        pitch += f"{second}{first if self.tilts else ''}</body>"
        yaw = f'<body name="yaw">{_joint("yaw", "0 0 1", self.viscous[0])}{_inertial(self.yaw)}{pitch}'
        yaw += f"{'' if self.tilts else first}</body>"
        motors = "".join(f'<motor joint="wheel_{k}" gear="{K / R!r}"/>' for k in (1, 2))
        return mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{step!r}" integrator="RK4" gravity="0 0 {-G!r}"/>'
            f"<worldbody>{yaw}</worldbody><actuator>{motors}</actuator></mujoco>"
        )


def _joint(name: str, axis: str, damping: float) -> str:
    return f'<joint name="{name}" type="hinge" axis="{axis}" damping="{damping!r}"/>'


def _inertial(lump: Lump) -> str:
    t = [lump.tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return f'<inertial pos="{_written(lump.at)}" mass="{lump.mass!r}" fullinertia="{_written(t)}"/>'


def _written(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def _ring(mass: float, J: float, axis: int, at: tuple[float, float, float]) -> Lump:
    tensor = np.eye(3) * 0.55 * J
    tensor[axis, axis] = J
    return Lump(mass, at, tensor)


def lopsided(tilts: bool = True) -> Testbed:
    """A testbed whose bodies share no plane of symmetry."""
    frame = Lump(0.8, (0.01, -0.02, -0.1), np.diag([0.004, 0.004, 0.006]))
    body = Lump(0.6, (0.03, 0.02, -0.02), np.array([[0.006, 2e-4, -5e-4], [2e-4, 0.009, 3e-4], [-5e-4, 3e-4, 0.011]]))
    wheels = _ring(0.15, 2.4e-4, 2, (0.12, 0.0, 0.03)), _ring(0.12, 1.24e-4, 1, (-0.1, 0.07, 0.0))
    return Testbed(frame, body, wheels, (2.4e-4, 1.24e-4), (0.003, 0.002), tilts)


NAMES = {
    "yaw": ("psi_1", "w_1"),
    "pitch": ("psi_2", "w_2"),
    "wheel_1": ("theta_1", "Omega_1"),
    "wheel_2": ("theta_2", "Omega_2"),
}


def simulate(bed: Testbed, start: dict[str, float], u: np.ndarray, every: float, step: float) -> dict[str, np.ndarray]:
    """States `(n + 1,)` by the library's names under voltages `u` (n, 2), each held for `every` seconds."""
    model = bed.model(step)
    data = mujoco.MjData(model)
    place = {name: model.joint(name).qposadr[0] for name in NAMES}
    for name, (angle, rate) in NAMES.items():
        data.qpos[place[name]], data.qvel[place[name]] = start.get(angle, 0.0), start.get(rate, 0.0)
    found = []
    for command in (*u, None):
        found.append(np.concatenate([data.qpos, data.qvel]))
        if command is not None:
            data.ctrl[:] = command
            mujoco.mj_step(model, data, nstep=round(every / step))
    states, n = np.array(found).T, len(place)
    both = {name: (states[k], states[n + k]) for name, k in place.items()}
    return {state: both[name][j] for name, pair in NAMES.items() for j, state in enumerate(pair)}
