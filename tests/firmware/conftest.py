"""The firmware, compiled once a session."""

import ctypes
from pathlib import Path

import pytest

from firmware.simavr.avr import build, desk
from tests.boards import need_compiler, need_simavr
from tests.firmware.desk import load


@pytest.fixture(scope="session")
def c() -> ctypes.CDLL:
    """The hardware-free parts on this machine."""
    need_compiler()
    return load(desk())


@pytest.fixture(scope="session")
def elf() -> Path:
    """The sketch for the ATmega328P."""
    need_simavr()
    return build()
