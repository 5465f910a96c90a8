"""Python's look for objects that hold each other: seldom inside, and as before afterwards."""

import gc

import pytest

from rwjax.fitting.garbage import YOUNG, seldom_collected


def test_what_is_there_stays_and_the_look_is_as_often_as_before_also_after_an_error() -> None:
    before, _ = gc.get_threshold(), gc.unfreeze()
    with pytest.raises(KeyError), seldom_collected():
        assert gc.get_threshold()[0] == YOUNG > 700 and gc.get_freeze_count() > 10_000
        raise KeyError
    assert gc.get_threshold() == before and gc.get_freeze_count() == 0
    gc.freeze()  # as the other tests have it
