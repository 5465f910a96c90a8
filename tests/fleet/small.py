"""A fleet of a few platforms on disk, simulated by the library."""

from pathlib import Path

import numpy as np

from rwjax import simulate, write_log, write_rig
from tests.systems import platform

PLAN = 'command = "fit"\nrig = "rig.toml"\nlogs = "logs/{rig}/*.csv"\n'


def write_small(folder: Path, rigs: tuple[str, ...] = ("a", "b", "c")) -> Path:
    """Writes rig file, two logs of each rig, and the plan; its path. The inertia of the k-th rig is 0.1 + 0.01 k kg m2."""
    time = 0.01 * np.arange(400)
    for k, name in enumerate(rigs):
        own = folder / "logs" / name
        own.mkdir(parents=True)
        for run, period in (("fast", 0.7), ("slow", 1.6)):
            volts = 2.0 * np.sign(np.sin(2.0 * np.pi * (time - 0.5) / period + 1e-9)) * (time > 0.5)
            angle = np.asarray(
                simulate(platform("viscous = 0.02"), time, volts, numbers={"axis.inertia": 0.1 + 0.01 * k})["yaw_rad"]
            )
            noise = np.random.default_rng([k, len(run), round(10 * period)]).normal(0.0, 1e-3, len(time))
            write_log(own / f"{run}.csv", {"time_s": time, "voltage_V": volts, "yaw_rad": angle + noise}, {})
    rig = platform("viscous = 0.03", '"axis.inertia", "axis.friction.viscous"')
    (folder / "rig.toml").write_text(write_rig(rig))
    (folder / "fleet.toml").write_text(PLAN)
    return folder / "fleet.toml"
