"""Labelled cases: a rig file, logs and the answer. `python -m experiments.blind.cases --kind platform --effect none -o DIR`"""

import argparse
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from experiments.blind.commands import TICK, command
from experiments.blind.simulator import STEP, Truth, simulate

KINDS = ("wheel", "platform", "reaction")
TRAINING = ("square", "multisine", "triangle", "stair", "coast", "prbs")
JITTER = 1e-4  # s, largest distance of a sample from its time stamp
COUNTS = (256, 512, 1024, 2048, 4096)
FIELD = {
    "motor.torque_constant": "K",
    "motor.resistance": "R",
    "motor.inductance": "L",
    "motor.friction": "b",
    "wheel.inertia": "J",
    "drive.gain": "gain",
    "axis.inertia": "I",
    "axis.friction.viscous": "viscous",
    "axis.friction.coulomb": "coulomb",
}


@dataclass(frozen=True)
class Case:
    """Text of the rig file, text of each log by file name, and the label."""

    rig: str
    logs: dict[str, str]
    truth: dict


def _base(kind: str, rng: np.random.Generator) -> tuple[Truth, list[str]]:
    """Truth without effects, and the friction terms that the rig file models."""

    def near(value: float, factor: float = 1.5) -> float:
        return float(value * np.exp(rng.uniform(-np.log(factor), np.log(factor))))

    truth = Truth(kind=KINDS.index(kind), K=near(0.0182, 1.1), R=near(0.83, 1.1), L=near(0.0641, 1.1))
    truth = replace(truth, b=near(4.07e-6, 1.2), J=near(1.24e-4, 1.15), gain=near(0.428, 1.1))
    if kind == "platform":
        truth = replace(truth, I=near(0.228), viscous=near(0.04, 2.0))
        coulomb = near(0.09)
    else:
        truth = replace(truth, I=near(0.06), viscous=near(0.006))
        coulomb = near(0.012, 2.0)
    terms = ["axis.friction.viscous"] if kind != "wheel" else []
    if kind != "wheel" and rng.random() < 0.6:
        truth, terms = replace(truth, coulomb=coulomb), [*terms, "axis.friction.coulomb"]
    return truth, terms


def _with_effect(truth: Truth, effect: str, kind: str, top: float, rng: np.random.Generator) -> tuple[Truth, dict]:
    """Truth with the effect, and the numbers of the rig file that are therefore wrong."""
    torque = truth.gain * top if kind == "platform" else truth.K * top / truth.R
    share = float(rng.uniform(0.06, 0.2))
    sign = float(rng.choice([-1.0, 1.0]))
    level = truth.coulomb or 0.1 * torque
    if effect.startswith("parameter."):
        name = effect.removeprefix("parameter.")
        wrong = getattr(truth, FIELD[name]) * float(np.exp(sign * rng.uniform(0.08, 0.3)))
        return truth, {name: wrong}
    change: dict[str, dict] = {
        "axis.viscous": {"viscous": truth.viscous * 2.0},
        "axis.coulomb": {"coulomb": share * torque},
        "axis.stribeck": {
            "coulomb": level,
            "excess": level * rng.uniform(0.4, 1.0),
            "v_s": rng.uniform(0.1, 0.4),
            "form": float(rng.integers(2)),
            "exponent": float(rng.choice([1.0, 1.5, 2.0])),
        },
        "axis.asymmetric_friction": {"coulomb": level, "asymmetry": sign * level * rng.uniform(0.2, 0.5)},
        "axis.bias_torque": {"bias_torque": sign * share * torque / 2},
        "wheel.coulomb": {
            "wheel_coulomb": share * truth.K * top / truth.R,
            "wheel_breakaway": rng.uniform(0.0, 0.3),
        },
        "drive.deadzone": {"deadzone": share * top, "deadzone_form": float(rng.choice([0.0, 2.0]))},
        "drive.bias": {"bias_command": sign * share * top / 2},
        "drive.delay": {"delay": rng.uniform(0.02, 0.1)},
    }
    return replace(truth, **change[effect]), {}


def _rig(kind: str, truth: Truth, terms: list[str], free: dict[str, float], wrong: dict, encoders: dict) -> str:
    values = {name: getattr(truth, FIELD[name]) for name in FIELD} | free | wrong
    sections: dict[str, list[str]] = {
        "wheel": [
            "motor.torque_constant",
            "motor.resistance",
            "motor.inductance",
            "motor.friction",
            "wheel.inertia",
        ],
        "platform": ["drive.gain", "axis.inertia", *terms],
        "reaction": [
            *(
                "motor.torque_constant",
                "motor.resistance",
                "motor.inductance",
                "motor.friction",
                "wheel.inertia",
            ),
            *("axis.inertia", *terms),
        ],
    }
    lines, section = [f'kind = "{kind}"', 'name = "blind"'], ""
    for name in sections[kind]:
        head, key = name.rsplit(".", 1)
        if head != section:
            section = head
            lines += ["", f"[{section}]"]
        lines.append(f"{key} = {values[name]:.10g}")
    for section, counts in encoders.items():
        lines += ["", f"[{section}]", f"counts_per_rev = {counts}"]
    return "\n".join([*lines, "", "[fit]", f"free = {json.dumps(list(free))}", ""])


def _log(kind: str, truth: Truth, u: np.ndarray, validate: bool, sensors: dict, rng: np.random.Generator) -> str:
    t = np.arange(len(u)) * TICK
    at = np.maximum.accumulate(np.maximum(t + rng.uniform(-JITTER, JITTER, len(t)), 0.0))
    x0 = np.zeros(5)
    x0[0] = sensors["angle"]
    x = simulate(t, u, at, x0, truth.array(), STEP)
    columns = {"time_s": [f"{v:.3f}" for v in t], "voltage_V": [f"{v:.3f}" for v in u]}
    if kind != "wheel":
        if "counts" in sensors:
            counts = np.round(x[:, 0] * sensors["counts"] / (2 * np.pi)).astype(int)
            columns["yaw_counts"] = [str(c) for c in counts]
        else:
            columns["yaw_rad"] = [f"{v:.5f}" for v in x[:, 0] + rng.normal(0.0, sensors["yaw"], len(t))]
    if kind != "platform":
        if sensors["with_wheel"]:
            columns["wheel_rad_s"] = [f"{v:.2f}" for v in x[:, 3] + rng.normal(0.0, sensors["wheel"], len(t))]
        columns["current_A"] = [f"{v:.3f}" for v in x[:, 5] + rng.normal(0.0, sensors["current"], len(t))]
    rows = [",".join(cells) for cells in zip(*columns.values(), strict=True)]
    return "\n".join([*(["# role: validate"] if validate else []), ",".join(columns), *rows, ""])


def make_case(kind: str, effect: str | None, seed: int) -> Case:
    """A random rig of a kind that lacks `effect`, or nothing; reproducible by its seed."""
    rng = np.random.default_rng([seed, KINDS.index(kind), *(ord(c) for c in effect or "none")])
    truth, terms = _base(kind, rng)
    top = float(rng.uniform(6.0, 9.0))
    if (
        effect in ("axis.stribeck", "axis.asymmetric_friction")
        and kind != "wheel"
        and "axis.friction.coulomb" not in terms
    ):
        terms = [*terms, "axis.friction.coulomb"]
    if effect in ("axis.coulomb", "axis.viscous"):
        missing = {"axis.coulomb": "axis.friction.coulomb", "axis.viscous": "axis.friction.viscous"}[effect]
        terms = [term for term in terms if term != missing]
        truth = replace(truth, coulomb=0.0) if effect == "axis.coulomb" else truth
    wrong: dict = {}
    if effect:
        truth, wrong = _with_effect(truth, effect, kind, top, rng)
    estimated = ["wheel.inertia", "motor.friction"] if kind == "wheel" else ["axis.inertia", *terms]
    estimated = [name for name in estimated if name not in wrong]
    true_numbers = {name: getattr(truth, FIELD[name]) for name in estimated}
    free = {name: value * float(np.exp(rng.uniform(-0.35, 0.35))) for name, value in true_numbers.items()}
    sensors: dict = {
        "angle": float(rng.uniform(-0.5, 0.5)),
        "with_wheel": kind == "wheel" or rng.random() < 0.6,
    }
    sensors |= {"wheel": float(rng.uniform(0.3, 0.8)), "current": float(rng.uniform(0.02, 0.06))}
    encoders = {}
    if kind != "wheel" and rng.random() < 0.7:
        sensors["counts"] = int(rng.choice(COUNTS))
        encoders = {"encoder": sensors["counts"]}
    sensors["yaw"] = float(rng.uniform(0.0005, 0.01))
    training = list(rng.choice(TRAINING, size=4, replace=False))
    runs = [(k, False) for k in training] + [("mixed", True), (str(rng.choice(training)), True)]
    logs = {}
    for k, (name, validate) in enumerate(runs):
        u = command(str(name), float(rng.uniform(10.0, 15.0)), top, rng)
        logs[f"{name}_{k}.csv"] = _log(kind, truth, u, validate, sensors, rng)
    label = {
        "kind": kind,
        "effects": [effect] if effect else [],
        "parameters": {k: v for k, v in asdict(truth).items()},
        "true_numbers": true_numbers,
        "wrong_numbers": wrong,
        "seed": seed,
    }
    return Case(_rig(kind, truth, terms, free, wrong, encoders), logs, label)


def write_case(case: Case, folder: Path) -> None:
    """Writes `rig.toml`, the logs and `truth.json`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.toml").write_text(case.rig)
    for name, text in case.logs.items():
        (folder / name).write_text(text)
    (folder / "truth.json").write_text(json.dumps(case.truth, indent=1) + "\n")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--effect", default="none", help="a name of diagnosis.json, or none")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-o", dest="folder", type=Path, required=True)
    a = parser.parse_args()
    write_case(make_case(a.kind, None if a.effect == "none" else a.effect, a.seed), a.folder)


if __name__ == "__main__":
    main()
