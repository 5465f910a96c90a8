"""Random joints as people have them, small geared servos up to robots' joints: rig file, logs, the true numbers.

`python -m experiments.joints.draw SORT SEED -o DIR` writes one. The numbers of a joint go with its size, a torque between 0.3 and
5 N m. Every run begins at rest: the joint hangs, or its loop has held the first goal for some seconds.
"""

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from experiments.blind.cases import Case, write_case
from experiments.blind.commands import TICK, command
from experiments.blind.joint import AMPERE, CURRENT, DUTY, PSI, STATES, TORQUE, VOLTAGE, Inputs, Joint, Servo, W, move
from experiments.blind.rigs import near

SORTS = ("voltage", "duty", "goal", "torque_off")
GIVEN = {"voltage": VOLTAGE, "duty": DUTY, "current": CURRENT, "torque": TORQUE}
COLUMN = {"voltage": "voltage_V", "duty": "duty"}
RUNS = ("square", "multisine", "stair", "triangle", "prbs", "coast")
LENGTH = 6.0  # s
SETTLE = 4.0  # s, that a loop has held the first goal when the log begins


@dataclass(frozen=True)
class Drawn:
    """A joint, its loop, and what its user has: a supply, a logger, sensors."""

    sort: str
    acts_on: str  # what the drive is given
    joint: Joint
    servo: Servo | None
    size: float  # N m
    supply: float  # V
    supply_logged: bool
    rate: float  # Hz, of the logger
    jitter: float  # share of its period by which a sample may be early or late
    counts: int  # of the encoder, 0: it logs radians
    noise: dict[str, float]  # standard deviation of each column [SI]
    free: tuple[str, ...]


def draw(sort: str, seed: int) -> Drawn:
    """A joint of a sort, reproducible by its seed."""
    rng = np.random.default_rng([seed, SORTS.index(sort), 26])
    acts_on = sort if sort in GIVEN else str(rng.choice(list(GIVEN)))
    size, supply = near(1.2, 4.0, rng), float(rng.choice([7.4, 12.0, 24.0]))
    joint = _joint(GIVEN[acts_on], size, supply, rng)
    servo = _servo(joint, supply, size, rng) if sort in ("goal", "torque_off") else None
    counts = int(rng.choice([0, 0, 1024, 4096, 4096, 16384]))
    noise = {"yaw_counts": 0.3 * 2 * np.pi / counts} if counts else {"yaw_rad": float(rng.uniform(0.0005, 0.003))}
    if rng.random() < 0.2:
        noise["yaw_rad_s"] = float(rng.uniform(0.02, 0.1))
    if sort in COLUMN and rng.random() < 0.3:
        noise["current_A"] = float(rng.uniform(0.005, 0.02)) * supply / joint.R
    return Drawn(
        sort=sort,
        acts_on=acts_on,
        joint=joint,
        servo=servo,
        size=size,
        supply=supply,
        supply_logged=bool(acts_on == "duty" and rng.random() < 0.5),
        rate=float(rng.choice([50.0, 100.0, 125.0, 200.0])),
        jitter=0.2 * float(rng.random() < 0.5),
        counts=counts,
        noise=noise,
        free=_free(joint, servo, acts_on, rng),
    )


def _joint(given: int, size: float, supply: float, rng: np.random.Generator) -> Joint:
    """Motor, gear, link, friction and gravity for a size [N m]."""
    back_emf = supply / float(rng.uniform(5.0, 20.0))  # V s/rad at the link, from the speed without load
    ratio = near(40.0, 8.0, rng)
    inertia, share = size * near(0.022, 2.0, rng), float(rng.uniform(0.1, 0.6)) * float(rng.random() < 0.8)
    R = back_emf * supply / (size * float(rng.uniform(2.0, 4.0)))  # from the torque at stall
    inductive, stribeck, hangs, turned = rng.random(4) < (0.4, 0.25, 0.7, 0.5)
    coulomb = size * near(0.09, 1.7, rng)
    excess, v_s = coulomb * float(rng.uniform(0.2, 0.6)), float(rng.uniform(0.1, 0.5))
    return Joint(
        given=given,
        ratio=ratio,
        K=back_emf / ratio,
        R=R,
        L=R * float(rng.uniform(2e-4, 2e-3)) * float(inductive and given in (VOLTAGE, DUTY)),
        rotor=share * inertia / ratio**2,
        I=(1.0 - share) * inertia,
        viscous=size * near(0.02, 2.0, rng),
        coulomb=coulomb,
        excess=excess * float(stribeck),
        v_s=v_s,
        gravity=size * near(0.5, 1.7, rng) * float(hangs),
        gravity_angle=float(rng.uniform(-np.pi, np.pi)) * float(hangs and turned),
    )


def torque_per_unit(joint: Joint, supply: float) -> float:
    """Torque at the link that the drive gives at standstill for 1 V, a whole duty, 1 A or 1 N m."""
    at_link = joint.ratio * joint.K
    return {VOLTAGE: at_link / joint.R, DUTY: supply * at_link / joint.R, CURRENT: at_link, TORQUE: 1.0}[joint.given]


def _servo(joint: Joint, supply: float, size: float, rng: np.random.Generator) -> Servo:
    """A loop whose poles would lie at 8 to 25 rad/s, damped well enough."""
    total = joint.I + joint.ratio**2 * joint.rotor
    wanted, damping = float(rng.uniform(8.0, 25.0)), float(rng.uniform(0.4, 0.9))
    braking = (joint.ratio * joint.K) ** 2 / joint.R if joint.given in (VOLTAGE, DUTY) else 0.0
    gain = torque_per_unit(joint, supply)
    kp = wanted**2 * total / gain
    kd = max(2.0 * damping * wanted * total - braking - joint.viscous, 0.0) / gain
    period = float(rng.choice([0.001, 0.002, 0.004, 0.005, 0.008, 0.01]))
    with_integral, with_filter, limited, out_of_step, on_speed = rng.random(5) < (0.35, 0.5, 0.15, 0.5, 0.5)
    strongest = {VOLTAGE: supply, DUTY: float(rng.uniform(0.6, 1.0))}.get(
        joint.given, size * rng.uniform(1.5, 3) / gain
    )
    return Servo(
        kp=kp,
        ki=kp * float(rng.uniform(0.5, 3.0)) * float(with_integral),
        kd=kd,
        on_speed=float(on_speed),
        filter=period * float(rng.uniform(1.0, 3.0)) * float(with_filter and kd > 0.0),
        error_limit=float(rng.uniform(0.3, 0.6)) if limited else Servo.error_limit,
        limit=float(strongest),
        period=period,
        phase=float(np.round(rng.uniform(0.0, period), 6)) * float(out_of_step),
    )


def _free(joint: Joint, servo: Servo | None, acts_on: str, rng: np.random.Generator) -> tuple[str, ...]:
    """What a fit estimates; where it estimates a gain, the inertia is known."""
    names = ["axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"]
    if joint.gravity and rng.random() < 0.8:
        names.append("axis.gravity.torque")
    gains = [] if acts_on == "torque" else ["motor.torque_constant"]
    gains += [] if servo is None else ["drive.servo.kp"]
    if gains and rng.random() < 0.3:
        names[0] = str(rng.choice(gains))
    return tuple(names)


def numbers(drawn: Drawn) -> dict[str, float]:
    """The true numbers of the rig file by name."""
    joint, servo = drawn.joint, drawn.servo
    found = {"gear.ratio": joint.ratio, "motor.torque_constant": joint.K, "motor.resistance": joint.R}
    found |= {"motor.inductance": joint.L} if joint.L else {}
    found |= {"motor.inertia": joint.rotor} if joint.rotor else {}
    if drawn.acts_on in ("current", "torque"):
        del found["motor.resistance"]
    if drawn.acts_on == "torque":
        del found["motor.torque_constant"]
    found |= {"drive.supply": drawn.supply} if drawn.acts_on == "duty" and not drawn.supply_logged else {}
    if servo is not None:
        found |= {"drive.servo.kp": servo.kp}
        found |= {"drive.servo.ki": servo.ki} if servo.ki else {}
        found |= {"drive.servo.kd": servo.kd} if servo.kd else {}
        found |= {"drive.servo.derivative_filter": servo.filter} if servo.filter else {}
        found |= {"drive.servo.error_limit": servo.error_limit} if servo.error_limit < 1e6 else {}
        found |= {"drive.servo.limit": servo.limit, "drive.servo.period": servo.period}
        found |= {"drive.servo.phase": servo.phase} if servo.phase else {}
    found |= {"axis.inertia": joint.I, "axis.friction.viscous": joint.viscous, "axis.friction.coulomb": joint.coulomb}
    if joint.excess:
        found |= {"axis.friction.static": joint.coulomb + joint.excess, "axis.friction.stribeck_velocity": joint.v_s}
    if joint.gravity:
        found |= {"axis.gravity.torque": joint.gravity}
        found |= {"axis.gravity.angle": joint.gravity_angle} if joint.gravity_angle else {}
    return found


def rig_text(drawn: Drawn, starts: dict[str, float]) -> str:
    """The rig file, with `starts` in place of the true numbers."""
    values = {name: f"{value:.10g}" for name, value in (numbers(drawn) | starts).items()}
    if drawn.servo is not None:
        values["drive.servo.acts_on"] = json.dumps(drawn.acts_on)
        values["drive.servo.damping_on"] = json.dumps("speed" if drawn.servo.on_speed else "error")
    if drawn.counts:
        values["encoder.counts_per_rev"] = str(drawn.counts)
    values["fit.free"] = json.dumps(list(drawn.free))
    sections: dict[str, list[str]] = {}
    for name, value in values.items():
        section, key = name.rsplit(".", 1)
        sections.setdefault(section, []).append(f"{key} = {value}")
    tables = ["\n".join([f"[{section}]", *lines]) for section, lines in sections.items()]
    return "\n\n".join(['kind = "joint"\nname = "apart"', *tables, ""])


def times(drawn: Drawn, rng: np.random.Generator) -> np.ndarray:
    """Times of the samples of one run, as they are written."""
    steps = np.full(round(LENGTH * drawn.rate), 1.0 / drawn.rate)
    steps *= 1.0 + drawn.jitter * rng.uniform(-1.0, 1.0, len(steps))
    return np.round(np.concatenate([[0.0], np.cumsum(steps)]), 6)


def amplitude(drawn: Drawn) -> float:
    """Largest command: a goal's distance from its middle, or what moves the joint well and not over the top."""
    joint = drawn.joint
    if drawn.servo is not None:
        return 0.5
    torque = joint.coulomb + joint.excess + (0.95 * joint.gravity if joint.gravity else 0.8 * drawn.size)
    return torque / torque_per_unit(joint, drawn.supply)


def run(drawn: Drawn, kind: str, rng: np.random.Generator) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """One run: what it was given, by column, and what its sensors would read without noise, in SI."""
    t = times(drawn, rng)
    top = amplitude(drawn) * float(rng.uniform(0.6, 1.0))
    u = command(kind, LENGTH + 1.0, top, rng)[(t / TICK + 1e-6).astype(int)]
    one, joint = np.ones(len(t)), drawn.joint
    middle = -joint.gravity_angle + float(rng.uniform(-0.6, 0.6))
    supply, enabled = one, one
    if joint.given == DUTY:
        swing = np.sin(2 * np.pi * rng.uniform(0.1, 0.4) * t) if drawn.supply_logged else 0.0 * t
        supply = np.round(drawn.supply * (1.0 + 0.04 * swing), 3)
    if drawn.servo is not None:
        u = np.round(u + middle, 4)
    if drawn.sort == "torque_off":
        begin, last = rng.uniform(1.5, 3.0), rng.uniform(0.8, 2.0)
        enabled = np.where((t >= begin) & (t < begin + last), 0.0, 1.0)
    states, _ = move(joint, drawn.servo, Inputs(t, u, supply, enabled), t, (middle, 0.0), begin=-SETTLE)
    given = {COLUMN.get(drawn.sort, "goal_rad"): u}
    given |= {"supply_V": supply} if drawn.supply_logged else {}
    given |= {"enabled": enabled} if drawn.sort == "torque_off" else {}
    clean = {"yaw_rad": states[:, PSI], "yaw_counts": states[:, PSI], "yaw_rad_s": states[:, W]}
    clean["current_A"] = states[:, STATES] if joint.L == 0.0 else states[:, AMPERE]
    return {"time_s": t} | given, {name: clean[name] for name in drawn.noise}


DIGITS = {"time_s": 6, "enabled": 0, "supply_V": 3, "yaw_rad": 5, "yaw_rad_s": 4, "current_A": 4}


def _log(drawn: Drawn, kind: str, validate: bool, rng: np.random.Generator) -> str:
    given, clean = run(drawn, kind, rng)
    columns = {name: [f"{v:.{DIGITS.get(name, 4)}f}" for v in values] for name, values in given.items()}
    for name, values in clean.items():
        noisy = values + drawn.noise[name] * rng.standard_normal(len(values))
        if name == "yaw_counts":
            columns[name] = [str(c) for c in np.round(noisy * drawn.counts / (2 * np.pi)).astype(int)]
        else:
            columns[name] = [f"{v:.{DIGITS[name]}f}" for v in noisy]
    rows = [",".join(row) for row in zip(*columns.values(), strict=True)]
    return "\n".join([*(["# role: validate"] if validate else []), ",".join(columns), *rows, ""])


def make_case(sort: str, seed: int) -> Case:
    """A random joint of a sort: rig file, three runs for the fit and one that is held out, the label."""
    drawn = draw(sort, seed)
    rng = np.random.default_rng([seed, SORTS.index(sort), 27])
    kinds = [str(kind) for kind in rng.choice(RUNS, 4, replace=False)]
    logs = {f"{kind}_{k}.csv": _log(drawn, kind, k == 3, rng) for k, kind in enumerate(kinds)}
    true = {name: value for name, value in numbers(drawn).items() if name in drawn.free}
    starts = {name: value * float(np.exp(rng.uniform(-0.35, 0.35))) for name, value in true.items()}
    if drawn.joint.excess:
        starts["axis.friction.coulomb"] = min(starts["axis.friction.coulomb"], drawn.joint.coulomb)
    label = {"kind": "joint", "sort": sort, "acts_on": drawn.acts_on, "seed": seed, "true_numbers": true}
    label |= {"parameters": asdict(drawn.joint), "servo": None if drawn.servo is None else asdict(drawn.servo)}
    return Case(rig_text(drawn, starts), logs, label)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sort", choices=SORTS)
    parser.add_argument("seed", type=int)
    parser.add_argument("-o", dest="folder", type=Path, required=True)
    a = parser.parse_args()
    write_case(make_case(a.sort, a.seed), a.folder)


if __name__ == "__main__":
    main()
