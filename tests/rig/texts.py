"""Texts of rig files for tests, and what is said of those that cannot be used."""

import pytest

from rwjax.errors import RigError
from rwjax.rig.read import parse_rig

MOTOR = "[motor]\ntorque_constant = 0.0182\nresistance = 0.83\n"
WHEEL = 'kind = "wheel"\n' + MOTOR + "[wheel]\ninertia = 1.24e-4\n"
PLATFORM = 'kind = "platform"\n[drive]\ngain = -0.428\n[axis]\ninertia = 0.228\n'
REACTION = 'kind = "reaction"\n' + MOTOR + "[wheel]\ninertia = 1.24e-4\n[axis]\ninertia = 0.0495\n"
STRIBECK = ("M_c", "M_e", "v_s", "n")
"""Parameters of the effect `axis.stribeck`."""


def is_refused(text: str, message: str) -> None:
    """Asserts that a rig file is refused in one line that names the file and holds the message."""
    with pytest.raises(RigError) as error:
        parse_rig(text)
    said = str(error.value)
    assert said.startswith("rig.toml:") and message in said and len(said.splitlines()) == 1
