"""Emitter: instructions of LLVM on numbers that all runs share and on vectors with a number for every run.

A term is a number of Python, a value that all lanes share, or a vector with one element for every lane. Operations on numbers
of Python are worked out at once; where a vector meets a shared value, that is repeated in every lane.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from llvmlite import ir

Value = Any
"""A value of LLVM: `double`, `i64`, `i1`, or a vector of these; llvmlite declares no types of its members."""
Term = Any
"""A number of Python, or a value of LLVM."""

DOUBLE, INT, BOOL, POINTER = ir.DoubleType(), ir.IntType(64), ir.IntType(1), ir.PointerType()
TYPES = {"f": DOUBLE, "i": INT, "b": BOOL}
"""LLVM's types of numbers, whole numbers and truth values, by the letters of `kind_of`."""


def kind_of(dtype: np.dtype) -> str:
    """Kind of a number.

    Args:
        dtype: Type of NumPy.

    Returns:
        `f`, `i` or `b`; any other letter stands for what is not lowered.
    """
    dtype = np.dtype(dtype)
    if dtype == np.float64:
        return "f"
    return {"i": "i", "u": "i", "b": "b"}.get(dtype.kind, "?")


class Unsupported(Exception):
    """Raised for a program that is not lowered; it says what is in the way."""


class Emitter:
    """Where instructions are put, and what has been put there already.

    Attributes:
        builder: LLVM's builder, at the end of the block that is being filled.
        lanes: How many runs stand side by side in a vector [1].
        direction: Number of the derivative that is worked out, None where values are.
    """

    def __init__(self, builder: ir.IRBuilder, lanes: int) -> None:
        self.builder, self.lanes = builder, lanes
        self.direction: Term | None = None
        self._known: list[dict] = [{}]
        self._depths: dict[int, int] = {}
        self._loops: list[Any] = []
        self._inverses: dict[int, Any] = {}
        self._constants: dict[tuple[str, str], Any] = {}
        self._repeats: dict[tuple[str, str], Any] = {}

    def once(self, key: object, make: Callable[[], Term]) -> Term:
        """What was emitted before under a key in this block or one around it, or else now.

        Args:
            key: What names the term.
            make: Emits it.

        Returns:
            The term.
        """
        for scope in reversed(self._known):
            if key in scope:
                return scope[key]
        found = self._known[-1][key] = make()
        return found

    @contextmanager
    def scope(self) -> Iterator[None]:
        """A part of the program whose terms are not known outside it.

        Yields:
            Nothing.
        """
        self._known.append({})
        yield
        self._known.pop()

    def constant(self, value: bool | int | float, kind: str) -> ir.Constant:
        """A number as a value that all lanes share, the same one wherever it stands: to make and to write one takes long.

        Args:
            value: The number [1].
            kind: Its kind, a letter of `TYPES`.

        Returns:
            The value.
        """
        number = {"f": float, "i": int, "b": bool}[kind](value)
        key = kind, repr(number)  # which tells -0.0 from 0.0
        if key not in self._constants:
            self._constants[key] = ir.Constant(TYPES[kind], number)
        return self._constants[key]

    def value(self, term: Term, kind: str) -> Value:
        """A term as a value of LLVM.

        Args:
            term: The term.
            kind: Its kind.

        Returns:
            The value.
        """
        return term if isinstance(term, ir.Value) else self.constant(term, kind)

    def is_vector(self, term: Term) -> bool:
        """Whether a term has an element for every lane.

        Args:
            term: The term.

        Returns:
            True where it has.
        """
        return isinstance(term, ir.Value) and isinstance(getattr(term, "type", None), ir.VectorType)

    def vector(self, term: Term, kind: str) -> Value:
        """A term with an element for every lane.

        Args:
            term: The term.
            kind: Its kind.

        Returns:
            The vector.
        """
        if self.is_vector(term):
            return term
        if not isinstance(term, ir.Value):
            return self._repeated(self.constant(term, kind), kind)
        if isinstance(term, ir.Constant):
            return self._repeated(term, kind)
        wide: Any = ir.VectorType(TYPES[kind], self.lanes)

        def emit() -> Term:
            first = self.builder.insert_element(ir.Constant(wide, ir.Undefined), term, ir.Constant(ir.IntType(32), 0))
            mask = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), [0] * self.lanes)
            return self.builder.shuffle_vector(first, ir.Constant(wide, ir.Undefined), mask)

        return self.once(("vector", id(term), term), emit)

    def _repeated(self, number: Any, kind: str) -> Value:
        """A constant with the same number in every lane, the same one wherever it stands."""
        key = kind, repr(number.constant)
        if key not in self._repeats:
            wide: Any = ir.VectorType(TYPES[kind], self.lanes)
            self._repeats[key] = ir.Constant(wide, [number.constant] * self.lanes)
        return self._repeats[key]

    def alike(self, kinds: str, *terms: Term) -> list[Value]:
        """Terms as values that are all shared by the lanes, or all vectors.

        Args:
            kinds: A letter of `TYPES` for each term.
            *terms: The terms.

        Returns:
            The values.
        """
        if any(self.is_vector(term) for term in terms):
            return [self.vector(term, kind) for kind, term in zip(kinds, terms, strict=True)]
        return [self.value(term, kind) for kind, term in zip(kinds, terms, strict=True)]

    def intrinsic(self, name: str, *operands: Value) -> Value:
        """Calls one of LLVM's own functions of numbers of one type.

        Args:
            name: Its name without the types.
            *operands: What it is applied to.

        Returns:
            Its value.
        """
        of = operands[0].type
        inner = of.element if isinstance(of, ir.VectorType) else of
        letter = ("f" if isinstance(inner, ir.DoubleType) else "i") + str(64 if inner != BOOL else 1)
        suffix = f"v{of.count}{letter}" if isinstance(of, ir.VectorType) else letter
        return self.builder.call(self.function(f"llvm.{name}.{suffix}", of, [o.type for o in operands]), operands)

    def function(self, name: str, result: ir.Type, operands: list[ir.Type]) -> ir.Function:
        """A function of the module, declared where it is not yet known.

        Args:
            name: Its name.
            result: Type of its value.
            operands: Types of its operands.

        Returns:
            The function.
        """
        module = self.builder.module
        found = module.globals.get(name)
        return ir.Function(module, ir.FunctionType(result, operands), name) if found is None else found

    def depth(self, term: Value) -> int:
        """How many loops stand around the instruction of a value.

        Args:
            term: The value.

        Returns:
            The number [1].
        """
        return self._depths.get(id(term.parent), 0) if isinstance(term, ir.Instruction) else 0

    def inverse(self, term: Term) -> Term | None:
        """Inverse of a number that stays the same in the present loop, worked out before it.

        Args:
            term: The number.

        Returns:
            The inverse; None for any other number.
        """
        if not isinstance(term, ir.Value):
            return 1.0 / term if term else None
        depth = self.depth(term)
        if depth == len(self._loops):
            return None
        if id(term) not in self._inverses:
            here = self.builder.block
            self.builder.position_before(self._loops[depth].terminator)
            one = self.vector(1.0, "f") if self.is_vector(term) else self.constant(1.0, "f")
            self._inverses[id(term)] = self.builder.fdiv(one, term)
            self.builder.position_at_end(here)
        return self._inverses[id(term)]

    def add(self, a: Term, b: Term) -> Term:
        """Sum of two whole numbers.

        Args:
            a: One of them.
            b: The other one.

        Returns:
            The sum.
        """
        if not isinstance(a, ir.Value) and not isinstance(b, ir.Value):
            return int(a) + int(b)
        if not isinstance(a, ir.Value) and a == 0:
            return b
        if not isinstance(b, ir.Value) and b == 0:
            return a
        return self.builder.add(*self.alike("ii", a, b))

    def times(self, a: Term, b: Term) -> Term:
        """Product of two whole numbers.

        Args:
            a: One of them.
            b: The other one.

        Returns:
            The product.
        """
        if not isinstance(a, ir.Value) and not isinstance(b, ir.Value):
            return int(a) * int(b)
        if not isinstance(b, ir.Value) and b == 1:
            return a
        return self.builder.mul(*self.alike("ii", a, b))

    def within(self, i: Term, last: int) -> Term:
        """A whole number brought into the range from 0 to `last`.

        Args:
            i: The number.
            last: The largest one.

        Returns:
            The number within the range.
        """
        if not isinstance(i, ir.Value):
            return min(max(int(i), 0), last)
        lowest, highest = (
            self.alike("ii", 0, last) if not self.is_vector(i) else (self.vector(0, "i"), self.vector(last, "i"))
        )
        return self.intrinsic("smin", self.intrinsic("smax", i, lowest), highest)

    @contextmanager
    def loop(self, count: Term) -> Iterator[Value]:
        """A loop whose body is what is emitted inside.

        Args:
            count: How often it runs [1].

        Yields:
            Number of the turn, from 0.
        """
        loop = Loop(self, count, [])
        yield loop.turn
        loop.close([])

    @contextmanager
    def branch(self, wanted: Value) -> Iterator[list[Value]]:
        """What is emitted inside is passed over where it is not wanted.

        Args:
            wanted: Whether it runs, the same for all lanes.

        Yields:
            A list for the values that are to be known afterwards; where it did not run they have no meaning.
        """
        b, handed = self.builder, []
        before, inside, after = b.block, b.append_basic_block("branch"), b.append_basic_block("joined")
        self._depths |= dict.fromkeys((id(inside), id(after)), len(self._loops))
        b.cbranch(wanted, inside, after)
        b.position_at_end(inside)
        inverses = dict(self._inverses)
        with self.scope():
            yield handed
        self._inverses = inverses
        end = b.block
        b.branch(after)
        b.position_at_end(after)
        for k, value in enumerate(handed):
            handed[k] = b.phi(value.type)
            handed[k].add_incoming(ir.Constant(value.type, ir.Undefined), before)
            handed[k].add_incoming(value, end)

    @contextmanager
    def entries(self, count: int) -> Iterator[Value]:
        """A loop over entries instead of each of them written out: in it no division becomes a product that would not be one without it.

        Args:
            count: How many entries [1].

        Yields:
            Number of the entry.
        """
        outer, inverses = self._loops, self._inverses
        self._inverses = dict(inverses)
        loop = Loop(self, count, [])
        self._loops = outer[:-1]
        self._depths[id(loop.head)] = len(self._loops)
        yield loop.turn
        self._loops = [*self._loops, loop.entry]
        loop.close([])
        self._inverses = inverses  # those within the loop are not known behind it


class Loop:
    """A loop that hands terms on from turn to turn.

    Attributes:
        turn: Number of the turn, from 0.
        carried: What is handed on, at the beginning of a turn.
    """

    def __init__(self, emitter: Emitter, count: Term, first: list[Value]) -> None:
        b = emitter.builder
        self.emitter, self.count = emitter, emitter.value(count, "i")
        self.entry, self.head = b.block, b.append_basic_block("loop")
        self.exit = b.append_basic_block("done")
        self.first = first
        zero = emitter.constant(0, "i")
        b.cbranch(b.icmp_signed(">", self.count, zero), self.head, self.exit)
        b.position_at_end(self.head)
        emitter._known.append({})
        emitter._loops.append(self.entry)
        emitter._depths[id(self.head)] = len(emitter._loops)
        self.turn = b.phi(INT)
        self.turn.add_incoming(zero, self.entry)
        self.carried = [b.phi(value.type) for value in first]
        for phi, value in zip(self.carried, first, strict=True):
            phi.add_incoming(value, self.entry)

    def close(self, last: list[Value], go_on: Value | None = None) -> list[Value]:
        """Ends the body.

        Args:
            last: What is handed on at the end of a turn.
            go_on: Whether there is another turn, where that does not depend on the count alone.

        Returns:
            What is handed on by the last turn; the first terms where there was none.
        """
        b = self.emitter.builder
        self.emitter._known.pop()
        self.emitter._loops.pop()
        following = b.add(self.turn, self.emitter.constant(1, "i"))
        more = b.icmp_signed("<", following, self.count)
        if go_on is not None:
            more = b.and_(more, go_on)
        end = b.block
        b.cbranch(more, self.head, self.exit)
        self.turn.add_incoming(following, end)
        for phi, value in zip(self.carried, last, strict=True):
            phi.add_incoming(value, end)
        b.position_at_end(self.exit)
        self.emitter._depths[id(self.exit)] = len(self.emitter._loops)
        found = []
        for before, value in zip(self.first, last, strict=True):
            phi = b.phi(value.type)
            phi.add_incoming(before, self.entry)
            phi.add_incoming(value, end)
            found.append(phi)
        return found
