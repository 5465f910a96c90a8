"""Programs kept on disk as they were traced: a new process neither traces nor lowers what an earlier one did.

The persistent compilation cache of JAX spares compiling, but not tracing, which takes longer for a plant with many parts.
A traced program depends on the library's source, the versions of JAX and of what is built on it, the platform, the structure, the solver and the arrays'
shapes: all of them name its file. Programs of a structure or a solver that is not `from_library` are not kept on disk, since the
library's source does not say what they compute.
"""

from collections.abc import Callable, Hashable
from functools import wraps
from inspect import Parameter, signature
from threading import Lock, RLock
from typing import Any

import jax
import numpy as np
from jax import export
from jax.core import Tracer

from rwjax.lowering import program_files

MOST_PROGRAMS = 100
"""Programs that a process holds. Of more, those not called for longest are dropped and read again when they are needed. Each takes up
to 350 memory maps, of which Linux gives a process 65 530, and up to 50 MB."""

OPTIONS = {"xla_disable_hlo_passes": "while-loop-invariant-code-motion"}
"""Options of the compiler. What a step's expressions share, the compiler finds only where it has not moved their parts out of the loop
before: a step with several kinds of friction otherwise works out the same power twelve times."""
ON_PROCESSOR = {"xla_backend_optimization_level": 1}
"""Further options on a processor: at the first level of optimisation a loop that is one function compiles in 0.8 instead of 1.1 s
and runs as fast."""
if jax.__version_info__ < (0, 11):
    ON_PROCESSOR["xla_cpu_use_fusion_emitters"] = False
    """Without the newer way to emit fused expressions a program compiles in half the time and runs as fast; JAX 0.11 has no other."""


class _Once:
    """A program that is called once alone, by which it is compiled, before several threads may call it at the same time."""

    def __init__(self, program: Callable) -> None:
        self.program, self.compiled, self.lock = program, False, Lock()

    def __call__(self, *arrays: Any) -> Any:
        if self.compiled:
            return self.program(*arrays)
        with self.lock:
            found = self.program(*arrays)
            self.compiled = True
            return found


_programs: dict[object, Callable] = {}
_lock = RLock()  # a program that is being traced may call another one


def _exported(flat: Callable, arrays: list[Any]) -> export.Exported | None:
    """A function as JAX can write it to disk; None for one that calls back to Python, as the checks of equinox do."""
    try:
        return export.export(jax.jit(flat))(*(jax.ShapeDtypeStruct(a.shape, a.dtype) for a in arrays))
    # reason: so JAX says that a program calls back; it is traced in every process, and runs all the same
    except NotImplementedError:
        return None


def _program(name: str, key: object, flat: Callable, arrays: list[Any], keep: bool) -> Callable:
    """The compiled program for arrays of these shapes, from disk or traced and put there; only traced if it is not to be kept."""
    path = program_files.file_of("traced", name, key) if keep else None
    data = program_files.read(path)
    traced = _exported(flat, arrays) if data is None else export.deserialize(data)
    if traced is not None and data is None:
        program_files.write(path, traced.serialize())
    program = flat if traced is None else traced.call
    own = ON_PROCESSOR if jax.default_backend() == "cpu" else {}
    return _Once(jax.jit(program, compiler_options=OPTIONS | own))


def stored(result: Callable) -> Callable:
    """Decorates `function(structure, *arrays, **choices)`: compiled once for each structure, choices and shapes, and kept on disk.

    The structure is hashable and static. The choices are arguments by keyword alone, such as a solver: modules whose arrays and
    numbers may change without a new program. Inside another traced function it is traced there, so that it can be differentiated.

    Args:
        result: Makes what is returned out of a sequence of arrays.

    Returns:
        The decorator.
    """

    def decorate(function: Callable) -> Callable:
        keywords = [p for p in signature(function).parameters.values() if p.kind is Parameter.KEYWORD_ONLY]
        defaults = {p.name: p.default for p in keywords if p.default is not Parameter.empty}
        plain = jax.jit(function, static_argnums=0)

        @wraps(function)
        def call(structure: Hashable, *arguments: Any, **given: Any) -> Any:
            choices = defaults | given
            leaves, tree = jax.tree.flatten((arguments, choices))
            if any(isinstance(leaf, Tracer) for leaf in leaves):
                return plain(structure, *arguments, **choices)
            arrays = [np.asarray(leaf) for leaf in leaves]
            key = (structure, tree, tuple((a.shape, a.dtype.name) for a in arrays))

            def flat(*leaves: Any) -> list:
                arguments, choices = jax.tree.unflatten(tree, leaves)
                return list(function(structure, *arguments, **choices))

            with _lock:
                if (function, key) not in _programs:
                    while len(_programs) >= MOST_PROGRAMS:
                        del _programs[next(iter(_programs))]
                    _programs[function, key] = _program(
                        function.__name__,
                        key,
                        flat,
                        arrays,
                        getattr(structure, "from_library", True)
                        and all(getattr(choice, "from_library", False) for choice in choices.values()),
                    )
                program = _programs[function, key] = _programs.pop((function, key))  # the last one called stands last
            return result(program(*arrays))

        return call

    return decorate
