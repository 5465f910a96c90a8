"""Arrays of a program while it is lowered: entries in registers, in memory, or worked out where they are asked for."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractContextManager
from itertools import count, product
from math import prod
from typing import NamedTuple

import numpy as np
from llvmlite import ir

from rwjax.lowering.emitter import DOUBLE, INT, POINTER, Emitter, Term, Value

FEW = 12
"""Longest axis of an array whose entries are worked out one by one, each a value of its own."""

UNROLLED = 16
"""Most entries that are written one by one, and not in a loop, where they lie in memory."""

Index = tuple[Term, ...]


class Spread(NamedTuple):
    """Over what a value differs.

    Attributes:
        lanes: Over the runs side by side.
        directions: Over the directions of a derivative.
    """

    lanes: bool = False
    directions: bool = False

    def __or__(self, other: "Spread") -> "Spread":
        return Spread(self.lanes or other.lanes, self.directions or other.directions)


SAME = Spread()
"""What does not differ at all."""
_numbers = count()


def _name(term: Term) -> object:
    """What tells a term from others; a value stays in its block, so that no other one gets its `id`."""
    if isinstance(term, ir.Constant):
        return ("constant", str(term))
    return ("value", id(term)) if isinstance(term, ir.Value) else term


class Array(ABC):
    """An array of numbers of one kind.

    Attributes:
        shape: Its shape, without lanes and directions.
        kind: `f`, `i` or `b`.
        spread: Over what its entries differ.
        number: A number that no other array has.
        in_place: Whether it lies in memory.
        rolled: Whether its entries can be worked out in loops though they are few: it lies in memory, or all of it is one number.
    """

    in_place = False
    rolled = False

    def __init__(self, shape: tuple[int, ...], kind: str, spread: Spread) -> None:
        self.shape, self.kind, self.spread, self.number = tuple(shape), kind, spread, next(_numbers)

    @property
    def size(self) -> int:
        """Number of entries."""
        return prod(self.shape)

    @property
    def few(self) -> bool:
        """Whether its entries are worked out one by one."""
        return max(self.shape, default=1) <= FEW and self.size <= FEW**2

    @property
    def matrix(self) -> bool:
        """Whether its entries are few, but too many to be written out for each of its uses."""
        return self.few and self.size > UNROLLED

    @abstractmethod
    def entry(self, e: Emitter, index: Index) -> Term:
        """Emits what an entry is.

        Args:
            e: Where to.
            index: Its index.

        Returns:
            The entry.
        """

    def at(self, e: Emitter, index: Index) -> Term:
        """An entry, emitted once in a block.

        Args:
            e: Where to.
            index: Its index.

        Returns:
            The entry.
        """
        direction = _name(e.direction) if self.spread.directions else None
        key = (self.number, direction, *map(_name, index))
        return e.once(key, lambda: self.entry(e, index))


class Entries(Array):
    """An array each entry of which is a term of its own."""

    def __init__(self, terms: np.ndarray, kind: str, spread: Spread = SAME) -> None:
        super().__init__(terms.shape, kind, spread)
        self.terms = terms

    def at(self, e: Emitter, index: Index) -> Term:
        """An entry; where its index is known only when the program runs, chosen among all."""
        if not any(isinstance(i, ir.Value) for i in index):
            return self.terms[index]
        return super().at(e, index)

    def entry(self, e: Emitter, index: Index) -> Term:
        """Chooses an entry among all."""
        place = flat(e, index, self.shape)
        found = self.terms.ravel()[0]
        for k, term in enumerate(self.terms.ravel()[1:], start=1):
            here, other = e.alike("ii", place, k)
            equal = e.builder.icmp_signed("==", here, other)
            yes, no, chosen = e.alike(self.kind + self.kind + "b", term, found, equal)
            found = e.builder.select(chosen, yes, no)
        return found


class Lazy(Array):
    """An array whose entries are worked out where they are asked for."""

    def __init__(self, shape: tuple[int, ...], kind: str, spread: Spread, of: Callable[[Emitter, Index], Term]) -> None:
        super().__init__(shape, kind, spread)
        self.of = of

    def entry(self, e: Emitter, index: Index) -> Term:
        """Emits what an entry is."""
        return self.of(e, index)


class Memory(Array):
    """An array in memory.

    Attributes:
        base: Address of its first entry.
        strides: Distances in numbers between lanes and between directions, where it differs over them.
        cleared: Whether all of it is 0 before the program begins.
    """

    in_place = True

    def __init__(
        self,
        shape: tuple[int, ...],
        kind: str,
        spread: Spread,
        base: Value,
        of_lane: Term,
        of_direction: Term,
        of_entry: Term,
    ) -> None:
        super().__init__(shape, kind, spread)
        self.base, self.of_lane, self.of_direction, self.of_entry = base, of_lane, of_direction, of_entry
        self.cleared = False
        self.rolled = self.matrix

    def _base(self, e: Emitter) -> Value:
        """Address of the first entry, of the direction that is worked out."""
        if not self.spread.directions:
            return self.base
        assert e.direction is not None

        def emit() -> Value:
            place = e.value(e.times(e.direction, self.of_direction), "i")
            return e.builder.gep(self.base, [place], source_etype=DOUBLE)

        return e.once(("base", self.number, _name(e.direction)), emit)

    def _place(self, e: Emitter, index: Index) -> Term:
        """Number of the first lane's entry from the first entry on."""
        return e.times(flat(e, index, self.shape), self.of_entry)

    def entry(self, e: Emitter, index: Index) -> Term:
        """Loads an entry."""
        place, b = self._place(e, index), e.builder
        stored = DOUBLE if self.kind == "f" else INT
        if not self.spread.lanes and not e.is_vector(place):
            found = b.load(self._address(e, place, stored), typ=stored, align=8)
        elif e.is_vector(place) or self.of_lane != 1:
            own = e.times(_lane_numbers(e), self.of_lane) if self.spread.lanes else 0
            found = _gathered(e, self._base(e), e.vector(e.add(place, own), "i"), stored)
        else:
            wide = ir.VectorType(stored, e.lanes)
            found = b.load(self._address(e, place, stored), typ=wide, align=8)
        if self.kind != "b":
            return found
        zero = e.vector(0, "i") if e.is_vector(found) else e.constant(0, "i")
        return b.icmp_signed("!=", found, zero)

    def _address(self, e: Emitter, place: Term, stored: ir.Type) -> Value:
        return e.builder.gep(self._base(e), [e.value(place, "i")], source_etype=stored)

    def store(self, e: Emitter, index: Index, term: Term) -> None:
        """Puts an entry into memory.

        Args:
            e: Where the instructions go.
            index: Its index, the same in all lanes.
            term: The entry.
        """
        if self.cleared and not isinstance(term, ir.Value) and term == 0.0:
            return
        b, place = e.builder, self._place(e, index)
        stored = DOUBLE if self.kind == "f" else INT
        value = e.vector(term, self.kind) if self.spread.lanes else e.value(term, self.kind)
        if self.kind == "b":
            value = b.zext(value, ir.VectorType(INT, e.lanes) if self.spread.lanes else INT)
        if not self.spread.lanes or self.of_lane == 1:
            b.store(value, self._address(e, place, stored), align=8)
            return
        for lane in range(e.lanes):
            one = b.extract_element(value, ir.Constant(ir.IntType(32), lane))
            b.store(one, self._address(e, e.add(place, e.times(self.of_lane, lane)), stored), align=8)


def _lane_numbers(e: Emitter) -> Value:
    return ir.Constant(ir.VectorType(INT, e.lanes), list(range(e.lanes)))


def _gathered(e: Emitter, base: Value, places: Value, stored: ir.Type) -> Value:
    """Numbers at places of their own, one for each lane."""
    b, n, letter = e.builder, e.lanes, "f" if stored == DOUBLE else "i"
    numbers, addresses = ir.VectorType(stored, n), ir.VectorType(POINTER, n)
    mask = ir.Constant(ir.VectorType(ir.IntType(1), n), [1] * n)
    kinds = [addresses, ir.IntType(32), mask.type, numbers]
    fn = e.function(f"llvm.masked.gather.v{n}{letter}64.v{n}p0", numbers, kinds)
    at: Value = b.gep(base, [places], source_etype=stored)
    at.type = addresses  # llvmlite takes it for one address
    return b.call(fn, [at, ir.Constant(ir.IntType(32), 8), mask, ir.Constant(numbers, ir.Undefined)])


def flat(e: Emitter, index: Index, shape: tuple[int, ...]) -> Term:
    """Number of an entry in the order of C.

    Args:
        e: Where the instructions go.
        index: Its index.
        shape: Shape of the array.

    Returns:
        The number.
    """
    found: Term = 0
    for i, n in zip(index, shape, strict=True):
        found = e.add(e.times(found, n), i)
    return found


def all_indices(shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Indices of all entries of an array of few.

    Args:
        shape: Its shape.

    Returns:
        The indices, in the order of C.
    """
    return list(product(*map(range, shape)))


def entries_of(e: Emitter, array: Array) -> Entries:
    """An array with each entry worked out now.

    Args:
        e: Where the instructions go.
        array: An array of few entries that does not differ over directions [any unit].

    Returns:
        Its entries.
    """
    if isinstance(array, Entries):
        return array
    terms = np.empty(array.shape, object)
    for index in all_indices(array.shape):
        terms[index] = array.at(e, index)
    return Entries(terms, array.kind, array.spread)


def each_entry(e: Emitter, shape: tuple[int, ...], do: Callable[[Index], None]) -> None:
    """Does something for every entry of an array: in loops over the leading axes, one by one over the few last entries.

    Args:
        e: Where the instructions go.
        shape: Shape of the array.
        do: What to do for an index.
    """
    _each(e.loop, UNROLLED, shape, do, ())


def each_of_few(e: Emitter, shape: tuple[int, ...], do: Callable[[Index], None]) -> None:
    """Does something for every entry of an array of few, in a loop over each of its axes.

    Args:
        e: Where the instructions go.
        shape: Shape of the array.
        do: What to do for an index.
    """
    _each(e.entries, 1, shape, do, ())


def _each(
    loop: Callable[[int], AbstractContextManager[Value]],
    one_by_one: int,
    shape: tuple[int, ...],
    do: Callable[[Index], None],
    before: Index,
) -> None:
    """Does something for every entry of an array, in loops until so few entries are left that they are done one by one."""
    if prod(shape) <= one_by_one:
        for index in all_indices(shape):
            do((*before, *index))
        return
    with loop(shape[0]) as i:
        _each(loop, one_by_one, shape[1:], do, (*before, i))
