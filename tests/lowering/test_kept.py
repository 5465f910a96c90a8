"""Lowered programs in the process and on disk: files that do not fit are made anew, and what is not lowered runs through XLA."""

import logging
from collections.abc import Callable, Iterator
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax.lowering import branches, elementwise, kept, loops, movement
from rwjax.lowering.arrays import Spread
from rwjax.lowering.program import Lowered

X = np.arange(3.0)
PRIMITIVES = {
    *("abs", "add", "add_any", "and", "argmax", "argmin", "broadcast_in_dim", "ceil", "clamp", "concatenate", "cond"),
    *(
        "convert_element_type",
        "copy",
        "copy_p",
        "cos",
        "cumsum",
        "div",
        "dot_general",
        "dynamic_slice",
        "dynamic_update_slice",
    ),
    *(
        "empty",
        "eq",
        "exp",
        "exp2",
        "expand_dims",
        "expm1",
        "floor",
        "gather",
        "ge",
        "gt",
        "integer_pow",
        "iota",
        "is_finite",
    ),
    *(
        "le",
        "log",
        "log1p",
        "logistic",
        "lt",
        "max",
        "min",
        "mul",
        "ne",
        "neg",
        "not",
        "one_minus_square",
        "optimization_barrier",
        "or",
        "pad",
    ),
    *(
        "pow",
        "reduce_and",
        "reduce_max",
        "reduce_min",
        "reduce_or",
        "reduce_sum",
        "rem",
        "reshape",
        "rev",
        "round",
        "rsqrt",
    ),
    *(
        "scan",
        "scatter",
        "select_n",
        "sign",
        "sin",
        "slice",
        "split",
        "sqrt",
        "square",
        "squeeze",
        "stack",
        "stop_gradient",
    ),
    *("sub", "tan", "tanh", "transpose", "unstack", "while", "xor"),
}
"""What is lowered, under the names of JAX 0.10 and 0.11; another version may have others for the same functions."""


@pytest.fixture
def builds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """Counts what is lowered, in a folder of its own; each `find` begins like a new process."""
    made, build = [], kept.build
    monkeypatch.setattr(kept, "build", lambda *a: (made.append(1), build(*a))[1])
    before = jax.config.values["jax_compilation_cache_dir"]
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield made
    jax.config.update("jax_compilation_cache_dir", before)


def find(function: Callable, key: object, monkeypatch: pytest.MonkeyPatch) -> Lowered:
    monkeypatch.setattr(kept, "programs", {})
    found = kept.lowered("test", key, function, [X], [Spread()], keep=True)
    assert found is not None
    return found


def double(x):
    return 2.0 * x


def test_the_accepted_primitives_are_these() -> None:
    assert {*elementwise.RULES, *movement.RULES, *loops.LOOPS, *branches.BRANCHES} == PRIMITIVES


def test_a_second_process_reads_the_program(builds: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    for _ in range(2):
        assert np.array_equal(find(double, "a", monkeypatch)([X])[0], 2.0 * X)
    assert len(builds) == 1


def test_a_torn_file_is_made_anew(builds: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    find(double, "b", monkeypatch)
    (path,) = tmp_path.glob("lowered-*")
    path.write_bytes(path.read_bytes()[:200])
    assert np.array_equal(find(double, "b", monkeypatch)([X])[0], 2.0 * X)
    assert len(builds) == 2


@pytest.mark.parametrize("of", ["processor", "effort", "version"])
def test_another_processor_effort_or_llvm_has_files_of_its_own(
    of: str, builds: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    find(double, "c", monkeypatch)
    if of == "processor":
        monkeypatch.setattr(kept, "processor", lambda: ("another", "-avx"))
    elif of == "effort":
        monkeypatch.setattr(kept.machine, "EFFORT", 3)
    else:
        monkeypatch.setattr(kept.llvmlite, "__version__", "0.0")
    find(double, "c", monkeypatch)
    assert len(builds) == 2 and len([*tmp_path.glob("lowered-*")]) == 2


def broken(x):
    raise ZeroDivisionError("an effect's own fault")


@pytest.mark.parametrize(("function", "why"), [(jnp.sort, "the primitive `sort`"), (broken, "an effect's own fault")])
def test_what_is_not_lowered_goes_through_xla_with_one_note(
    function: Callable, why: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(kept, "programs", {})
    with caplog.at_level(logging.WARNING, "rwjax"):
        for _ in range(3):
            assert kept.lowered("test", why, function, [X], [Spread()], keep=False) is None
    (record,) = [r for r in caplog.records if r.name == "rwjax"]
    assert why in record.getMessage() and "runs through XLA" in record.getMessage()


def test_a_variable_has_xla_run_all_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(kept.THROUGH_XLA, "1")
    assert kept.lowered("test", "d", double, [X], [Spread()], keep=False) is None
