"""What every part of a chapter needs: a row of its table, a figure in a file, a run without readings."""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from rwjax import Log


def folder_of() -> Path:
    """Where figures go: the first argument, or `build/thesis`."""
    return Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/thesis")


def row(what: str, printed: str, here: str) -> None:
    """One line: what it is, what the thesis prints, what comes out here."""
    print(f"  {what:86s} {printed:>14s}  {here}")


def save(figure: plt.Figure, folder: Path, name: str) -> None:
    """Write a figure as PNG and close it."""
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"{name}.png", dpi=110)
    plt.close(figure)


def run(time: np.ndarray, command: np.ndarray) -> Log:
    """A command [V] over time [s] without readings: its free run starts at rest."""
    return Log("run", time, command, {}, {}, {}, False, None, float(time[0]))


def rms(x: np.ndarray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(x))))
