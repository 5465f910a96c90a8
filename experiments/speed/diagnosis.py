"""How long a diagnosis takes: `python -m experiments.speed.diagnosis [CASE …]`, four logs of 30 s, all effects, the whole process.

Each case is a rig of the separate simulator (`experiments/blind`) that lacks one effect. `rwjax diagnose` runs twice in processes of
their own with a cache of their own: the first compiles everything, the second finds it on disk.
"""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.blind.commands import TICK, command
from experiments.blind.simulator import simulate
from experiments.blind.truth import OMEGA, PSI, THETA, Truth
from experiments.speed.run import machine
from experiments.speed.table import show, timed
from rwjax import write_log

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
PLATFORM, REACTION, WHEEL = Truth(kind=1, viscous=0.06), Truth(kind=2, I=0.0495, viscous=0.0026), Truth(kind=0)
CASES = {
    "platform, Stribeck friction": replace(PLATFORM, coulomb=0.45, excess=0.3, v_s=0.35),
    "platform, nothing": PLATFORM,
    "reaction, Coulomb friction": replace(REACTION, coulomb=0.012),
    "reaction, a dead zone": replace(REACTION, deadzone=0.8),
    "reaction, nothing": REACTION,
    "wheel, Coulomb friction": replace(WHEEL, wheel_coulomb=0.004),
}


def write(truth: Truth, folder: Path) -> list[str]:
    """The rig file and the logs of a case; the logs' names."""
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


def once(folder: Path, logs: list[str], cache: Path) -> dict:
    """The answer of `rwjax diagnose` in a process of its own."""
    call = [sys.executable, "-m", "rwjax", "diagnose", "rig.toml", *logs, "--json", "-o", "out"]
    env = os.environ | {"XDG_CACHE_HOME": str(cache), "PYTHONPATH": os.pathsep.join(["", *sys.path])}
    return json.loads(subprocess.run(call, cwd=folder, env=env, check=True, capture_output=True, text=True).stdout)


def main(names: list[str]) -> None:
    """Prints a line for each case."""
    rows = []
    for name in names or CASES:
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as cache:
            logs = write(CASES[name], Path(folder))
            cold, found = timed(once, Path(folder), logs, Path(cache))
            warm, again = timed(once, Path(folder), logs, Path(cache))
        assert again == found, name
        rows.append([name, f"{found['verdict']}: {', '.join(found['effects']) or '-'}", f"{cold:.1f}", f"{warm:.1f}"])
        print(rows[-1], file=sys.stderr, flush=True)
    show(
        f"`rwjax diagnose`, four logs of {SECONDS:g} s; {machine()}",
        ("rig and what it lacks", "answer", "cold [s]", "warm [s]"),
        rows,
    )


if __name__ == "__main__":
    main(sys.argv[1:])
