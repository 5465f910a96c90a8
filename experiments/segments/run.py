"""Whole runs against segments on measured pendulums that go over the top or are kept on it.

`python -m experiments.segments.run [dfki] [hva]` fits each rig both ways and prints the numbers and the error of a prediction by segments
and by the whole run on what was held out. `dfki`: a swing-up over several turns is fitted, another one held out, the measured torque is
the command. `hva`: a reaction-wheel pendulum kept on its top by PID; the last third is held out. Its inertia is given, since an angle
tells all others in proportion to it, and the wheel's own speed is neglected.
"""

import argparse
import math
from time import perf_counter

import numpy as np

from experiments.realdata import need
from rwjax import Log, Rig, fit, parse_rig, predict
from rwjax.fitting.segments import said, segment_s, with_segments

PENDULUM = """
kind = "platform"
[drive]
gain = {gain}
[axis]
inertia = {inertia}
[axis.friction]
viscous = {viscous}
coulomb = {coulomb}
[axis.gravity]
torque = {torque}
angle = {angle}
[fit]
free = {free}
"""


def _log(name: str, t: np.ndarray, command: np.ndarray, angle: np.ndarray) -> Log:
    """A log of an angle."""
    t, first = np.unique(t, return_index=True)  # the clock of one rig is rounded, so that samples share a time
    return Log(name, t, command[first], {"yaw_rad": angle[first]}, {"yaw_rad": 0.0}, {}, False, None, float(t[0]))


def dfki() -> tuple[Rig, Log, Log]:
    """The torque-driven pendulum: its rig, the run that is fitted and the one that is held out."""
    free = '["axis.inertia", "axis.friction.coulomb", "axis.gravity.torque"]'
    rig = PENDULUM.format(gain=1.0, inertia=0.15, viscous=0.02, coulomb=0.2, torque=3.0, angle=0.0, free=free)
    found = []
    for name in ("energy_shaping", "ilqr"):
        d = np.genfromtxt(need() / "dfki_simple_pendulum" / f"{name}.csv", delimiter=",", names=True)
        found.append(_log(name, d["time_s"], d["torque_meas_Nm"], d["position_rad"]))
    return parse_rig(rig), found[0], found[1]


def hva() -> tuple[Rig, Log, Log]:
    """The reaction-wheel pendulum on its top: its rig, and the run in two parts."""
    free = '["drive.gain", "axis.friction.viscous", "axis.gravity.torque", "axis.gravity.angle"]'
    upright = math.pi - math.radians(25.5)
    rig = PENDULUM.format(gain=0.01, inertia=0.01, viscous=0.005, coulomb=0.0, torque=0.5, angle=upright, free=free)
    path = need() / "hva_reaction_wheel_pendulum" / "t3_pid_balance_heavy_wheel.csv"
    d = np.genfromtxt(path, delimiter=",", names=True)
    log = _log("t3_pid_balance", d["time_s"], 12.0 / 255.0 * d["pwm_command"], np.radians(d["angle_deg"]))
    split = len(log.time) - len(log.time) // 3
    return parse_rig(rig), log.cut(0, split), log.cut(split, len(log.time))


def _error(rig: Rig, log: Log, seconds: float) -> float:
    """RMS error of a prediction [rad], in segments or of the whole run."""
    predicted = predict(rig, log, segments=seconds).columns["yaw_rad"]
    return float(np.sqrt(np.mean((predicted - log.outputs["yaw_rad"]) ** 2)))


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    rigs = {"dfki": dfki, "hva": hva}
    parser.add_argument("rigs", nargs="*", help=" or ".join(rigs))
    print("| rig | fitted by | numbers | held out, in segments [rad] | held out, whole run [rad] | fit [s] |")
    print("| --- | --- | --- | --- | --- | --- |")
    reasons = []
    for name in parser.parse_args().rigs or rigs:
        rig, train, test = rigs[name]()
        logs = with_segments(rig, [train, test])
        chosen = segment_s(logs) or math.inf
        reasons += [f"{name}: {sentence}" for sentence in said(logs)]
        for seconds in (chosen, math.inf):
            begin = perf_counter()
            found = fit(rig, [train], segments=seconds).rig
            took = perf_counter() - begin
            numbers = ", ".join(
                f"{n.split('.', 1)[1]} {found.values[n]:.3g} ± {found.standard_error.get(n, math.nan):.1g}"
                for n in rig.free
            )
            way = f"segments of {seconds:g} s" if math.isfinite(seconds) else "whole runs"
            errors = f"{_error(found, test, chosen):.3g} | {_error(found, test, math.inf):.3g}"
            print(f"| {name} | {way} | {numbers} | {errors} | {took:.0f} |", flush=True)
    print("\n".join(["", *reasons]))


if __name__ == "__main__":
    main()
