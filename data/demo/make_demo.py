"""Makes the logs of the demo: `python data/demo/make_demo.py [FOLDER]`. Simulated, not measured.

The rig is the thesis's platform, its friction a Stribeck curve that the rig file (viscous friction only) does not hold.
The simulator is `experiments/blind`, which shares no code with the library.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from experiments.blind.commands import TICK
from experiments.blind.simulator import STEP, Truth, simulate

TRUTH = Truth(kind=1, I=0.228, gain=0.428, viscous=0.06, coulomb=0.45, excess=0.3, v_s=0.35, exponent=1.5)
COUNTS_PER_REV = 2048
LENGTH = 20.0  # s
RIG = """kind = "platform"
name = "thesis platform"

[drive]
gain = 0.428        # k, N m/V

[axis]
inertia = 0.228     # I, kg m2

[axis.friction]
viscous = 0.082     # b, N m s/rad

[encoder]
counts_per_rev = 2048

[fit]
free = ["axis.inertia", "axis.friction.viscous"]
"""


def commands() -> dict[str, np.ndarray]:
    """Command [V] of each run at 100 Hz; all begin with half a second at rest."""
    t = np.arange(round(LENGTH / TICK)) * TICK
    s = np.maximum(t - 0.5, 0.0)
    tones = ((0.11, 0.4), (0.27, 2.1), (0.6, 4.4), (1.3, 1.0))
    steps = np.array([2.0, 3.0, 0.0, -2.5, -3.5, 1.5, 0.0, 4.0, -4.0, -1.5])
    found = {
        "square": 3.4 * np.sign(np.sin(2 * np.pi * s / 5.0)),
        "triangle": 3.2 * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * s / 8.0)),
        "multisine": 1.5 * sum(np.sin(2 * np.pi * f * s + phase) for f, phase in tones),
        "stair": steps[np.minimum((s / 2.0).astype(int), 9)],
        "mixed": np.where(s < 10.0, 3.6 * np.sign(np.sin(2 * np.pi * s / 3.3)), 3.0 * np.sin(2 * np.pi * s / 6.5)),
    }
    return {name: np.round(np.where(t >= 0.5, u, 0.0), 3) for name, u in found.items()}


def main(folder: Path) -> None:
    """Writes `rig.toml` and the five logs."""
    rng = np.random.default_rng(2026)
    (folder / "rig.toml").write_text(RIG)
    for name, u in commands().items():
        t = np.arange(len(u)) * TICK
        at = np.maximum(t + rng.uniform(-1e-4, 1e-4, len(t)), 0.0)
        x0 = np.zeros(5)
        x0[0] = rng.uniform(0.0, 2 * np.pi)
        psi = simulate(t, u, at, x0, TRUTH.array(), STEP)[:, 0]
        counts = np.floor(psi * COUNTS_PER_REV / (2 * np.pi)).astype(int)
        notes = [
            "# simulated: data/demo/make_demo.py",
            *(["# role: validate"] if name in ("stair", "mixed") else []),
        ]
        rows = [f"{a:.2f},{b:.3f},{c}" for a, b, c in zip(t, u, counts, strict=True)]
        (folder / f"{name}.csv").write_text("\n".join([*notes, "time_s,voltage_V,yaw_counts", *rows, ""]))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent)
