"""A jaxpr as a function of machine code: its arguments, its results, its memory."""

import ctypes
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from math import prod
from threading import local
from typing import NamedTuple

import jax
import numpy as np
from jax.extend.core import ClosedJaxpr
from llvmlite import ir

from rwjax.lowering.arrays import Array, Memory, Spread
from rwjax.lowering.emitter import DOUBLE, INT, POINTER, Emitter, kind_of
from rwjax.lowering.flow import Program, flattened, spreads
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

    def __init__(self, bases: tuple[ir.Value, ir.Value], e: Emitter, directions: ir.Value) -> None:
        self.bases, self.e, self.directions, self.used = bases, e, directions, [0, 0]

    def __call__(self, shape: tuple[int, ...], kind: str, spread: Spread) -> Memory:
        """Room for an array."""
        e, lanes = self.e, self.e.lanes if spread.lanes else 1
        which, place = int(spread.directions), self.used[int(spread.directions)]
        self.used[which] += -(-prod(shape) * lanes // 8) * 8
        offset = e.times(self.directions, place) if which else place
        base = e.builder.gep(self.bases[which], [e.value(offset, "i")], source_etype=DOUBLE)
        of_entry = e.times(self.directions, lanes) if which else lanes
        return Memory(shape, kind, spread, base, 1, lanes, of_entry)


def _constant(module: ir.Module) -> object:
    """What puts an array of numbers into the module."""

    def put(value: np.ndarray) -> Memory:
        kind = kind_of(value.dtype)
        inner = DOUBLE if kind == "f" else INT
        flat = [float(v) if kind == "f" else int(v) for v in value.ravel()]
        of = ir.ArrayType(inner, len(flat))
        found = ir.GlobalVariable(module, of, f"constant.{len(module.globals)}")
        found.global_constant, found.linkage = True, "internal"
        found.initializer = ir.Constant(of, [ir.Constant(inner, v) for v in flat])
        return Memory(value.shape, kind, Spread(), found, 1, 1, 1)

    return put


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
    program = flattened(closed)
    module = ir.Module("rwjax")
    words = [POINTER] * 4 + [INT] * 4
    fn = ir.Function(module, ir.FunctionType(ir.VoidType(), words), ENTRY)
    for argument in fn.args[:4]:
        argument.add_attribute("noalias")
    inputs, outputs, work, work_d, first, count, rows, directions = fn.args
    e = Emitter(ir.IRBuilder(fn.append_basic_block("entry")), lanes)
    kept = _flush(e)
    rooms = _Rooms((work, work_d), e, directions)
    lowering = Lowering(e, directions, rooms, _constant(module))
    spread = spreads(program, given)
    slots = tuple(Slot(v.aval.shape, kind_of(v.aval.dtype), s) for v, s in zip(closed.jaxpr.invars, given, strict=True))
    results = tuple(
        Slot(v.aval.shape, kind_of(v.aval.dtype), spread.get(id(name), Spread()))
        for v, name in zip(closed.jaxpr.outvars, program.outputs, strict=True)
    )
    known: dict[int, Array] = {}

    def bind(of_lanes: bool, lane: ir.Value | int) -> None:
        for k, (v, slot) in enumerate(zip(program.inputs, slots, strict=True)):
            if slot.spread.lanes == of_lanes:
                known[id(v)] = _argument(e, inputs, k, slot, lane)
        for k, (v, slot) in enumerate(zip(program.outputs, results, strict=True)):
            if slot.spread.lanes == of_lanes:
                lowering.results[id(v)] = _result(e, outputs, k, slot, lane, rows)

    late = _of_lanes(program, spread)

    def finish(of_lanes: bool) -> None:
        pairs = []
        for v, slot in zip(program.outputs, results, strict=True):
            mine = (slot.spread.lanes or id(v) in late) == of_lanes
            if mine and lowering.read(v, known) is not lowering.results[id(v)]:
                pairs.append((lowering.read(v, known), lowering.results[id(v)]))
        lowering.put(pairs)

    bind(False, 0)
    lowering.all_of([q for q in program.equations if id(q.outputs[0]) not in late], known)
    finish(False)
    of_lanes = [q for q in program.equations if id(q.outputs[0]) in late]
    lowering.ready(of_lanes, known)
    with e.loop(e.builder.sdiv(count, e.constant(lanes, "i"))) as turn:
        bind(True, e.add(first, e.times(turn, lanes)))
        lowering.all_of(of_lanes, known)
        finish(True)
    _restore(e, kept)
    e.builder.ret_void()
    return str(module), Code(b"", lanes, slots, results, tuple(rooms.used))


def _of_lanes(program: Program, spread: dict[int, Spread]) -> set[int]:
    """What is worked out for every vector of runs, by the `id` of its name: also what no run changes but a loop gives that has lanes."""
    late: set[int] = set()
    for q in program.equations:
        if any(spread[id(v)].lanes for v in q.outputs) or any(id(v) in late for v in q.inputs):
            late |= {id(v) for v in q.outputs}
    return late


def _flush(e: Emitter) -> ir.Value | None:
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


def _restore(e: Emitter, kept: ir.Value | None) -> None:
    if kept is not None:
        e.builder.call(e.function("llvm.x86.sse.ldmxcsr", ir.VoidType(), [POINTER]), [kept])


def _is_x86() -> bool:
    from platform import machine

    return machine().lower() in ("x86_64", "amd64")


def _pointer(e: Emitter, table: ir.Value, k: int) -> ir.Value:
    place = e.builder.gep(table, [ir.Constant(INT, k)], source_etype=POINTER)
    return e.builder.load(place, typ=POINTER)


def _argument(e: Emitter, table: ir.Value, k: int, slot: Slot, lane: ir.Value | int) -> Memory:
    size, base = prod(slot.shape), _pointer(e, table, k)
    if slot.spread.lanes:
        base = e.builder.gep(base, [e.value(e.times(lane, size), "i")], source_etype=DOUBLE)
    return Memory(slot.shape, slot.kind, slot.spread, base, size, size, 1)


def _result(e: Emitter, table: ir.Value, k: int, slot: Slot, lane: ir.Value | int, rows: ir.Value) -> Memory:
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
        self, arguments: Sequence[np.ndarray], rows: int = 1, directions: int = 0, threads: int = 1
    ) -> list[np.ndarray]:
        """Runs the program.

        Args:
            arguments: Arrays of the slots' shapes, behind axes of directions and of runs where they differ over these.
            rows: How many runs [1].
            directions: How many directions [1].
            threads: How many threads share the runs [1]; the results do not depend on it.

        Returns:
            The results, with the same axes in front.
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
        return [a[_rows(slot, rows)] for a, slot in zip(out, self.code.results, strict=True)]

    def fill(
        self, held: Sequence[np.ndarray], out: Sequence[np.ndarray], first: int, count: int, rows: int, directions: int
    ) -> None:
        """Works out some of the runs.

        Args:
            held: Arguments as they lie in memory.
            out: Where results go.
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


def _laid(a: np.ndarray, slot: Slot, rows: int) -> np.ndarray:
    """An argument in memory, its last run repeated up to a number of runs."""
    of = np.float64 if slot.kind == "f" else np.int64
    a = np.ascontiguousarray(a, of)
    if slot.spread.lanes and len(a) < rows:
        a = np.concatenate([a, np.repeat(a[-1:], rows - len(a), axis=0)])
    return a


def _made(slot: Slot, rows: int, directions: int) -> np.ndarray:
    front = (*([directions] if slot.spread.directions else []), *([rows] if slot.spread.lanes else []))
    return np.zeros((*front, *slot.shape), np.float64 if slot.kind == "f" else np.int64)


def _rows(slot: Slot, rows: int) -> tuple[slice, ...]:
    every = [slice(None)] if slot.spread.directions else []
    return (*every, slice(rows)) if slot.spread.lanes else (*every,)


def build(function: object, arguments: Sequence, given: Sequence[Spread], lanes: int, features: str = "") -> Code:
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
