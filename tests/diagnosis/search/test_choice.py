"""Choice: what a search says."""

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.search.choice import Choice


def test_nothing_is_chosen_without_a_search() -> None:
    choice = Choice.nothing()
    assert choice.best == Hypothesis() and choice.criterion == {Hypothesis(): 0.0}
    assert choice.ranking == ((Hypothesis(), 1.0),) and not choice.alternatives and not choice.equivalents
