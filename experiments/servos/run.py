"""Measured servo joints, each fitted three ways and judged by free runs on logs that took no part.

`python -m experiments.servos.run [--only NAME]`

by goal: the loop closed with the model's own position, its goal late by a free time. error as voltage: what the servo gave, worked
out from the measured positions, is the command. plain: inertia, viscous and dry friction, bias and gravity by least squares on
smoothed accelerations, and the loop closed around them.
"""

import sys
from dataclasses import replace
from time import perf_counter

import numpy as np
from scipy.signal import savgol_filter

from experiments.realdata import need
from experiments.servos.cases import Case, cases
from rwjax import fit, parse_rig, predict, read_logs
from rwjax.errors import InputError
from rwjax.logs.driven import driven, without_servo
from rwjax.logs.log import Log
from rwjax.rig.model import Driven, Rig

SMOOTHED_S = 0.1
"""Length of the polynomials by which the plain way smooths positions [s]."""
MOVING = 0.05
"""Rate above which the plain way takes a joint to slide [rad/s]."""


def rms(rig: Rig, logs: tuple[Log, ...]) -> list[float]:
    """Free-run RMS error of the position in each log [rad]; infinite where the run goes further than any rig."""
    found = []
    for log in logs:
        try:
            error = predict(rig, log)["yaw_rad"] - log.outputs["yaw_rad"]
        except InputError:
            error = np.full(1, np.inf)
        found.append(float(np.sqrt(np.nanmean(error**2))))
    return found


def by_error(rig: Rig, train: tuple[Log, ...], held_out: tuple[Log, ...]) -> list[float]:
    """Errors of the same terms with the measured error fed in."""
    rig = replace(
        rig,
        effects={name: values for name, values in rig.effects.items() if name != "drive.goal_delay"},
        free=tuple(name for name in rig.free if not name.startswith("drive.goal_delay")),
    )
    opened, logs = without_servo(rig, train)
    return rms(replace(fit(opened, logs).rig, driven=Driven()), without_servo(rig, held_out)[1])


def plain(rig: Rig, train: tuple[Log, ...], held_out: tuple[Log, ...]) -> list[float]:
    """Errors of five terms by least squares on smoothed accelerations, in the loop."""
    rig, train = driven(rig, train)
    acts = rig.servo.acts_on if rig.servo is not None else "voltage"
    K, R = rig.numbers["motor.torque_constant"], rig.numbers["motor.resistance"]
    per_unit = (
        1.0 if acts == "torque" else K / R * (1.0 if rig.driven.supplied else rig.numbers.get("drive.supply", 1.0))
    )
    rows, aims = [], []
    for log in train:
        step = float(np.median(np.diff(log.time)))
        t = np.arange(log.time[0], log.time[-1], step)
        q, u = np.interp(t, log.time, log.outputs["yaw_rad"]), np.interp(t, log.time, log.at_drive)
        width = 2 * round(0.5 * SMOOTHED_S / step) + 1
        q, w, a = (savgol_filter(q, width, 3, deriv=d, delta=step) for d in range(3))
        on = np.abs(w) > MOVING
        on &= True if log.enabled is None else np.interp(t, log.time, log.enabled) > 0.5
        rows.append(np.stack([a, w, np.sign(w), np.ones_like(w), np.sin(q)], axis=1)[on])
        aims.append(per_unit * u[on])
    inertia, viscous, coulomb, bias, gravity = np.linalg.lstsq(np.concatenate(rows), np.concatenate(aims), rcond=None)[
        0
    ]
    braking = 0.0 if acts == "torque" else K * K / R
    numbers = rig.numbers | {
        "axis.inertia": max(inertia, 1e-6),
        "motor.inertia": 0.0,
        "axis.friction.viscous": viscous - braking,
        "axis.friction.coulomb": max(coulomb, 0.0),
        "axis.gravity.torque": gravity,
    }
    return rms(replace(rig, numbers=numbers, effects={"axis.bias_torque": {"T": -bias}}, free=()), held_out)


def judged(case: Case) -> list[tuple[str, list[float]]]:
    """Held-out logs of a joint with the errors of the three ways [rad]."""
    folder = need() / case.data
    rig = parse_rig(case.rig, f"{case.data}/{case.name}.toml")
    train, held_out = (read_logs([folder / name for name in names], rig) for names in (case.train, case.held_out))
    begin = perf_counter()
    fitted = fit(rig, train)
    seconds = perf_counter() - begin
    told = {name: float(f"{fitted.rig.values[name]:.4g}") for name in rig.free}
    print(f"  {case.data} {case.name}: {told} in {seconds:.0f} s", flush=True)
    ways = rms(fitted.rig, held_out), by_error(rig, train, held_out), plain(rig, train, held_out)
    return [(f"{case.data} {case.name}: {log.name}", errors) for log, *errors in zip(held_out, *ways, strict=True)]


def main(only: str) -> None:
    """Prints the errors of all held-out runs, and on how many the goal's are the least."""
    rows = [row for case in cases() if only in f"{case.data}/{case.name}" for row in judged(case)]
    print("| held-out run | by goal [rad] | error as voltage [rad] | plain [rad] |\n| --- | --- | --- | --- |")
    for name, errors in rows:
        print(f"| {name} | " + " | ".join(f"{e:.4f}" for e in errors) + " |")
    other, base = (sum(errors[0] < errors[k] for _, errors in rows) for k in (1, 2))
    both = sum(errors[0] < min(errors[1:]) for _, errors in rows)
    print(
        f"of {len(rows)} runs by goal less than error as voltage on {other}, than plain on {base}, than both on {both}"
    )


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--only") + 1] if "--only" in sys.argv else "")
