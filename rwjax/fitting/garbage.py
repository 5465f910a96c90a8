"""Python's look for objects that hold each other and can go: it takes a tenth of a search that makes programs."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager

YOUNG = 5000
"""New objects after which Python looks for those that can go [1]; programs are made of many small parts."""


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Inside, Python seldom looks for objects that hold each other, and what is there already stays.

    Yields:
        Nothing.
    """
    before, frozen = gc.get_threshold(), gc.get_freeze_count()
    gc.freeze()
    if 0 < before[0] < YOUNG:  # with 0 Python does not look at all
        gc.set_threshold(YOUNG)
    try:
        yield
    finally:
        gc.set_threshold(*before)
        if not frozen:
            gc.unfreeze()
