"""One structure's programs in a process of its own: seconds from nothing to the first results, without imports, as JSON."""

import json
import sys
from pathlib import Path

import numpy as np

from experiments.speed.table import timed
from rwjax import read_logs, read_rig
from rwjax.fitting.batched_runs import BATCH
from rwjax.fitting.problem import pose
from rwjax.fitting.sensitivities import sensitivities
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.simulation.free_run import free_runs


def main(folder: Path) -> None:
    """Reads `rig.toml` and the logs of a folder; calls the batch of free runs and the sensitivities twice each."""
    rig = read_rig(folder / "rig.toml")
    structure = structure_of(rig)
    problem, theta = pose(structure, read_logs(sorted(folder.glob("*.csv")), rig)), theta_of(rig, structure)
    structure = problem.structure
    log = np.zeros(BATCH, int)
    batch, windows = problem.batch.of(0), problem.batch.windows
    free = np.array([k for k, name in enumerate(structure.names) if name in rig.free])
    nodes = np.repeat(problem.start[:, None], problem.batch.windows, axis=1)

    def runs() -> np.ndarray:
        return np.asarray(free_runs(structure, np.tile(theta, (BATCH, 1)), problem.start[log], windows, batch))

    def derivatives() -> object:
        return sensitivities(problem, theta, free, nodes)

    found = {}
    for name, call in (("free runs", runs), ("sensitivities", derivatives)):
        first, again = timed(call)[0], timed(call)[0]
        found[name] = first - again
    print(json.dumps(found))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
