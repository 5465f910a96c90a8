"""Figs. 4.5 to 4.11 fitted from their goal. `python -m experiments.thesis.closed_loop`.

The runs are regenerated, not measured: the loop of `experiments.thesis.square_waves`, which reads counts, makes them. Each log holds the
goal and the counts of the axis. They are fitted twice from numbers that are wrong. One fit follows the goal by `[drive.servo]`. The other
takes the voltage that the loop gives on the measured error as the command. So are their every fifth samples, as a logger slower than the
loop would have them, and the runs of a loop that reads the angle itself.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from experiments.thesis.square_waves import CLOCK, HALF, HEIGHTS, SMOOTH, SOFT, STIFF, controller
from experiments.thesis.testbed import VOLTS, yaw_testbed
from rwjax import Log, Rig, fit
from rwjax.control.closed_loop import run_rig
from rwjax.kinds import COEFFICIENTS, SERVO
from rwjax.logs.driven import without_servo
from rwjax.rig.model import Servo

FREE = ("axis.inertia", *COEFFICIENTS[:2])
OFF = {"axis.inertia": 1.1, COEFFICIENTS[0]: 0.85}
"""Factors by which the fits begin off what made the runs [1]."""
COUNT = 2.0 * np.pi / CLOCK.counts  # rad
SLOWER = 5  # samples of the loop in one of a slow logger


def rig_of(gains: tuple[float, float]) -> Rig:
    """The testbed with the thesis's loop: K_p [V/rad], K_d [V s/rad], 10 V, 100 Hz."""
    kp, kd = gains
    loop = {"kp": kp, "kd": kd, "derivative_filter": SMOOTH, "limit": VOLTS, "period": CLOCK.period}
    rig = yaw_testbed()
    numbers = rig.numbers | {f"{SERVO}.{name}": value for name, value in loop.items()}
    return replace(rig, numbers=numbers, servo=Servo("voltage"), free=FREE)


def logs_of(
    gains: tuple[float, float], heights: Sequence[float] = HEIGHTS, every: int = 1, counts: int = CLOCK.counts
) -> list[Log]:
    """One log for each square wave of a height [°], of every so many samples: the goal, and the axis in counts.

    `counts` a turn is what the loop reads; 0 for the angle itself.
    """
    found = []
    for height in heights:
        goal = np.tile(np.repeat([np.radians(height), 0.0], HALF), 2)
        angle = run_rig(yaw_testbed(), controller(*gains), goal, CLOCK._replace(counts=counts)).angle
        time, kept = CLOCK.period * np.arange(len(goal)), slice(None, None, every)
        yaw = COUNT * np.round(np.asarray(angle)[kept] / COUNT)
        log = Log(f"{height:g} deg", time[kept], goal[kept], {"yaw_rad": yaw}, {"yaw_rad": COUNT}, {}, False, None, 0.0)
        found.append(replace(log, input="goal_rad"))
    return found


class Found(NamedTuple):
    """What a fit found: `values` and half the 95 % `width` of each of `FREE` [SI], and its free run's error `rms` [rad]."""

    values: np.ndarray
    width: np.ndarray
    rms: float


def fitted(gains: tuple[float, float], logs: Sequence[Log], by_goal: bool) -> Found:
    """The free numbers from logs, following the goal, or under the voltage that the loop gives on the measured error."""
    truth = rig_of(gains)
    rig = truth.with_values({name: factor * truth.values[name] for name, factor in OFF.items()})
    found = fit(rig, logs) if by_goal else fit(*without_servo(rig, logs))
    error = found.rig.standard_error
    values = np.array([found.rig.values[name] for name in FREE])
    return Found(values, 1.96 * np.array([error.get(name, np.inf) for name in FREE]), found.rms["yaw_rad"])


def main() -> None:
    """Prints the numbers of every fit beside those that made the runs."""
    print("regenerated, not measured: square waves of 10, 20, 30 and 45 deg, 40 s each; values with 95 % intervals")
    units = (" [kg m2]", " [mN m]", " [mN m s/rad]")
    heads = [name.rpartition(".")[2] + unit for name, unit in zip(FREE, units, strict=True)]
    print(f"{'':46s}" + "".join(f"{head:>22s}" for head in (*heads, "free run misses")))
    for gains in (SOFT, STIFF):
        truth = rig_of(gains)
        made = Found(np.array([truth.values[name] for name in FREE]), np.full(len(FREE), np.nan), np.nan)
        print(_line(f"{gains} made by", made))
        for every in (1, SLOWER):
            logs = logs_of(gains, every=every)
            for by_goal, words in ((True, "from the goal"), (False, "error as a voltage")):
                print(_line(f"  {words}, {100 // every} Hz", fitted(gains, logs, by_goal)), flush=True)
        free = logs_of(gains, counts=0)
        print(_line("  from the goal, 100 Hz, the loop reads rad", fitted(gains, free, True)), flush=True)


def _line(what: str, found: Found) -> str:
    """One row of the table."""
    scale = np.array([1.0, 1e3, 1e3])
    cells = [
        f"{value:.4g}" + ("" if np.isnan(width) else f" ± {width:.2g}")
        for value, width in zip(scale * found.values, scale * found.width, strict=True)
    ]
    rms = "" if np.isnan(found.rms) else f"{1e3 * found.rms:.3g} mrad"
    return f"{what:46s}" + "".join(f"{cell:>22s}" for cell in (*cells, rms))


if __name__ == "__main__":
    main()
