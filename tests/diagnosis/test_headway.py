"""Headway: what is counted, and how long it is said to take."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rwjax.diagnosis.budget import Budget
from rwjax.diagnosis.headway import Headway
from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.search.successive_halving import SuccessiveHalving
from tests.diagnosis.simulated import fits_of, true_log
from tests.diagnosis.test_budget import Clock
from tests.systems import platform

SOME = [Hypothesis((name,)) for name in ("axis.coulomb", "drive.bias", "drive.lag", "sensor.delay")]


def seconds(line: str) -> int:
    found = re.search(r"about (\d+) s left(?: \(at most \d+ s\))?$", line)
    assert found, line
    return int(found[1])


def test_at_an_even_pace_the_time_left_is_what_is_left() -> None:
    clock, told = Clock(), list[str]()
    headway = Headway(Budget(clock=clock), told.append, clock)
    headway.enter(SOME, "candidates", besides=2.0, further=4.0)
    for k, hypothesis in enumerate(SOME):
        clock.now += 3.0
        headway.compare(hypothesis)
        headway.advance(1.0)
        assert told[-1] == f"{k + 1} of 4 candidates, about {3 * (10 - k - 1)} s left"
    headway.enter(SOME, "rivals", besides=4.0, further=0.0)  # all of them compared: the rest is what is besides
    clock.now += 3.0
    headway.advance(1.0)
    assert told[-1] == "4 of 4 rivals, about 9 s left"  # 12 + 3 s for 5 pieces of work


def test_the_start_of_the_first_pass_says_nothing_of_the_time() -> None:
    clock, told = Clock(), list[str]()
    headway = Headway(Budget(clock=clock), told.append, clock)
    headway.enter(SOME, "candidates", besides=36.0, further=0.0)
    clock.now += 3.0
    headway.advance(3.0)
    assert told[-1] == "0 of 4 candidates" and headway.left is None
    headway.advance(1.0)
    assert told[-1] == "0 of 4 candidates, about 27 s left"  # 36 pieces of work at 0.75 s


def test_before_a_pass_nothing_is_told() -> None:
    told: list[str] = []
    headway = Headway(tell=told.append)
    headway.advance(1.0)
    assert told == [] and headway.left is None
    headway.say("the rig as it is")
    assert told == ["the rig as it is"]


@given(steps=st.lists(st.tuples(st.floats(0.0, 30.0), st.floats(0.0, 2.0)), min_size=1, max_size=30))
def test_within_a_pass_the_time_left_falls_and_stays_within_the_budget(steps: list[tuple[float, float]]) -> None:
    clock, told = Clock(), list[str]()
    budget = Budget(60.0, clock)
    headway = Headway(budget, told.append, clock)
    headway.enter(SOME, "candidates", besides=1.0, further=5.0)
    last = np.inf
    for wait, work in steps:
        clock.now += wait
        headway.advance(work)
        if " s left" not in told[-1]:
            continue  # no work is done yet
        left = seconds(told[-1])
        assert 1 <= left <= max(budget.left + 0.5, 1.0) and left <= last
        last = left


@pytest.mark.slow
def test_what_leaves_least_is_told_by_its_error() -> None:
    rig, told = platform("viscous = 0.02"), list[str]()
    fits = fits_of(rig, true_log(rig, noise=2e-3, **{"axis.bias_torque": {"T": 0.03}}))
    fits(Hypothesis())
    fits.headway = Headway(tell=told.append)
    fits.headway.signal = "yaw_rad"
    right, wrong = Hypothesis(("axis.bias_torque",)), Hypothesis(("sensor.scale",))
    fits.headway.enter([right, wrong], "candidates", besides=0.0, further=0.0)
    SuccessiveHalving(fits).fit([wrong, right], Hypothesis())
    assert told[0].startswith("0 of 2 candidates")
    found = re.match(
        r"2 of 2 candidates, best so far constant torque \((.*) rad left of the fitted runs\), about", told[-1]
    )
    assert found and 0.5 * 2e-3 < float(found[1]) < 3.0 * 2e-3  # the noise, and what a few steps leave
    assert fits.headway.compared == {right, wrong}
    assert fits.headway.best == f"constant torque ({found[1]} rad left of the fitted runs)"


def test_a_pass_that_was_not_foreseen_is_said_and_what_the_budget_leaves_never_rises() -> None:
    clock, told = Clock(), list[str]()
    headway = Headway(Budget(60.0, clock), told.append, clock)
    headway.enter(SOME, "candidates", besides=0.0, further=0.0)
    for hypothesis in SOME:
        clock.now += 2.0
        headway.compare(hypothesis)
        headway.advance(1.0)
    headway.enter(SOME, "pairs", besides=10.0, further=0.0)
    clock.now += 2.0
    headway.advance(1.0)
    assert told[0] == "1 of 4 candidates, about 6 s left (at most 58 s)"
    assert told[-1] == "4 of 4 pairs, the search goes on, about 18 s left (at most 50 s)"
    most = [int(found[1]) for line in told if (found := re.search(r"at most (\d+) s", line))]
    assert len(most) == len(told) and most == sorted(most, reverse=True)


def test_what_is_told_as_left_is_never_above_what_the_budget_leaves() -> None:
    """The clock goes on while the line is written."""

    class Running(Clock):
        def __call__(self) -> float:
            self.now += 0.3
            return self.now

    told = list[str]()
    headway = Headway(Budget(60.0, Running()), told.append, clock := Running())
    headway.enter(SOME, "candidates", besides=0.0, further=1e4)
    clock.now += 10.0
    for _ in range(30):
        headway.advance(0.4)
    both = [re.findall(r"(\d+) s", line) for line in told]
    assert all(int(about) <= int(most) for about, most in both)


def test_a_pass_that_takes_less_than_an_unforeseen_one_before_it_goes_on_as_well() -> None:
    clock, told = Clock(), list[str]()
    headway = Headway(Budget(600.0, clock), told.append, clock)
    for what, many in (("candidates", 1.0), ("pairs", 10.0), ("more", 5.0)):
        headway.enter(SOME, what, besides=many, further=0.0)
        clock.now += 10.0
        headway.advance(1.0)
    assert ["the search goes on" in line for line in told] == [False, True, True]


def test_what_is_done_besides_a_pass_is_said_without_a_time_until_it_ends() -> None:
    clock, told = Clock(), list[str]()
    headway = Headway(Budget(60.0, clock), told.append, clock)
    headway.enter(SOME, "candidates", besides=6.0, further=0.0)
    clock.now += 10.0
    headway.advance(5.0)
    headway.doing("those ahead from all of their places")
    headway.advance(0.0)
    assert told[-1] == "0 of 4 candidates, those ahead from all of their places, at most 50 s left"
    headway.doing("")
    headway.advance(0.0)
    assert told[-1] == "0 of 4 candidates, about 10 s left (at most 50 s)"
    headway.doing("those ahead from all of their places")
    headway.enter(SOME, "rivals", besides=1.0, further=0.0)  # a pass begins with nothing besides
    headway.advance(0.0)
    assert told[-1].startswith("0 of 4 rivals, about ")
