"""Python's look for objects that hold each other: seldom inside, and as before afterwards."""

import gc
from collections.abc import Iterator

import pytest

from rwjax.fitting.garbage import YOUNG, seldom_collected


@pytest.fixture(autouse=True)
def _as_the_other_tests_have_it() -> Iterator[None]:
    before = gc.get_threshold()
    gc.unfreeze()
    yield
    gc.set_threshold(*before)
    gc.freeze()


@pytest.mark.parametrize(("before", "inside"), [(700, YOUNG), (10 * YOUNG, 10 * YOUNG), (0, 0)])
def test_it_looks_seldom_and_as_often_as_before_also_after_an_error(before: int, inside: int) -> None:
    gc.set_threshold(before)
    with pytest.raises(KeyError), seldom_collected():
        assert gc.get_threshold()[0] == inside and gc.get_freeze_count() > 0
        raise KeyError
    assert gc.get_threshold()[0] == before and gc.get_freeze_count() == 0


def test_what_the_user_has_frozen_stays_so() -> None:
    gc.freeze()
    with seldom_collected():
        pass
    assert gc.get_freeze_count() > 0
