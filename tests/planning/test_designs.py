"""Designs of runs: the experiment of an amplitude, and what the recommended ones are made of."""

import pytest

from rwjax.effects.shown import RUNS
from rwjax.planning.designs import BACK, DESIGNS, LONGEST_S, Design
from rwjax.planning.experiment import REST_S, SHAPES
from rwjax.planning.files import ROLES
from rwjax.planning.motion import TAIL_S


def test_an_experiment_has_its_amplitude_pace_and_direction() -> None:
    design = Design("square", 0.6, 6.0, 12.0, "", offset=0.15, direction=-1.0)
    found = design.at(2.0, pace=0.5)
    assert (found.kind, found.amplitude, found.offset) == ("square", -2.0, pytest.approx(0.3))
    assert (found.period, found.length) == (3.0, 6.0)
    turned = design.at(2.0, sign=-1.0)
    assert (turned.amplitude, turned.offset, turned.period) == (2.0, pytest.approx(-0.3), 6.0)
    assert str(DESIGNS["triangle"].at(2.0, sign=-1.0).offset) == "0.0"  # never -0.0


def test_the_designs_hold_together() -> None:
    for name, design in DESIGNS.items():
        assert design.kind in SHAPES and design.role in ROLES and design.shows in {"", *RUNS}
        assert 0.0 < design.share <= 1.0 and design.length + REST_S + TAIL_S <= LONGEST_S
        if name.endswith(BACK):
            assert DESIGNS[name.removesuffix(BACK)].direction == -design.direction
    assert {design.shows for design in DESIGNS.values()} == {"", *RUNS}  # every kind of run is there
    assert not DESIGNS["coast_fast"].reverses and not DESIGNS["square_offset"].reverses and DESIGNS["triangle"].reverses
