"""How often signatures are checked while the tests run: the first calls of every function in each test file, or every call.

A check takes longer than most of the functions that it checks, and to make one anew for each function within a function a millisecond.
All of them would be most of the tests' time. With `RWJAX_EVERY_CALL=1`, as in `make test-all`, none is left out.
"""

import os
import sys
from collections import Counter
from collections.abc import Callable
from functools import wraps
from types import CodeType, FunctionType

import jaxtyping

FIRST = 4
"""Calls of a function in a test file that are checked."""
FIRST_MADE = 2
"""Of a function within a function, how many of the functions that it was are checked."""
_every = jaxtyping.jaxtyped
_calls: Counter[CodeType] = Counter()
_made: Counter[CodeType] = Counter()


def _first(function: Callable, checked: Callable) -> Callable:
    code = function.__code__

    @wraps(function)
    def called(*args: object, **kwargs: object) -> object:
        if _calls[code] >= FIRST:
            return function(*args, **kwargs)
        _calls[code] += 1
        return checked(*args, **kwargs)

    return called


def _at_first(*, typechecker: Callable) -> Callable:
    """What jaxtyping's hook puts before every function and class of the library."""

    def decorate(it: object) -> object:
        check = _every(typechecker=typechecker)
        if not isinstance(it, FunctionType):
            return check(it)
        _made[it.__code__] += 1
        return it if _made[it.__code__] > FIRST_MADE else _first(it, check(it))

    return decorate


def begin_anew() -> None:
    """Has the first calls checked again."""
    _calls.clear()
    _made.clear()


# A check is three frames around each call, and a servo's derivatives are lowered some 300 calls deep.
sys.setrecursionlimit(3000)
if not os.environ.get("RWJAX_EVERY_CALL"):
    jaxtyping.jaxtyped = _at_first
