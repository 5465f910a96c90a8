"""Rigs for campaigns: one of each kind with an axis or a wheel, and a slide."""

from tests.systems import platform, reaction, wheel

RIGS = {
    "wheel": wheel(),
    "platform": platform("viscous = 0.02\ncoulomb = 0.05\nstatic = 0.08\nstribeck_velocity = 0.2"),
    "reaction": reaction("viscous = 0.0026\ncoulomb = 0.004"),
}


SLIDE = RIGS["platform"].with_values(
    {
        "drive.gain": 35.0,
        "axis.inertia": 95.0,
        "axis.friction.viscous": 200.0,
        "axis.friction.coulomb": 20.0,
        "axis.friction.static": 25.0,
    }
)
"""A slide of 95 kg."""
