"""Lowered programs of the simulation against the same programs through XLA: every kind, effect, command and servo."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

import jax
import numpy as np
import pytest

from rwjax.effects.library import BY_NAME, EFFECTS, ON_TWO_AXES
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import AxisElastic, Coupling
from rwjax.fitting.problem import pose
from rwjax.fitting.scales import scales
from rwjax.kinds import GIVEN, GOAL, SUBSYSTEMS
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.lowering.kept import THROUGH_XLA
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.plant import Plant
from rwjax.plant.structure import Structure
from rwjax.rig.model import Rig
from rwjax.simulation import machine_code
from rwjax.simulation.batch import Batch
from rwjax.simulation.exact import EXACT, Exact
from rwjax.simulation.exponential_step import SQUARINGS, ExponentialStep, Matrix, Propagator
from rwjax.simulation.free_run import free_run, free_runs
from rwjax.simulation.shooting import Evaluation, evaluate
from rwjax.types import Scalar
from tests.joints import joint, servo
from tests.systems import platform, reaction, record, wheel
from tests.two_axes import GIMBAL, GRAVITY, two_axis

TIME = np.arange(61) * 0.01
WAVE = 1.0 + 0.3 * np.sin(4.0 * TIME)
"""A command that keeps its sign: away from standstill nothing is decided by the last digit."""
SIZE = {"voltage": 6.0, "duty": 0.5, "current": 0.5, "torque": 0.5}
LATE = ("drive.delay", "sensor.delay", "drive.lag", "drive.goal_delay")
LAST_DIGITS = np.finfo(float).eps * 2.0**SQUARINGS
"""Relative error that rounding makes in the exponentials of a step: each of their squarings doubles it. All steps share it."""
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


def _close(
    found: np.ndarray, wanted: np.ndarray, within: float, size: float = 0.0, moved: np.ndarray | float = 0.0
) -> None:
    found, wanted = np.asarray(found), np.asarray(wanted)
    assert found.shape == wanted.shape
    assert np.isfinite(wanted).all()
    assert np.all(np.abs(found - wanted) <= within * max(np.max(np.abs(wanted), initial=0.0), size) + moved)


@dataclass(frozen=True)
class _OtherwiseRounded(ExponentialStep):
    """The same steps by exponentials that are off by what rounding may do to them."""

    from_library: ClassVar[bool] = False

    def prepare(self, plant: Plant, h: Scalar) -> Propagator:
        p, rng = super().prepare(plant, h), np.random.default_rng(0)

        def off(M: Matrix) -> Matrix:
            return tuple(tuple(entry * (1.0 + LAST_DIGITS * rng.choice([-1.0, 1.0])) for entry in row) for row in M)

        return p._replace(E=off(p.E), phi1=off(p.phi1), phi2=off(p.phi2))


def _moved(structure: Structure, theta: np.ndarray, start: np.ndarray, batch: Batch) -> tuple[np.ndarray, ...]:
    """By how much XLA's own run leaves itself, up to each window, where numbers, start and exponentials are rounded otherwise."""
    rng, wanted, moved = np.random.default_rng(0), free_run(structure, theta, start, batch), []
    solver = Exact(stepper=_OtherwiseRounded())
    for _ in range(4):
        a, b = (v * (1.0 + LAST_DIGITS * rng.choice([-1.0, 1.0], v.shape)) for v in (theta, start))
        other = free_run(structure, a, b, batch, solver=solver)
        moved.append([np.abs(there - here) for there, here in zip(other, wanted, strict=True)])
    most = [np.max(part, axis=0) for part in zip(*moved, strict=True)]
    so_far = [np.maximum.accumulate(part.max(axis=(0, *range(2, part.ndim)))) for part in most]
    return tuple(by.reshape(1, -1, *[1] * (part.ndim - 2)) for by, part in zip(so_far, most, strict=True))


def _kept(e: Evaluation, columns: np.ndarray) -> Evaluation:
    """An evaluation as arrays, of some columns of its derivatives, which come first."""
    e = Evaluation(*map(np.asarray, e))
    chain = np.moveaxis(e.chain, -1, 0)[columns]
    return e._replace(H=e.H[:, columns][:, :, columns], g=e.g[:, columns], local=e.local[columns], chain=chain)


def _same_evaluation(e: Evaluation, of_xla: Evaluation, rounded: Evaluation, size: float) -> None:
    """Equal up to rounding, and up to what exponentials that are rounded otherwise change."""
    e = e._replace(chain=np.moveaxis(np.asarray(e.chain), -1, 0))
    for field, within in (("residual", 1e-11), ("defect", 1e-11), ("shift", 1e-11), ("H", 1e-10), ("g", 1e-10)):
        wanted, other = getattr(of_xla, field), getattr(rounded, field)
        least = size if field in ("defect", "shift") else 0.0
        _close(getattr(e, field), wanted, within, least, 2.0 * np.max(np.abs(other - wanted)))
    for field in ("local", "chain"):
        for column, wanted, other in zip(*(getattr(each, field) for each in (e, of_xla, rounded)), strict=True):
            moved = 2.0 * np.max(np.abs(other - wanted), initial=0.0)
            _close(column, wanted, 1e-9, moved=moved)  # a column may be the difference of larger ones


@pytest.mark.parametrize(
    "name", [case if case in FAST else pytest.param(case, marks=pytest.mark.slow) for case in CASES]
)
def test_lowered_programs_are_those_of_xla(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    structure, theta, batch = CASES[name]()
    begin = {"w": 1.0, "Omega": 20.0, "w_1": 1.0, "w_2": 0.5, "Omega_1": 20.0, "Omega_2": 10.0}
    start = np.array([[begin.get(state, 0.0) for state in structure.states]])
    several = theta * (1.0 + 1e-3 * np.arange(3)[:, None]), np.repeat(start, 3, axis=0)
    assert machine_code.whole_run(structure, theta, start[0], batch, 0, EXACT) is not None
    assert machine_code.runs(structure, *several, 2, batch, EXACT) is not None
    y, nodes = free_run(structure, theta, start, batch)
    off = np.asarray(nodes) * (1.0 + 0.01 * np.cos(np.arange(batch.windows)))[:, None]  # windows that do not join
    numbers = np.arange(len(theta))
    assert machine_code.sensitivities(structure, theta, numbers, off[0], batch, 0, EXACT) is not None
    runs, e = free_runs(structure, *several, 2, batch), evaluate(structure, theta, numbers, off, batch)
    monkeypatch.setenv(THROUGH_XLA, "1")
    wanted = free_run(structure, theta, start, batch)
    steps = len(batch.step_index) * batch.windows
    moved = _moved(structure, theta, start, batch)
    _close(y, wanted[0], 1e-14 * steps, moved=2.0 * moved[0])  # rounding of every step, and what becomes of it
    _close(nodes, wanted[1], 1e-14 * steps, moved=2.0 * moved[1])
    _close(runs, free_runs(structure, *several, 2, batch), 1e-14 * steps)
    x, n = evaluate(structure, theta, numbers, off, batch), len(structure.states)
    kept = np.concatenate([numbers, np.arange(len(x.local) - n, len(x.local))])  # XLA's program adds columns of zeros
    rounded = evaluate(structure, theta, numbers, off, batch, solver=Exact(stepper=_OtherwiseRounded()))
    _same_evaluation(e, _kept(x, kept), _kept(rounded, kept), float(np.max(np.abs(off))))
    jax.clear_caches()


@pytest.mark.parametrize("n", [2, 20])
def test_columns_carried_from_window_to_window(n: int) -> None:
    """Few states and many: equal to powers of one matrix, $c_w = A^w c_0 + \\sum_{i<w} A^i b$."""
    rng = np.random.default_rng(0)
    A, b, first = rng.normal(size=(n, n)) / n, rng.normal(size=(3, n)), rng.normal(size=(3, n))
    found = machine_code.continued(np.broadcast_to(A, (5, n, n)), np.repeat(b[:, None], 5, axis=1), first)
    powers = [np.linalg.matrix_power(A, w) for w in range(5)]
    wanted = [powers[w] @ first.T + sum((powers[i] @ b.T for i in range(w)), np.zeros((n, 3))) for w in range(5)]
    assert found is not None
    assert found == pytest.approx(np.moveaxis(wanted, -1, 0), abs=1e-13)
