"""Free run of a rig on a log, as `rwjax predict` writes it."""

import numpy as np

from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import pose
from rwjax.logs.columns import unit_of
from rwjax.logs.log import Log
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.model import Rig


class FreeRun(dict[str, np.ndarray]):
    """Columns of a free run `(time,)` [SI] by name: `time_s`, and the predicted outputs. Prints as a summary."""

    def __str__(self) -> str:
        time, outputs = self["time_s"], [name for name in self if name != "time_s"]
        lines = [f"free run of {len(time)} samples over {time[-1] - time[0]:.4g} s"]
        lines += [f"  {name} from {self[name].min():.4g} to {self[name].max():.4g} {unit_of(name)}" for name in outputs]
        return "\n".join(lines)


def predict(rig: Rig, log: Log) -> FreeRun:
    """Free run of a rig under a log's command, from the initial state of the log's first 0.5 s.

    A log without outputs starts at rest at 0, and gets every output that the kind of rig has.

    Args:
        rig: The rig.
        log: The log.

    Returns:
        `time_s` [s] and each measured output `(time,)` [SI], at the log's times.
    """
    structure = structure_of(rig)
    problem = pose(structure, (log,))
    outputs = predict_logs(problem, theta_of(rig, structure), with_floor=False)[0].outputs
    wanted = [name for name in structure.outputs if not log.outputs or name in log.outputs]
    return FreeRun({"time_s": log.time, **{name: outputs[name] for name in wanted}})

