"""Free run of a rig on a log, as `rwjax predict` writes it."""

import numpy as np

from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import pose
from rwjax.logs.log import Log
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig


def predict(rig: Rig, log: Log) -> dict[str, np.ndarray]:
    """Columns of `rwjax predict`: `time_s` and the free run of each measured output in SI at the log's times.

    A log without outputs starts at rest at 0 and gets every output that the kind of rig has.
    """
    structure = structure_of(rig)
    problem = pose(structure, (log,))
    outputs = predict_logs(problem, theta_of(rig, structure), with_floor=False)[0].outputs
    wanted = [name for name in structure.outputs if not log.outputs or name in log.outputs]
    return {"time_s": log.time, **{name: outputs[name] for name in wanted}}


UNITS = {"_rad": "rad", "_rad_s": "rad/s", "_A": "A"}


def unit_of(output: str) -> str:
    """The SI unit of an output, from the end of its name."""
    return next(unit for end, unit in UNITS.items() if output.endswith(end))
