"""Estimates that ran away: far off and unsure, and only those."""

from dataclasses import replace

import numpy as np
import pytest

from rwjax import parse_rig, write_rig
from rwjax.fitting.fit import fit
from rwjax.fitting.ran_away import negative_friction, ran_away, runaway_words, without_runaways
from rwjax.rig.model import Rig
from tests.diagnosis.simulated import COMMAND, TIME
from tests.systems import platform, record, run, wheel

RIG = platform("viscous = 0.02\ncoulomb = 0.0", '"axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"')


def fitted(name: str, value: float, error: float) -> Rig:
    errors = {name: error} if np.isfinite(error) else {}
    return replace(RIG.with_values({name: value}), standard_error=errors)


@pytest.mark.parametrize(
    ("name", "value", "error", "away"),
    [
        ("axis.friction.viscous", 1.5e8, 5e15, True),
        ("axis.friction.viscous", 1.5e8, np.inf, True),
        ("axis.friction.viscous", -1.5e8, 5e15, True),
        ("axis.friction.coulomb", 1e4, 1e5, True),
        ("axis.friction.viscous", np.inf, np.inf, True),
        ("axis.inertia", 3.5e17, 3.2e15, True),
        ("axis.inertia", 150.0, 1.0, False),
        ("axis.inertia", 90.0, 1e9, False),
        ("axis.friction.coulomb", 0.0, np.inf, False),
    ],
)
def test_far_and_unsure_is_away(name: str, value: float, error: float, away: bool) -> None:
    found = fitted(name, value, error)
    assert ran_away(RIG, found) == ((name,) if away else ())
    assert len(runaway_words(RIG, found)) == away


@pytest.mark.parametrize(("weight", "asked"), [("", True), ("\n[axis.gravity]\ntorque = 0.1", False)])
def test_a_weight_is_asked_for_where_the_rig_file_has_none(weight: str, asked: bool) -> None:
    rig = parse_rig(
        f'kind = "platform"\n[drive]\ngain = 0.4\n[axis]\ninertia = 0.1\n[axis.friction]\nviscous = 0.02{weight}\n[fit]\nfree = ["axis.inertia"]'
    )
    (said,) = runaway_words(rig, rig.with_values({"axis.inertia": 8e6}))
    assert ("`[axis.gravity]`" in said) == asked


def test_a_rig_without_them_has_the_numbers_of_its_file() -> None:
    found = fitted("axis.friction.viscous", 1.5e8, 5e15)
    assert without_runaways(RIG, found).numbers == RIG.numbers
    assert without_runaways(RIG, found).standard_error == {}
    sure = fitted("axis.inertia", 0.2, 0.01)
    assert without_runaways(RIG, sure) == sure


def test_numbers_that_make_no_rig_together_ran_away_together() -> None:
    found = replace(fitted("axis.inertia", 1e-9, 1e-12), standard_error={"axis.inertia": 1e-12})  # b/I of 2e7 1/s
    assert ran_away(RIG, found) == RIG.free
    assert parse_rig(write_rig(without_runaways(RIG, found))).numbers == RIG.numbers


def test_a_number_of_an_added_effect_stays_in_the_range_of_a_rig_file() -> None:
    found = replace(RIG, effects={"axis.spring": {"k": 1e40, "T_0": 0.0}})
    assert parse_rig(write_rig(without_runaways(RIG, found))).effects["axis.spring"]["k"] == 1e12


@pytest.mark.slow
def test_the_numbers_of_a_wheel_that_is_held_run_away_and_those_of_one_that_turns_do_not() -> None:
    rig, noise = wheel(), np.random.default_rng(2).normal(0.0, 1e-3, len(TIME))
    held = fit(rig, [record(TIME, COMMAND, {"wheel_rad_s": noise})])
    assert ran_away(rig, held.rig) == ("wheel.inertia", "motor.friction")
    asked = record(TIME, COMMAND, {"wheel_rad_s": TIME})
    turns = fit(rig, [record(TIME, COMMAND, run(rig, asked, {}))])
    assert ran_away(rig, turns.rig) == ()


def test_a_viscous_friction_that_came_out_negative_is_noted() -> None:
    values = {"axis.friction.viscous": -0.01, "axis.inertia": 0.1, "motor.friction": 0.0}
    (said,) = negative_friction(values, values)
    assert said.startswith(
        "viscous friction came out negative: axis.friction.viscous = -0.01 drives the motion on; likely "
    )
    assert negative_friction(["axis.friction.viscous"], {"axis.friction.viscous": 0.01}) == []
    true = platform("viscous = -0.02", '"axis.inertia", "axis.friction.viscous"')
    free = replace(true, bounds={"axis.friction.viscous": (-1.0, 1.0)})
    measured = run(true, record(TIME, COMMAND, {"yaw_rad": TIME}), {})["yaw_rad"]
    found = fit(free, [record(TIME, COMMAND, {"yaw_rad": measured})])
    assert found.rig.numbers["axis.friction.viscous"] < 0.0
    assert sum("viscous friction came out negative" in note for note in found.notes) == 1
