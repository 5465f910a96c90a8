r"""Which side of the motor lacks a torque: the split of total angular momentum of a rig whose wheel and yaw are both read.

The wheel's equation $J\dot\Omega + b\,\Omega + M_w = K i$ holds what is between motor and wheel. The sum of both bodies' equations,
$I\dot w + J\dot\Omega + M_f + M_g = 0$, holds only what acts on the axis from outside: motor, drive and wheel friction cancel in it.

Weak form: with test functions $\varphi$ that vanish at both ends of their support,
$\int\varphi\,I\dot w = -\int\dot\varphi\,I w = \int\ddot\varphi\,I\psi$. No reading is differentiated (Messenger and Bortz, Multiscale
Model. Simul. 19 (2021)). Where the current is read, the wheel's equation takes the reading, and the winding's equation
$L\,di/dt + R i + K\Omega = V$ stands beside it. Elsewhere the current is what the command drives through the winding. Changes that the
free numbers of an equation could make in it are projected out.

Null of each statistic: noise and counts are drawn anew about the smoothed motion. It has to be the motion of the log, since rounding
depends on how fast an encoder turns. Smoothing, and sums in place of integrals, leave something of the rig's own free run without
noise; that is added to every draw.
"""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from rwjax.diagnosis.localise.body_motion import Read
from rwjax.diagnosis.localise.own_noise import above, draws, rates
from rwjax.diagnosis.localise.weak_form import WeakForm
from rwjax.diagnosis.settings import LocalisationSettings, MomentumSettings
from rwjax.effects.library import BY_NAME
from rwjax.effects.ports import AxisDry, AxisTorque, MotorTorque, WheelDry, WheelTorque
from rwjax.fitting.multiple_shooting import Fit
from rwjax.logs.log import Log
from rwjax.plant.assemble import one_axis_plant_of

_PORTS = (AxisTorque, AxisDry, WheelTorque, WheelDry, MotorTorque)
"""Ports of the effects that the rig may have: effects on other ports change readings or command."""


@dataclass(frozen=True)
class Side:
    """The residual of one equation.

    Attributes:
        p: probability of so much by the rig's own noise [1].
        ratio: its weighted square over that noise's [1].
        torque: its RMS beyond that noise [N m], for a winding [V].
    """

    p: float
    ratio: float
    torque: float


@dataclass(frozen=True)
class Momentum:
    """The split of the missing torque.

    Attributes:
        side: external, internal, both or neither.
        external: probability that the axis's equation holds by chance [1].
        internal: the same of the equations of wheel and winding [1].
        length: length of the test functions [s].
        equations: residuals by equation: `axis` (the sum of both bodies), `wheel`, `winding`.
    """

    side: str
    external: float
    internal: float
    length: float
    equations: dict[str, Side]

    def json(self) -> dict:
        """The split as `diagnosis.json` holds it.

        Returns:
            Plain objects.
        """
        return {
            "side": self.side,
            "external_p": self.external,
            "internal_p": self.internal,
            "length_s": self.length,
            "equations": {name: {"p": s.p, "ratio": s.ratio, "rms": s.torque} for name, s in self.equations.items()},
        }


def split(
    fitted: Fit,
    yaw: dict[int, Read],
    wheel: dict[int, Read],
    clean: list[dict[str, np.ndarray]],
    limits: LocalisationSettings,
) -> Momentum | None:
    """Split of the missing torque of the logs that tell both bodies' motion.

    Args:
        fitted: the fit of the rig as it is.
        yaw: motion of the axis by log number.
        wheel: motion of the wheel by log number.
        clean: readings of the rig's own free runs by log and output (time,) [SI].
        limits: limits of the localisation.

    Returns:
        The split, None where it cannot be told.
    """
    structure = fitted.problem.structure
    logs = [k for k in yaw if k in wheel]
    if structure.kind != "reaction" or not logs or any(":" in state for state in structure.states):
        return None
    if structure.command != "voltage" or structure.switched or structure.tied or structure.unsigned:
        return None
    if any(not issubclass(BY_NAME[effect], _PORTS) for effect in structure.effects):
        return None
    length = _length(fitted, logs, yaw, wheel, limits.momentum)
    each = [_Equations.of(fitted, k, (yaw[k], wheel[k]), clean[k], length, limits) for k in logs]
    found = {}
    for name in each[0].names(each):
        if (side := _judge(fitted, name, each, limits.momentum)) is not None:
            found[name] = side
    inner = [found[name].p for name in ("wheel", "winding") if name in found]
    if "axis" not in found or not inner:
        return None
    external, internal = found["axis"].p, min(1.0, len(inner) * min(inner))
    names = {(True, True): "both", (True, False): "external", (False, True): "internal", (False, False): "neither"}
    return Momentum(
        names[external < limits.momentum.level, internal < limits.momentum.level], external, internal, length, found
    )


def _length(
    fitted: Fit, logs: list[int], yaw: dict[int, Read], wheel: dict[int, Read], limits: MomentumSettings
) -> float:
    """Shortest test functions that leave little noise of the torque that turns the wheel."""
    number = dict(zip(fitted.problem.structure.names, fitted.theta, strict=True))
    span = min(np.ptp(fitted.problem.logs[k].time) for k in logs)
    step = max(np.median(np.diff(fitted.problem.logs[k].time)) for k in logs)
    lengths = limits.shortest * np.sqrt(2.0) ** np.arange(limits.lengths)
    possible = [float(s) for s in lengths if 10.0 * step <= s <= span / 6.0] or [float(span / 6.0)]
    for length in possible:
        turns, noise = [], []
        for k in logs:
            weak = WeakForm.of(fitted.problem.logs[k].time, length)
            turns.append(number["wheel.inertia"] * weak.acceleration(wheel[k], slice(0, 1))[:, 0])
            for read, inertia in ((yaw[k], "axis.inertia"), (wheel[k], "wheel.inertia")):
                noise.append(number[inertia] * weak.noise(read, fitted.problem.noise[read.name]))
        if np.sqrt(np.mean(np.concatenate(noise) ** 2)) <= limits.noise * np.sqrt(np.mean(np.concatenate(turns) ** 2)):
            return length
    return possible[-1]


@dataclass(frozen=True)
class _Equations:
    """Weak residuals of one log as functions of the numbers."""

    fitted: Fit
    number: int
    weak: WeakForm
    yaw: Read
    wheel: Read
    current: np.ndarray | None
    told: dict[str, np.ndarray]
    """Test functions of an equation over which all signs of dry friction are known."""
    chunk: int

    @classmethod
    def of(
        cls,
        fitted: Fit,
        number: int,
        bodies: tuple[Read, Read],
        clean: dict,
        length: float,
        limits: LocalisationSettings,
    ) -> "_Equations":
        log, rng, count = fitted.problem.logs[number], np.random.default_rng([number, 2]), 2 * limits.momentum.half
        yaw, wheel = (read.about_itself(fitted, log, clean[read.name], count, rng) for read in bodies)
        weak = WeakForm.of(log.time, length)
        current = None
        if "current_A" in log.outputs:
            seen = np.isfinite(log.outputs["current_A"])
            i = np.interp(log.time, log.time[seen], log.outputs["current_A"][seen])
            own = draws(fitted, log, i, "current_A", count, rng)
            current = np.concatenate([i[:, None], i[:, None], clean["current_A"][:, None], own], axis=1)
        structure = fitted.problem.structure
        dry = {
            structure.states[body.rate] for body, _ in one_axis_plant_of(structure, jnp.asarray(fitted.theta)).bodies()
        }
        creeps: dict[str, np.ndarray] = {}
        for state, read in (("w", yaw), ("Omega", wheel)):
            speed = read.rate[:, [0, 2]]
            slow = np.abs(speed) <= limits.momentum.creeps * np.median(read.deviation[0])
            turns = np.diff(np.sign(speed), append=np.sign(speed[-1:]), axis=0) != 0
            creeps[state] = np.any(slow | turns, axis=1).astype(float) * (state in dry)
        inside = weak.by_order[0]
        told = {
            "axis": np.asarray(inside @ creeps["w"]) == 0.0,
            "wheel": np.asarray(inside @ creeps["Omega"]) == 0.0,
            "winding": np.ones(len(inside.indptr) - 1, bool),
        }
        return cls(fitted, number, weak, yaw, wheel, current, told, limits.chunk)

    @staticmethod
    def names(each: "list[_Equations]") -> tuple[str, ...]:
        """Equations that all logs have."""
        return ("axis", "wheel", "winding") if all(e.current is not None for e in each) else ("axis", "wheel")

    def residual(self, name: str, theta: np.ndarray, columns: slice) -> np.ndarray:
        r"""$\int\varphi\,(\ldots)$ of an equation `(m, …)` for readings (column 0), smoothed motion (1), own run (2) or draws."""
        log, structure = self.fitted.problem.logs[self.number], self.fitted.problem.structure
        number = dict(zip(structure.names, theta + np.array(structure.vector(log.added)), strict=True))
        K, R, L = (number.get(f"motor.{n}", 0.0) for n in ("torque_constant", "resistance", "inductance"))
        I, J = number["axis.inertia"], number["wheel.inertia"]
        held = 0.5 * (log.at_drive + np.append(log.at_drive[:1], log.at_drive[:-1]))[:, None]  # the mean on both sides
        Omega = self.wheel.rate[:, columns]
        value, first, _ = self.weak.by_order
        if name == "winding":
            assert self.current is not None
            i = self.current[:, columns]
            return value @ (R * i + K * Omega - held) - (first @ i) * L
        if self.current is not None:
            i = self.current[:, columns]
        elif L > 0.0:
            i = self._driven(log, Omega, K, R, L)
        else:
            i = (held - K * Omega) / R
        states = {"psi": self.yaw.position(log.time)[:, columns], "w": self.yaw.rate[:, columns]}
        states |= {"theta": self.wheel.position(log.time)[:, columns], "Omega": Omega, "i": i}
        along = rates(self.fitted, log, theta, states, R * i + K * Omega, self.chunk)
        spins = J * self.weak.acceleration(self.wheel, columns)
        if name == "wheel":
            return spins - value @ (J * along["Omega"])
        return I * self.weak.acceleration(self.yaw, columns) + spins - value @ (I * along["w"] + J * along["Omega"])

    def _driven(self, log: Log, Omega: np.ndarray, K: float, R: float, L: float) -> np.ndarray:
        """Current that the held command drives against the back-EMF of a speed `(time, …)`."""
        fitted = self.fitted
        i = np.full(Omega.shape, fitted.start[self.number, fitted.problem.structure.states.index("i")])
        decay = np.exp(-R / L * np.diff(log.time))
        aim = (log.at_drive[:-1, None] - 0.5 * K * (Omega[1:] + Omega[:-1])) / R
        for k in range(len(decay)):
            i[k + 1] = aim[k] + decay[k] * (i[k] - aim[k])
        return i


_ENTER = {
    "axis": ("axis.", "wheel.inertia"),
    "wheel": ("motor.", "wheel."),
    "winding": ("motor.",),
}
"""How the names of the numbers begin that enter each equation."""


def _numbers(fitted: Fit, name: str) -> list[int]:
    """Free numbers that may change an equation; one of those that only scale it as a whole stays."""
    free = [n for n in fitted.free if n.startswith(_ENTER[name])]
    scaled = {"axis": "axis.inertia", "wheel": "motor.torque_constant"}.get(name)
    if scaled in free and "wheel.inertia" in free:
        free.remove("wheel.inertia")
    return [fitted.problem.names.index(n) for n in free]


def _judge(fitted: Fit, name: str, each: list[_Equations], limits: MomentumSettings) -> Side | None:
    """One equation over all logs."""
    told = np.concatenate([e.told[name] for e in each])
    theta = fitted.theta
    numbers = _numbers(fitted, name)
    if told.sum() < max(limits.fewest, 2 * len(numbers)):
        return None

    def over(columns: slice, theta: np.ndarray) -> np.ndarray:
        return np.concatenate([e.residual(name, theta, columns) for e in each])[told]

    every = over(slice(None), theta)
    own = every[:, 3:] - every[:, 1:2] + every[:, 2:3]
    weigh, null = own[:, : limits.half], own[:, limits.half :]
    scale = np.sqrt(np.mean(weigh**2, axis=1))
    scale = np.maximum(scale, 0.5 * np.median(scale) + 1e-300)  # at rest a count tells less than it seems to
    A = np.empty((len(scale), len(numbers)))
    for j, k in enumerate(numbers):
        moved = theta.copy()
        moved[k] += 1e-4 * max(abs(theta[k]), 1e-6)
        A[:, j] = (over(slice(0, 1), moved)[:, 0] - every[:, 0]) / scale
    A /= np.linalg.norm(A, axis=0) + 1e-300
    U, size, _ = np.linalg.svd(A, full_matrices=False)
    U = U[:, size > 1e-6]

    def left(r: np.ndarray) -> np.ndarray:
        return r - U @ (U.T @ r)

    own, found = left(null / scale[:, None]), left(every[:, :1] / scale[:, None])
    null_square, square = np.sum(own**2, axis=0), float(np.sum(found**2))
    beyond = np.mean((found[:, 0] * scale) ** 2) - np.mean((own * scale[:, None]) ** 2)
    return Side(above(square, null_square), square / float(np.mean(null_square)), float(np.sqrt(max(beyond, 0.0))))
