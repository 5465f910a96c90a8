"""Logs that several tests of the methods share."""

import numpy as np

from tests.systems import record, run

TIME = np.arange(1001) * 0.01


FREE = '"axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"'


COMMAND = np.where(TIME > 0.6, 0.9 * np.sign(np.sin(1.7 * TIME)) + 0.3 * np.sin(5.0 * TIME), 0.0)


def axis_log(rig, seed: int = 0, **more):
    y = run(rig, record(TIME, COMMAND), {})["yaw_rad"]
    return record(TIME, COMMAND, {"yaw_rad": y + np.random.default_rng(seed).normal(0.0, 3e-4, len(y))}, **more)
