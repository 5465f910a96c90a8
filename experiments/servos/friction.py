"""Which friction does a measured servo need? `python -m experiments.servos.friction [--only NAME]`

The pendulums on Feetech servos, each fitted with the friction models of Rhoban's BAM (arXiv 2410.08650) as far as the library has them, and
judged by free runs on logs that took no part. Beside them stand the authors' own errors of the same trajectories.
"""

import sys
from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from experiments.realdata import need
from experiments.servos.cases import Case, cases
from experiments.speed.table import machine, show
from rwjax import fit, parse_rig, predict, read_logs
from rwjax.effects.library import BY_NAME
from rwjax.effects.parameter import parameters
from rwjax.errors import InputError
from rwjax.logs.log import Log
from rwjax.rig.model import Rig

MODELS = {
    "M1: dry and viscous": (),
    "M2: M1 and Stribeck": ("axis.stribeck",),
    "M3: M1 and load-dependent": ("axis.load_friction",),
    "M4: M2 and M3": ("axis.stribeck", "axis.load_friction"),
    "M4 and speed squared": ("axis.stribeck", "axis.load_friction", "axis.quadratic_drag"),
}
"""Effects beside dry and viscous friction."""
BEGUN = {"axis.stribeck.M_c": 0.05, "axis.stribeck.M_e": 0.1, "axis.stribeck.v_s": 0.15, "axis.load_friction.mu": 0.05}
"""Where a fit begins, in the units of the files; other numbers at what adds nothing [SI]."""
DRY = "axis.friction.coulomb"
PUBLISHED = {"up_and_down": (0.0245, 0.0124), "sin_time_square": (0.0817, 0.0838)}
"""Mean absolute errors of the authors' M1 and M6 on the STS3215, fitted to all its loads and gains at once, which is harder [rad]."""


def with_friction(rig: Rig, effects: Sequence[str]) -> Rig:
    """A joint's rig with further friction whose numbers are free; a Stribeck friction has the dry one in it.

    Args:
        rig: The rig with dry and viscous friction.
        effects: Names of the effects.

    Returns:
        The rig.
    """
    given = {e: {name: BEGUN.get(f"{e}.{name}", p.null) for name, p in parameters(BY_NAME[e]).items()} for e in effects}
    own = tuple(f"{e}.{name}" for e in effects for name, p in parameters(BY_NAME[e]).items() if p.fitted)
    numbers, free = rig.numbers, rig.free
    if "axis.stribeck" in effects:
        numbers, free = numbers | {DRY: 0.0}, tuple(name for name in free if name != DRY)
    return replace(rig, numbers=numbers, effects=rig.effects | given, free=free + own)


def mean_errors(rig: Rig, logs: Sequence[Log]) -> list[float]:
    """Mean absolute error of a free run of each log [rad]; infinite where it goes further than any rig."""
    found = []
    for log in logs:
        try:
            found.append(float(np.nanmean(np.abs(predict(rig, log)["yaw_rad"] - log.outputs["yaw_rad"]))))
        except InputError:
            found.append(np.inf)
    return found


def judged(case: Case) -> list[list[str]]:
    """A row for each friction model: errors on fitted and held-out logs [rad]."""
    folder = need() / case.data
    rig = parse_rig(case.rig, f"{case.data}/{case.name}.toml")
    train, held_out = (read_logs([folder / name for name in names], rig) for names in (case.train, case.held_out))
    rows = []
    for name, effects in MODELS.items():
        begin = perf_counter()
        fitted = fit(with_friction(rig, effects), train).rig
        seconds = perf_counter() - begin
        errors = [*mean_errors(fitted, train), *mean_errors(fitted, held_out)]
        rows.append([f"{case.data} {case.name}", name, *(f"{e:.4f}" for e in errors), f"{seconds:.0f}"])
    return rows


def main(only: str) -> None:
    """Prints the table."""
    joints = [case for case in cases() if case.data.startswith("feetech")]
    chosen = [case for case in joints if only in f"{case.data}/{case.name}"] or joints
    rows = [row for case in chosen for row in judged(case)]
    logs = [name.split("_L")[0] for name in (*chosen[0].train, *chosen[0].held_out)]
    show(f"Mean absolute error [rad]; {machine()}", ["joint", "friction", *logs, "fit [s]"], rows)
    print("; ".join(f"published for the STS3215, {log}: M1 {a}, M6 {b}" for log, (a, b) in PUBLISHED.items()))


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--only") + 1] if "--only" in sys.argv else "")
