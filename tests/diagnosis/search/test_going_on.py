"""Going on: what a search that goes on begins from."""

import pytest

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.left_out import LeftOut
from tests.diagnosis.several_runs import run_of, searched

DRY, BIAS = Hypothesis(("axis.coulomb",)), Hypothesis(("axis.bias_torque",))
BOTH = {"axis.coulomb": {"M_c": 0.06}, "axis.bias_torque": {"T": 0.02}}


def test_a_second_name_is_found_beside_the_first() -> None:
    search = searched([run_of(k, BOTH) for k in range(3)], DRY, BIAS)
    assert search.go_on(DRY).best == DRY.plus(*BIAS.names)


def test_it_begins_from_what_follows_left_out_runs_where_the_choice_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = {"axis.coulomb": {"M_c": 0.03}, "axis.bias_torque": {"T": 0.03}}  # of which the bias removes more
    search, begun = searched([run_of(k, truth) for k in range(2)], DRY, BIAS), []
    left = {DRY: 1000.0, BIAS: 50.0}
    monkeypatch.setattr(LeftOut, "excess", lambda _, e: left.get(e, 1000.0))
    monkeypatch.setattr(search, "forward", lambda hypothesis, most: begun.append(hypothesis) or hypothesis)
    search.go_on(DRY)
    left[BIAS] = 3000.0
    search.go_on(DRY)
    assert begun == [BIAS, DRY]


def test_it_begins_from_a_larger_set_that_was_tried_among_the_rivals(monkeypatch: pytest.MonkeyPatch) -> None:
    pair, begun = DRY.plus(*BIAS.names), []
    search = searched([run_of(k, BOTH) for k in range(2)], DRY, pair)
    monkeypatch.setattr(search, "forward", lambda hypothesis, most: begun.append(hypothesis) or hypothesis)
    assert search.go_on(DRY).best == pair
    assert begun == [pair]
