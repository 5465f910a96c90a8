"""How long a diagnosis takes: `python -m experiments.speed.diagnosis [--xla] [CASE …]`, four logs, all effects, the whole process.

Each case is a rig of the separate simulator (`experiments/blind`) that lacks one effect. Logs are 30 s long, those of the servo 6 s. `rwjax diagnose` runs twice in processes of
their own with a cache of their own: the first compiles everything, the second finds it on disk.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from experiments.blind.cases import write_case
from experiments.blind.commands import TICK, command
from experiments.blind.simulator import simulate
from experiments.blind.truth import OMEGA, PSI, THETA, Truth
from experiments.joints.draw import make_case
from experiments.speed.lowering import XLA, by_xla
from experiments.speed.table import machine, show, timed
from rwjax import write_log
from rwjax.cache_folder import VARIABLE

ROOT = Path(__file__).parents[2]
SECONDS, TOP, COUNTS = 30.0, 6.0, 2048
RUNS = {"square": "train", "multisine": "train", "triangle": "train", "mixed": "validate"}
MOTOR = "[motor]\ntorque_constant = 0.0182\nresistance = 0.83\ninductance = 0.0641\nfriction = 4.07e-6\n[wheel]\ninertia = 1.24e-4\n"
AXIS = "[axis.friction]\nviscous = {viscous}\n[encoder]\ncounts_per_rev = 2048\n[fit]\n"
RIGS = {
    0: f'kind = "wheel"\n{MOTOR}[wheel_encoder]\ncounts_per_rev = 2048\n[fit]\nfree = ["wheel.inertia", "motor.friction"]\n',
    1: 'kind = "platform"\n[drive]\ngain = 0.428\n[axis]\ninertia = 0.25\n'
    + AXIS.format(viscous=0.08)
    + 'free = ["axis.inertia", "axis.friction.viscous"]\n',
    2: f'kind = "reaction"\n{MOTOR}[axis]\ninertia = 0.06\n'
    + AXIS.format(viscous=0.004)
    + 'free = ["axis.inertia", "axis.friction.viscous"]\n',
}


class ServoCase(NamedTuple):
    """A servo joint of `experiments.joints.draw`, whose rig file lacks its load."""

    seed: int


PLATFORM, REACTION, WHEEL = Truth(kind=1, viscous=0.06), Truth(kind=2, I=0.0495, viscous=0.0026), Truth(kind=0)
CASES = {
    "platform, Stribeck friction": replace(PLATFORM, coulomb=0.45, excess=0.3, v_s=0.35),
    "platform, nothing": PLATFORM,
    "reaction, Coulomb friction": replace(REACTION, coulomb=0.012),
    "reaction, a dead zone": replace(REACTION, deadzone=0.8),
    "reaction, nothing": REACTION,
    "wheel, Coulomb friction": replace(WHEEL, wheel_coulomb=0.004),
    "servo, its load": ServoCase(10),
}


def write(truth: Truth | ServoCase, folder: Path) -> list[str]:
    """The rig file and the logs of a case; the logs' names."""
    if isinstance(truth, ServoCase):
        case = make_case("goal", truth.seed)
        rig, sections = re.subn(r"\[axis\.gravity\]\n(?:.+\n)*", "", case.rig)
        assert sections == 1, "this joint has a load"
        write_case(replace(case, rig=rig), folder)
        return sorted(case.logs)
    rng = np.random.default_rng(11)
    (folder / "rig.toml").write_text(RIGS[truth.kind])
    for name, role in RUNS.items():
        u = command(name, SECONDS, TOP, rng)
        t = np.round(TICK * np.arange(len(u)), 3)
        x = simulate(t, u, t, np.zeros(5), truth.array())
        angle, column = (x[:, THETA], "wheel_counts") if truth.kind == 0 else (x[:, PSI], "yaw_counts")
        columns = {"time_s": t, "voltage_V": u, column: np.floor(angle * COUNTS / (2.0 * np.pi) + 0.5)}
        if truth.kind == 2:
            columns["wheel_rad_s"] = np.round(x[:, OMEGA] + rng.normal(0.0, 0.5, len(u)), 2)
        write_log(folder / f"{name}.csv", columns, {"role": role})
    return [f"{name}.csv" for name in RUNS]


def once(folder: Path, logs: list[str], cache: Path, out: str = "out") -> dict:
    """The answer of `rwjax diagnose` in a process of its own."""
    call = [sys.executable, "-m", "rwjax", "diagnose", "rig.toml", *logs, "--json", "--budget", "inf", "-o", out]
    done = subprocess.run(call, cwd=folder, env=environment(cache), check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def environment(cache: Path) -> dict[str, str]:
    """Variables for a process with a cache of its own, which may start in another folder."""
    kept = {name: value for name, value in os.environ.items() if name != VARIABLE}
    return kept | {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}


class Timed(NamedTuple):
    """Seconds of a case, cold and then warm, and its answer."""

    seconds: list[float]
    answer: dict

    def __str__(self) -> str:
        """The answer in short."""
        return f"{self.answer['verdict']}: {', '.join(self.answer['effects']) or '-'}"


def cold_and_warm(name: str, ways: dict[str, Callable[..., dict]]) -> dict[str, Timed]:
    """A case by each way in turn, first all cold and then all warm, each with a cache of its own."""
    found: dict[str, Timed] = {}
    with tempfile.TemporaryDirectory() as folder:
        logs = write(CASES[name], Path(folder))
        for state in ("cold", "warm"):
            for k, (way, call) in enumerate(ways.items()):
                took, answer = timed(call, Path(folder), logs, Path(folder) / f"cache{k}")
                before = found.setdefault(way, Timed([], answer))
                assert answer == before.answer, f"{name}: {way} answers otherwise {state}"
                before.seconds.append(took)
    return found


def main() -> None:
    """Prints a line for each case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="CASE", help=", ".join(CASES))
    parser.add_argument("--xla", action="store_true", help=f"each case with {XLA} too, in turn")
    a = parser.parse_args()
    if unknown := {*a.names} - {*CASES}:
        parser.error(f"unknown case {', '.join(unknown)}; cases are {'; '.join(CASES)}")
    ways: dict[str, Callable[..., dict]] = {"rwjax": once} | ({XLA: by_xla(once)} if a.xla else {})
    rows = []
    for name in a.names or CASES:
        found = cold_and_warm(name, ways)
        answers = " | ".join(dict.fromkeys(str(found[way]) for way in ways))
        rows.append([name, answers, *(f"{seconds:.1f}" for way in ways for seconds in found[way].seconds)])
        print(rows[-1], file=sys.stderr, flush=True)
    show(
        f"`rwjax diagnose`, four logs; {machine()}",
        ("rig and what it lacks", "answer", *(f"{way}, {kind} [s]" for way in ways for kind in ("cold", "warm"))),
        rows,
    )


if __name__ == "__main__":
    main()
