"""Hypotheses as keys, what may be named on a rig, and which numbers a hypothesis frees."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.hypothesis import (
    Hypothesis,
    as_written,
    candidates,
    chosen_names,
    coordinate_of,
    free_names,
    shown_by,
    simplest,
    space,
    spoken,
    structure_for,
)
from rwjax.rig.model import Driven
from tests.diagnosis.simulated import COMMAND, TIME
from tests.joints import joint, servo
from tests.systems import platform, reaction, record, wheel


def test_equal_sets_free_the_same_numbers_and_are_one_key() -> None:
    one, other = Hypothesis(("axis.stribeck", "axis.bias_torque")), Hypothesis(("axis.bias_torque", "axis.stribeck"))
    assert one == other and {one: 1}[other] == 1
    assert one != Hypothesis(("axis.stribeck",))


def test_candidates_fit_the_kind_and_leave_out_what_is_modelled() -> None:
    assert not any(name.startswith("axis.") for name in candidates(wheel()))
    assert not any(name.startswith("wheel.") for name in candidates(platform()))
    assert "axis.coulomb" not in candidates(platform())
    assert "axis.coulomb" in candidates(platform("viscous = 0.02"))
    assert "parameter.axis.inertia" not in candidates(platform())  # it is free
    assert "parameter.drive.gain" in candidates(platform())


def test_a_number_that_follows_from_others_is_not_wrong_by_itself() -> None:
    tied = replace(platform(), tied={"axis.friction.viscous": "axis.inertia / 5"})
    every = {*candidates(platform())} - {*candidates(tied)}
    assert every == {"parameter.axis.friction.viscous"}


def test_a_fixed_number_of_an_effect_that_the_rig_file_holds_may_be_wrong() -> None:
    held = {"axis.stribeck": {"M_c": 0.05, "M_e": 0.01, "v_s": 0.2, "n": 2.0}, "sensor.delay": {"tau": 0.0}}
    rig = replace(platform("viscous = 0.02"), effects=held, free=("axis.inertia", "axis.stribeck.v_s"))
    wrong = {name for name in candidates(rig) if name.startswith(("parameter.axis.stribeck", "parameter.sensor"))}
    assert wrong == {"parameter.axis.stribeck.M_c", "parameter.axis.stribeck.M_e"}  # others are free, of the form, or 0
    stops = replace(rig, effects={"axis.end_stop": {"low": -1.0, "high": 1e6}, "sensor.offset": {"w_b": 0.1}})
    own = [name for name in candidates(stops) if name.startswith(("parameter.axis.end_stop", "parameter.sensor"))]
    assert own == ["parameter.axis.end_stop.low", "parameter.sensor.offset.w_b"]  # 1e6 is no stop
    assert "parameter.sensor.offset.w_b" not in shown_by(own, {"yaw_rad"})
    assert coordinate_of("parameter.axis.stribeck.M_c") == coordinate_of("axis.stribeck")
    assert "axis.stribeck.M_c" in free_names(rig, Hypothesis(("parameter.axis.stribeck.M_c",)), ("yaw_rad",))


def test_a_coulomb_level_belongs_to_an_effect_only_where_nothing_else_models_it() -> None:
    stribeck = Hypothesis(("axis.stribeck",))
    assert "axis.stribeck.M_c" in free_names(reaction(), stribeck, ())
    assert "axis.stribeck.M_c" not in free_names(platform(), stribeck, ())
    both = free_names(reaction(), Hypothesis(("axis.stribeck", "axis.asymmetric_friction")), ())
    assert sum(name.endswith(".M_c") for name in both) == 1


def test_an_offset_is_looked_for_only_where_a_log_holds_its_output() -> None:
    offset, rig = Hypothesis(("sensor.offset",)), reaction()
    assert free_names(rig, offset, {"yaw_rad", "current_A"})[len(rig.free) :] == ("sensor.offset.i_b",)
    every = candidates(rig)
    assert "sensor.offset" in every and {*every} - {*shown_by(every, {"yaw_rad", "wheel_rad"})} == {"sensor.offset"}
    assert shown_by(every, {"wheel_rad_s"}) == every
    pitch = Hypothesis(("sensor_2.offset",))
    assert free_names(rig, pitch, {"yaw_rad_s", "pitch_rad_s"})[len(rig.free) :] == ("sensor_2.offset.w_b",)
    log = record(TIME, COMMAND, {"yaw_rad": np.sin(TIME), "current_A": np.cos(TIME)})
    coordinates, starts = space(rig, offset, [log], wrong_by=2.0)
    names = structure_for(rig, offset).names
    assert names.index("sensor.offset.i_b") in coordinates.index
    assert len(starts) == 1 and starts[0][names.index("sensor.offset.i_b")] > 0.0  # none without any offset


def test_of_a_choice_a_fit_tries_the_starts_alone() -> None:
    one_sided, log = Hypothesis(("drive.one_sided",)), record(TIME, COMMAND, {"yaw_rad": np.sin(TIME)})
    rig = platform()
    assert free_names(rig, one_sided, {"yaw_rad"}) == rig.free
    assert chosen_names(one_sided) == ("drive.one_sided.s",)
    _, starts = space(rig, one_sided, [log], wrong_by=2.0)
    assert [start[structure_for(rig, one_sided).names.index("drive.one_sided.s")] for start in starts] == [1.0, -1.0]
    square = Hypothesis(("drive.square_law",))
    assert free_names(rig, square, {"yaw_rad"}) == (*rig.free, "drive.square_law.u_1")
    assert Hypothesis(("drive.curvature",)).contains(square) and not square.contains(Hypothesis(("drive.curvature",)))


def test_the_delay_of_a_goal_needs_a_servo() -> None:
    assert "drive.goal_delay" not in candidates(joint())
    assert "drive.goal_delay" not in candidates(servo(joint()))  # driven by voltages
    assert "drive.goal_delay" in candidates(replace(servo(joint()), driven=Driven(by="goal_rad")))


def test_a_logged_supply_does_not_sag_unseen() -> None:
    sagging = "drive.supply_sag"
    assert sagging in candidates(joint())
    assert sagging not in candidates(replace(joint(), driven=Driven("voltage_V", supplied=True)))


def test_what_ticks_is_no_wrong_number() -> None:
    closed = replace(servo(joint(), kd=0.1, phase=0.002), driven=Driven("goal_rad"))
    found = {name for name in candidates(closed) if name.startswith("parameter.drive.servo.")}
    assert found == {"parameter.drive.servo.kp", "parameter.drive.servo.kd"}


def test_containment() -> None:
    coulomb, stribeck = Hypothesis(("axis.coulomb",)), Hypothesis(("axis.stribeck",))
    assert stribeck.contains(coulomb) and not coulomb.contains(stribeck) and not coulomb.contains(coulomb)
    load, imbalance = (
        Hypothesis((name, "axis.spring")) for name in ("parameter.axis.gravity.torque", "axis.imbalance")
    )
    assert imbalance.contains(load) and not load.contains(imbalance)


def test_names_are_effects_or_numbers() -> None:
    both = Hypothesis(("axis.coulomb",)).plus("parameter.drive.gain", "axis.coulomb")
    assert both.names == ("axis.coulomb", "parameter.drive.gain")
    assert both.effects == ("axis.coulomb",) and both.numbers == ("drive.gain",)
    assert both.without("axis.coulomb").names == ("parameter.drive.gain",)
    assert coordinate_of("parameter.drive.gain") == "voltage" and coordinate_of("axis.coulomb") == "yaw_rate"


def test_a_wrong_number_is_looked_for_within_a_factor() -> None:
    rig, wrong = wheel(), Hypothesis(("parameter.motor.resistance",))
    readings = {name: np.sin(TIME) for name in ("wheel_rad_s", "current_A")}
    coordinates, starts = space(rig, wrong, [record(TIME, COMMAND, readings)], wrong_by=2.0)
    k = structure_for(rig, wrong).names.index("motor.resistance")
    assert coordinates.bounds[list(coordinates.index).index(k)] == pytest.approx([0.5 * 0.83, 2.0 * 0.83])
    assert all(start[k] == 0.83 for start in starts)


def test_of_a_periodic_torque_a_whole_turn_fits_into_the_longest_run() -> None:
    rig, periodic = platform(), Hypothesis(("axis.periodic_torque",))
    k = structure_for(rig, periodic).names.index("axis.periodic_torque.omega")
    for seconds in (5.0, 20.0):
        t = np.linspace(0.0, seconds, 200)
        logs = [record(part, np.sin(part), {"yaw_rad": np.sin(part)}) for part in (t[:50], t)]
        coordinates, starts = space(rig, periodic, logs, wrong_by=2.0)
        turn = 2.0 * np.pi / seconds
        assert coordinates.bounds[list(coordinates.index).index(k)] == pytest.approx([turn, 200.0])
        assert min(start[k] for start in starts) == pytest.approx(max(turn, 0.6))


def test_names_in_words() -> None:
    assert [as_written(name) for name in ("axis.coulomb", "parameter.axis.inertia")] == [
        "axis.coulomb",
        "parameter.axis.inertia",
    ]
    assert as_written("axis.growing_inertia") == "an inertia that grows with the speed"
    assert spoken("parameter.axis.inertia") == "wrong axis.inertia" and spoken("axis.coulomb") == "dry friction"


def test_the_simplest_are_no_special_case_s_and_of_two_that_are_each_other_s_both() -> None:
    one, other = (
        Hypothesis(("axis.spring", "axis.coulomb")),
        Hypothesis(("axis.spring", "axis.bias_torque", "axis.coulomb")),
    )
    assert one.contains(other) and other.contains(one)
    assert simplest([one, other, Hypothesis(("axis.spring", "axis.stribeck"))]) == [one, other]
