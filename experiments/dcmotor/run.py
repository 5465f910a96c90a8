"""Geared motor on an L298N bridge: linear fit, diagnosis, and the sets that it leaves open, fitted to the whole log.

`python -m experiments.dcmotor.run [FOLDER]`
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.realdata import dcmotor
from rwjax import read_log, read_rig
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.fitting.fit import fit
from rwjax.fitting.prediction import errors, predict_logs
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.report.html import write_report

RPM = 60.0 / (2.0 * np.pi)
SETS = (
    {},
    {"drive.deadzone": {"u_0": 1.0}},
    {"wheel.coulomb": {"M_c": 0.2}},
    {"drive.deadzone": {"u_0": 1.0}, "drive.bias": {"u_b": 0.05}},
    {"wheel.coulomb": {"M_c": 0.2}, "drive.bias": {"u_b": 0.05}},
    {"wheel.coulomb": {"M_c": 0.2}, "drive.deadzone": {"u_0": 0.5}, "drive.bias": {"u_b": 0.05}},
    {"drive.deadzone": {"u_0": 1.0}, "drive.bias": {"u_b": 0.05}, "drive.delay": {"tau": 0.02}},
)


def mae_rpm(rig, log) -> float:
    """Mean absolute error of the free run [rpm]."""
    structure = structure_of(rig)
    problem = pose(structure, (log,))
    error = errors(problem, predict_logs(problem, theta_of(rig, structure), with_floor=False))[0]["wheel_rad_s"]
    return RPM * float(np.mean(np.abs(error)))


def main(folder: Path) -> None:
    """Prints the fits and the diagnosis; writes the report into `folder`."""
    base = read_rig(Path(__file__).with_name("rig.toml"))
    log = read_log(dcmotor(folder), base)
    print("sets of effects fitted to the whole log          MAE [rpm]   numbers")
    for effects in SETS:
        free = (*base.free, *(f"{e}.{p}" for e, given in effects.items() for p in given))
        found = fit(replace(base, effects=effects, free=free), [log]).rig
        numbers = ", ".join(f"{name} {found.values[name]:.4g}" for name in free[len(base.free) :])
        print(f"  {' + '.join(effects) or 'linear':46s} {mae_rpm(found, log):8.2f}   {numbers}")
    result = diagnose(base, [log])
    print(result)
    print(f"  report: {write_report(result, folder)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/dcmotor"))
