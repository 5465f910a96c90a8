"""A jaxpr as a function of machine code: its arguments, its results, its memory."""

import ctypes
import platform
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from math import prod
from threading import local
from typing import Any, NamedTuple

import jax
import numpy as np
from jax.extend.core import ClosedJaxpr
from llvmlite import ir

from rwjax.lowering.arrays import Array, Memory, Spread
from rwjax.lowering.branches import BRANCHES
from rwjax.lowering.emitter import DOUBLE, INT, POINTER, Emitter, Unsupported, Value, kind_of
from rwjax.lowering.flow import flattened, invariant, result_spreads
from rwjax.lowering.loops import LOOPS
from rwjax.lowering.lower import Lowering
from rwjax.lowering.machine import compiled, loaded

ENTRY = "rwjax.run"
PARTS = 4
"""Parts into which the runs are divided for each of several threads, so that none waits long for another one [1]."""
FLUSH_TO_ZERO = 0x8040
"""Bits of the processor's control word by which numbers below the range of normal ones are 0, as XLA has them."""


class Slot(NamedTuple):
    """An argument or a result.

    Attributes:
        shape: Its shape, without lanes and directions.
        kind: `f`, `i` or `b`.
        spread: Over what it differs.
    """

    shape: tuple[int, ...]
    kind: str
    spread: Spread


class Code(NamedTuple):
    """A program as object code.

    Attributes:
        code: The object code.
        lanes: Runs side by side in a vector [1].
        arguments: Its arguments.
        results: Its results.
        workspace: Numbers of working memory [1], and further ones for every direction.
    """

    code: bytes
    lanes: int
    arguments: tuple[Slot, ...]
    results: tuple[Slot, ...]
    workspace: tuple[int, int]


class _Rooms:
    """Working memory, given out while a program is lowered."""

    def __init__(self, bases: tuple[Value, ir.Value], e: Emitter, directions: Value) -> None:
        self.bases, self.e, self.directions, self.used = bases, e, directions, [0, 0]

    def __call__(self, shape: tuple[int, ...], kind: str, spread: Spread) -> Memory:
        """Room for an array."""
        e, lanes = self.e, self.e.lanes if spread.lanes else 1
        which, place = int(spread.directions), self.used[int(spread.directions)]
        of_direction = -(-prod(shape) * lanes // 8) * 8
        self.used[which] += of_direction
        offset = e.times(self.directions, place) if which else place
        base = e.builder.gep(self.bases[which], [e.value(offset, "i")], source_etype=DOUBLE)
        return Memory(shape, kind, spread, base, 1, of_direction, lanes)


def _constant(module: ir.Module) -> Callable[[np.ndarray], Array]:
    """What puts an array of numbers into the module."""

    def put(value: np.ndarray) -> Memory:
        kind = kind_of(value.dtype)
        inner = DOUBLE if kind == "f" else INT
        flat = [float(v) if kind == "f" else int(v) for v in value.ravel()]
        of = ir.ArrayType(inner, len(flat))
        found: Any = ir.GlobalVariable(module, of, f"constant.{len(module.globals)}")
        found.global_constant, found.linkage = True, "internal"
        found.initializer = ir.Constant(of, [ir.Constant(inner, v) for v in flat])
        return Memory(value.shape, kind, Spread(), found, 1, 1, 1)

    return put


class _Function:
    """The function of a program, while it is written.

    Attributes:
        module: The module in which it stands.
        rooms: Its working memory.
        slots: Its arguments.
        results: Its results.
    """

    def __init__(self, closed: ClosedJaxpr, given: Sequence[Spread], lanes: int) -> None:
        self.program = program = flattened(closed)
        self.module = ir.Module("rwjax")
        words = [POINTER] * 4 + [INT] * 4
        fn = ir.Function(self.module, ir.FunctionType(ir.VoidType(), words), ENTRY)
        for argument in fn.args[:4]:
            argument.add_attribute("noalias")
        self.inputs, self.outputs, work, work_d, self.first, self.count, self.rows, directions = fn.args
        self.e = Emitter(ir.IRBuilder(fn.append_basic_block("entry")), lanes)
        self.rooms = _Rooms((work, work_d), self.e, directions)
        self.lowering = Lowering(self.e, directions, self.rooms, _constant(self.module), LOOPS | BRANCHES)
        self.slots = tuple(_slot(v, s) for v, s in zip(closed.jaxpr.invars, given, strict=True))
        spread = result_spreads(program, given)
        self.results = tuple(_slot(v, s) for v, s in zip(closed.jaxpr.outvars, spread, strict=True))
        self.known: dict[int, Array] = {}
        self.places: dict[int, Memory] = {}

    def write(self) -> None:
        """Writes it: first what all runs share, then the runs, as many at a time as there are lanes."""
        e, program = self.e, self.program
        kept = _flush(e)
        of_lanes = [v for v, slot in zip(program.inputs, self.slots, strict=True) if slot.spread.lanes]
        shared, each = invariant(program, of_lanes)
        late = {id(v) for v in of_lanes} | {id(v) for q in each for v in q.outputs}
        self._bind(False, 0)
        self.lowering.all_of(shared, self.known)
        self._finish([k for k, v in enumerate(program.outputs) if id(v) not in late])
        self.lowering.ready(each, self.known)
        with e.loop(e.builder.sdiv(self.count, e.constant(e.lanes, "i"))) as turn:
            self._bind(True, e.add(self.first, e.times(turn, e.lanes)))
            self.lowering.all_of(each, self.known)
            self._finish([k for k, v in enumerate(program.outputs) if id(v) in late])
        _restore(e, kept)
        e.builder.ret_void()

    def _bind(self, of_lanes: bool, lane: Value | int) -> None:
        """Says where the arguments and the results lie that differ from run to run, or those that do not."""
        for k, (v, slot) in enumerate(zip(self.program.inputs, self.slots, strict=True)):
            if slot.spread.lanes == of_lanes:
                self.known[id(v)] = _argument(self.e, self.inputs, k, slot, lane)
        for k, (v, slot) in enumerate(zip(self.program.outputs, self.results, strict=True)):
            if slot.spread.lanes == of_lanes:
                self.places[k] = _result(self.e, self.outputs, k, slot, lane, self.rows)
                self.lowering.results[id(v)] = self.places[k]

    def _finish(self, numbers: Sequence[int]) -> None:
        """Writes results that do not lie yet where they belong."""
        found = [(self.lowering.read(self.program.outputs[k], self.known), self.places[k]) for k in numbers]
        self.lowering.put([(a, place) for a, place in found if a is not place])


def _slot(v: Any, spread: Spread) -> Slot:
    return Slot(v.aval.shape, kind_of(v.aval.dtype), spread)


def assembled(closed: ClosedJaxpr, given: Sequence[Spread], lanes: int) -> tuple[str, Code]:
    """A jaxpr in LLVM's language.

    Args:
        closed: The jaxpr of one run and one direction.
        given: Over what its arguments differ.
        lanes: Runs side by side in a vector [1].

    Returns:
        The module, and what is known of its code, which is still empty.

    Raises:
        Unsupported: The program holds what is not lowered.
    """
    function = _Function(closed, given, lanes)
    function.write()
    return str(function.module), Code(
        b"", lanes, function.slots, function.results, (function.rooms.used[0], function.rooms.used[1])
    )


def _flush(e: Emitter) -> Value | None:
    """Sets the processor to flush what is below the range of normal numbers; the control word of before."""
    if not _is_x86():
        return None
    place = e.builder.alloca(ir.IntType(32), size=2)
    e.builder.call(e.function("llvm.x86.sse.stmxcsr", ir.VoidType(), [POINTER]), [place])
    word = e.builder.load(place, typ=ir.IntType(32))
    changed = e.builder.gep(place, [ir.Constant(INT, 1)], source_etype=ir.IntType(32))
    e.builder.store(e.builder.or_(word, ir.Constant(ir.IntType(32), FLUSH_TO_ZERO)), changed)
    e.builder.call(e.function("llvm.x86.sse.ldmxcsr", ir.VoidType(), [POINTER]), [changed])
    return place


def _restore(e: Emitter, kept: Value | None) -> None:
    if kept is not None:
        e.builder.call(e.function("llvm.x86.sse.ldmxcsr", ir.VoidType(), [POINTER]), [kept])


def _is_x86() -> bool:
    return platform.machine().lower() in ("x86_64", "amd64")


def _pointer(e: Emitter, table: Value, k: int) -> Value:
    place = e.builder.gep(table, [ir.Constant(INT, k)], source_etype=POINTER)
    return e.builder.load(place, typ=POINTER)


def _argument(e: Emitter, table: Value, k: int, slot: Slot, lane: Value | int) -> Memory:
    if slot.spread.lanes and slot.spread.directions:
        raise Unsupported("an argument that differs over lanes and directions")
    size, base = prod(slot.shape), _pointer(e, table, k)
    if slot.spread.lanes:
        base = e.builder.gep(base, [e.value(e.times(lane, size), "i")], source_etype=DOUBLE)
    return Memory(slot.shape, slot.kind, slot.spread, base, size, size, 1)


def _result(e: Emitter, table: Value, k: int, slot: Slot, lane: Value | int, rows: Value) -> Memory:
    size, base = prod(slot.shape), _pointer(e, table, k)
    if slot.spread.lanes:
        base = e.builder.gep(base, [e.value(e.times(lane, size), "i")], source_etype=DOUBLE)
    of_direction = e.times(rows, size) if slot.spread.lanes else size
    place = Memory(slot.shape, slot.kind, slot.spread, base, size, of_direction, 1)
    place.cleared = True
    return place


class Lowered:
    """A program that can be called.

    Attributes:
        code: Its code.
    """

    def __init__(self, code: Code) -> None:
        self.code = code
        self._entry = loaded(code.code, ENTRY, None, *[ctypes.c_void_p] * 4, *[ctypes.c_int64] * 4)
        self._own = local()

    def _workspace(self, k: int, numbers: int) -> np.ndarray:
        held = getattr(self._own, f"work{k}", None)
        if held is None or len(held) < numbers:
            held = np.empty(numbers + 8)
            setattr(self._own, f"work{k}", held)
        return held

    def __call__(
        self, arguments: Sequence[np.ndarray | np.generic], rows: int = 1, directions: int = 0, threads: int = 1
    ) -> list[np.ndarray]:
        """Runs the program.

        Args:
            arguments: Arrays of the slots' shapes, behind axes of directions and of runs where they differ over these.
            rows: How many runs [1].
            directions: How many directions [1].
            threads: How many threads share the runs [1]; the results do not depend on it.

        Returns:
            The results, with the same axes in front; one that is the same in all runs is repeated.
        """
        lanes = self.code.lanes
        padded = -(-rows // lanes) * lanes
        held = [_laid(a, slot, padded) for a, slot in zip(arguments, self.code.arguments, strict=True)]
        out = [_made(slot, padded, directions) for slot in self.code.results]
        parts = min(padded // lanes, PARTS * threads) if threads > 1 else 1
        ends = [padded // lanes * k // parts * lanes for k in range(parts + 1)]

        def fill(first: int, end: int) -> None:
            self.fill(held, out, first, end - first, padded, directions)

        if parts == 1:
            fill(*ends)
        else:
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(fill, ends[:-1], ends[1:]))
        of_runs = any(slot.spread.lanes for slot in self.code.arguments)
        return [_of_rows(a, slot, rows) if of_runs else a for a, slot in zip(out, self.code.results, strict=True)]

    def fill(
        self, held: Sequence[np.ndarray], out: Sequence[np.ndarray], first: int, count: int, rows: int, directions: int
    ) -> None:
        """Works out some of the runs.

        Args:
            held: Arguments as they lie in memory [any unit].
            out: Where results go [any unit].
            first: Number of the first run [1].
            count: How many, a multiple of the lanes [1].
            rows: How many runs the results have room for [1].
            directions: How many directions [1].
        """
        pointers = [
            (ctypes.c_void_p * max(len(a), 1))(*(x.__array_interface__["data"][0] for x in a)) for a in (held, out)
        ]
        fixed, each = self.code.workspace
        work = [self._workspace(0, fixed), self._workspace(1, each * directions)]
        addresses = [(w.ctypes.data + 63) // 64 * 64 for w in work]
        self._entry(*pointers, *addresses, first, count, rows, directions)


def _laid(a: np.ndarray | np.generic, slot: Slot, rows: int) -> np.ndarray:
    """An argument in memory, its last run repeated up to a number of runs."""
    of = np.float64 if slot.kind == "f" else np.int64
    if not (isinstance(a, np.ndarray) and a.dtype == of and a.flags.c_contiguous):
        a = np.ascontiguousarray(a, of).reshape(np.shape(a))
    if slot.spread.lanes and len(a) < rows:
        a = np.concatenate([a, np.repeat(a[-1:], rows - len(a), axis=0)])
    return a


def _made(slot: Slot, rows: int, directions: int) -> np.ndarray:
    front = (*([directions] if slot.spread.directions else []), *([rows] if slot.spread.lanes else []))
    return np.zeros((*front, *slot.shape), np.float64 if slot.kind == "f" else np.int64)


def _of_rows(a: np.ndarray, slot: Slot, rows: int) -> np.ndarray:
    """A result with an axis of runs, behind that of directions where it has one."""
    axis = int(slot.spread.directions)
    if not slot.spread.lanes:
        a = np.expand_dims(a, axis)
        return np.broadcast_to(a, (*a.shape[:axis], rows, *a.shape[axis + 1 :]))
    return a[:, :rows] if axis else a[:rows]


def build(function: Callable, arguments: Sequence, given: Sequence[Spread], lanes: int, features: str = "") -> Code:
    """A function of JAX as object code.

    Args:
        function: The function of one run and one direction.
        arguments: Arrays of the shapes of its arguments.
        given: Over what the arguments differ.
        lanes: Runs side by side in a vector [1].
        features: What the processor is to be taken to have or lack.

    Returns:
        The code.
    """
    text, code = assembled(jax.make_jaxpr(function)(*arguments), given, lanes)
    return code._replace(code=compiled(text, features))
