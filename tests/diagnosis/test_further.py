"""What may be claimed of a choice, where a law outside the list of effects may stand for one of its names."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from rwjax.diagnosis.budget import Stopped
from rwjax.diagnosis.further import Further, may_be_claimed
from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.judged import Judged, errors_of_the_rig
from rwjax.diagnosis.layout import laid_out
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.diagnosis.outside_laws import OutsideLaw
from rwjax.diagnosis.search.forward_backward import ForwardBackward
from tests.diagnosis.several_runs import RIG, run_of

DRY, STRIBECK = Hypothesis(("axis.coulomb",)), Hypothesis(("axis.stribeck",))
OUTSIDE = "rwjax.diagnosis.further.doing_as_well"


def claimed_of_dry_friction(alternatives: Sequence[Hypothesis]) -> Further:
    """What may be claimed of dry friction, which explains its runs, where some sets stand beside it."""
    layout = laid_out(RIG, [run_of(k, {"axis.coulomb": {"M_c": 0.06}}) for k in range(3)])
    fits = ModelFits.of(RIG, layout.logs, layout.train)
    fits(NOTHING)
    fits.start_from_first_readings()
    choice = ForwardBackward().choose(fits, (*DRY.names, *STRIBECK.names))
    assert choice.best == DRY
    judged = Judged(fits, layout, errors_of_the_rig(fits, layout), "yaw_rad")
    return may_be_claimed(judged, replace(choice, alternatives=tuple(alternatives)), DRY.names)


@pytest.mark.parametrize("alternatives", [(), (STRIBECK,)])
def test_a_law_is_asked_of_what_stands_beside_the_choice_too(
    alternatives: tuple[Hypothesis, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(OUTSIDE, lambda fits, asked: list(asked))
    found = claimed_of_dry_friction(alternatives)
    assert found.complete and {*found.refused} == {name for e in alternatives for name in e.names}
    assert found.outside == tuple(e for one in alternatives for e in (one, Hypothesis(("axis.growing_stiction",))))


def test_errors_are_judged_anew_behind_the_fits_of_a_law(monkeypatch: pytest.MonkeyPatch) -> None:
    def moved(fits: ModelFits, asked: Sequence[OutsideLaw]) -> list[OutsideLaw]:
        better = fits(DRY)
        worse = replace(better, theta=better.theta * np.where(np.arange(len(better.theta)) == 0, 1.2, 1.0))
        fits.put(DRY, worse, ended=True)
        return []

    before = claimed_of_dry_friction(()).judged.rms(DRY)
    monkeypatch.setattr(OUTSIDE, moved)
    assert claimed_of_dry_friction((STRIBECK,)).judged.rms(DRY) > 1.5 * before


def test_nothing_is_claimed_where_the_budget_ends_before_a_law_was_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    def ended(fits: ModelFits, asked: Sequence[OutsideLaw]) -> list[OutsideLaw]:
        raise Stopped

    monkeypatch.setattr(OUTSIDE, ended)
    assert claimed_of_dry_friction(()).complete and not claimed_of_dry_friction((STRIBECK,)).complete
