"""Object code for this processor, and functions of it."""

import ctypes

import pytest

from rwjax.lowering.machine import compiled, doubles_in_a_vector, loaded, processor

TEXT = "define double @twice(double %x) {\n  %y = fadd double %x, %x\n  ret double %y\n}\n"


def test_a_function_of_object_code_can_be_called() -> None:
    twice = loaded(compiled(TEXT), "twice", ctypes.c_double, ctypes.c_double)
    assert twice(1.25) == 2.5


def test_code_is_for_this_processor_and_one_that_lacks_something() -> None:
    name, features = processor()
    assert name and features
    assert compiled(TEXT) == compiled(TEXT)


def test_the_widest_vectors_are_those_of_this_processor() -> None:
    features = set(processor()[1].split(","))
    assert doubles_in_a_vector() == (8 if "+avx512f" in features else 4 if "+avx" in features else 2)
    assert "+sse2" in features


def test_what_llvm_cannot_read_is_an_error() -> None:
    with pytest.raises(RuntimeError):
        compiled("define double @twice(")
