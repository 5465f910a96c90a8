"""Identification methods on EMPS, with the bias that its logs need and without it: which keep the mass?

`python -m experiments.methods.emps [FOLDER]` (ten minutes on two cores, most of them the Kalman filter's)
"""

import sys
from dataclasses import replace
from pathlib import Path

from experiments.realdata import emps
from rwjax import read_log, read_rig
from rwjax.compare import compare
from rwjax.report.comparison import table


def main(folder: Path) -> None:
    """Prints a table for each of the two models."""
    base = read_rig(Path(__file__).parents[1] / "emps" / "rig.toml")
    logs = [read_log(path, base) for path in emps(folder)]
    without = replace(
        base,
        numbers=base.numbers | {"axis.friction.coulomb": 10.0},
        free=(*base.free, "axis.friction.coulomb"),
    )
    biased = replace(without, effects={"axis.bias_torque": {"T": 0.0}}, free=(*without.free, "axis.bias_torque.T"))
    for title, rig in (("without a bias", without), ("with a bias", biased)):
        print(title)
        print(table(compare(rig, logs)), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/emps"))
