"""Writes the campaign in `data/testbed/`: `python -m experiments.testbed.make_data`. Simulated, its firmware included.

The testbed has the ESC of the case `esc`: a dead zone, a lag and a supply that sags, which `data/testbed/rig.toml` does not hold.
"""

import shutil
import tempfile
from pathlib import Path

from experiments.testbed.campaign import FOLDER, campaign
from experiments.testbed.cases import truth


def main() -> None:
    """Replaces the logs."""
    with tempfile.TemporaryDirectory() as folder:
        for log in campaign(truth("esc"), Path(folder)):
            shutil.copy(log, FOLDER)


if __name__ == "__main__":
    main()
