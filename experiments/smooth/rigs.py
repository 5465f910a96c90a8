"""The rigs on which the smooth solver is tried: measured, regenerated and simulated ones, each with dry friction in its model."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count, islice
from pathlib import Path

import numpy as np

from experiments.blind.cases import KINDS as BLIND
from experiments.blind.cases import Case, _log, make_case, prepare, write_case
from experiments.blind.rigs import number, rig_text
from experiments.blind.sensors import cells, readings
from experiments.realdata import ROOT, dcmotor, emps
from experiments.thesis.regenerate import FRICTION
from rwjax import Log, Rig, folds, read_log, read_logs, read_rig, simulate

KINDS = (*BLIND, "two_axis")
FIRST_SEED = 150_000
LENGTH = 1000  # samples of a simulated log: programs serve several rigs
EXPONENT = 1.5  # of the demo's Stribeck friction
OFF = 0.35  # logarithm within which the start of a fit is off


@dataclass(frozen=True)
class Trial:
    """A rig with the logs to fit and those to judge on; `truth`: its numbers where they are known, in SI by name."""

    name: str
    rig: Rig
    train: Sequence[Log]
    held_out: Sequence[Log]
    truth: dict[str, float]


def _trial(name: str, rig: Rig, logs: Sequence[Log], truth: dict[str, float] | None = None) -> Trial:
    """The logs marked for validation are held out; where none is, the first split of the library's rule counts."""
    split = folds(logs)[1][0]
    return Trial(name, rig, split.train, split.test, truth or {})


def demo() -> Trial:
    """The demo's platform with the Stribeck friction that its rig file lacks, as `newcomer.py` begins; its exponent is given."""
    base = read_rig(ROOT / "data" / "demo" / "rig.toml")
    begin, right = {"M_c": 0.3, "M_e": 0.1, "v_s": 0.2}, (0.45, 0.3, 0.35)
    effect = {f"axis.stribeck.{name}": value for name, value in zip(begin, right, strict=True)}
    rig = replace(base, effects={"axis.stribeck": begin | {"n": EXPONENT}}, free=(*base.free, *effect))
    truth = {"axis.inertia": 0.228, "axis.friction.viscous": 0.06} | effect
    return _trial("demo", rig, read_logs(sorted((ROOT / "data" / "demo").glob("*.csv")), rig), truth)


def with_four_terms() -> Rig:
    """EMPS as its published model has it, where a fit begins."""
    base = read_rig(ROOT / "experiments" / "emps" / "rig.toml")
    return replace(
        base,
        numbers=base.numbers | {"axis.friction.coulomb": 10.0},
        effects={"axis.bias_torque": {"T": 0.0}},
        free=(*base.free, "axis.friction.coulomb", "axis.bias_torque.T"),
    )


def electro_mechanical(folder: Path) -> Trial:
    """EMPS with its four terms: fitted to one log, judged on the other."""
    rig = with_four_terms()
    first, pulses = (read_log(path, rig) for path in emps(folder))
    return Trial("EMPS", rig, (first,), (pulses,), {})


def thesis() -> Trial:
    """The runs regenerated from the thesis's polynomials, with the friction law of its eq. 4.7 and numbers up to 30 % off."""
    base = read_rig(ROOT / "data" / "thesis" / "platform.toml")
    inertia, names = base.numbers["axis.inertia"], ("b3", "b2", "b1", "b0")
    truth = {"axis.inertia": inertia}
    truth |= {f"axis.friction.{name}": inertia * float(c) for name, c in zip(names, FRICTION.coef, strict=True)}
    begin = {name: value * off for (name, value), off in zip(truth.items(), (1.2, 0.8, 1.3, 0.8, 1.3), strict=True)}
    numbers = {name: value for name, value in base.numbers.items() if name != "axis.friction.viscous"}
    rig = replace(base, numbers=numbers | begin, free=tuple(truth))
    paths = [ROOT / "data" / "thesis" / f"{name}.csv" for name in ("square", "stairs", "triangle")]
    return _trial("thesis", rig, read_logs(paths, rig), truth)


def geared_motor(folder: Path) -> Trial:
    """The geared motor with the three effects that fit it best: fitted to the first two thirds of its staircase."""
    base = read_rig(ROOT / "experiments" / "dcmotor" / "rig.toml")
    effects = {"wheel.coulomb": {"M_c": 0.2}, "drive.deadzone": {"u_0": 0.5}, "drive.bias": {"u_b": 0.05}}
    free = (*base.free, *(f"{e}.{p}" for e, given in effects.items() for p in given))
    rig = replace(base, effects=effects, free=free)
    return _trial("geared motor", rig, [read_log(dcmotor(folder), rig)])


def simulated(kind: str, index: int) -> Trial:
    """The rig `index` of a kind: it lacks nothing, and its dry friction is among the numbers to be found."""
    if kind == "two_axis":
        return _two_axis(FIRST_SEED + index)
    case = _wheel(FIRST_SEED + index) if kind == "wheel" else _with_dry_axis(kind, index)
    with tempfile.TemporaryDirectory() as folder:
        write_case(case, Path(folder))
        rig = read_rig(Path(folder) / "rig.toml")
        logs = read_logs(sorted(Path(folder).glob("*.csv")), rig)
    if kind == "wheel":
        begin = case.truth["start"]
        rig = replace(rig, effects={"wheel.coulomb": {"M_c": begin}}, free=(*rig.free, "wheel.coulomb.M_c"))
    whole = _trial(f"{kind} {index}", rig, logs, case.truth["true_numbers"])
    train, held_out = ([log.cut(0, LENGTH) for log in group] for group in (whole.train[:3], whole.held_out[:1]))
    return replace(whole, train=train, held_out=held_out)


def _with_dry_axis(kind: str, index: int) -> Case:
    seeds = (s for s in count(FIRST_SEED) if "axis.friction.coulomb" in prepare(kind, None, s).rig.free)
    return make_case(kind, None, next(islice(seeds, index, None)), raw=False)


def _wheel(seed: int) -> Case:
    """A wheel whose bearing has dry friction, without the higher breakaway that the simulator draws with it."""
    case, rng = prepare("wheel", None, seed), np.random.default_rng([seed, 7])
    truth = replace(case.rig.truth, wheel_coulomb=rng.uniform(0.04, 0.2) * case.scene.stall)
    sensors, logs = case.rig.sensors, {}
    for name, (record, validate) in case.runs.items():
        logs[name] = _log(record, validate, cells(readings(truth, record, sensors.noise), sensors, rng))
    numbers = {name: number(truth, name) for name in case.rig.free} | {"wheel.coulomb.M_c": truth.wheel_coulomb}
    begin = {name: value * float(np.exp(rng.uniform(-OFF, OFF))) for name, value in numbers.items()}
    label = {"true_numbers": numbers, "start": begin["wheel.coulomb.M_c"]}
    return Case(rig_text(replace(case.rig, truth=truth), begin), logs, label)


WHEELS = ("wheel_1_rad_s", "wheel_2_rad_s")
FINER = 10  # steps of the simulated rig with two axes for each of its samples


def _two_axis(seed: int) -> Trial:
    """A rig with two axes; the library's own exact step in steps of 1 ms makes its logs, since no other simulator of two
    axes at hand lets an axis stick."""
    rng = np.random.default_rng(seed)
    base = read_rig(ROOT / "data" / "two_axis" / "rig.toml")
    drawn = (n for n in base.numbers if n.rpartition(".")[2] in ("inertia", "viscous", "coulomb", "torque"))
    rig = base.with_values({name: base.values[name] * np.exp(rng.uniform(-0.3, 0.3)) for name in drawn})
    angle = {name: 2.0 * np.pi / rig.counts_per_rev[on] for name, on in (("yaw_rad", "axis"), ("pitch_rad", "pitch"))}
    logs = []
    for k, volts in enumerate(_volts(rng)):
        t = 0.01 * np.arange(len(volts))
        fine = 0.01 / FINER * np.arange(FINER * len(t))
        run = simulate(rig, fine, np.repeat(volts, FINER, axis=0))
        y = {name: np.asarray(run[name])[::FINER] for name in (*angle, *WHEELS)}
        y |= {name: step * np.rint(y[name] / step) for name, step in angle.items()}
        y |= {name: np.round(y[name] + 0.3 * rng.normal(size=len(t)), 1) for name in WHEELS}
        resolution = {name: angle.get(name, 0.0) for name in y}
        logs.append(Log(f"run {k}", t, volts, y, resolution, {}, k == 2, None, 0.0))
    truth = {name: rig.values[name] for name in rig.free}
    begin = {name: value * np.exp(rng.uniform(-OFF, OFF)) for name, value in truth.items()}
    return _trial(f"two_axis {seed - FIRST_SEED}", rig.with_values(begin), logs, truth)


def _volts(rng: np.random.Generator) -> list[np.ndarray]:
    """Commands `(n, 2)` of three runs; the wheel of the yaw axis runs up first."""
    t = 0.01 * np.arange(700)
    found = []
    for shape in (np.sin, lambda x: np.sign(np.sin(x)), lambda x: np.sign(np.sin(x + 0.1 * x**1.2))):
        slow, fast = rng.uniform(1.5, 2.5), rng.uniform(2.5, 4.0)
        level = rng.choice([-1.0, 1.0]) * rng.uniform(3.0, 5.0)
        volts = np.stack([level + 1.5 * shape(slow * t), rng.uniform(1.0, 1.5) * shape(fast * t + 0.4)], axis=1)
        found.append(np.round(np.where(t[:, None] > 0.6, volts, 0.0), 3))
    return found
