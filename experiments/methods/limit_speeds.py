"""Limit speeds: the thesis's motor, the geared motor, and how often the 95 % intervals hold the truth on simulated rigs.

`python -m experiments.methods.limit_speeds [RIGS]` simulates staircases up and down again by the exact solution of eq. 3.1 over
every sample, which shares no code with the library.
"""

import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter
from scipy.stats import binomtest

from experiments.realdata import dcmotor, folder
from rwjax import InputError, Log, Rig, parse_rig, read_log, read_rig
from rwjax.methods.identified import Identified
from rwjax.methods.limit_speeds import limit_speeds

YAW = Path(__file__).parents[2] / "data" / "thesis" / "yaw.toml"
TICK = 0.01  # s
COUNTS = 2048


class Motor(NamedTuple):
    """Numbers of eq. 3.1, SI, and the level of dry friction of the wheel."""

    K: float
    R: float
    L: float
    b: float
    J: float
    dry: float = 0.0

    def run(self, volts: np.ndarray, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Angle [rad] and speed with current `(time, 2)` from rest; the wheel turns one way, against a load [N m] besides."""
        A = np.array(
            [[0.0, 1.0, 0.0], [0.0, -self.b / self.J, self.K / self.J], [0.0, -self.K / self.L, -self.R / self.L]]
        )
        push = np.zeros((5, 5))
        push[:3, :3], push[1, 3], push[2, 4] = A, -1.0 / self.J, 1.0 / self.L
        step = expm(TICK * push)[:3]
        x = np.zeros((len(volts), 3))
        way = np.sign(volts[0])
        for k in range(len(volts) - 1):
            x[k + 1] = step @ np.append(x[k], [way * self.dry + load[k], volts[k]])
        return x[:, 0], x[:, 1:]


class Case(NamedTuple):
    """What is logged and estimated: outputs, free numbers, kind of rig, and how loads differ between plateaus."""

    name: str
    outputs: tuple[str, ...]
    free: tuple[str, ...]
    kind: str = "wheel"
    dry: bool = False
    uneven: float = 0.0


B, K, DRY = "motor.friction", "motor.torque_constant", "wheel.coulomb.M_c"
CASES = (
    Case("speed: b", ("wheel_rad_s",), (B,)),
    Case("speed: K", ("wheel_rad_s",), (K,)),
    Case("counts: b", ("wheel_rad",), (B,), "reaction"),
    Case("speed and current: K and b", ("wheel_rad_s", "current_A"), (K, B)),
    Case("speed, dry friction: b and M_c", ("wheel_rad_s",), (B, DRY), dry=True),
    Case("speed and current, dry friction: all", ("wheel_rad_s", "current_A"), (K, B, DRY), dry=True),
    Case("speed, a load that differs by plateau: b", ("wheel_rad_s",), (B,), uneven=0.003),
)


def rig_of(motor: Motor, case: Case) -> Rig:
    """The rig file that a user would have, its free numbers a fifth off."""
    values = {name: 1.2 if name in case.free else 1.0 for name in (K, B, DRY)}
    axis = "[axis]\ninertia = 0.05\n" if case.kind == "reaction" else ""
    dry = f'[effects."wheel.coulomb"]\nM_c = {motor.dry * values[DRY]}\n' if case.dry else ""
    return parse_rig(
        f'kind = "{case.kind}"\n[motor]\ntorque_constant = {motor.K * values[K]}\nresistance = {motor.R}\n'
        f"inductance = {motor.L}\nfriction = {motor.b * values[B]}\n[wheel]\ninertia = {motor.J}\n{axis}{dry}"
        f"[wheel_encoder]\ncounts_per_rev = {COUNTS}\n[fit]\nfree = {[*case.free]}".replace("'", '"')
    )


def noise(rng: np.random.Generator, n: int, size: float) -> np.ndarray:
    """White noise, or noise that is alike over ten samples, half of the time each."""
    white = rng.normal(size=n)
    return size * (white if rng.uniform() < 0.5 else np.asarray(lfilter([np.sqrt(1.0 - 0.9**2)], [1.0, -0.9], white)))


def staircase(rng: np.random.Generator, motor: Motor, case: Case, way: float, wait: float) -> Log:
    """A staircase up to 10 V and down again, one way, each level held for `wait` seconds."""
    levels = way * np.array([2.0, 4.0, 6.0, 8.0, 10.0, 7.0, 5.0, 3.0])
    held = round(wait / TICK)
    volts = np.repeat(levels, held)
    top = 10.0 / motor.K
    uneven = case.uneven * top * (motor.R * motor.b / motor.K + motor.K) * motor.K / motor.R
    angle, x = motor.run(volts, np.repeat(uneven * rng.normal(size=len(levels)), held))
    quantum = 2.0 * np.pi / COUNTS
    outputs = {
        "wheel_rad_s": x[:, 0] + noise(rng, len(volts), top * rng.uniform(0.001, 0.01)),
        "current_A": x[:, 1] + noise(rng, len(volts), 0.03 * motor.K / motor.R * top * rng.uniform(0.01, 0.1)),
        "wheel_rad": quantum * np.floor(angle / quantum + rng.uniform()),
    }
    kept = {name: outputs[name] for name in case.outputs}
    resolution = {name: quantum if name == "wheel_rad" else 0.0 for name in kept}
    return Log("stairs.csv", np.arange(len(volts)) * TICK, volts, kept, resolution, {}, False, None, 0.0)


def draw(rng: np.random.Generator, case: Case) -> tuple[Motor, list[Log]]:
    """A motor and its logs, one for each way."""
    k, r, tau = np.exp(rng.uniform(np.log([0.01, 0.3, 0.05]), np.log([0.1, 3.0, 0.5])))
    b = k**2 / r * np.exp(rng.uniform(np.log(0.01), np.log(0.3)))
    dry = 0.03 * 10.0 * k / r if case.dry else 0.0
    motor = Motor(k, r, r * tau * rng.uniform(0.02, 0.2), b, tau * k**2 / r, dry)
    wait = max(1.5, tau * rng.uniform(12.0, 30.0))
    return motor, [staircase(rng, motor, case, way, wait) for way in (1.0, -1.0)]


def held(case: Case, seed: int) -> list[bool] | None:
    """Whether the interval of every free number holds the truth; None where the method refuses the logs."""
    motor, logs = draw(np.random.default_rng(seed), case)
    truth = {K: motor.K, B: motor.b, DRY: motor.dry}
    try:
        found = limit_speeds(rig_of(motor, case), logs)
    except InputError:
        return None
    return [low <= truth[name] <= high for name, (low, high) in found.interval.items()]


def thesis() -> Identified:
    """The motor's friction from staircases of the thesis's motor, regenerated and read in counts."""
    rig = read_rig(YAW)
    n = rig.numbers
    motor = Motor(n[K], n["motor.resistance"], n["motor.inductance"], n[B], n["wheel.inertia"])
    rng = np.random.default_rng(0)
    case = Case("thesis", ("wheel_rad",), (B,), "reaction")
    return limit_speeds(rig_of(motor, case), [staircase(rng, motor, case, way, 6.0) for way in (1.0, -1.0)])


def geared() -> Identified:
    """The friction of the geared motor from the staircase of its published log."""
    rig = replace(read_rig(Path(__file__).parents[1] / "dcmotor" / "rig.toml"), free=(B,))
    with TemporaryDirectory() as target:
        return limit_speeds(rig, [read_log(dcmotor(Path(target)), rig)])


def shown(name: str, found: Identified) -> None:
    """Prints what a rig's steady speeds say of b."""
    print(f"{name}: b {found.rig.values[B]:.4g} ± {found.rig.standard_error[B]:.1g} N m s/rad")
    print("  " + "\n  ".join(found.notes))


def main(rigs: int) -> None:
    """Prints the coverage of every case."""
    shown("thesis's motor, regenerated staircases in counts", thesis())
    if folder() is not None:
        shown("geared motor", geared())
    print(f"{'logged: estimated':45s} {'intervals':>9s} {'hold':>7s}  95 % binomial  refused")
    for k, case in enumerate(CASES):
        results = [held(case, 10_000 * k + seed) for seed in range(rigs)]
        each = [hold for result in results if result for hold in result]
        low, high = binomtest(sum(each), len(each)).proportion_ci(method="exact")
        print(
            f"{case.name:45s} {len(each):9d} {100.0 * np.mean(each):6.1f} %  {100 * low:.1f} to {100 * high:.1f}  "
            f"{sum(result is None for result in results)}"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
