"""Work on threads: order, errors, and matrix products on one thread meanwhile."""

import sys
from threading import Event
from types import ModuleType

import pytest
from threadpoolctl import ThreadpoolController

from rwjax.fitting import threads
from rwjax.fitting.threads import SINGLE_THREADED_BLAS, SingleThreadedBlas, on_threads


def blas_threads() -> set[int]:
    return {library["num_threads"] for library in ThreadpoolController().select(user_api="blas").info()}


def test_results_come_in_the_order_of_the_arguments() -> None:
    assert on_threads(lambda a, b: a - b, [5, 4, 3], [1, 2, 3]) == [4, 2, 0]


def test_an_error_does_not_wait_for_what_runs_beside_it() -> None:
    begun, go_on, ended = Event(), Event(), Event()

    def job(fails: bool) -> None:
        if fails:
            begun.wait(5.0)
            raise ZeroDivisionError("here")
        begun.set()
        go_on.wait(5.0)
        ended.set()

    with pytest.raises(ZeroDivisionError, match="here"):
        on_threads(job, [True, False])
    assert not ended.is_set()
    go_on.set()


def test_products_have_one_thread_until_the_last_one_leaves() -> None:
    before = blas_threads()
    with SINGLE_THREADED_BLAS:
        with SINGLE_THREADED_BLAS:
            assert blas_threads() == {1}
        assert blas_threads() == {1}
    assert blas_threads() == before


def test_libraries_are_looked_for_again_after_an_import_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    looked = []
    monkeypatch.setattr(threads, "ThreadpoolController", lambda: looked.append(0) or ThreadpoolController())
    blas = SingleThreadedBlas()
    for _ in range(2):
        with blas:
            assert blas_threads() == {1}
    assert len(looked) == 1
    monkeypatch.setitem(sys.modules, "imported", ModuleType("imported"))
    with blas:
        assert len(looked) == 2
