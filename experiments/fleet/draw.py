"""A simulated fleet: rigs of one design that differ by some percent, measured in two sessions, some of which wear in between.

`python -m experiments.fleet.draw FOLDER [--rigs 100] [--worn 0.05] [--by 0.05] [--appears 0.05] [--seed 0]` writes rig file, logs and
plans; `label.json` says which rigs changed, and no command reads it.
"""

import argparse
import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from experiments.blind.commands import TICK, command
from experiments.blind.simulator import simulate
from experiments.blind.truth import OMEGA, PSI, Truth
from experiments.speed.diagnosis import MOTOR
from rwjax import write_log

SESSIONS = ("2026-01", "2026-02")
RUNS = ("square", "multisine", "triangle")
SECONDS, TOP, COUNTS = 10.0, 6.0, 4096
DESIGN = Truth(kind=2, I=0.0495, viscous=0.0026, coulomb=0.012)
DIFFER = {"I": 0.02, "viscous": 0.05, "coulomb": 0.03}
"""Standard deviation over rigs, as a share of the design's number [1]."""
DAYS = {"viscous": 0.01, "coulomb": 0.007}
"""The same from session to session of a sound rig, for temperature and grease: two sessions differ by 1 % in dry friction [1]."""
WEARS = "coulomb"
APPEARS = {"deadzone": 0.1}
"""What appears in some rigs [V]."""
AXIS = """[axis]
inertia = 0.05
[axis.friction]
viscous = 0.003
coulomb = 0.01
[encoder]
counts_per_rev = 4096
[fit]
free = ["axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"]
"""
RIG = f'kind = "reaction"\n{MOTOR}{AXIS}'
PLAN = 'command = "{}"\nrig = "rig.toml"\nlogs = "logs/{{rig}}/{{when}}/*.csv"\n'


def drawn(number: int, seed: int, changed: str, by: float) -> list[Truth]:
    """The truth of a rig in each session; `changed` is `worn`, `appears` or nothing."""
    rng = np.random.default_rng([seed, number])
    own = replace(DESIGN, **{name: getattr(DESIGN, name) * (1.0 + s * rng.normal()) for name, s in DIFFER.items()})
    found = [
        replace(own, **{name: getattr(own, name) * (1.0 + s * rng.normal()) for name, s in DAYS.items()})
        for _ in SESSIONS
    ]
    if changed == "worn":
        found[-1] = replace(found[-1], **{WEARS: getattr(found[-1], WEARS) * (1.0 + by)})
    if changed == "appears":
        found[-1] = replace(found[-1], **APPEARS)
    return found


def written(number: int, seed: int, changed: str, by: float, folder: Path) -> None:
    """Writes the logs of a rig."""
    rng = np.random.default_rng([seed, number, 1])
    for session, truth in zip(SESSIONS, drawn(number, seed, changed, by), strict=True):
        own = folder / "logs" / name_of(number) / session
        own.mkdir(parents=True, exist_ok=True)
        for run in RUNS:
            u = command(run, SECONDS, TOP, rng)
            t = np.round(TICK * np.arange(len(u)), 3)
            x = simulate(t, u, t, np.zeros(5), truth.array())
            counts = np.floor(x[:, PSI] * COUNTS / (2.0 * np.pi) + 0.5)
            rate = np.round(x[:, OMEGA] + rng.normal(0.0, 0.5, len(u)), 2)
            write_log(own / f"{run}.csv", {"time_s": t, "voltage_V": u, "yaw_counts": counts, "wheel_rad_s": rate}, {})


def name_of(number: int) -> str:
    """Name of a rig."""
    return f"rig{number:05d}"


def write_fleet(
    folder: Path,
    rigs: int,
    worn: float = 0.0,
    by: float = 0.05,
    appears: float = 0.0,
    seed: int = 0,
    processes: int = 2,
) -> dict[str, str]:
    """Writes a fleet, its plans and its label; what changed by the name of the rig."""
    folder.mkdir(parents=True, exist_ok=True)
    order = np.random.default_rng([seed, rigs]).permutation(rigs)
    first, second = round(worn * rigs), round((worn + appears) * rigs)
    kinds = dict.fromkeys(order[:first].tolist(), "worn") | dict.fromkeys(order[first:second].tolist(), "appears")
    one = partial(_one, seed=seed, kinds=kinds, by=by, folder=folder)
    if processes > 1 and rigs > 1:
        with ProcessPoolExecutor(processes) as pool:
            list(pool.map(one, range(rigs), chunksize=max(rigs // (4 * processes), 1)))
    else:
        list(map(one, range(rigs)))
    (folder / "rig.toml").write_text(RIG)
    for do in ("fit", "diagnose"):
        (folder / f"{do}.toml").write_text(PLAN.format(do))
    label = {name_of(number): kind for number, kind in sorted(kinds.items())}
    (folder / "label.json").write_text(json.dumps(label))
    return label


def _one(number: int, seed: int, kinds: dict[int, str], by: float, folder: Path) -> None:
    written(number, seed, kinds.get(number, ""), by, folder)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rigs", type=int, default=100)
    parser.add_argument("--worn", type=float, default=0.05)
    parser.add_argument("--by", type=float, default=0.05)
    parser.add_argument("--appears", type=float, default=0.05)
    parser.add_argument("--seed", type=int, default=0)
    a = parser.parse_args(arguments)
    label = write_fleet(a.folder, a.rigs, a.worn, a.by, a.appears, a.seed)
    print(
        f"{a.rigs} rigs, {len(label)} of them changed; next: rwjax fleet {a.folder / 'fit.toml'} -o {a.folder / 'fitted'}"
    )


if __name__ == "__main__":
    main()
