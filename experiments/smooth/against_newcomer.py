"""A newcomer's script against this library: the same model, the same logs and the same start, each in a process of its own.

`python -m experiments.smooth.against_newcomer [FOLDER]` prints time, numbers and held-out errors on the demo's logs and on EMPS. No
program is compiled when a process begins. The newcomer runs once more with the XLA flag that the library sets for loops. The held-out
error is that of everybody's own simulation, and besides that of a simulator with exact stick and slip that shares no code with any of
them. Adding `demo` or `emps` and `smooth` or `exact` prints one fit of
the library as JSON.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from experiments.emps import oracle
from experiments.emps.run import PUBLISHED
from experiments.realdata import ROOT
from experiments.smooth.rigs import EXPONENT, Trial, demo, electro_mechanical
from experiments.speed.table import seconds, show, timed

NAMES = {  # of the newcomer's parameters in the rig file
    "demo": {
        "inertia": "axis.inertia",
        "viscous": "axis.friction.viscous",
        "coulomb": "axis.stribeck.M_c",
        "excess": "axis.stribeck.M_e",
        "v_s": "axis.stribeck.v_s",
    },
    "emps": {
        "mass": "axis.inertia",
        "viscous": "axis.friction.viscous",
        "dry": "axis.friction.coulomb",
        "bias": "axis.bias_torque.T",
    },
}
FLAG = "newcomer, an XLA flag"
WHOLE_LOOPS = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=1000000000000"
"""A loop's body as one function of XLA's, not a kernel for each expression."""
CONTESTANTS = ("newcomer", FLAG, "smooth", "exact")
LIMIT = 900.0  # s


def trial(case: str, folder: Path) -> Trial:
    """The problem as the library reads it."""
    return demo() if case == "demo" else electro_mechanical(folder)


def rms(errors: list[np.ndarray]) -> float:
    """Root of the mean square of all errors."""
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def library(case: str, solver: str, folder: Path) -> dict:
    """Two fits by the library, the first one with compilation."""
    import rwjax

    chosen = rwjax.Smooth() if solver == "smooth" else rwjax.Exact()
    given = trial(case, folder)
    first, found = timed(lambda: rwjax.fit(given.rig, given.train, solver=chosen))
    warm, _ = timed(lambda: rwjax.fit(given.rig, given.train, solver=chosen))
    values, error = found.rig.values, found.rig.standard_error
    own = [log.outputs["yaw_rad"] - rwjax.predict(found.rig, log, solver=chosen)["yaw_rad"] for log in given.held_out]
    numbers = {short: [values[name], error.get(name, np.inf)] for short, name in NAMES[case].items()}
    return {"first": first, "warm": warm, "numbers": numbers, "held_out": rms(own), "notes": list(found.notes)}


def contest(case: str, name: str, folder: Path) -> dict:
    """What one contestant prints, in a process that finds no compiled program."""
    if name in ("newcomer", FLAG):
        given = trial(case, folder)
        where = ROOT / "data" / "demo" if case == "demo" else folder
        logs = [[str(where / log.name) for log in group] for group in (given.train, given.held_out)]
        command = [str(Path(__file__).with_name("newcomer.py")), case, *logs[0], "--", *logs[1]]
    else:
        command = ["-m", "experiments.smooth.against_newcomer", str(folder), case, name]
    with tempfile.TemporaryDirectory() as programs:
        environment = os.environ | {"JAX_COMPILATION_CACHE_DIR": programs}
        if name == FLAG:
            environment["XLA_FLAGS"] = WHOLE_LOOPS
        done = subprocess.run(
            [sys.executable, *command], cwd=ROOT, env=environment, capture_output=True, text=True, timeout=LIMIT
        )
    if done.returncode:
        raise SystemExit(f"{name} on {case}: {done.stderr.strip().splitlines()[-1]}")
    return json.loads(done.stdout.splitlines()[-1])


def exactly(case: str, numbers: dict[str, float], given: Trial) -> float:
    """Held-out error of the same numbers in a simulator with exact stick and slip [rad or m]."""
    if case == "emps":
        p = [numbers[name] for name in ("mass", "viscous", "dry", "bias")]
        return 1e-3 * oracle.rmse(p, (oracle.GAIN * given.held_out[0].command, given.held_out[0].outputs["yaw_rad"]))
    return rms([log.outputs["yaw_rad"] - platform(numbers, log) for log in given.held_out])


def platform(numbers: dict[str, float], log) -> np.ndarray:
    """Angle [rad] of the demo's platform with these numbers, from rest at the first reading."""
    from experiments.blind.simulator import STEP, Truth, simulate

    n = numbers
    truth = Truth(
        kind=1, gain=0.428, I=n["inertia"], viscous=n["viscous"], coulomb=n["coulomb"], excess=n["excess"],
        v_s=n["v_s"], exponent=EXPONENT,
    )  # fmt: skip
    start = np.zeros(5)
    start[0] = log.outputs["yaw_rad"][0]
    return simulate(log.time, log.command, log.time, start, truth.array(), STEP)[:, 0]


def known(case: str, given: Trial) -> dict[str, float]:
    """The true numbers of the demo, the published ones of EMPS, by the newcomer's names."""
    values = given.truth or PUBLISHED
    return {short: values[name] for short, name in NAMES[case].items()}


def tables(case: str, found: dict[str, dict], given: Trial) -> None:
    """Prints what was found on one case."""
    unit, scale = ("rad", 1.0) if case == "demo" else ("mm", 1e3)
    rows = []
    for name, one in found.items():
        plain = {number: value for number, (value, _) in one["numbers"].items()}
        errors = (f"{scale * one['held_out']:.3g} {unit}", f"{scale * exactly(case, plain, given):.3g} {unit}")
        rows.append([name, seconds(one["first"]), seconds(one["warm"]), *errors])
    show(f"{given.name}: time and held-out error", ["", "first fit", "again", "own simulation", "exact stick"], rows)
    right, head = known(case, given), "true" if given.truth else "published"
    show(
        f"{given.name}: numbers",
        ["", head, *found],
        [
            [number, f"{right[number]:.4g}", *(f"{v:.5g} ± {e:.2g}" for v, e in (one["numbers"][number] for one in found.values()))]
            for number in right
        ],
    )  # fmt: skip


def main(folder: Path) -> None:
    """Runs everybody on both rigs."""
    folder = folder.resolve()
    for case in NAMES:
        given = trial(case, folder)
        tables(case, {name: contest(case, name, folder) for name in CONTESTANTS}, given)


if __name__ == "__main__":
    place = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/emps")
    if len(sys.argv) > 2:
        print(json.dumps(library(sys.argv[2], sys.argv[3], place)))
    else:
        main(place)
