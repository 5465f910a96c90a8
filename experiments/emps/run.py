"""EMPS: four terms fitted to one log and judged on the other, then diagnosed from a rig without dry friction and bias.

`python -m experiments.emps.run [FOLDER]`
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.realdata import emps
from rwjax import read_log, read_rig
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.fitting.fit import fit
from rwjax.fitting.prediction import errors, predict_logs
from rwjax.fitting.problem import pose
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.report.html import write_report

SKIPPED = 20  # first samples, as in the benchmark's rule
PUBLISHED = {
    "axis.inertia": 95.1089,
    "axis.friction.viscous": 203.5034,
    "axis.friction.coulomb": 20.3935,
    "axis.bias_torque.T": 3.1648,
}


def rmse_mm(rig, log) -> float:
    """Free-run RMSE of the position [mm]."""
    structure = structure_of(rig)
    problem = pose(structure, (log,))
    error = errors(problem, predict_logs(problem, theta_of(rig, structure), with_floor=False))[0]["yaw_rad"]
    return 1e3 * float(np.sqrt(np.mean(error[SKIPPED:] ** 2)))


def main(folder: Path) -> None:
    """Prints the fit of the four terms and the diagnosis; writes the report into `folder`."""
    base = read_rig(Path(__file__).with_name("rig.toml"))
    logs = [read_log(path, base) for path in emps(folder)]
    four = replace(
        base,
        numbers=base.numbers | {"axis.friction.coulomb": 10.0},
        effects={"axis.bias_torque": {"T": 0.0}},
        free=(*base.free, "axis.friction.coulomb", "axis.bias_torque.T"),
    )
    result = fit(four, logs[:1])
    print("four terms fitted to DATA_EMPS alone")
    for name, value in PUBLISHED.items():
        ours, error = result.rig.values[name], result.uncertainty.standard_error[name]
        print(f"  {name:24s} {ours:9.4f} ± {error:.4f}   published {value:9.4f}   {100 * (ours / value - 1):+.1f} %")
    print(f"  RMSE {rmse_mm(result.rig, logs[0]):.2f} mm on DATA_EMPS, {rmse_mm(result.rig, logs[1]):.2f} mm on PULSES")
    print("diagnosis from inertia and viscous friction, both logs, each judged by the fit to the other")
    found = diagnose(base, logs)
    print(found)
    print("  effects added              gap [mm]   mass [kg]   shift     viscous [N s/m]   shift")
    for rung in (*found.waterfall, *found.alternatives_waterfall):
        m, b = rung.numbers["axis.inertia"][0], rung.numbers["axis.friction.viscous"][0]
        shift = [rung.drift[name][1] for name in ("axis.inertia", "axis.friction.viscous")]
        names = " + ".join(rung.names) or "none"
        print(f"  {names:44s} {1e3 * rung.rms:8.2f} {m:9.2f} {shift[0]:+7.1f} % {b:9.1f} {shift[1]:+7.1f} %")
    print(f"  report: {write_report(found, folder)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/emps"))
