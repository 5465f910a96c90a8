"""Logs regenerated from the thesis's printed equations: nobody measured them.

`python -m experiments.thesis.regenerate [FOLDER]` writes the coast-down of eq. 3.12 and runs of the platform whose friction
is eq. 3.14, both with their misprints corrected, into `data/thesis` by default. Exact stick, Euler steps of 0.1 ms; nothing of
the library is used.
"""

import sys
from pathlib import Path

import numpy as np

COUNTS = 2048  # 1024 lines, both edges of one channel
TICK, STEP = 0.01, 1e-4  # s
SPEED = np.polynomial.Polynomial([10.9, -1.3, 9.5e-2, -4.1e-3, 6.7e-5])  # rad/s over s, eq. 3.12 with + 9.5e-2 t^2
FRICTION = np.polynomial.Polynomial([0.37570, -0.052491, 0.020461, -0.00068912])  # rad/s^2 over rad/s: listing A.4
GAIN = 0.08911  # rad/s^2 per volt, eq. 3.6
LABEL = "regenerated from the thesis's printed polynomials (eq. 3.12, 3.14, 3.6 corrected), not measured"


def coast_down() -> np.ndarray:
    """Angle [rad] at 100 Hz over 15 s."""
    t = np.arange(1501) * TICK
    angle = SPEED.integ()(t)
    return angle - angle[0]


def platform(command: np.ndarray) -> np.ndarray:
    """Angle [rad] at every tick of the platform under held commands [V], from rest."""
    psi = w = 0.0
    out = np.empty(len(command))
    inner = round(TICK / STEP)
    for k, u in enumerate(command):
        out[k] = psi
        push = GAIN * u
        for _ in range(inner):
            way = np.sign(w) if w else np.sign(push)
            if w == 0.0 and abs(push) <= FRICTION(0.0):
                break
            new = w + STEP * (push - way * FRICTION(abs(w)))
            new = 0.0 if new * way < 0.0 else new
            psi, w = psi + 0.5 * STEP * (w + new), new
    return out


def commands() -> dict[str, np.ndarray]:
    """Staircase, square wave and triangle [V], the last one for validation."""
    t = np.arange(4000) * TICK
    on = t > 0.6
    square = np.where(np.mod(t, 8.0) < 5.0, 6.7, -5.5)
    stairs = np.array([0.0, 3.0, 5.0, 6.0, 6.7, 4.6, 0.0, -5.0])[np.minimum((t / 5.0).astype(int), 7)]
    triangle = 7.0 * (1.0 - 4.0 * np.abs(np.mod(t / 16.0 + 0.25, 1.0) - 0.5))
    return {name: np.where(on, u, 0.0) for name, u in dict(square=square, stairs=stairs, triangle=triangle).items()}


def write(path: Path, command: np.ndarray, angle: np.ndarray, role: str = "train") -> None:
    """One log in counts."""
    counts = np.floor(angle / (2.0 * np.pi) * COUNTS + 0.5).astype(int)
    rows = [f"{k * TICK:.2f},{u:.3f},{c}" for k, (u, c) in enumerate(zip(command, counts, strict=True))]
    path.write_text("\n".join([f"# note: {LABEL}", f"# role: {role}", "time_s,voltage_V,yaw_counts", *rows, ""]))


def main(folder: Path) -> None:
    """Writes all logs."""
    folder.mkdir(parents=True, exist_ok=True)
    angle = coast_down()
    write(folder / "coast_down.csv", np.zeros(len(angle)), angle)
    for name, command in commands().items():
        write(folder / f"{name}.csv", command, platform(command), "validate" if name == "triangle" else "train")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2] / "data" / "thesis")
