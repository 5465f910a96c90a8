"""Budget: by the clock or by request, and for the search alone."""

from collections.abc import Iterator

import pytest

from rwjax.diagnosis.budget import Budget, Stopped
from rwjax.errors import InputError


class Clock:
    """A clock that stands until it is moved."""

    now = 7.0

    def __call__(self) -> float:
        return self.now


def test_the_clock_ends_a_search_and_nothing_else() -> None:
    clock = Clock()
    budget = Budget(3.0, clock)
    with budget.searching():
        clock.now += 2.0
        budget.check()
        assert budget.left == 1.0
        clock.now += 2.0
        assert budget.left == 0.0 and not budget.stopped
        with pytest.raises(Stopped):
            budget.check()
        end = budget.ending()
    with pytest.raises(Stopped):  # what another thread works out for the search that has left
        end()
    budget.check()  # the answer is worked out whatever the time


def test_what_is_kept_of_a_budget_is_left_for_the_next_search_and_not_for_threads_of_the_first() -> None:
    clock = Clock()
    budget = Budget(10.0, clock)
    with budget.searching():
        clock.now += 6.0
        budget.keep(0.3)
        budget.check()
        assert budget.left == 4.0
        end_first = budget.ending()
        end_first()
        clock.now += 1.5
        with pytest.raises(Stopped):
            budget.check()
    with budget.searching():
        budget.check()
        assert budget.left == 2.5
        budget.ending()()
        with pytest.raises(Stopped):
            end_first()
    endless = Budget(clock=clock)
    with endless.searching():
        endless.keep(0.3)  # nothing of no limit
        clock.now += 1e9
        endless.check()


def test_who_asks_before_the_search_has_no_answer_to_come_and_who_asks_later_has() -> None:
    budget = Budget()
    assert budget.left == float("inf")
    assert not budget.stop() and budget.stopped
    with budget.searching(), pytest.raises(Stopped):
        budget.check()
    late = Budget()
    with late.searching():
        late.check()
    assert late.stop() and late.left == 0.0


def test_a_heeded_search_is_the_same_search_until_the_budget_ends() -> None:
    def search() -> Iterator[int]:
        total = 0
        for k in range(3):
            total += yield k
        return total

    budget = Budget()
    same = budget.heeded(search())  # pyright: ignore[reportArgumentType]
    with budget.searching():
        assert [next(same), same.send(10), same.send(20)] == [0, 1, 2]  # pyright: ignore[reportArgumentType]
        with pytest.raises(StopIteration) as end:
            same.send(30)  # pyright: ignore[reportArgumentType]
        assert end.value.value == 60
        ended = budget.heeded(search())  # pyright: ignore[reportArgumentType]
        next(ended)
        budget.stop()
        with pytest.raises(Stopped):
            ended.send(10)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), "10"])
def test_a_budget_is_positive(seconds: float | str) -> None:
    with pytest.raises(InputError, match="has to be a positive number of seconds"):
        Budget(seconds)  # pyright: ignore[reportArgumentType]
