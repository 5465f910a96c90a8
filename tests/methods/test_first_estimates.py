"""Numbers of a first rig file by a regression: what is told, what is none, and a datasheet that does not fit."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import Log, Rig, parse_rig, simulate
from rwjax.methods.first_estimates import FirstEstimates, first_estimates, rounded
from rwjax.methods.known import Known
from tests.systems import platform, reaction, record, wheel

T = 0.01 * np.arange(3000)
VOLTS = 8.0 * np.sign(np.sin(0.8 * T)) * (1.0 + 0.3 * T / T[-1]) * (T > 0.6)


def log_of(rig: Rig, name: str, noise: float, command: np.ndarray = VOLTS) -> Log:
    """A log of a rig under slow squares, with noise [SI]."""
    y = np.asarray(simulate(rig, T, command)[name])
    return record(T, command, {name: y + noise * np.random.default_rng(1).standard_normal(len(T))})


def of_a_wheel(faster: float, *, inertia_free: bool = True) -> FirstEstimates:
    """Estimates of a wheel without friction, whose torque constant a datasheet's speed gives too large by a factor [1]."""
    rig = wheel(0.0).with_values({"motor.friction": 0.0})
    log = log_of(rig, "wheel_rad_s", 0.3)
    K = rig.values["motor.torque_constant"] * faster
    numbers = {
        "motor.torque_constant": Known(K, "by a speed"),
        "motor.resistance": Known(rig.values["motor.resistance"], "given"),
        "motor.friction": Known(0.0, "a guess", free=True),
        "wheel.inertia": Known(1e-4 if inertia_free else rig.values["wheel.inertia"], "a guess", free=inertia_free),
    }
    free = tuple(name for name in numbers if numbers[name].free)
    start = replace(rig, free=free).with_values({name: known.value for name, known in numbers.items()})
    return first_estimates(start, [log], numbers, by_no_load_speed=True)


@pytest.mark.parametrize("inertia_free", [True, False])
def test_friction_that_would_be_negative_is_none_and_the_torque_constant_is_free_instead(inertia_free: bool) -> None:
    found = of_a_wheel(1.05, inertia_free=inertia_free)
    K = wheel().values["motor.torque_constant"]
    assert not found.numbers["motor.friction"].free and found.numbers["motor.friction"].value == 0.0
    assert found.numbers["motor.torque_constant"].free
    assert found.numbers["motor.torque_constant"].value == pytest.approx(K, rel=0.02)
    none, speed = found.notes
    assert none.startswith("motor.friction is 0 and fixed: ") and "1.05 times as fast per volt" in speed


@pytest.mark.parametrize(("factor", "said"), [(1.0, False), (3.0, True), (1.0 / 60.0, True)])
def test_a_speed_that_is_far_off_is_said(factor: float, said: bool) -> None:
    """A sixtieth is the speed of a motor before its gear."""
    notes = [note for note in of_a_wheel(factor).notes if "--no-load-speed" in note and "per volt" in note]
    assert bool(notes) == said


def test_friction_above_its_error_is_estimated_and_free() -> None:
    rig = platform("viscous = 0.05", '"axis.inertia", "axis.friction.viscous"')
    numbers = {name: Known(rig.values[name], "a guess", free=True) for name in rig.free}
    found = first_estimates(rig, [log_of(rig, "yaw_rad", 1e-4)], numbers)
    assert found.notes == () and all(known.free and "regression" in known.why for known in found.numbers.values())
    assert found.numbers["axis.friction.viscous"].value == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize(
    ("known", "said"),
    [
        (Known(0.03, "a guess", free=True), ()),
        (Known(0.12, "of a bob, m l²", free=True, by_mass=True), ()),
        (
            Known(0.03, "of a rod, m l²/3", free=True, by_mass=True),
            (
                "axis.inertia: a regression has 0.1 kg m2 where the mass and the length give 0.03 kg m2 (of a rod, m l²/3)",
            ),
        ),
    ],
)
def test_an_estimate_far_from_what_a_mass_and_a_length_give_is_said(known: Known, said: tuple[str, ...]) -> None:
    rig = platform("viscous = 0.05", '"axis.inertia", "axis.friction.viscous"')
    numbers = {"axis.inertia": known, "axis.friction.viscous": Known(0.05, "a guess", free=True)}
    found = first_estimates(rig, [log_of(rig, "yaw_rad", 1e-4)], numbers)
    assert found.notes == said and found.numbers["axis.inertia"].value == pytest.approx(0.1, rel=0.02)


def test_a_weight_that_stands_up_at_angle_0_is_a_positive_one_with_that_angle() -> None:
    text = 'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.05\n'
    rig = parse_rig(
        f'{text}[axis.gravity]\ntorque = 0.3\nangle = 0.0\n[fit]\nfree = ["axis.inertia", "axis.gravity.torque"]'
    )
    up = rig.with_values({"axis.gravity.torque": -0.3})
    weight = Known(0.3, "of a bob, m g l; of a rod half of that", free=True, by_mass=True)
    numbers = {"axis.inertia": Known(0.2, "a guess", free=True), "axis.gravity.torque": weight}
    numbers |= {"axis.gravity.angle": Known(0.0, "0 where the bob hangs down at angle 0")}
    found = first_estimates(rig, [log_of(up, "yaw_rad", 1e-4)], numbers)
    (note,) = found.notes
    assert note.startswith("axis.gravity.torque: by a regression the link stands up at angle 0; if it hangs down there")
    values = {name: known.value for name, known in found.numbers.items()}
    assert values == pytest.approx(
        {"axis.inertia": 0.1, "axis.gravity.torque": 0.3, "axis.gravity.angle": np.pi}, rel=0.02
    )
    told = simulate(rig.with_values(values), T, VOLTS)["yaw_rad"]
    assert np.sqrt(np.mean((told - simulate(up, T, VOLTS)["yaw_rad"]) ** 2)) < 0.1


def test_an_inertia_that_would_be_negative_keeps_its_guess() -> None:
    """The command has the wrong sign."""
    rig = platform("viscous = 0.05")
    log = log_of(rig, "yaw_rad", 1e-4)
    found = first_estimates(
        rig, [replace(log, command=-log.command)], {"axis.inertia": Known(0.2, "a guess", free=True)}
    )
    assert found.numbers["axis.inertia"].value == 0.2
    assert found.notes == ("axis.inertia stays 0.2 kg m2, a guess: a regression does not tell it",)


def test_friction_of_which_a_regression_says_nothing_keeps_its_guess_and_stays_free() -> None:
    """The drive's gain is far off, and its size drowns all friction."""
    rig = platform("viscous = 0.05", '"axis.inertia", "axis.friction.viscous"')
    numbers = {"axis.inertia": Known(0.1, "a guess", free=True)}
    numbers |= {"axis.friction.viscous": Known(0.01, "a guess", free=True)}
    log = log_of(rig, "yaw_rad", 1e-4)
    drowned = replace(log, command=1e7 * np.random.default_rng(0).standard_normal(len(T)))
    found = first_estimates(rig.with_values({"axis.friction.viscous": 0.01}), [drowned], numbers)
    known = found.numbers["axis.friction.viscous"]
    assert known.free and known.value == 0.01
    assert any("axis.friction.viscous stays 0.01" in note and "does not tell it" in note for note in found.notes)


def test_friction_below_its_error_is_none() -> None:
    rig = platform("viscous = -0.0001", '"axis.inertia", "axis.friction.viscous"')
    numbers = {"axis.inertia": Known(0.2, "a guess", free=True)}
    numbers |= {"axis.friction.viscous": Known(0.01, "a guess", free=True)}
    started = rig.with_values({name: known.value for name, known in numbers.items()})
    found = first_estimates(started, [log_of(rig, "yaw_rad", 1e-4)], numbers)
    b = found.numbers["axis.friction.viscous"]
    assert (b.value, b.free) == (0.0, False) and "add it to free" in b.why and len(found.notes) == 1
    assert found.numbers["axis.inertia"].value == pytest.approx(0.1, rel=0.05)


def test_of_two_frictions_that_stand_for_each_other_one_stays() -> None:
    rig = reaction()
    free = ("motor.friction", "axis.inertia", "axis.friction.viscous")
    numbers = {name: Known(rig.values[name], "a guess", free=True) for name in free}
    found = first_estimates(replace(rig, free=free), [log_of(rig, "yaw_rad", 3e-3)], numbers).numbers
    assert sum(found[name].free for name in free) == 2 and found["axis.inertia"].free
    assert found["axis.inertia"].value == pytest.approx(rig.values["axis.inertia"], rel=0.05)


def test_friction_that_nothing_else_stands_beside_stays_free() -> None:
    rig = platform("viscous = -0.0001", '"axis.friction.viscous"')
    numbers = {"axis.friction.viscous": Known(0.01, "a guess", free=True)}
    started = rig.with_values({"axis.friction.viscous": 0.01})
    found = first_estimates(started, [log_of(rig, "yaw_rad", 1e-4)], numbers)
    assert found.numbers["axis.friction.viscous"].free and "does not tell it" in found.notes[0]


def test_a_number_has_three_digits() -> None:
    assert rounded(0.123456) == 0.123 and rounded(-98765.0) == -98800.0
