"""Free run of a rig on a log, as `rwjax predict` writes it."""

import numpy as np

from rwjax.errors import RigError, refuses_other_types
from rwjax.fitting.prediction import predict_logs
from rwjax.fitting.problem import pose
from rwjax.fitting.segments import with_segments
from rwjax.kinds import RANGES
from rwjax.logs.driven import driven
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.logs.segments import cut_up
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Rig
from rwjax.simulation.exact import EXACT
from rwjax.simulation.layout import finer
from rwjax.simulation.solver import Solver
from rwjax.simulation.trajectory import Trajectory


@refuses_other_types
def predict(rig: Rig, log: Log, *, solver: Solver = EXACT, segments: float | None = None) -> Trajectory:
    """Free run of a rig under a log's command, from the initial state of the first 0.5 s of the log or of each segment.

    A log without outputs starts at rest at 0, and gets every output that the kind of rig has.

    Args:
        rig: The rig.
        log: The log.
        solver: What moves the plant through the log.
        segments: Length of the segments [s] in which the free run follows the log, infinite for the whole run; chosen by
            the rig and the log without it.

    Returns:
        Each measured output `(time,)` [SI] at the log's times.

    Raises:
        RigError: Where the run goes further than any rig, or is not finite.
        InputError: An argument is of another type.
    """
    rig, (log,) = driven(rig, (log,))
    structure = structure_of(rig)
    parts = (
        cut_up(with_segments(rig, (log,), segments)) if log.outputs else (log,)
    )  # nothing tells where a segment begins
    problem = pose(
        structure, parts, pooled_noise((log,)), refine=finer(structure, parts), solver=solver.suited(rig, (log,))
    )
    found = predict_logs(problem, theta_of(rig, structure), with_floor=False)
    outputs = {name: np.concatenate([part.outputs[name] for part in found]) for name in problem.structure.outputs}
    for name, values in outputs.items():
        most = RANGES[unit_of(name)].most
        if len(bad := np.flatnonzero(~(np.abs(values) <= most))):
            raise RigError(
                f"rig `{rig.name}`: its free run on {log.name} goes beyond {most:g} {unit_of(name)} of {name} "
                f"{log.time[bad[0]] - log.time[0]:.4g} s after the start, as no rig does; check the rig's numbers"
            )
    return Trajectory(log.name, log.time, outputs)
