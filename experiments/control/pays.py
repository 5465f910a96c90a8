"""What the diagnosis pays: gains designed on the corrected model against gains designed on the rig file as it was fitted.

`python -m experiments.control.pays [CASE …]`. The rig is the separate simulator's (`experiments/blind`). The library fits and diagnoses its
logs. The same design is made on both models: largest margin, then tuned through the model's nonlinear loop, its friction fed forward.
Both controllers then run on the simulator's rig.
"""

import sys
from dataclasses import replace

import numpy as np
from numba import njit

from experiments.blind.axis import warmth
from experiments.blind.commands import command
from experiments.blind.drive import follow, shape
from experiments.blind.simulator import STEP, advance, simulate
from experiments.blind.truth import LAG_1, LAG_2, LOAD, PLAY, PSI, PSI_DRIVE, SLEW, STATES, Truth
from experiments.speed.table import show
from rwjax import Log, Rig, parse_rig
from rwjax.control.breakaway import breakaway
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.robust_gains import robust_gains
from rwjax.control.tuning import tune_from
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.errors import InputError
from rwjax.fitting.fit import fit
from rwjax.plant.from_rig import structure_of, theta_of

COUNTS, TICK, TOP = 2048, 0.01, 8.0  # s, V
CLOCK = LoopTiming(TICK, counts=COUNTS)
RUNS = {"square": False, "multisine": False, "stair": False, "triangle": True}  # and whether it validates
LIMIT, SMOOTH, SIGMA, FED, DEAD = 10.0, 0.02, 1.0, 0.8, np.radians(0.2)
BASE = Truth(kind=2, I=0.0495, viscous=0.0026)
CASES = {
    "Stribeck friction": replace(BASE, coulomb=0.010, excess=0.006, v_s=0.2),
    "Coulomb friction": replace(BASE, coulomb=0.012),
    "a dead zone": replace(BASE, deadzone=0.8),
    "nothing": BASE,
}
STEPS = np.radians([10.0, 25.0, 22.0, -5.0, 0.0, 3.0])  # of the trial's reference, one after the other
HOLD = 600  # samples
RIG = parse_rig(
    'kind = "reaction"\n[motor]\ntorque_constant = 0.0182\nresistance = 0.83\ninductance = 0.0641\nfriction = 4.07e-6\n[wheel]\n'
    f"inertia = 1.24e-4\n[axis]\ninertia = 0.06\n[axis.friction]\nviscous = 0.004\n[encoder]\ncounts_per_rev = {COUNTS}\n[fit]\n"
    'free = ["axis.inertia", "axis.friction.viscous"]'
)


def logs(truth: Truth) -> list[Log]:
    """What the simulator's rig logs: angle in counts, wheel rate and current with noise."""
    rng, found = np.random.default_rng(5), []
    for name, validates in RUNS.items():
        u = command(name, 14.0, TOP, rng)
        t = TICK * np.arange(len(u))
        x = simulate(t, u, t, np.zeros(5), truth.array())
        count = 2.0 * np.pi / COUNTS
        outputs = {
            "yaw_rad": np.floor(x[:, 0] / count + 0.5) * count,
            "wheel_rad_s": x[:, 3] + rng.normal(0.0, 0.5, len(u)),
            "current_A": x[:, 5] + rng.normal(0.0, 0.02, len(u)),
        }
        resolution = {"yaw_rad": count, "wheel_rad_s": 0.0, "current_A": 0.0}
        found.append(Log(f"{name}.csv", t, u, outputs, resolution, {}, validates, None, 0.0))
    return found


@njit
def simulated_rig(reference, law, sign, p):
    """Angles of the simulator's rig at the controller's samples."""
    x, half, slope_of = np.zeros(STATES), np.zeros(STATES), np.zeros(STATES)
    kp, ki, kd, smooth, forward, dead, limit = law
    count = 2.0 * np.pi / COUNTS
    before, slope, integral = reference[0], 0.0, 0.0
    angle, volts = np.empty(len(reference)), np.empty(len(reference))
    for k in range(len(reference)):
        angle[k] = x[PSI]
        error = reference[k] - np.floor(x[PSI] / count + 0.5) * count
        slope = (smooth * slope + error - before) / (smooth + TICK)
        before = error
        asked = kp * error + ki * integral + kd * slope + (forward * np.sign(error) if abs(error) > dead else 0.0)
        given = min(max(asked, -limit), limit)
        if asked == given or np.sign(asked) != np.sign(error):
            integral += TICK * error
        volts[k] = sign * given
        v = shape(volts[k], p)
        if k == 0:
            x[SLEW] = x[LAG_1] = x[LAG_2] = v
            x[LOAD], x[PLAY] = abs(v), v
            x[PSI_DRIVE] = x[PSI]
        for j in range(round(TICK / STEP)):
            t = k * TICK + (j + 0.5) * STEP
            warm = warmth(t, p) if p.drift != 0.0 or p.drift_viscous != 0.0 else 0.0
            advance(x, follow(x, v, t, STEP, p), 0.0, warm, STEP, p, slope_of, half)
    return angle, volts


def trial(truth: Truth, law: Controller) -> dict[str, float]:
    """What a controller does on the simulator's rig over the steps."""
    reference = np.repeat(STEPS, HOLD)
    numbers = np.array(
        [law.kp, law.ki, law.kd, law.filter_time, law.feedforward, law.deadband, law.voltage_limit], float
    )
    angle, volts = simulated_rig(reference, numbers, -1.0, truth.array())
    error = np.degrees(reference - angle).reshape(len(STEPS), HOLD)
    late = error[:, -HOLD // 4 :]
    return {
        "tracking": float(np.sqrt(np.mean(error**2))),
        "stays": float(np.mean(np.abs(late.mean(axis=1)))),
        "cycle": float(np.mean(0.5 * np.ptp(late, axis=1))),
        "saturated": float(np.mean(np.abs(volts) >= LIMIT)),
    }


def design(model: Rig) -> Controller:
    """Gains for a model, the same way for every one."""
    model = replace(model, effects={n: v for n, v in model.effects.items() if not n.startswith("sensor.")})
    theta = theta_of(model, structure_of(model))[None]
    robust = robust_gains(model, theta, np.array([0.0, 100.0]), np.array([0.0, 100.0]), SIGMA, CLOCK, SMOOTH)
    start = Controller(robust.kp, 0.3 * robust.kp, robust.kd, SMOOTH, FED * breakaway(model), DEAD, LIMIT)
    step = np.full(600, np.radians(15.0))
    return tune_from(model, start, step, CLOCK).controller


def case(name: str) -> list[str]:
    """Row of the table: what is missing, what was found, both controllers and what they do."""
    truth = CASES[name]
    records = logs(truth)
    fitted = fit(RIG, records).rig
    found = diagnose(RIG, records)
    laws = [design(fitted), design(found.corrected)]
    did = [trial(truth, law) for law in laws]
    cells = [name, f"{found.verdict}: {', '.join(found.effects) or '-'}"]
    cells += [" → ".join(f"{getattr(law, g):.3g}" for law in laws) for g in ("kp", "ki", "kd", "feedforward")]
    cells += [" → ".join(f"{d[key]:.3g}" for d in did) for key in ("tracking", "stays", "cycle")]
    return cells


def main(names: list[str]) -> None:
    """Prints the table; a case that cannot be designed is said."""
    rows = []
    for name in names or CASES:
        try:
            rows.append(case(name))
        except InputError as error:
            rows.append([name, str(error)])
        print(rows[-1], file=sys.stderr, flush=True)
    head = (
        "missing",
        "diagnosis",
        "kp",
        "ki",
        "kd",
        "fed forward [V]",
        "RMS error [°]",
        "error that stays [°]",
        "cycle [°]",
    )
    show("designed on the fitted rig file → on the corrected one; both on the simulator's rig", head, rows)


if __name__ == "__main__":
    main(sys.argv[1:])
