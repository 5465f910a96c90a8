"""Files as loggers write them, each to a first fit without a script: an Arduino's CSV, a MAT file, a data frame.

The measurements are those of a geared motor on an L298N bridge (`dcmotor_deadzone_l298n` of the published logs), brought into each form in a
temporary folder. The rig file is all that a user types, and a line for the command. `python -m experiments.columns.run`
"""

import tempfile
from pathlib import Path

import numpy as np
from scipy.io import savemat

import rwjax
from experiments.realdata import folder
from rwjax.fitting.questions.check import check

MOTOR = """kind = "wheel"
[motor]
torque_constant = 0.3
resistance = 5.0
[wheel]
inertia = 0.01
[wheel_encoder]
counts_per_rev = 2400
[fit]
free = ["wheel.inertia", "motor.friction", "effects"]
[effects."drive.deadzone"]
u_0 = 1.0
[columns]
"""
MOTOR = MOTOR.replace(', "effects"]', ', "drive.deadzone.u_0"]').replace(
    "resistance = 5.0\n", "resistance = 5.0\nfriction = 1e-3\n"
)
SUPPLY_V, FULL_POWER = 12.0, 255
ARDUINO = """time_s = { column = "ms", unit = "ms" }
voltage_V = { column = "pwm", scale = "12 V / 255" }
wheel_counts = "counts"
"""
MATLAB = """time_s = "t"
voltage_V = "u"
wheel_rad_s = { column = "speed", unit = "rpm" }
"""
TURNED = """time_s = "t"
voltage_V = "u"
yaw_rad = { column = "angle", unit = "deg" }
yaw_rad_s = { column = "speed", unit = "rpm" }
"""
AXIS = """kind = "platform"
[drive]
gain = 0.02
[axis]
inertia = 0.01
friction = { viscous = 0.01, coulomb = 0.05 }
[fit]
free = ["axis.friction.viscous", "axis.friction.coulomb"]
[columns]
"""


def measured(source: Path) -> dict[str, np.ndarray]:
    """The staircase: time [s], command [V], speed [rpm], and the angle [deg] that the speed sums up to."""
    t, u, rpm = np.genfromtxt(
        source / "dcmotor_deadzone_l298n" / "staircase_run.csv", delimiter=",", skip_header=1, usecols=(0, 1, 2)
    ).T
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (rpm[1:] + rpm[:-1]) * np.diff(t) * 6.0)])
    return {"t": t, "u": u, "speed": rpm, "angle": angle}


def arduino(target: Path, run: dict[str, np.ndarray]) -> Path:
    """`ms,pwm,counts` as an Arduino prints them."""
    columns = [1e3 * run["t"], run["u"] * FULL_POWER / SUPPLY_V, run["angle"] / 360.0 * 2400.0]
    path = target / "arduino.csv"
    np.savetxt(path, np.rint(np.stack(columns, axis=1)), "%d", ",", header="ms,pwm,counts", comments="")
    return path


def first_fit(title: str, text: str, log_of, lines: int) -> str:
    """A row of the table: what was typed, what the check said, and the first fit's error."""
    rig = rwjax.parse_rig(text)
    log = log_of(rig)
    said = [finding.about for finding in check(rig, [log])]
    found = rwjax.fit(rig, [log])
    name, error = next(iter(found.rms.items()))
    share = error / float(np.sqrt(np.nanmean((log.outputs[name] - np.nanmean(log.outputs[name])) ** 2)))
    typed = len([line for line in text.splitlines() if line.strip()]) + lines
    mapped = len(rig.sources)
    return f"{title:<34} {typed:>5} {mapped:>7}  {name:<12} {error:>8.3g} {100.0 * share:>6.1f} %  {', '.join(said) or 'nothing'}"


def main() -> None:
    """Prints the table."""
    source = folder()
    if source is None:
        print(
            "real data not found, nothing to show: set RWJAX_REALDATA to the folder that holds dcmotor_deadzone_l298n/ …"
        )
        return
    import pandas

    run = measured(source)
    print("file                               lines  mapped  reading           RMS    of it  check says")
    with tempfile.TemporaryDirectory() as name:
        target = Path(name)
        csv = arduino(target, run)
        savemat(target / "run.mat", {"run": run, "Ts": 0.01})
        frame = pandas.DataFrame(run)
        rows = (
            ("Arduino: ms,pwm,counts", MOTOR + ARDUINO, lambda rig: rwjax.read_log(csv, rig), 1),
            (
                "MAT: a structure, degrees and rpm",
                AXIS + TURNED,
                lambda rig: rwjax.read_log(target / "run.mat", rig),
                1,
            ),
            ("data frame: rpm", MOTOR + MATLAB, lambda rig: rwjax.Log.from_frame(rig, frame), 3),
        )
        for row in rows:
            print(first_fit(*row), flush=True)


if __name__ == "__main__":
    main()
