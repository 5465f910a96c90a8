"""Rigs without anything missing: their true numbers, what the rig file models and estimates, what they log."""

import json
from dataclasses import dataclass, replace

import numpy as np

from experiments.blind.sensors import Sensors
from experiments.blind.truth import Truth

KINDS = ("wheel", "platform", "reaction")
COUNTS = (256, 512, 1024, 2048, 4096)
MOTOR = ("motor.torque_constant", "motor.resistance", "motor.inductance", "motor.friction", "wheel.inertia")
FIELD = {
    "motor.torque_constant": "K",
    "motor.resistance": "R",
    "motor.inductance": "L",
    "motor.friction": "b",
    "wheel.inertia": "J",
    "drive.gain": "gain",
    "axis.inertia": "I",
    "axis.friction.viscous": "viscous",
    "axis.friction.coulomb": "coulomb",
    "axis.gravity.torque": "gravity",
    "axis.gravity.angle": "gravity_angle",
}
STATIC = ("axis.friction.static", "axis.friction.stribeck_velocity")


@dataclass(frozen=True)
class Rig:
    """A rig: its truth, the numbers that its file holds, and those of them that a fit estimates."""

    kind: str
    truth: Truth
    names: tuple[str, ...]
    free: tuple[str, ...]
    top: float  # V, largest command
    sensors: Sensors


def number(truth: Truth, name: str) -> float:
    """Value of a number of the rig file."""
    if name == "axis.friction.static":
        return truth.coulomb + truth.excess
    return getattr(truth, "v_s" if name == "axis.friction.stribeck_velocity" else FIELD[name])


def with_number(truth: Truth, name: str, value: float) -> Truth:
    """Truth with a number of the rig file at `value`; the breakaway stays where the sliding friction moves."""
    if name == "axis.friction.static":
        return replace(truth, excess=max(value - truth.coulomb, 0.0))
    if name == "axis.friction.coulomb" and truth.excess > 0.0:
        return replace(truth, coulomb=value, excess=max(truth.coulomb + truth.excess - value, 0.0))
    return replace(truth, **{"v_s" if name == "axis.friction.stribeck_velocity" else FIELD[name]: value})


@dataclass(frozen=True)
class Wishes:
    """What an effect asks of the rig that is to show it."""

    models: tuple[str, ...] = ()  # numbers that the rig file must hold
    lacks: tuple[str, ...] = ()  # and those that neither file nor base may hold
    fixed: tuple[str, ...] = ()  # numbers that must not be estimated
    slow: bool = False  # few turns rather than many
    logs: tuple[str, ...] = ()  # kinds of command, one of which must be among the runs
    columns: tuple[str, ...] = ()  # columns that must be logged
    inductance: bool = False

    def __or__(self, other: "Wishes") -> "Wishes":
        return Wishes(
            models=self.models + other.models,
            lacks=self.lacks + other.lacks,
            fixed=self.fixed + other.fixed,
            slow=self.slow or other.slow,
            logs=self.logs + other.logs,
            columns=self.columns + other.columns,
            inductance=self.inductance or other.inductance,
        )


def near(value: float, factor: float, rng: np.random.Generator) -> float:
    """A value within a factor of another."""
    return float(value * np.exp(rng.uniform(-np.log(factor), np.log(factor))))


def draw_rig(kind: str, wishes: Wishes, rng: np.random.Generator) -> Rig:
    """A random rig of a kind."""
    truth = Truth(
        kind=KINDS.index(kind),
        K=near(0.0182, 1.15, rng),
        R=near(0.83, 1.2, rng),
        L=near(0.0641, 1.5, rng),
        b=near(4.07e-6, 1.5, rng),
        J=near(1.24e-4, 1.3, rng),
        gain=near(0.428, 1.2, rng),
    )
    if rng.random() < 0.15 and not wishes.inductance:
        truth = replace(truth, L=0.0)
    names = MOTOR if kind == "wheel" else (("drive.gain", "axis.inertia") if kind == "platform" else MOTOR)
    if kind == "reaction":
        names = (*names, "axis.inertia")
    if kind != "wheel":
        truth, terms = _axis(kind, truth, wishes, rng)
        names = names + terms
    if truth.L == 0.0:
        names = tuple(name for name in names if name != "motor.inductance")
    top = {"wheel": (4.0, 9.0), "platform": (2.5, 6.0), "reaction": (4.0, 9.0)}[kind]
    if wishes.slow and kind == "platform":
        top = (1.5, 3.0)
    free = _free(kind, names, wishes, rng)
    return Rig(kind, truth, names, free, float(rng.uniform(*top)), _sensors(kind, wishes, rng))


def _axis(kind: str, truth: Truth, wishes: Wishes, rng: np.random.Generator) -> tuple[Truth, tuple[str, ...]]:
    """Inertia, friction and gravity of the axis, and which of them the rig file models."""
    platform = kind == "platform"
    truth = replace(truth, I=near(0.228 if platform else 0.06, 1.5, rng))
    viscous, coulomb, gravity = (near(v, 2.0, rng) for v in ((0.06, 0.15, 0.12) if platform else (0.006, 0.012, 0.02)))
    with_coulomb, with_static, with_gravity = rng.random(3) < (0.6, 0.2, 0.25)
    excess, v_s = coulomb * rng.uniform(0.3, 0.9), rng.uniform(0.1, 0.4)
    angle = rng.uniform(-np.pi, np.pi)

    def holds(name: str, chosen: bool) -> bool:
        return name not in wishes.lacks and (bool(chosen) or name in wishes.models)

    terms = []
    if holds("axis.friction.viscous", True):
        truth, terms = replace(truth, viscous=viscous), [*terms, "axis.friction.viscous"]
    if holds("axis.friction.coulomb", with_coulomb):
        truth, terms = replace(truth, coulomb=coulomb), [*terms, "axis.friction.coulomb"]
        if holds("axis.friction.static", with_static):
            truth, terms = replace(truth, excess=float(excess), v_s=float(v_s)), [*terms, *STATIC]
    if holds("axis.gravity.torque", with_gravity):
        truth = replace(truth, gravity=gravity, gravity_angle=float(angle))
        terms += ["axis.gravity.torque", "axis.gravity.angle"]
    return truth, tuple(terms)


def _free(kind: str, names: tuple[str, ...], wishes: Wishes, rng: np.random.Generator) -> tuple[str, ...]:
    """Numbers that a fit estimates: mostly the body's inertia and its friction, now and then fewer or more."""
    if kind == "wheel":
        choice = [("wheel.inertia", "motor.friction"), ("motor.friction",), ("wheel.inertia",)]
        free = choice[int(rng.choice(3, p=[0.7, 0.15, 0.15]))]
    else:
        free = ("axis.inertia", *(n for n in names if n.startswith("axis.friction")))
        if rng.random() < 0.15:
            free = free[1:] or free
        if "axis.gravity.torque" in names and rng.random() < 0.6:
            free = (*free, "axis.gravity.torque", "axis.gravity.angle")
    kept = tuple(name for name in free if name not in wishes.fixed)
    spare = [n for n in ("axis.inertia", "motor.friction", "wheel.inertia") if n in names and n not in wishes.fixed]
    return kept or tuple(spare[:1])


def _sensors(kind: str, wishes: Wishes, rng: np.random.Generator) -> Sensors:
    noise, counts = {}, {}
    yaw, rate, wheel, current = (rng.uniform(*r) for r in ((0.0005, 0.008), (0.02, 0.1), (0.3, 0.8), (0.02, 0.06)))
    axis_counts, wheel_counts = (int(n) for n in rng.choice(COUNTS, 2))
    in_counts, with_rate, with_current, which = rng.random(4)
    if kind != "wheel":
        name = "yaw_counts" if in_counts < 0.7 else "yaw_rad"
        noise[name] = 0.0 if name == "yaw_counts" else yaw
        if name == "yaw_counts":
            counts[name] = axis_counts
        if with_rate < 0.25:
            noise["yaw_rad_s"] = rate
    if kind != "platform":
        wishes_rate = "wheel_rad_s" in wishes.columns
        if "wheel_counts" in wishes.columns or (which < 0.25 and not wishes_rate):
            noise["wheel_counts"], counts["wheel_counts"] = 0.0, wheel_counts
        elif wishes_rate or kind == "wheel" or which < 0.75:
            noise["wheel_rad_s"] = wheel
        if with_current < 0.85 or "current_A" in wishes.columns or len(noise) < 2:
            noise["current_A"] = current
    return Sensors({k: float(v) for k, v in noise.items()}, counts)


def rig_text(rig: Rig, starts: dict[str, float]) -> str:
    """The rig file, with `starts` in place of the true numbers."""
    lines, section = [f'kind = "{rig.kind}"', 'name = "blind"'], ""
    for name in sorted(rig.names, key=_place):
        head, key = name.rsplit(".", 1)
        if head != section:
            section = head
            lines += ["", f"[{section}]"]
        lines.append(f"{key} = {starts.get(name, number(rig.truth, name)):.10g}")
    for column, table in (("yaw_counts", "encoder"), ("wheel_counts", "wheel_encoder")):
        if column in rig.sensors.counts:
            lines += ["", f"[{table}]", f"counts_per_rev = {rig.sensors.counts[column]}"]
    return "\n".join([*lines, "", "[fit]", f"free = {json.dumps(list(rig.free))}", ""])


def _place(name: str) -> tuple[int, str]:
    """Order in the file: motor, wheel, drive, axis, and the tables inside the axis last."""
    sections = ("motor", "wheel", "drive", "axis", "axis.friction", "axis.gravity")
    return sections.index(name.rsplit(".", 1)[0]), ""
