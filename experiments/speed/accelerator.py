"""Does a GPU make anything faster? `python -m experiments.speed.accelerator` times the same calls on the processor and on what JAX takes by itself.

Where JAX finds no GPU, both columns are the processor's. Each call is timed twice, the first time with what it compiles, in a process of
its own for each device. `loops` are nonlinear closed loops by XLA's programs, in one batch as suits a GPU; all else runs as the library
runs it.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable

import jax
import numpy as np

from experiments.control.problem import LIMIT, SIGMA, SMOOTH, gains, reference
from experiments.control.problem import rig as control_rig
from experiments.realdata import ROOT
from experiments.speed.lowering import by_xla
from experiments.speed.table import machine, show, timed
from rwjax import diagnose, fit, read_logs, read_rig
from rwjax.control import sweep
from rwjax.control.controller import Controller
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import pd_loop
from rwjax.control.over_gains import gain_grid, over_gains
from rwjax.control.poles import slowest_pole
from rwjax.control.stability import stable
from rwjax.control.transfer import controller_form, transfer

DEMO = ROOT / "data" / "demo"
LOOPS = 16_000


def calls() -> dict[str, Callable[[], object]]:
    """What is timed, by its name."""
    rig = read_rig(DEMO / "rig.toml")
    logs = read_logs(sorted(DEMO.glob("*.csv")), rig)
    loop, axis = pd_loop(transfer(linearised(control_rig(dry=False)))), np.linspace(0.0, 100.0, 4000)
    plant, pairs = controller_form(transfer(linearised(rig))), gain_grid(axis[1::20], axis[1::20])
    kp, kd = gains(LOOPS)
    laws = [Controller(p, kd=d, filter_time=SMOOTH, voltage_limit=LIMIT) for p, d in zip(kp, kd, strict=True)]

    def loops() -> object:
        return jax.block_until_ready(sweep.step_responses(control_rig(), laws, reference()[None], since=500))

    return {
        "fit of the demo": lambda: fit(rig, logs),
        "diagnosis of the demo": lambda: diagnose(rig, logs),
        "gain region, 1.6 × 10⁷ pairs": lambda: np.asarray(stable(loop, axis[:, None], axis[None, :], sigma=SIGMA)),
        "slowest pole, 4 × 10⁴ pairs": lambda: np.asarray(over_gains(slowest_pole, pairs, plant)),
        f"loops, {LOOPS:.2g} of 10 s": by_xla(loops),
    }


def main() -> None:
    """Times every call in two processes, or, told so, in this one."""
    if sys.argv[1:] == ["here"]:
        sweep.BATCH, sweep.SAMPLES = LOOPS, LOOPS * len(reference())
        found = {name: [timed(call)[0] for _ in range(2)] for name, call in calls().items()}
        print(json.dumps({"device": str(jax.devices()[0]), "seconds": found}))
        return
    answers = []
    for platform in ("cpu", None):
        env = os.environ | ({"JAX_PLATFORMS": platform} if platform else {})
        done = subprocess.run(
            [sys.executable, "-m", __spec__.name, "here"], cwd=ROOT, env=env, check=True, capture_output=True, text=True
        )
        answers.append(json.loads(done.stdout.splitlines()[-1]))
    rows = [
        [name, *(" then ".join(f"{t:.3g}" for t in one["seconds"][name]) for one in answers)]
        for name in answers[0]["seconds"]
    ]
    show(f"First and second call [s]; {machine()}", ["call", *(one["device"] for one in answers)], rows)


if __name__ == "__main__":
    main()
