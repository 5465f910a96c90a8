"""The command at which the axis breaks loose: what is held, by effect."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import parse_rig
from rwjax.control.breakaway import breakaway
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.errors import InputError
from tests.control.loop_rigs import FREE_TEXT, TESTBED_TEXT
from tests.joints import joint
from tests.systems import platform, reaction

GAIN = 0.0182 / 0.83  # N m/V


@pytest.mark.parametrize(
    ("text", "volts"),
    [
        (f"{FREE_TEXT.replace('0.4', '-0.4')}\n[axis.friction]\ncoulomb = 0.05", 0.05 / 0.4),
        (
            f'{FREE_TEXT}\n[effects."axis.presliding"]\nM_c = 0.03\nx_s = 1e-3\n[axis.friction]\ncoulomb = 0.05',
            0.08 / 0.4,
        ),
        (f'{FREE_TEXT}\n[effects."axis.asymmetric_friction"]\nM_c = 0.05\nd = 0.02', 0.07 / 0.4),
        ('[effects."axis.coulomb"]\nM_c = 0.01\n[effects."wheel.coulomb"]\nM_c = 0.002', 0.012 / GAIN),
        ('[effects."axis.coulomb"]\nM_c = 0.01\n[effects."drive.bias"]\nu_b = 0.1', 0.01 / GAIN + 0.1),
        # mu of the drive's own torque is held besides: T = 0.01 + 0.5 T
        ('[effects."axis.coulomb"]\nM_c = 0.01\n[effects."axis.load_friction"]\nmu = 0.5', 0.02 / GAIN),
        ('[effects."axis.coulomb"]\nM_c = 0.01\n[effects."axis.bias_torque"]\nT = 0.005', 0.005 / GAIN),
        ('[effects."axis.coulomb"]\nM_c = 0.01\n[effects."axis.bias_torque"]\nT = -0.005', 0.015 / GAIN),
        ('[effects."axis.coulomb"]\nM_c = 0.01\n[effects."axis.bias_torque"]\nT = 0.02', 0.0),
        (
            f"{FREE_TEXT}\n[axis.friction]\ncoulomb = 0.05\n[axis.gravity]\ntorque = 0.1\nangle = 0.3",
            (0.05 + 0.1 * np.sin(0.3)) / 0.4,
        ),
        # K i/(1 + a i^2) = 0.01 has the smaller root i
        (
            '[effects."axis.coulomb"]\nM_c = 0.01\n[effects."motor.saturation"]\na = 0.5',
            0.83 * (0.0182 - np.sqrt(0.0182**2 - 4.0 * 0.5 * 0.01**2)) / (2.0 * 0.5 * 0.01),
        ),
        (
            '[effects."axis.coulomb"]\nM_c = 0.01\n[effects."axis.flexible_coupling"]\ns = 0.3\nk = 40.0\nc = 0.2',
            0.01 / GAIN,
        ),
    ],
    ids=[
        *("backward", "presliding", "asymmetric", "wheel", "bias", "load friction", "helped", "hindered", "moved"),
        *("gravity", "saturation", "coupling"),
    ],
)
def test_what_breaks_loose_is_what_is_held(text: str, volts: float) -> None:
    assert breakaway(parse_rig(text if text.startswith("kind") else f"{TESTBED_TEXT}\n{text}")) == pytest.approx(volts)


def test_a_drive_too_weak_to_break_loose_is_said() -> None:
    weak = f'{FREE_TEXT}\n[axis.friction]\ncoulomb = 0.05\n[effects."drive.saturation"]\nu_m = 0.1'
    with pytest.raises(InputError, match=r"never gives the torque .*; at its most 0\.01 N m are missing"):
        breakaway(parse_rig(weak))
    limited = '[effects."axis.coulomb"]\nM_c = 0.02\n[effects."motor.current_limit"]\ni_m = 0.6'
    with pytest.raises(InputError, match=r"never gives the torque .*; at its most 0\.00908 N m are missing"):
        breakaway(parse_rig(f"{TESTBED_TEXT}\n{limited}"))  # 0.02 - 0.0182 * 0.6


WITH = {
    "with a dead zone": {"drive.deadzone": {"u_0": 0.3, "j": 0.0}},
    "with friction that grows with the load": {"axis.load_friction": {"mu": 0.4}},
    "with a load": {"axis.bias_torque": {"T": -0.007}},
}


@pytest.mark.parametrize("share, moves", [(0.999, False), (1.001, True)])
@pytest.mark.parametrize("kind", ["platform", pytest.param("reaction", marks=pytest.mark.slow), *WITH])
def test_breakaway_is_where_the_axis_lets_go(kind: str, share: float, moves: bool) -> None:
    friction = "coulomb = 0.01\nstatic = 0.015\nstribeck_velocity = 0.1"
    rig = reaction(friction) if kind == "reaction" else platform(friction)
    rig = replace(rig, effects=WITH.get(kind, {}))
    push = Controller(0.0, feedforward=share * breakaway(rig))
    # the wheel of a reaction rig speeds up and takes the torque away: the first instants decide, and need no inductance
    rig = parse_rig(_without_inductance(rig)) if kind == "reaction" else rig
    run = run_rig(rig, push, np.full(4, 1.0), LoopTiming(1e-3, 1))
    assert bool(np.any(np.asarray(run.angle) != 0.0)) == moves


def _without_inductance(rig) -> str:
    from rwjax.rig.write import write_rig

    return "\n".join(line for line in write_rig(rig).splitlines() if not line.startswith("inductance"))


def test_a_joint_breaks_loose_at_the_volts_that_its_gear_turns_into_the_torque() -> None:
    rig = joint(axis__friction__coulomb=0.05, axis__gravity__torque=0.3, axis__gravity__angle=0.2)
    assert breakaway(rig) == pytest.approx((0.05 + 0.3 * np.sin(0.2)) * 2.0 / (100.0 * 0.02), rel=1e-6)
