"""Identification methods on measured logs, with a model that lacks something and with one that lacks less.

`python -m experiments.methods.measured [emps|dcmotor] [FOLDER]` (EMPS: ten minutes on two cores, most of them the Kalman
filter's; the geared motor: one)
"""

import sys
from dataclasses import replace
from pathlib import Path

from experiments.realdata import dcmotor, emps
from rwjax import Log, Rig, read_log, read_rig
from rwjax.methods.comparison import compare
from rwjax.report.comparison import table

FOLDERS = Path(__file__).parents[1]


def _with(rig: Rig, effects: dict[str, dict[str, float]]) -> Rig:
    return replace(rig, effects=effects, free=(*rig.free, *(f"{e}.{p}" for e, given in effects.items() for p in given)))


def emps_models(folder: Path) -> tuple[list[Log], dict[str, Rig]]:
    """EMPS with the bias that its logs need and without it: which methods keep the mass?"""
    base = read_rig(FOLDERS / "emps" / "rig.toml")
    logs = [read_log(path, base) for path in emps(folder)]
    free = (*base.free, "axis.friction.coulomb")
    without = replace(base, numbers=base.numbers | {"axis.friction.coulomb": 10.0}, free=free)
    return logs, {"EMPS without a bias": without, "EMPS with a bias": _with(without, {"axis.bias_torque": {"T": 0.0}})}


def dcmotor_models(folder: Path) -> tuple[list[Log], dict[str, Rig]]:
    """Geared motor, linear and with the three effects that fit it best."""
    base = read_rig(FOLDERS / "dcmotor" / "rig.toml")
    found = {"wheel.coulomb": {"M_c": 0.2}, "drive.deadzone": {"u_0": 0.5}, "drive.bias": {"u_b": 0.05}}
    return [read_log(dcmotor(folder), base)], {"geared motor, linear": base, "with three effects": _with(base, found)}


def main(rig: str, folder: Path) -> None:
    """Prints a table for each model."""
    logs, models = {"emps": emps_models, "dcmotor": dcmotor_models}[rig](folder)
    for title, model in models.items():
        print(title)
        print(table(compare(model, logs)), flush=True)


if __name__ == "__main__":
    chosen = sys.argv[1] if len(sys.argv) > 1 else "emps"
    main(chosen, Path(sys.argv[2]) if len(sys.argv) > 2 else Path("build") / chosen)
