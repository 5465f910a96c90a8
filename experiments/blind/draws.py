"""Every effect once: the kinds of rig that can show it, what it asks of the rig, how its form and numbers are drawn.

Numbers are drawn in proportion to what the rig does without the effect (`Scene`), so that the effect is excited. A
number that is a plain float is part of the form; `Power` and `Limit` grow with the amplitude.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from experiments.blind.rigs import Rig, Wishes
from experiments.blind.truth import Truth

TURNING = ("platform", "reaction")
MOTORED = ("wheel", "reaction")
ALL = ("wheel", "platform", "reaction")
DRY = ("axis.friction.coulomb",)
STATIC = ("axis.friction.static",)


@dataclass(frozen=True)
class Power:
    """A number that goes with a power of the amplitude."""

    value: float
    exponent: float = 1.0

    def at(self, amplitude: float) -> float:
        return float(self.value * amplitude**self.exponent)


@dataclass(frozen=True)
class Limit:
    """A limit that just holds what happens at amplitude 0, a `share` of it at 1, and nothing in the end."""

    reach: float
    share: float
    middle: float = 0.0

    def at(self, amplitude: float) -> float:
        return float(self.middle + self.reach / (1.0 + amplitude * (1.0 / self.share - 1.0)))


Numbers = dict[str, float | Power | Limit]


@dataclass(frozen=True)
class Scene:
    """What a rig does without the effect, over all its runs."""

    rig: Rig
    torque: float  # N m, RMS of the drive's torque on the axis (wheel: on the wheel)
    speed: float  # rad/s, 95 % quantile of the sensed coordinate
    spin: float  # rad/s, the same of the wheel
    low: float  # rad, of the sensed coordinate
    high: float
    start: float
    ampere: float  # A, 99 % quantile
    energy: float  # J, most heat in the winding in one run
    floor: dict[str, float]  # of each column in SI: noise, quantisation, jitter

    @property
    def truth(self) -> Truth:
        return self.rig.truth

    @property
    def stall(self) -> float:
        """Torque of the largest command at standstill."""
        return self.truth.K * self.rig.top / self.truth.R

    @property
    def dry(self) -> float:
        """Dry friction of the rig, or a plausible one where it has none."""
        return self.truth.coulomb or 0.12 * self.torque


def put(truth: Truth, numbers: Numbers, amplitude: float) -> Truth:
    """Truth with an effect at an amplitude; 0 is without it."""
    if amplitude <= 0.0:
        return truth
    return replace(truth, **{k: v if isinstance(v, float) else v.at(amplitude) for k, v in numbers.items()})


Rng = np.random.Generator


def sign(rng: Rng) -> float:
    return float(rng.choice([-1.0, 1.0]))


def between(rng: Rng, low: float, high: float) -> float:
    return float(rng.uniform(low, high))


def phase(rng: Rng) -> float:
    return between(rng, -np.pi, np.pi)


def one_of(rng: Rng, *values: float) -> float:
    return float(rng.choice(values))


def with_dry(scene: Scene) -> Numbers:
    """Sliding friction as part of the effect, where neither file nor base has any."""
    return {} if scene.truth.coulomb > 0.0 else {"coulomb": Power(scene.dry)}


def viscous(scene: Scene, rng: Rng) -> Numbers:
    return {"viscous": Power(between(rng, 0.2, 0.6) * scene.torque / scene.speed)}


def coulomb(scene: Scene, rng: Rng) -> Numbers:
    return {"coulomb": Power(between(rng, 0.08, 0.3) * scene.torque)}


def stribeck(scene: Scene, rng: Rng) -> Numbers:
    form, exponent = [(0.0, 2.0), (0.0, 1.0), (1.0, 2.0), (0.0, 1.5)][int(rng.integers(4))]
    excess = scene.dry * between(rng, 0.4, 1.2)
    return with_dry(scene) | {
        "excess": Power(excess),
        "v_s": between(rng, 0.1, 0.5),
        "form": form,
        "exponent": exponent,
    }


def quadratic(scene: Scene, rng: Rng) -> Numbers:
    power = one_of(rng, 2.0, 2.0, 1.8)
    return {
        "quadratic": Power(between(rng, 0.2, 0.6) * scene.torque / scene.speed**power),
        "quadratic_power": power,
    }


def asymmetric(scene: Scene, rng: Rng) -> Numbers:
    return {"asymmetry": Power(sign(rng) * scene.dry * between(rng, 0.2, 0.6))}


def presliding(scene: Scene, rng: Rng) -> Numbers:
    form, length = one_of(rng, 1.0, 2.0, 3.0), between(rng, 0.01, 0.08)
    damping = between(rng, 0.1, 0.5) * 2.0 * np.sqrt(scene.dry / length * scene.truth.I)
    found: Numbers = with_dry(scene) | {"preslide_form": form, "preslide": Power(length)}
    return found | ({"preslide_damping": Power(float(damping), -0.5)} if form == 1.0 else {})


def angle_friction(scene: Scene, rng: Rng) -> Numbers:
    return {
        "angle_friction": Power(between(rng, 0.4, 1.0)),
        "angle_form": one_of(rng, 0.0, 0.0, 1.0),
        "angle_order": one_of(rng, 1.0, 2.0),
        "angle_phase": phase(rng),
    }


def load_friction(scene: Scene, rng: Rng) -> Numbers:
    return {"load_friction": Power(between(rng, 0.05, 0.2))}


def drift(scene: Scene, rng: Rng) -> Numbers:
    form, share = one_of(rng, 0.0, 1.0), between(rng, 0.4, 1.2)
    found: Numbers = {"drift": Power(share), "drift_form": form}
    found["drift_time"] = between(rng, 2.0, 8.0) if form == 0.0 else between(rng, 8.0, 16.0)
    return found | ({"drift_viscous": Power(share)} if rng.random() < 0.5 or not scene.truth.coulomb else {})


def imbalance(scene: Scene, rng: Rng) -> Numbers:
    size = between(rng, 0.1, 0.4) * scene.torque
    return {"imbalance": Power(size), "imbalance_phase": phase(rng)}


def spring(scene: Scene, rng: Rng) -> Numbers:
    reach = scene.high - scene.low
    k = between(rng, 0.15, 0.6) * scene.torque / reach
    hardening = between(rng, 1.0, 4.0) if rng.random() < 0.5 else 0.0
    return {
        "spring": Power(k),
        "spring_3": Power(hardening * k / reach**2),
        "spring_zero": scene.start + between(rng, -0.4, 0.4) * (rng.random() < 0.5),
    }


def bias_torque(scene: Scene, rng: Rng) -> Numbers:
    return {"bias_torque": Power(sign(rng) * between(rng, 0.06, 0.25) * scene.torque)}


def contact(scene: Scene, hertz: float, damping: float, share: float) -> tuple[float, float]:
    """Stiffness and damping that give the two halves of the inertia a natural frequency."""
    mass = scene.truth.I * share * (1.0 - share)
    omega = 2.0 * np.pi * hertz
    return float(mass * omega**2), float(2.0 * damping * mass * omega)


def backlash(scene: Scene, rng: Rng) -> Numbers:
    share, form = between(rng, 0.15, 0.5), one_of(rng, 2.0, 3.0)
    found: Numbers = {"coupling": form, "gap": Power(between(rng, 0.04, 0.2)), "drive_share": share}
    if form == 2.0:
        k, c = contact(scene, between(rng, 15.0, 40.0), between(rng, 0.1, 0.5), share)
        found |= {"stiffness": k, "damping": c}
    return found


def flexible(scene: Scene, rng: Rng) -> Numbers:
    share = between(rng, 0.3, 0.7)
    k, c = contact(scene, between(rng, 0.7, 2.5), between(rng, 0.02, 0.15), share)
    return {"coupling": 1.0, "drive_share": share, "stiffness": Power(k, -1.0), "damping": Power(c, -0.5)}


def end_stop(scene: Scene, rng: Rng) -> Numbers:
    sides = int(rng.integers(3))
    far = scene.high - scene.start > scene.start - scene.low  # the side on which the runs get further
    found: Numbers = {"stop_form": one_of(rng, 1.0, 2.0)}
    if sides == 0 or far:
        found["stop_high"] = Limit(scene.high - scene.start, between(rng, 0.4, 0.8), scene.start)
    if sides == 0 or not far:
        found["stop_low"] = Limit(scene.low - scene.start, between(rng, 0.4, 0.8), scene.start)
    if found["stop_form"] == 2.0:
        return found | {"restitution": between(rng, 0.0, 0.6)}
    omega = 2.0 * np.pi * between(rng, 3.0, 12.0)
    found["stop_stiffness"] = float(scene.truth.I * omega**2)
    found["stop_damping"] = float(2.0 * between(rng, 0.05, 0.6) * scene.truth.I * omega)
    return found


def periodic(scene: Scene, rng: Rng) -> Numbers:
    return {
        "periodic": Power(between(rng, 0.1, 0.4) * scene.torque),
        "periodic_rate": 2.0 * np.pi * between(rng, 0.2, 1.5),
        "periodic_phase": phase(rng),
        "periodic_2": between(rng, 0.2, 0.5) if rng.random() < 0.3 else 0.0,
    }


def wheel_coulomb(scene: Scene, rng: Rng) -> Numbers:
    return {
        "wheel_coulomb": Power(between(rng, 0.04, 0.2) * scene.stall),
        "wheel_breakaway": between(rng, 0.0, 0.3),
    }


def wheel_drag(scene: Scene, rng: Rng) -> Numbers:
    return {"wheel_drag": Power(between(rng, 0.05, 0.25) * scene.stall / scene.spin**2)}


def cogging(scene: Scene, rng: Rng) -> Numbers:
    return {
        "cogging": Power(between(rng, 0.03, 0.12) * scene.stall),
        "cogging_order": float(rng.integers(4, 13)),
        "cogging_phase": phase(rng),
        "cogging_2": between(rng, 0.1, 0.5) if rng.random() < 0.4 else 0.0,
    }


def heating(scene: Scene, rng: Rng) -> Numbers:
    return {"heat": Power(between(rng, 0.15, 0.5) / scene.energy), "heat_time": between(rng, 8.0, 60.0)}


def torque_saturation(scene: Scene, rng: Rng) -> Numbers:
    knee = between(rng, 0.7, 1.5) * scene.ampere
    return {"saturation_current": Power(knee, -0.5), "saturation_form": one_of(rng, 0.0, 1.0, 2.0)}


def current_limit(scene: Scene, rng: Rng) -> Numbers:
    foldback = one_of(rng, 0.0, 1.0) * between(rng, 20.0, 60.0) * scene.truth.R
    return {"current_limit": Limit(scene.ampere, between(rng, 0.4, 0.75)), "foldback": foldback}


def dead_zone(scene: Scene, rng: Rng) -> Numbers:
    return {
        "deadzone": Power(between(rng, 0.08, 0.3) * scene.rig.top),
        "deadzone_form": one_of(rng, 0.0, 1.0, 2.0),
    }


def delay(scene: Scene, rng: Rng) -> Numbers:
    return {"delay": Power(between(rng, 0.02, 0.1))}


def lag(scene: Scene, rng: Rng) -> Numbers:
    second = between(rng, 0.3, 0.8) if rng.random() < 0.4 else 0.0
    return {"lag": Power(between(rng, 0.04, 0.2)), "lag_2": second}


def rate_limit(scene: Scene, rng: Rng) -> Numbers:
    return {"rate_limit": Power(scene.rig.top / between(rng, 0.15, 0.6), -1.0)}


def saturation(scene: Scene, rng: Rng) -> Numbers:
    if rng.random() < 0.5:
        return {"saturation": Limit(scene.rig.top, between(rng, 0.45, 0.8))}
    return {"saturation": Power(between(rng, 0.8, 1.4) * scene.rig.top, -0.5), "drive_saturation_form": 1.0}


def bias_command(scene: Scene, rng: Rng) -> Numbers:
    return {"bias_command": Power(sign(rng) * between(rng, 0.03, 0.12) * scene.rig.top)}


def asymmetric_gain(scene: Scene, rng: Rng) -> Numbers:
    return {"gain_asymmetry": Power(sign(rng) * between(rng, 0.04, 0.2))}


def sag(scene: Scene, rng: Rng) -> Numbers:
    form = one_of(rng, 0.0, 1.0)
    if scene.rig.kind == "platform":
        share = between(rng, 0.1, 0.4) / scene.rig.top
        return {"sag": Power(share), "sag_form": form, "sag_time": between(rng, 0.3, 1.5)}
    ohm = between(rng, 0.1, 0.35) * scene.truth.R if form == 0.0 else between(rng, 0.4, 1.2)
    return {"sag": Power(ohm), "sag_form": form}


def curvature(scene: Scene, rng: Rng) -> Numbers:
    return {
        "curvature": Power(sign(rng) * between(rng, 0.1, 0.4)),
        "curvature_form": one_of(rng, 0.0, 1.0, 2.0),
        "curvature_volts": scene.rig.top,
    }


def scale(scene: Scene, rng: Rng) -> Numbers:
    return {"scale": Power(sign(rng) * between(rng, 0.02, 0.1))}


def eccentricity(scene: Scene, rng: Rng) -> Numbers:
    second = between(rng, 0.1, 0.4) if rng.random() < 0.3 else 0.0
    size = Power(between(rng, 0.04, 0.15))
    return {"eccentricity": size, "eccentricity_phase": phase(rng), "eccentricity_2": second}


def sensor_delay(scene: Scene, rng: Rng) -> Numbers:
    return {"sensor_delay": Power(between(rng, 0.02, 0.08))}


def missed(scene: Scene, rng: Rng) -> Numbers:
    above, form = between(rng, 0.4, 0.8) * scene.speed, one_of(rng, 0.0, 1.0)
    size = between(rng, 0.05, 0.3) if form == 0.0 else between(rng, 0.3, 3.0)
    return {"missed": Power(size), "missed_form": form, "missed_above": above}


def clock(scene: Scene, rng: Rng) -> Numbers:
    return {"clock": Power(sign(rng) * between(rng, 0.02, 0.08))}


NOTHING = Wishes()


@dataclass(frozen=True)
class Effect:
    """One effect: kinds of rig, its draw, what it asks of every rig and of most (three in four)."""

    kinds: tuple[str, ...]
    draw: Callable[[Scene, Rng], Numbers]
    always: Wishes = NOTHING
    mostly: Wishes = NOTHING


INERTIAS = ("axis.inertia", "wheel.inertia")
EFFECTS = {
    "axis.viscous": Effect(TURNING, viscous, Wishes(lacks=("axis.friction.viscous",))),
    "axis.coulomb": Effect(TURNING, coulomb, Wishes(lacks=DRY + STATIC)),
    "axis.stribeck": Effect(
        TURNING, stribeck, Wishes(lacks=STATIC, slow=True, logs=("triangle", "multisine")), Wishes(models=DRY)
    ),
    "axis.quadratic_drag": Effect(TURNING, quadratic),
    "axis.asymmetric_friction": Effect(TURNING, asymmetric, Wishes(models=DRY)),
    "axis.presliding": Effect(
        TURNING, presliding, Wishes(lacks=STATIC, slow=True, logs=("triangle", "multisine")), Wishes(models=DRY)
    ),
    "axis.angle_friction": Effect(TURNING, angle_friction, Wishes(models=DRY, slow=True)),
    "axis.load_friction": Effect(TURNING, load_friction),
    "axis.friction_drift": Effect(TURNING, drift, mostly=Wishes(models=DRY)),
    "axis.imbalance": Effect(TURNING, imbalance, Wishes(lacks=("axis.gravity.torque",), slow=True)),
    "axis.spring": Effect(TURNING, spring, Wishes(slow=True)),
    "axis.bias_torque": Effect(TURNING, bias_torque),
    "axis.backlash": Effect(TURNING, backlash, Wishes(slow=True, logs=("multisine", "prbs"))),
    "axis.flexible_coupling": Effect(TURNING, flexible, Wishes(slow=True, logs=("square", "prbs"))),
    "axis.end_stop": Effect(TURNING, end_stop, Wishes(slow=True)),
    "axis.periodic_torque": Effect(TURNING, periodic),
    "wheel.coulomb": Effect(MOTORED, wheel_coulomb),
    "wheel.drag": Effect(MOTORED, wheel_drag),
    "wheel.cogging": Effect(
        MOTORED, cogging, Wishes(logs=("triangle", "multisine", "stair"), columns=("wheel_rad_s",))
    ),
    "motor.heating": Effect(MOTORED, heating),
    "motor.saturation": Effect(MOTORED, torque_saturation),
    "motor.current_limit": Effect(MOTORED, current_limit, Wishes(logs=("square", "prbs"))),
    "drive.deadzone": Effect(ALL, dead_zone, Wishes(logs=("triangle", "multisine"))),
    "drive.delay": Effect(ALL, delay),
    "drive.lag": Effect(ALL, lag, Wishes(logs=("square", "prbs"))),
    "drive.rate_limit": Effect(ALL, rate_limit, Wishes(logs=("square", "prbs"))),
    "drive.saturation": Effect(ALL, saturation),
    "drive.bias": Effect(ALL, bias_command),
    "drive.asymmetric_gain": Effect(ALL, asymmetric_gain),
    "drive.supply_sag": Effect(ALL, sag, Wishes(inductance=True)),
    "drive.curvature": Effect(ALL, curvature),
    "sensor.scale": Effect(ALL, scale, Wishes(fixed=INERTIAS)),
    "sensor.eccentricity": Effect(ALL, eccentricity, Wishes(slow=True, columns=("wheel_counts",))),
    "sensor.delay": Effect(ALL, sensor_delay, Wishes(columns=("current_A",))),
    "sensor.missed_counts": Effect(ALL, missed),
    "sensor.clock": Effect(ALL, clock, Wishes(fixed=INERTIAS)),
}
