"""Chapter 4 of the thesis: control. `python -m experiments.thesis.chapter4 [FOLDER]`."""

from pathlib import Path

from experiments.thesis.axis_model import axis_model
from experiments.thesis.left_open import left_open
from experiments.thesis.region import region
from experiments.thesis.slews import slews
from experiments.thesis.square_waves import square_waves
from experiments.thesis.table import folder_of


def main(folder: Path) -> None:
    """Prints every table and draws every figure."""
    for part in (slews, axis_model, region, square_waves, left_open):
        print(part.__doc__)
        part(folder)


if __name__ == "__main__":
    main(folder_of())
