"""A platform with delays of command and reading, and its loop."""

from dataclasses import replace

from rwjax import Rig, parse_rig
from rwjax.control.controller import LoopTiming

GAIN, INERTIA, VISCOUS, H, SMOOTH = 0.4, 0.1, 0.02, 0.01, 0.03
RIG = parse_rig(
    f'kind = "platform"\n[drive]\ngain = {GAIN}\n[axis]\ninertia = {INERTIA}\n[axis.friction]\nviscous = {VISCOUS}'
)
TIMING = LoopTiming(H, delay_steps=2.0)  # 5 ms


def with_delays(command: float, reading: float) -> Rig:
    return replace(RIG, effects={"drive.delay": {"tau": command}, "sensor.delay": {"tau": reading}})
