"""The dictionary of the regressions: what each effect of the library would leave in the equations of a fitted rig.

An effect has one or more forms, each a list of terms that are linear in their coefficients; forms differ in what is not linear (a Stribeck
speed, a dead zone's width, a frequency). Terms hold along the measured motion, so some effects have none (`BEYOND`).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from experiments.rivals.equations import Blocks, Motion

BEYOND = {
    "axis.asymmetric_friction": "along a sliding motion the same as a constant torque",
    "axis.backlash": "a second body that no reading shows",
    "axis.flexible_coupling": "a second body that no reading shows",
    "sensor.delay": "only to first order the same as a late command, whose name is given",
    "sensor.missed_counts": "an error of the reading from a speed on that is not known",
    "sensor.clock": "to first order the same as a scale of the reading",
    "sensor.offset": "no acceleration shows it",
}
"""Effects that no term of the dictionary says, and why."""
SHARES = (0.1, 0.2, 0.35, 0.5, 0.65, 0.8)
"""Levels of dead zones, limits and stops as shares of the largest value."""


@dataclass(frozen=True)
class Term:
    """One column: its name, and what it is in every equation of a run."""

    name: str
    of: Callable[[Motion], Blocks]


Form = tuple[Term, ...]


def _axis(name: str, torque: Callable[[Motion], np.ndarray]) -> Term:
    """A torque on the axis."""
    return Term(f"axis {name}", lambda m: {"w": torque(m) / m.numbers["axis.inertia"]})


def _wheel(name: str, torque: Callable[[Motion], np.ndarray]) -> Term:
    """A torque between motor and wheel, which pushes the axis backwards."""

    def blocks(m: Motion) -> Blocks:
        found = {"Omega": torque(m) / m.numbers["wheel.inertia"]}
        return found | ({"w": -torque(m) / m.numbers["axis.inertia"]} if m.kind == "reaction" else {})

    return Term(f"wheel {name}", blocks)


def _volts(name: str, volts: Callable[[Motion], np.ndarray]) -> Term:
    """A voltage that the drive adds: through its gain to the axis, or through the winding to the current and the wheel."""

    def blocks(m: Motion) -> Blocks:
        if m.kind == "platform":
            return {"w": m.numbers["drive.gain"] * volts(m) / m.numbers["axis.inertia"]}
        i = volts(m) / m.numbers["motor.resistance"]
        return {"i": i} | _wheel("", lambda m: m.numbers["motor.torque_constant"] * i).of(m)

    return Term(f"volts {name}", blocks)


def _amperes(name: str, ampere: Callable[[Motion], np.ndarray]) -> Term:
    """A current that a driver takes away."""

    def blocks(m: Motion) -> Blocks:
        return {"i": ampere(m)} | _wheel("", lambda m: m.numbers["motor.torque_constant"] * ampere(m)).of(m)

    return Term(f"amperes {name}", blocks)


def _lagged(x: np.ndarray, seconds: float, h: float) -> np.ndarray:
    keep = np.exp(-h / seconds)
    return np.asarray(lfilter([1.0 - keep], [1.0, -keep], x))


def _late(m: Motion, seconds: float) -> np.ndarray:
    return np.interp(m.t - seconds, m.t, m.V, left=0.0) - m.V


def _no_faster(m: Motion, volts_per_s: float) -> np.ndarray:
    """What a drive that follows at a limited rate gives less the command [V]."""
    y, most = np.empty_like(m.V), volts_per_s * m.h
    last = 0.0
    for k, v in enumerate(m.V):
        last += min(max(v - last, -most), most)
        y[k] = last
    return y - m.V


def _presliding(m: Motion, length: float) -> np.ndarray:
    """Friction state of Dahl's model along a motion, from -1 to 1, begun at 0."""
    z, state = np.empty_like(m.t), 0.0
    for k, step in enumerate(np.diff(m.states["psi"], prepend=m.states["psi"][0])):
        toward = np.sign(step)
        state = toward + (state - toward) * np.exp(-abs(step) / length)
        z[k] = state
    return z


def _friction() -> Iterator[tuple[str, list[Form]]]:
    """Friction of the axis."""
    sliding = _axis("sign", lambda m: -np.sign(m.states["w"]))
    yield "axis.viscous", [(_axis("speed", lambda m: -m.states["w"]),)]
    yield "axis.coulomb", [(sliding,)]
    yield (
        "axis.stribeck",
        [
            (
                _axis(f"stribeck {v}", lambda m, v=v: -np.sign(m.states["w"]) * np.exp(-((m.states["w"] / v) ** 2))),
                sliding,
            )
            for v in (0.1, 0.2, 0.35, 0.5)
        ],
    )
    yield "axis.quadratic_drag", [(_axis("speed squared", lambda m: -m.states["w"] * np.abs(m.states["w"])),)]
    yield (
        "axis.presliding",
        [(_axis(f"dahl {x}", lambda m, x=x: -_presliding(m, x)), sliding) for x in (0.01, 0.03, 0.1)],
    )
    turning = [
        _axis(f"sign {f.__name__} {n}", lambda m, f=f, n=n: -np.sign(m.states["w"]) * f(n * m.states["psi"]))
        for n in (1, 2)
        for f in (np.sin, np.cos)
    ]
    yield "axis.angle_friction", [tuple(turning)]
    yield "axis.load_friction", [(_axis("load", lambda m: -np.abs(m.i) * np.sign(m.states["w"])),)]
    yield (
        "axis.friction_drift",
        [
            (
                _axis(f"cold sign {T}", lambda m, T=T: -np.sign(m.states["w"]) * np.exp(-m.t / T)),
                _axis(f"cold speed {T}", lambda m, T=T: -m.states["w"] * np.exp(-m.t / T)),
            )
            for T in (2.0, 4.0, 8.0)
        ],
    )


def _external(runs: list[Motion]) -> Iterator[tuple[str, list[Form]]]:
    """Torques on the axis that are no friction."""
    psi = np.concatenate([m.states["psi"] for m in runs])
    middle, reach = float(np.mean(psi)), float(np.ptp(psi)) + 1e-9
    one = _axis("one", lambda m: np.ones_like(m.t))
    yield "axis.imbalance", [tuple(_axis(f.__name__, lambda m, f=f: f(m.states["psi"])) for f in (np.sin, np.cos))]
    away = [_axis(f"angle {n}", lambda m, n=n: ((m.states["psi"] - middle) / reach) ** n) for n in (1, 3)]
    yield "axis.spring", [(*away, one)]
    yield "axis.bias_torque", [(one,)]
    high, low = float(np.max(psi)), float(np.min(psi))
    stops = [
        (
            _axis(f"above {s}", lambda m, s=s: -np.maximum(m.states["psi"] - (high - 0.5 * s * reach), 0.0)),
            _axis(f"below {s}", lambda m, s=s: np.maximum(low + 0.5 * s * reach - m.states["psi"], 0.0)),
        )
        for s in (0.02, 0.05, 0.1, 0.2)
    ]
    yield "axis.end_stop", [*((a,) for a, _ in stops), *((b,) for _, b in stops), *stops]
    yield (
        "axis.periodic_torque",
        [
            tuple(_axis(f"{f.__name__} t {x:.3g}", lambda m, f=f, x=x: f(x * m.t)) for f in (np.sin, np.cos))
            for x in 2.0 * np.pi * np.arange(0.2, 1.6, 0.04)
        ],
    )


def _motor(runs: list[Motion]) -> Iterator[tuple[str, list[Form]]]:
    """Wheel, motor and driver."""
    most = max(float(np.max(np.abs(m.i))) for m in runs)

    def heated(m: Motion, T: float) -> np.ndarray:
        return -m.i * T * _lagged(m.i**2, T, m.h)

    yield "wheel.coulomb", [(_wheel("sign", lambda m: -np.sign(m.states["Omega"])),)]
    yield "wheel.drag", [(_wheel("speed squared", lambda m: -m.states["Omega"] * np.abs(m.states["Omega"])),)]
    yield (
        "wheel.cogging",
        [
            tuple(_wheel(f"{f.__name__} {n}", lambda m, f=f, n=n: f(n * m.states["theta"])) for f in (np.sin, np.cos))
            for n in range(4, 13)
        ],
    )
    yield "motor.heating", [(_volts(f"heat {T:g}", lambda m, T=T: heated(m, T)),) for T in (8.0, 20.0, 60.0)]
    yield "motor.saturation", [(_wheel(f"i^{n}", lambda m, n=n: -m.i * np.abs(m.i) ** (n - 1)),) for n in (2, 3)]
    yield (
        "motor.current_limit",
        [
            (_amperes(f"over {s}", lambda m, s=s: np.clip(m.i, -s * most, s * most) - m.i),)
            for s in (0.4, 0.5, 0.6, 0.7, 0.8)
        ],
    )


def _drive(runs: list[Motion]) -> Iterator[tuple[str, list[Form]]]:
    """What stands between the command and the motor."""
    top = max(float(np.max(np.abs(m.V))) for m in runs)
    motored = runs[0].kind != "platform"
    yield (
        "drive.deadzone",
        [(_volts(f"dead {s}", lambda m, s=s: -np.clip(m.V, -s * top, s * top)),) for s in SHARES[:4]],
    )
    yield "drive.delay", [(_volts(f"late {d}", lambda m, d=d: _late(m, d)),) for d in (0.01, 0.03, 0.06, 0.1)]
    yield "drive.lag", [(_volts(f"lag {T}", lambda m, T=T: _lagged(m.V, T, m.h) - m.V),) for T in (0.03, 0.07, 0.15)]
    yield (
        "drive.rate_limit",
        [(_volts(f"rate {T}", lambda m, T=T: _no_faster(m, top / T)),) for T in (0.08, 0.15, 0.3, 0.6)],
    )
    yield (
        "drive.saturation",
        [(_volts(f"over {s}", lambda m, s=s: np.clip(m.V, -s * top, s * top) - m.V),) for s in SHARES[2:]],
    )
    yield "drive.bias", [(_volts("one", lambda m: np.ones_like(m.t)),)]
    yield "drive.asymmetric_gain", [(_volts("size", lambda m: np.abs(m.V)),)]
    power = (lambda m: -m.i) if motored else (lambda m: -m.V * np.abs(m.V))
    yield "drive.supply_sag", [(_volts("sag", power),)]
    yield "drive.curvature", [(_volts(f"power {n}", lambda m, n=n: m.V * np.abs(m.V) ** (n - 1)),) for n in (2, 3)]


def _sensor(kind: str) -> Iterator[tuple[str, list[Form]]]:
    """Errors of the encoder by their first-order sensitivity: what is read too far is also accelerated too much."""
    angle, rate = ("theta", "Omega") if kind == "wheel" else ("psi", "w")

    def wobble(m: Motion, f: Callable[[np.ndarray], np.ndarray]) -> Blocks:
        return {rate: np.gradient(np.gradient(f(m.states[angle]), m.h), m.h)}

    yield "sensor.scale", [(Term("scale", lambda m: m.scaled),)]
    yield (
        "sensor.eccentricity",
        [tuple(Term(f"turn {f.__name__}", lambda m, f=f: wobble(m, f)) for f in (np.sin, np.cos))],
    )


def forms(runs: list[Motion]) -> dict[str, list[Form]]:
    """Forms of every effect that the dictionary knows for a rig.

    Args:
        runs: The runs of the rig.

    Returns:
        By the library's name; `parameter.NAME` has one form, the change with that number.
    """
    kind = runs[0].kind
    found = dict(_drive(runs)) | dict(_sensor(kind))
    if kind != "wheel":
        found = dict(_friction()) | dict(_external(runs)) | found
    if kind != "platform":
        found |= dict(_motor(runs))
    numbers = runs[0].by_number
    return found | {f"parameter.{n}": [(Term(n, lambda m, n=n: m.by_number[n]),)] for n in numbers}
