"""Chapter 3 of the thesis: every number again, what was printed beside it, and what one command finds.

`python -m experiments.thesis.chapter3 [FOLDER]` prints the tables and draws the figures into `build/thesis` by default.
"""

from pathlib import Path

from experiments.thesis.friction_laws import friction_laws
from experiments.thesis.motor import motor
from experiments.thesis.platform_models import platform
from experiments.thesis.table import folder_of, row
from experiments.thesis.two_stages import misprints, two_stages
from rwjax import read_logs, read_rig
from rwjax.diagnosis.diagnosis import diagnose

DATA = Path(__file__).parents[2] / "data" / "thesis"


def diagnosis(_: Path) -> None:
    """What took a chapter: from the viscous model of eq. 3.6 to the friction that it lacks."""
    rig = read_rig(DATA / "platform.toml")
    found = diagnose(rig, read_logs([DATA / f"{name}.csv" for name in ("square", "stairs", "triangle")], rig))
    print(found)


def main(folder: Path) -> None:
    """Prints every table and draws every figure."""
    row("", "printed", "here")
    for part in (motor, platform, friction_laws, misprints, two_stages, diagnosis):
        print(part.__doc__)
        part(folder)
    print(f"figures: {folder}")


if __name__ == "__main__":
    main(folder_of())
