"""Plants that act on everything: every kind, effect, command and servo, each with its numbers and a log."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from rwjax.effects.library import BY_NAME, EFFECTS, ON_TWO_AXES
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import AxisElastic, Coupling
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import scales
from rwjax.kinds import GIVEN, GOAL, SUBSYSTEMS
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation.batch import Batch
from tests.joints import joint, servo
from tests.systems import platform, reaction, record, wheel
from tests.two_axes import GIMBAL, GRAVITY, two_axis

TIME = np.arange(61) * 0.01
WAVE = 1.0 + 0.3 * np.sin(4.0 * TIME)
"""A command that keeps its sign: away from standstill nothing is decided by the last digit."""
SIZE = {"voltage": 6.0, "duty": 0.5, "current": 0.5, "torque": 0.5}
LATE = ("drive.delay", "sensor.delay", "drive.lag", "drive.goal_delay")
Posed = tuple[Structure, np.ndarray, Batch]


def _inductive(rig: Rig, L: float) -> Rig:
    return replace(rig, numbers=rig.numbers | {"motor.inductance": L})


DRY = "viscous = 0.003\ncoulomb = 0.002"
RIGS = {
    "wheel": wheel(0.0),
    "inductive wheel": wheel(),
    "platform": platform(),
    "reaction": _inductive(reaction(DRY), 0.0),
    "inductive reaction": reaction(DRY),
    "joint": joint(axis__friction__coulomb=0.02),
    "inductive joint": joint(axis__friction__coulomb=0.02, motor__inductance=1e-3),
    "two_axis": two_axis(GIMBAL + GRAVITY),
}


def _log(rig: Rig, u: np.ndarray, **more: object) -> Log:
    u = np.stack([u, -0.7 * u], axis=-1) if rig.kind == "two_axis" else u
    outputs = structure_of(rig).outputs
    return record(TIME, u, {name: 0.5 + TIME * (2.0 if "wheel" in name else 1.0) for name in outputs}, **more)


def _posed(rig: Rig, log: Log, effects: tuple[str, ...]) -> Posed:
    """A problem with effects that act."""
    structure = structure_of(rig).with_effects(*effects)
    theta = theta_of(rig, structure)
    typical = scales(reaction(), [_log(reaction(), 3.0 * WAVE)]) if rig.kind == "two_axis" else scales(rig, [log])
    for effect in effects:
        for name, p in parameters(BY_NAME[effect]).items():
            small = (0.003 if name in ("s_2", "c_2") else 0.1) * typical[p.scale]
            value = 0.93 * next(filter(None, p.begin(typical)[::-1]), small)
            theta[structure.names.index(f"{effect}.{name}")] = np.clip(value, *p.bounds)
    return structure, theta, pose(structure, (log,), dict.fromkeys(structure.outputs, 1.0)).batch


def _of_kind(kind: str) -> list[str]:
    pool = ON_TWO_AXES if kind == "two_axis" else EFFECTS
    return [e.name for e in pool if kind in SUBSYSTEMS[e.name.partition(".")[0]] and not e.needs_servo]


def _together(kind: str) -> tuple[str, ...]:
    return tuple(name for name in _of_kind(kind) if not issubclass(BY_NAME[name], AxisElastic | Coupling))


def _joint(by: str, off: bool, loop: tuple[str, str] | None, effects: tuple[str, ...]) -> Posed:
    """A joint under a command or a goal, its torque off for a while or not. Ticks lie between samples."""
    rig, u, column = joint(axis__friction__coulomb=0.02, drive__supply=12.0), SIZE[by] * WAVE, None
    if loop is not None:
        gains = dict(kp=8.0, ki=3.0, kd=0.1, period=0.0131, phase=0.0033, limit=2.0 * SIZE[by])
        rig, u, column = servo(rig, by, *loop, **gains), 0.4 * WAVE, GOAL
    column = column or next(name for name, given in GIVEN.items() if given == by)
    log = _log(rig, u, input=column, enabled=TIME < 0.3 if off else None)
    rig, (log,) = driven(rig, [log])
    return _posed(rig, log, effects)


def _every() -> Iterator[tuple[str, Callable[[], Posed]]]:
    for name, rig in RIGS.items():
        for effects in ((), *((effect,) for effect in _of_kind(rig.kind)), _together(rig.kind)):
            words = "all effects" if len(effects) > 1 else " ".join(effects)
            yield f"{name}: {words}", lambda rig=rig, effects=effects: _posed(rig, _log(rig, 3.0 * WAVE), effects)
    for by in SIZE:
        for off in (False, True):
            loops = [
                (d, s, e) for d in ("error", "speed") for s in ("link", "motor") for e in ((), ("axis.backlash",), LATE)
            ]
            yield f"joint by {by}, off {off}", lambda by=by, off=off: _joint(by, off, None, ())
            for d, s, e in loops:
                words = f"servo on {by}, off {off}, damping on {d}, encoder on {s}: {' '.join(e)}"
                yield words, lambda by=by, off=off, d=d, s=s, e=e: _joint(by, off, (d, s), e)


CASES = dict(_every())
FAST = ("platform: axis.coulomb",)
