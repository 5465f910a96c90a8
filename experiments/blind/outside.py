"""Causes outside the library's list of effects, for the verdict `unknown`; drawn like the effects."""

from experiments.blind.draws import (
    ALL,
    DRY,
    STATIC,
    TURNING,
    Effect,
    Numbers,
    Power,
    Rng,
    Scene,
    between,
    phase,
    sign,
)
from experiments.blind.rigs import Wishes


def dwell_stiction(scene: Scene, rng: Rng) -> Numbers:
    return {"dwell": Power(between(rng, 0.5, 1.0) * scene.torque), "dwell_time": between(rng, 0.2, 0.8)}


def moving_inertia(scene: Scene, rng: Rng) -> Numbers:
    speed = between(rng, 0.4, 0.8) * scene.speed
    return {"moving_inertia": Power(between(rng, 0.5, 1.5)), "moving_speed": speed}


def gain_hysteresis(scene: Scene, rng: Rng) -> Numbers:
    width = between(rng, 0.2, 0.4) * scene.rig.top
    return {"hysteresis": Power(between(rng, 0.4, 0.9)), "hysteresis_volts": width}


def hysteretic_deadzone(scene: Scene, rng: Rng) -> Numbers:
    on = between(rng, 0.3, 0.55) * scene.rig.top
    return {"gate_on": Power(on), "gate_off": Power(between(rng, 0.1, 0.3) * on)}


def torque_bursts(scene: Scene, rng: Rng) -> Numbers:
    torque = scene.torque if scene.rig.kind != "wheel" else scene.stall
    return {"bursts": Power(between(rng, 0.5, 1.5) * torque)}


def intermittent_contact(scene: Scene, rng: Rng) -> Numbers:
    loss = between(rng, 0.3, 0.8)
    return {"loose": Power(loss)}


def friction_memory(scene: Scene, rng: Rng) -> Numbers:
    strength = between(rng, 1.5, 4.0) if scene.rig.kind != "wheel" else between(rng, 10.0, 30.0)
    speed = between(rng, 0.2, 0.6) * scene.speed
    return {"memory": Power(strength), "memory_time": between(rng, 0.5, 2.0), "memory_speed": speed}


def angle_gain(scene: Scene, rng: Rng) -> Numbers:
    return {"angle_gain": Power(between(rng, 0.15, 0.5)), "angle_gain_phase": phase(rng)}


def stick_noise(scene: Scene, rng: Rng) -> Numbers:
    return {"roughness": Power(between(rng, 1.0, 3.0))}


def angle_jump(scene: Scene, rng: Rng) -> Numbers:
    return {"jump": Power(sign(rng) * between(rng, 0.1, 0.4)), "jump_time": between(rng, 2.0, 6.0)}


RESTS = Wishes(slow=True, lacks=STATIC, models=DRY, logs=("triangle",))
OUTSIDE = {
    "outside.dwell_stiction": Effect(TURNING, dwell_stiction, RESTS),
    "outside.moving_inertia": Effect(ALL, moving_inertia),
    "outside.gain_hysteresis": Effect(ALL, gain_hysteresis, Wishes(logs=("triangle", "multisine"))),
    "outside.hysteretic_deadzone": Effect(ALL, hysteretic_deadzone, Wishes(logs=("triangle", "multisine"))),
    "outside.torque_bursts": Effect(ALL, torque_bursts),
    "outside.intermittent_contact": Effect(ALL, intermittent_contact),
    "outside.friction_memory": Effect(ALL, friction_memory, Wishes(models=DRY)),
    "outside.angle_gain": Effect(TURNING, angle_gain, Wishes(slow=True)),
    "outside.stick_noise": Effect(TURNING, stick_noise, Wishes(models=DRY, slow=True)),
    "outside.angle_jump": Effect(ALL, angle_jump, Wishes(columns=("wheel_counts",))),
}
