"""A MuJoCo model played under commands that are held between samples."""

from collections.abc import Mapping

import mujoco
import numpy as np


def played(
    xml: str, time: np.ndarray, command: np.ndarray, start: Mapping[str, float] | None = None
) -> dict[str, np.ndarray]:
    """Readings of a model's sensors at the samples of a log.

    Args:
        xml: The model, with time steps of which a sample holds several.
        time: Times of the samples [s], `(n,)`.
        command: Control of the actuator `drive` at these times, `(n,)`.
        start: First angles and rates by output, as `yaw_rad` and `yaw_rad_s` [rad, rad/s]; 0 where none is given.

    Returns:
        Readings by the same names, `(n,)` each.
    """
    model = mujoco.MjModel.from_xml_string(xml)
    data, start = mujoco.MjData(model), dict(start or {})
    for k in range(model.njnt):
        name = model.joint(k).name
        data.qpos[k], data.qvel[k] = start.get(f"{name}_rad", 0.0), start.get(f"{name}_rad_s", 0.0)
    mujoco.mj_forward(model, data)
    names = [model.sensor(k).name for k in range(model.nsensor)]
    found = {name: np.empty(len(time)) for name in names}
    for k, t in enumerate(time):
        while data.time < t - time[0] - 0.5 * model.opt.timestep:
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        for name in names:
            found[name][k] = data.sensor(name).data[0]
        data.ctrl[0] = command[k]
    return found
