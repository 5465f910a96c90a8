"""Labelled cases: a rig file, logs and the answer.

`python -m experiments.blind.cases --kind platform --effect axis.stribeck+drive.delay --amplitude 0.5 -o DIR`
"""

import argparse
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from experiments.blind.commands import TICK, command
from experiments.blind.draws import EFFECTS, STATIC, Effect, Numbers, Scene, between, put, sign
from experiments.blind.outside import OUTSIDE
from experiments.blind.rigs import FIELD, KINDS, MOTOR, Rig, Wishes, draw_rig, number, rig_text, with_number
from experiments.blind.sensors import Recorded, cells, readings
from experiments.blind.simulator import run
from experiments.blind.truth import OMEGA, PSI, STATES, THETA, Truth, W

__all__ = ["KINDS", "Case", "Prepared", "amplitude_for", "kinds_of", "make_case", "prepare", "write_case"]

TRAINING = ("square", "multisine", "triangle", "stair", "coast", "prbs")
JITTER = 1e-4  # s, largest distance of a sample from its time stamp
OFF = {  # by how much (logarithm) a number of the rig file is off, where 8 to 30 % could hardly be seen
    "parameter.motor.friction": (1.2, 2.0),
    "parameter.motor.inductance": (0.3, 0.6),
    "parameter.axis.friction.viscous": (0.2, 0.6),
    "parameter.axis.friction.coulomb": (0.2, 0.6),
    "parameter.axis.gravity.torque": (0.2, 0.6),
    "parameter.axis.gravity.angle": (0.2, 0.6),
}
GRAVITY = ("axis.gravity.torque", "axis.gravity.angle")


@dataclass(frozen=True)
class Case:
    """Text of the rig file, text of each log by file name, and the label."""

    rig: str
    logs: dict[str, str]
    truth: dict


@dataclass(frozen=True)
class Prepared:
    """A rig before its effects: inputs of its runs, what it does without effects, and the effects' drawn numbers."""

    rig: Rig
    scene: Scene
    runs: dict[str, tuple[Recorded, bool]]  # by file name; whether a run is marked for validation
    numbers: dict[str, Numbers]  # of each effect
    wrong: dict[str, float]  # logarithm (angle: difference) by which a number of the rig file is off


def split(effect: str | None) -> list[str]:
    """Names joined by +; none for `None` and "none"."""
    return [] if effect in (None, "none") else effect.split("+")


def kinds_of(name: str) -> tuple[str, ...]:
    """Kinds of rig that can show an effect."""
    if name.startswith("parameter."):
        number_name = name.removeprefix("parameter.")
        if number_name not in FIELD:
            raise ValueError(f"{name}: no such number; one of {', '.join(FIELD)}")
        if number_name in MOTOR:
            return ("wheel", "reaction")
        return ("platform",) if number_name == "drive.gain" else ("platform", "reaction")
    return _effect(name).kinds


def _effect(name: str) -> Effect:
    known = EFFECTS | OUTSIDE
    if name not in known:
        raise ValueError(f"{name}: no such effect; one of {', '.join(known)} or parameter.NAME")
    return known[name]


def _wishes(name: str, kind: str, rng: np.random.Generator) -> Wishes:
    mostly = rng.random() < 0.75
    if name.startswith("parameter."):
        wrong = name.removeprefix("parameter.")
        models = GRAVITY if wrong in GRAVITY else (wrong,) if wrong.startswith("axis.friction") else ()
        fixed = (wrong, "axis.inertia") if wrong == "drive.gain" else (wrong,)
        lacks = STATIC if wrong == "axis.friction.coulomb" else ()
        return Wishes(models=models, lacks=lacks, fixed=fixed, inductance=wrong == "motor.inductance")
    effect = _effect(name)
    wishes = effect.always | effect.mostly if mostly else effect.always
    columns = tuple(c for c in wishes.columns if c != "wheel_counts" or kind == "wheel")
    return replace(wishes, columns=columns)


@lru_cache(maxsize=4)
def prepare(kind: str, effect: str | None, seed: int) -> Prepared:
    """Everything of a case that does not depend on the amplitude, reproducible by the seed."""
    names = split(effect)
    for name in names:
        if kind not in kinds_of(name):
            raise ValueError(f"{name} makes no sense in a rig of kind {kind}")
    rng = np.random.default_rng([seed, KINDS.index(kind), *(ord(c) for c in effect or "none")])
    for_wishes, for_rig, for_runs, for_effects = rng.spawn(4)
    wishes = Wishes()
    for name in names:
        wishes = wishes | _wishes(name, kind, for_wishes)
    rig = draw_rig(kind, replace(wishes, models=tuple(set(wishes.models) - set(wishes.lacks))), for_rig)
    runs = _runs(rig, wishes, for_runs)
    scene = observe(rig, [record for record, _ in runs.values()])
    numbers, wrong = {}, {}
    for name in names:
        if name.startswith("parameter."):
            wrong[name.removeprefix("parameter.")] = sign(for_effects) * between(
                for_effects, *OFF.get(name, (0.08, 0.3))
            )
        else:
            numbers[name] = _effect(name).draw(scene, for_effects)
    return Prepared(rig, scene, runs, numbers, wrong)


def _runs(rig: Rig, wishes: Wishes, rng: np.random.Generator) -> dict[str, tuple[Recorded, bool]]:
    """Inputs of four to six runs; mostly one or two are marked for validation, now and then none."""
    count = int(rng.integers(4, 7))
    marked = 0 if rng.random() < 0.2 else 2 if count > 4 else 1
    kinds = [str(k) for k in rng.choice(TRAINING, size=count - max(marked, 1), replace=False)]
    if wishes.logs and not set(kinds) & set(wishes.logs):
        kinds[0] = str(rng.choice(wishes.logs))
    kinds += ["mixed"] + [str(rng.choice(kinds))] * (marked == 2)
    angle, runs = float(rng.uniform(-0.5, 0.5)), {}
    for k, kind in enumerate(kinds):
        level = rig.top * float(rng.choice([1.0, 1.0, rng.uniform(0.5, 1.0)]))
        u = command(kind, float(rng.uniform(10.0, 15.0)), level, rng)
        t = np.arange(len(u)) * TICK
        at = sampled(rig, t, rng.uniform(-JITTER, JITTER, len(t)))
        start = np.zeros(5)
        if rig.kind != "wheel":
            start[PSI] = angle + rng.uniform(-0.3, 0.3)
        start[THETA] = rng.uniform(-np.pi, np.pi)
        runs[f"{kind}_{k}.csv"] = (Recorded(t, u, at, start, float(k)), k >= count - marked)
    return runs


def sampled(rig: Rig, time: np.ndarray, late: np.ndarray) -> np.ndarray:
    """When samples are taken that come `late` [s] after `time` [s]; in order, none before the run begins."""
    if rig.truth.L == 0.0 and "current_A" in rig.sensors.noise:  # that jumps with the command: read once it is written
        late = np.maximum(late, 0.0)
    return np.maximum.accumulate(np.maximum(time + late, 0.0))


def settled(truth: Truth, start: np.ndarray) -> np.ndarray:
    """Where a rig comes to rest without command, since a run begins at rest."""
    start = start.copy()
    start[PSI] = min(max(start[PSI], truth.stop_low), truth.stop_high)
    if truth.gravity == truth.imbalance == truth.spring == truth.cogging == 0.0:
        return start
    damped = replace(truth, viscous=5.0 * truth.I, b=5.0 * truth.J, preslide_form=0.0, coupling=0.0, drift=0.0)
    damped = replace(damped, periodic=0.0, bursts=0.0, bias_command=0.0, L=0.0, memory=0.0)
    time = np.array([0.0, 20.0])
    end = run(time, np.zeros(2), time, start, damped.array(), 1e-3)[-1]
    start[PSI], start[THETA] = end[PSI], end[THETA]
    return start


def observe(rig: Rig, records: list[Recorded], jitter: float = JITTER) -> Scene:
    """What a rig does without effects; its samples are up to `jitter` [s] from their time stamps."""
    found = []
    for record in records:
        start = settled(rig.truth, record.start)
        states = run(record.time, record.command, record.at, start, rig.truth.array())
        found.append((states, record.command, start))
    states = np.concatenate([s for s, _, _ in found])
    ampere = states[:, STATES]
    volts = np.concatenate([u for _, u, _ in found])
    torque = rig.truth.gain * volts if rig.kind == "platform" else rig.truth.K * ampere
    angle, rate = (states[:, THETA], states[:, OMEGA]) if rig.kind == "wheel" else (states[:, PSI], states[:, W])
    energy = max(TICK * float(np.sum(s[:, STATES] ** 2)) for s, _, _ in found) * rig.truth.R
    return Scene(
        rig=rig,
        torque=float(np.sqrt(np.mean(torque**2))),
        speed=float(np.quantile(np.abs(rate), 0.95)),
        spin=float(np.quantile(np.abs(states[:, OMEGA]), 0.95)),
        low=float(np.min(angle)),
        high=float(np.max(angle)),
        start=float(np.mean([x[THETA if rig.kind == "wheel" else PSI] for _, _, x in found])),
        ampere=float(np.quantile(np.abs(ampere), 0.99)),
        energy=energy,
        floor=_floor(rig, states, jitter),
    )


def _floor(rig: Rig, states: np.ndarray, jitter: float) -> dict[str, float]:
    """What noise, quantisation and the unknown instant of each sample leave of each column, in SI."""
    late = jitter / np.sqrt(3.0)
    wheel, axis = (late * float(np.sqrt(np.mean(states[:, k] ** 2))) for k in (OMEGA, W))
    by_column = {"wheel_counts": wheel, "yaw_counts": axis, "yaw_rad": axis}
    return {name: float(np.hypot(f, by_column.get(name, 0.0))) for name, f in rig.sensors.floor().items()}


def _raw_size(with_it: list[dict], without: list[dict], floor: dict[str, float]) -> float:
    """RMS difference in units of the noise floor, of the column where it is largest."""
    sizes = []
    for name, noise in floor.items():
        with np.errstate(over="ignore", invalid="ignore"):  # a rig file far off may run away
            gap = np.concatenate([a[name] - b[name] for a, b in zip(with_it, without, strict=True)])
            size = float(np.sqrt(np.mean(gap**2))) / noise
        sizes.append(size if np.isfinite(size) else np.inf)
    return max(sizes)


def _starts(rig: Rig, rng: np.random.Generator) -> dict[str, float]:
    """Where a fit begins: the free numbers off by up to 40 %."""
    found = {}
    for name in rig.free:
        off, value = float(rng.uniform(-0.35, 0.35)), number(rig.truth, name)
        found[name] = value + off if name == "axis.gravity.angle" else value * float(np.exp(off))
    static, sliding = "axis.friction.static", "axis.friction.coulomb"
    if static in found:
        found[static] = found[sliding] * number(rig.truth, static) / number(rig.truth, sliding)
    return found


def equivalent(kind: str, name: str, truth: Truth) -> list[str]:
    """Other names for the very same thing in this rig, as far as they are known exactly."""
    pure = truth.excess == 0.0 and truth.preslide_form == 0.0
    if name == "drive.supply_sag":
        alone = {"platform": "drive.curvature"}.get(kind, "parameter.motor.resistance")
        return [alone] if truth.sag_form == 0.0 else []
    if kind != "platform":
        return []
    same = {
        "drive.delay": ["sensor.delay"],
        "sensor.delay": ["drive.delay"],
        "drive.curvature": ["drive.supply_sag"] if truth.curvature < 0.0 == truth.curvature_form else [],
        "parameter.drive.gain": ["parameter.axis.inertia"] if truth.coulomb == 0.0 == truth.gravity else [],
        "axis.bias_torque": ["drive.bias"] + ["axis.asymmetric_friction"] * pure,
        "drive.bias": ["axis.bias_torque"] + ["axis.asymmetric_friction"] * pure,
        "axis.asymmetric_friction": ["axis.bias_torque", "drive.bias"] if pure else [],
    }
    return same.get(name, [])


Amplitude = float | Mapping[str, float]
"""Strength of every cause, or of each by its name; 1 is as drawn, 0 without it."""


def strength(amplitude: Amplitude, name: str) -> float:
    """Amplitude of one cause."""
    return amplitude[name] if isinstance(amplitude, Mapping) else amplitude


def make_case(kind: str, effect: str | None, seed: int, amplitude: Amplitude = 1.0, raw: bool = True) -> Case:
    """A random rig of a kind that lacks `effect`, or nothing; reproducible by its seed.

    `effect` is a name of the interface, `outside.NAME`, several joined by +, or None. `amplitude` scales the strength
    (1: as drawn, 0: without the effect) and changes neither rig, inputs nor noise. `raw`: whether the label holds the
    raw size, which takes runs without the effect.
    """
    return built(prepare(kind, effect, seed), effect, seed, amplitude, raw)


def built(case: Prepared, effect: str | None, seed: int, amplitude: Amplitude, raw: bool) -> Case:
    """The case of a rig with all its causes; the label asks for those in `effect`."""
    rig, names = case.rig, split(effect)
    kind, truth = rig.kind, rig.truth
    for name, numbers in case.numbers.items():
        truth = put(truth, numbers, strength(amplitude, name))
    wrong = {}
    for name, off in case.wrong.items():
        value, by = number(truth, name), strength(amplitude, f"parameter.{name}") * off
        wrong[name] = value + by if name == "axis.gravity.angle" else value * np.exp(by)
    believed = truth if case.wrong else rig.truth
    for name, value in wrong.items():
        believed = with_number(believed, name, value)

    noise = np.random.default_rng([seed, KINDS.index(kind), 1])
    columns, logs, with_it, without, starts = rig.sensors.noise, {}, [], [], {}
    for name, (record, validate) in case.runs.items():
        record = replace(record, start=settled(truth, record.start))
        clean = readings(truth, record, columns)
        with_it.append(clean)
        if raw:
            without.append(clean if believed == truth else readings(believed, record, columns))
        logs[name] = _log(record, validate, cells(clean, rig.sensors, noise))
        starts[name] = record.start.tolist()
    outside = [name for name in names if name.startswith("outside.")]
    present = [name for name in names if strength(amplitude, name) > 0.0]
    causes = dict.fromkeys([*names, *case.numbers, *(f"parameter.{name}" for name in case.wrong)])
    there = [name for name in causes if strength(amplitude, name) > 0.0]
    label = {
        "kind": kind,
        "verdict": "none" if not present else "unknown" if outside else "effect",
        "effects": [name for name in present if name not in outside],
        "outside": [name for name in present if name in outside],
        "seed": seed,
        "effect": effect or "none",
        "amplitude": dict(amplitude) if isinstance(amplitude, Mapping) else amplitude,
        "raw_size": _raw_size(with_it, without, case.scene.floor) if raw else None,
        "same_as": {name: equivalent(kind, name, truth) for name in there if equivalent(kind, name, truth)},
        "changed": {e: {k: getattr(truth, k) for k in numbers} for e, numbers in case.numbers.items() if e in there},
        "true_numbers": {name: number(truth, name) for name in rig.free},
        "wrong_numbers": {name: float(value) for name, value in wrong.items()},
        "floor": case.scene.floor,
        "starts": starts,
        "parameters": {k: v for k, v in asdict(truth).items() if k != "rumble"},  # which is a run's alone
    }
    first = _starts(rig, np.random.default_rng([seed, KINDS.index(kind), 2]))
    return Case(rig_text(replace(rig, truth=truth), first | label["wrong_numbers"]), logs, label)


def _log(record: Recorded, validate: bool, readings_as_text: dict[str, list[str]]) -> str:
    columns = {"time_s": [f"{v:.3f}" for v in record.time], "voltage_V": [f"{v:.3f}" for v in record.command]}
    columns |= readings_as_text
    rows = [",".join(row) for row in zip(*columns.values(), strict=True)]
    return "\n".join([*(["# role: validate"] if validate else []), ",".join(columns), *rows, ""])


def raw_size(kind: str, effect: str, seed: int, amplitude: float) -> float:
    """Approximate size of a case's effect, without any refit."""
    return make_case(kind, effect, seed, amplitude).truth["raw_size"]


def amplitude_for(
    wanted: float, kind: str, effect: str, seed: int, measure: Callable[..., float] = raw_size, steps: int = 12
) -> float:
    """Amplitude at which `measure(kind, effect, seed, amplitude)` has a value, between 1e-4 and 1e2, by bisection."""
    low, high = np.log(1e-4), np.log(1e2)
    for _ in range(steps):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if measure(kind, effect, seed, float(np.exp(middle))) < wanted else (low, middle)
    return float(np.exp(0.5 * (low + high)))


def write_case(case: Case, folder: Path) -> None:
    """Writes `rig.toml`, the logs and `truth.json`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.toml").write_text(case.rig)
    for name, text in case.logs.items():
        (folder / name).write_text(text)
    (folder / "truth.json").write_text(json.dumps(case.truth, indent=1) + "\n")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--effect", default="none", help="names of diagnosis.json joined by +, outside.NAME, or none")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--amplitude", type=float, default=1.0, help="strength, 1 as drawn")
    parser.add_argument("-o", dest="folder", type=Path, required=True)
    a = parser.parse_args()
    write_case(make_case(a.kind, a.effect, a.seed, a.amplitude), a.folder)


if __name__ == "__main__":
    main()
