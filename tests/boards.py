"""Whether the firmware can be compiled and run here; where it cannot, its tests say which packages they need.

With RWJAX_FIRMWARE=required they fail instead, as they have to on a machine that was set up for them.
"""

import os
import shutil

import pytest

from firmware.simavr.avr import missing, missing_for_ide


def need_simavr() -> None:
    """Skips, or fails where the tests are required, without the compiler and the simulator."""
    if packages := missing():
        _give_up(packages)


def need_compiler() -> None:
    """The same for the parts that are compiled for this machine."""
    if packages := [name for name in ("gcc", "make") if shutil.which(name) is None]:
        _give_up(packages)


def need_arduino() -> None:
    """The same, and the core of the Arduino IDE."""
    if packages := missing_for_ide():
        _give_up(packages)


def _give_up(packages: list[str]) -> None:
    said = f"the firmware's tests need the Debian packages {' '.join(packages)}"
    if os.environ.get("RWJAX_FIRMWARE") == "required":
        pytest.fail(said)
    # reason: a machine without the board's compiler and simulator has no board to test; the continuous test requires both
    pytest.skip(said)
