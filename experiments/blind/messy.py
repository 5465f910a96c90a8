"""Rigs as they are: beside one or two large causes, or none, there is much that is small.

* Three to six *small causes*, in the library's list and outside it. Each by itself has a size of 0.3 to 3 floors and is no stronger than
  a large one is drawn.
* Up to two fixed numbers of the rig file that are off by 2 to 10 %; by 2 % where more would be larger than 3 floors, and not at all where
  2 % would. Where the free numbers follow, such a number has hardly any size.
* Coloured noise of the torque, of 0.2 to 1 floor; coloured noise of the readings; samples up to 0.5 ms from their time stamps.
* Friction that differs from run to run by 1 to 5 % (standard deviation); by less where that alone would be larger than 3 floors.

Small causes and wrong numbers are sized each on the rig without anything missing, torque and friction on the rig with its large causes, all
without a refit (`tangent`).
`small_parts` draws them; `case_of` makes the case of a line that holds them.
"""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np

from experiments.blind.cases import JITTER, KINDS, Case, Prepared, built, observe, prepare, sampled, split
from experiments.blind.draws import EFFECTS, Numbers, between, put, sign
from experiments.blind.outside import OUTSIDE
from experiments.blind.rigs import FIELD, Rig, number, with_number
from experiments.blind.sensors import Recorded
from experiments.blind.sizes import OutOfReach, reach
from experiments.blind.tangent import Tangent, tangent
from experiments.blind.truth import Truth

SMALL = (0.3, 3.0)  # sizes of small causes
LEAST_SPREAD = 1e-4  # of the friction from run to run, below which something else is that large
FEWEST, MOST = 3, 6  # small causes
STRONGEST = 1.0  # amplitude of a small cause
OFF = (0.02, 0.1)  # relative error of a fixed number
TORQUE = (0.2, 1.0)  # sizes of the noise of the torque
DRAW, PLACE, NUMBERS, SAMPLES, FRICTION = range(101, 106)  # apart from the random numbers of `cases`


@dataclass(frozen=True)
class Mess:
    """What varies without any name."""

    jitter: float  # s, largest further distance of a sample from its time stamp
    colour: float  # correlation of the noise of neighbouring samples
    torque: float  # N m, RMS of the coloured noise of the torque
    friction: float  # standard deviation of the logarithm by which friction differs from run to run


def _rng(kind: str, seed: int, *what: int) -> np.random.Generator:
    return np.random.default_rng([seed, KINDS.index(kind), *what])


def drawn(prepared: Prepared, seed: int, name: str) -> Numbers:
    """Numbers of a small cause in a rig, whatever others there are."""
    effect = (EFFECTS | OUTSIDE)[name]
    return effect.draw(prepared.scene, _rng(prepared.rig.kind, seed, NUMBERS, *(ord(c) for c in name)))


def off(kind: str, seed: int, name: str) -> float:
    """Logarithm (angle: difference in rad) by which a fixed number is off at amplitude 1."""
    rng = _rng(kind, seed, NUMBERS, *(ord(c) for c in name))
    return sign(rng) * float(np.log1p(between(rng, *OFF)))


def friction(kind: str, seed: int, count: int, spread: float) -> np.ndarray:
    """Factor on the friction of each run."""
    return np.exp(spread * _rng(kind, seed, FRICTION).standard_normal(count))


def possible(rig: Rig, name: str) -> bool:
    """Whether a rig that was drawn for other causes can show this one, too."""
    effect = (EFFECTS | OUTSIDE)[name]
    asked = effect.always
    columns = set(asked.columns) - ({"wheel_counts"} if rig.kind != "wheel" else set())
    return (
        rig.kind in effect.kinds
        and {*asked.models} <= {*rig.names}
        and columns <= {*rig.sensors.noise}
        and not {*asked.lacks} & {*rig.names}
        and not {*asked.fixed} & {*rig.free}
        and not (asked.inductance and rig.truth.L == 0.0)
    )


def small_parts(kind: str, effect: str, seed: int, amplitude: Mapping[str, float]) -> dict:
    """Everything small of a rig whose large causes have these amplitudes.

    `small` has the amplitude and the size of each name, `mess` what varies, `mess_size` the sizes of two parts of that.
    """
    prepared, rng = prepare(kind, effect, seed), _rng(kind, seed, DRAW)
    near, large = tangent(prepared), prepared.rig.truth
    for name, numbers in prepared.numbers.items():
        large = put(large, numbers, amplitude[name])
    small = _causes(prepared, near, seed, rng) | _wrong(prepared, near, seed, rng)
    torque, by_torque = _torque(prepared, near, large, rng)
    spread, by_friction = _spread(near, large, prepared.rig.kind, seed, rng)
    mess = Mess(float(f"{rng.uniform(1e-4, 5e-4):.3g}"), float(f"{rng.uniform(0.5, 0.95):.3g}"), torque, spread)
    return {"small": small, "mess": asdict(mess), "mess_size": {"torque": by_torque, "friction": by_friction}}


def _causes(prepared: Prepared, near: Tangent, seed: int, rng: np.random.Generator) -> dict[str, dict[str, float]]:
    """Small causes that share no number with each other or with a large one."""
    rig = prepared.rig
    taken = {field for numbers in prepared.numbers.values() for field in numbers}
    able = [name for name in (*EFFECTS, *OUTSIDE) if name not in prepared.numbers and possible(rig, name)]
    count, found = int(rng.integers(FEWEST, MOST + 1)), {}
    for name in rng.permutation(able):
        wanted = float(np.exp(rng.uniform(*np.log(SMALL))))
        numbers = drawn(prepared, seed, str(name))
        if len(found) == count:
            break
        if taken & {*numbers}:
            continue
        try:
            amplitude, size = _reached(near, numbers, wanted)
        except OutOfReach:
            continue
        if amplitude <= STRONGEST:
            found[str(name)] = {"amplitude": amplitude, "size": size}
            taken |= {*numbers}
    if len(found) < FEWEST:
        raise OutOfReach(f"only {len(found)} small causes can be found")
    return found


def _reached(near: Tangent, numbers: Numbers, wanted: float) -> tuple[float, float]:
    """Amplitude of a cause for a size, and the size."""
    sizes: dict[float, float] = {}

    def measure(amplitude: float) -> float:
        sizes[amplitude] = near.size(put(near.truth, numbers, amplitude))
        return sizes[amplitude]

    amplitude = reach(measure, wanted, float(np.log(0.1)), SMALL)
    return amplitude, float(f"{sizes[amplitude]:.3g}")


def _wrong(prepared: Prepared, near: Tangent, seed: int, rng: np.random.Generator) -> dict[str, dict[str, float]]:
    """One or two numbers of the rig file that no fit estimates, and by how much they are off."""
    rig, found = prepared.rig, {}
    taken = {field for numbers in prepared.numbers.values() for field in numbers}
    fixed = [n for n in rig.names if n in FIELD and n not in rig.free and FIELD[n] not in taken]
    count = int(rng.integers(1, 3))
    for name in rng.permutation(fixed):
        by = off(rig.kind, seed, str(name))
        for amplitude in (1.0, float(f"{np.log1p(OFF[0]) / abs(by):.4g}")):
            size = near.size(rig.truth, believed=misread(rig.truth, str(name), amplitude * by))
            if size <= SMALL[1] and len(found) < count:
                found[f"parameter.{name}"] = {"amplitude": amplitude, "size": float(f"{size:.3g}")}
                break
    return found


def misread(truth: Truth, name: str, by: float) -> Truth:
    """The rig as its file has it, with a number off by a logarithm (angle: a difference in rad)."""
    value = number(truth, name)
    return with_number(truth, name, value + by if name == "axis.gravity.angle" else value * float(np.exp(by)))


def _torque(prepared: Prepared, near: Tangent, large: Truth, rng: np.random.Generator) -> tuple[float, float]:
    """RMS of the noise of the torque [N m] and its size."""
    scene, sizes = prepared.scene, {}
    full = 0.1 * (scene.stall if scene.rig.kind == "wheel" else scene.torque)

    def measure(amplitude: float) -> float:
        shaken = [replace(record, rumble=float(f"{amplitude * full:.4g}")) for record in near.records]
        sizes[amplitude] = near.size(large, shaken, large)
        return sizes[amplitude]

    wanted = float(np.exp(rng.uniform(*np.log(TORQUE))))
    amplitude = reach(measure, wanted, float(np.log(0.1)), TORQUE)
    return float(f"{amplitude * full:.4g}"), float(f"{sizes[amplitude]:.3g}")


def _spread(near: Tangent, large: Truth, kind: str, seed: int, rng: np.random.Generator) -> tuple[float, float]:
    """Spread of the friction from run to run, and its size."""
    spread = float(f"{rng.uniform(0.01, 0.05):.3g}")
    while True:
        factors = friction(kind, seed, len(near.records), spread)
        varied = [replace(r, friction=float(f)) for r, f in zip(near.records, factors, strict=True)]
        size = near.size(large, varied, large)
        if size <= SMALL[1]:
            return spread, float(f"{size:.3g}")
        spread = float(f"{0.7 * spread:.3g}")
        if spread < LEAST_SPREAD:
            raise OutOfReach(f"size {size:.3g} with friction that hardly differs from run to run")


def messed(prepared: Prepared, seed: int, small: Iterable[str], mess: Mess) -> Prepared:
    """A rig with small causes and mess."""
    rig, rng = prepared.rig, _rng(prepared.rig.kind, seed, SAMPLES)
    rig = replace(rig, sensors=replace(rig.sensors, colour=mess.colour))
    factors = friction(rig.kind, seed, len(prepared.runs), mess.friction)
    runs: dict[str, tuple[Recorded, bool]] = {}
    for (name, (record, validate)), factor in zip(prepared.runs.items(), factors, strict=True):
        at = sampled(rig, record.at, rng.uniform(-mess.jitter, mess.jitter, len(record.at)))
        runs[name] = (replace(record, at=at, friction=float(factor), rumble=mess.torque), validate)
    scene = observe(rig, [record for record, _ in runs.values()], float(np.hypot(JITTER, mess.jitter)))
    numbers, wrong = dict(prepared.numbers), dict(prepared.wrong)
    for name in small:
        if name.startswith("parameter."):
            wrong[name.removeprefix("parameter.")] = off(rig.kind, seed, name.removeprefix("parameter."))
        else:
            numbers[name] = drawn(prepared, seed, name)
    return Prepared(rig, scene, runs, numbers, wrong)


def prepared_of(row: Mapping) -> Prepared:
    """The rig and the runs of a line of a set, messy or not."""
    prepared = prepare(row["kind"], row["effect"], row["seed"])
    return messed(prepared, row["seed"], row["small"], Mess(**row["mess"])) if "mess" in row else prepared


def case_from(prepared: Prepared, row: Mapping) -> Case:
    """The case of a line of a set with the runs of `prepared`, without its raw size."""
    effect, seed = row["effect"], row["seed"]
    if "mess" not in row:
        return built(prepared, effect, seed, row["amplitude"], raw=False)
    amplitude = {name: float(row["amplitude"][name]) for name in split(effect)}
    amplitude |= {name: one["amplitude"] for name, one in row["small"].items()}
    case = built(prepared, effect, seed, amplitude, raw=False)
    mess = row["mess"] | {"friction_of_runs": {name: record.friction for name, (record, _) in prepared.runs.items()}}
    return replace(case, truth=case.truth | {"small": row["small"], "mess": mess})


def case_of(row: Mapping) -> Case:
    """The case of a line of a set, messy or not, without its raw size."""
    return case_from(prepared_of(row), row)
