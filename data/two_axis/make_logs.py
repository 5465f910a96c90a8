"""Writes the logs beside this file: a simulated testbed with two axes whose pitch body carries wheel 1, which `rig.toml` does
not know. `python data/two_axis/make_logs.py`"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from rwjax.fitting.predict import predict
from rwjax.logs.read import read_log
from rwjax.logs.write import write_log
from rwjax.rig.read import read_rig

HERE = Path(__file__).parent
COUNT = 2.0 * np.pi / 4096
MISSING = {"wheel_1.gyroscopic": {"s": 1.0}}
"""What the simulated testbed has and its rig file lacks."""


def commands(t: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Voltages of both motors; wheel 1 runs up first, so that there is momentum to be tilted."""
    on = t > 0.6
    square = np.sign(np.sin(2.0 * np.pi * t / 3.1))
    return {
        "square": (on * (4.0 + 1.5 * square), on * 1.3 * np.sign(np.sin(2.0 * np.pi * t / 1.7))),
        "sines": (on * (-4.0 + 1.5 * np.sin(1.3 * t)), on * 1.2 * np.sin(3.1 * t + 0.4 * t**1.5)),
        "steps": (on * np.where(np.mod(t, 4.0) < 2.0, 5.0, -3.0), on * 1.2 * np.sign(np.sin(2.0 * np.pi * t / 2.3))),
    }


def main() -> None:
    rig = read_rig(HERE / "rig.toml")
    truth = replace(rig, effects={**rig.effects, **MISSING})
    t = 0.01 * np.arange(700)
    for seed, (name, volts) in enumerate(commands(t).items()):
        path, rng = HERE / f"{name}.csv", np.random.default_rng(seed)
        inputs = {"time_s": t, "voltage_1_V": np.round(volts[0], 3), "voltage_2_V": np.round(volts[1], 3)}
        notes = {"role": "validate"} if name == "steps" else {}
        write_log(path, inputs, notes)
        y = predict(truth, read_log(path, rig, outputs_required=False))
        read = {f"{axis}_counts": np.rint(y[f"{axis}_rad"] / COUNT).astype(int) for axis in ("yaw", "pitch")}
        for k in (1, 2):
            noisy = y[f"wheel_{k}_rad_s"] + 0.3 * rng.normal(size=len(t))
            read[f"wheel_{k}_rad_s"] = np.round(noisy, 1)
        write_log(path, inputs | read, notes)


if __name__ == "__main__":
    main()
