"""Equations of a jaxpr as instructions, and what is kept in memory; what single primitives do stands in other modules.

Arrays of few entries stand in registers, each entry a value of its own. All others are worked out entry by entry where they are
asked for, or lie in memory: what a loop gives out, a running sum, and what is looked up at places that differ from run to run.
What depends on a direction of a derivative is worked out in a loop over the directions, after all values of the same turn.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from jax.extend.core import Literal
from llvmlite import ir

from rwjax.lowering import elementwise, movement
from rwjax.lowering.arrays import (
    Array,
    Entries,
    Index,
    Lazy,
    Memory,
    Spread,
    all_indices,
    each_entry,
    each_of_few,
    entries_of,
)
from rwjax.lowering.emitter import Emitter, Term, Unsupported, Value, kind_of
from rwjax.lowering.flow import ABSENT, Constant, Equation, Program

LOOKED_UP = ("gather", "dynamic_slice")


class Unset(Lazy):
    """An array whose entries nobody has given yet."""


class Lowering:
    """A program that is being lowered.

    Attributes:
        e: Where its instructions go.
        directions: Number of directions of a derivative, when the program runs.
        allocate: Makes room for an array of a shape, a kind and a spread.
        constant: Puts an array of numbers into memory.
        rules: Rule of each primitive that is more than an entry of its operands, by its name.
        results: Where results of the program go, by the `id` of their names.
        again_and_again: Whether it stands in a loop of many turns, in which matrices are written out: that is faster.
    """

    def __init__(
        self,
        e: Emitter,
        directions: Value,
        allocate: Callable[[tuple[int, ...], str, Spread], Memory],
        constant: Callable[[np.ndarray], Array],
        rules: "Mapping[str, Rule]",
    ) -> None:
        self.e, self.directions, self.allocate, self.constant, self.rules = e, directions, allocate, constant, rules
        self.results: dict[int, Memory] = {}
        self.again_and_again = False

    def run(self, program: Program, arguments: Sequence[Array]) -> list[Array]:
        """Emits a program.

        Args:
            program: The program.
            arguments: Its arguments [any unit].

        Returns:
            Its results [any unit].
        """
        known = {id(v): a for v, a in zip(program.inputs, arguments, strict=True)}
        self.all_of(program.equations, known)
        return [self.read(v, known) for v in program.outputs]

    def all_of(self, equations: Sequence[Equation], known: dict[int, Array]) -> None:
        """Emits equations.

        Args:
            equations: The equations, in order.
            known: What the variables stand for, by the `id` of their names; the results are added.
        """
        for equation in equations:
            inputs = [self.read(v, known) for v in equation.inputs]
            for v, array in zip(equation.outputs, self.one(equation, inputs), strict=True):
                known[id(v)] = array

    def read(self, v: Any, known: dict[int, Array]) -> Array:
        """What a variable, a literal or a constant stands for.

        Args:
            v: Any of them.
            known: What the variables stand for, by the `id` of their names.

        Returns:
            The array [any unit].
        """
        if isinstance(v, (Literal, Constant)):
            value = np.asarray(v.val if isinstance(v, Literal) else v.value)
            if value.size == 1 or value.size <= 16:
                terms = np.empty(value.shape, object)
                for index in np.ndindex(value.shape):
                    terms[index] = value[index].item()
                return Entries(terms, kind_of(value.dtype))
            return self.constant(value)
        if v is ABSENT:
            return Unset((), "f", Spread(), lambda e, index: 0.0)
        return known[id(v)]

    def one(self, equation: Equation, inputs: list[Array]) -> list[Array]:
        """Emits one equation; what has few entries is worked out at once.

        Args:
            equation: The equation.
            inputs: Its operands [any unit].

        Returns:
            Its results [any unit].
        """
        for aval in equation.avals:
            if kind_of(aval.dtype) == "?":
                raise Unsupported(f"{equation.name} of {aval.dtype}")
        if equation.name in LOOKED_UP:
            inputs = self._looked_up(equation, inputs)
        if equation.name in self.rules:
            found = self.rules[equation.name](self, equation, inputs)
        elif equation.name in movement.RULES:
            found = movement.RULES[equation.name](self.e, equation, inputs)
        elif elementwise.is_elementwise(equation.name):
            found = self._elementwise(equation, inputs)
        else:
            raise Unsupported(f"the primitive `{equation.name}`")
        in_loops = equation.name not in self.rules and not self.again_and_again
        if in_loops and all(a.matrix for a in found) and _rolled(inputs):
            return [self._rolled_out(a, any(b.matrix for b in inputs)) for a in found]
        return [entries_of(self.e, a) if a.few and not a.spread.directions and not a.in_place else a for a in found]

    def _rolled_out(self, a: Array, of_matrices: bool) -> Array:
        """A matrix whose entries are worked out in loops: now, unless all of it is one number."""
        a.rolled = True
        return self.placed(a) if of_matrices else a

    def _looked_up(self, equation: Equation, inputs: list[Array]) -> list[Array]:
        """Operands of a look-up, the array in memory where its places differ from run to run."""
        a, *places = inputs
        if any(p.spread.lanes for p in places):
            a = self.in_memory(a)
        return [a, *places]

    def _elementwise(self, equation: Equation, inputs: list[Array]) -> list[Array]:
        kinds = "".join(a.kind for a in inputs)
        of = elementwise.Operation(equation.name, kinds, kind_of(equation.avals[0].dtype), equation.params)

        def own(a: Array, index: Index) -> Index:
            """Index in an operand: 0 along an axis of length 1, none where it is a single number."""
            return tuple(0 if n == 1 else i for i, n in zip(index, a.shape, strict=True)) if a.shape else ()

        def entry(e: Emitter, index: Index) -> Term:
            return elementwise.emit(e, of, [a.at(e, own(a, index)) for a in inputs])

        return movement.lazy(equation, inputs, entry)

    def ready(self, equations: Sequence[Equation], known: dict[int, Array]) -> None:
        """Puts into memory, before a loop over the lanes, the long arrays that equations in it take.

        Args:
            equations: The equations in the loop.
            known: What the variables stand for before it.
        """
        for v in (v for q in equations for v in q.inputs if id(v) in known):
            if not known[id(v)].few and not isinstance(known[id(v)], Unset):
                known[id(v)] = self.in_memory(known[id(v)])

    def in_memory(self, array: Array) -> Array:
        """An array in memory, put there where it does not yet lie there.

        Args:
            array: The array [any unit].

        Returns:
            The same in memory [any unit]; one of few entries stays what it is, unless it differs over directions.
        """
        if array.in_place or (array.few and not array.spread.directions and isinstance(array, Entries)):
            return array
        return self.placed(array)

    def placed(self, array: Array) -> Array:
        """An array in memory, however few entries it has; put there once in a block.

        Args:
            array: The array [any unit].

        Returns:
            The same in memory [any unit].
        """
        return array if array.in_place else self.e.once(("memory", array.number), lambda: self.copied(array))

    def copied(self, array: Array) -> Memory:
        """An array in memory where nothing else goes.

        Args:
            array: The array [any unit].

        Returns:
            Its copy [any unit].
        """
        place = self.allocate(array.shape, array.kind, array.spread)
        self.put([(array, place)])
        return place

    def room(self, v: Any, aval: Any, spread: Spread) -> Memory:
        """Where a variable goes that lies in memory: where the program's result goes if it is one.

        Args:
            v: Name of the variable.
            aval: Its shape and type.
            spread: Over what it differs.

        Returns:
            The place.
        """
        return self.results.get(id(v)) or self.allocate(aval.shape, kind_of(aval.dtype), spread)

    def put(self, pairs: Sequence[tuple[Array, Memory]], before: Index = ()) -> None:
        """Writes arrays into memory: entries of few at once, all others of one shape in one loop.

        Args:
            pairs: Arrays and where they go [any unit].
            before: Index of axes that the places have in front of those of the arrays.
        """
        for shape, rolled in dict.fromkeys((a.shape, a.rolled) for a, _ in pairs):
            alike = [(a, place) for a, place in pairs if (a.shape, a.rolled) == (shape, rolled)]
            if alike[0][0].few and not rolled:
                self._put_at(alike, all_indices(shape), before)
            else:
                loops = each_of_few if rolled else each_entry
                loops(self.e, shape, lambda index, alike=alike: self._put_at(alike, [index], before))

    def _put_at(self, pairs: Sequence[tuple[Array, Memory]], indices: Sequence[Index], before: Index) -> None:
        each = [(a, place, index, (*before, *index)) for a, place in pairs for index in indices]
        same = [one for one in each if not one[1].spread.directions]
        terms = [a.at(self.e, index) for a, _, index, _ in same]
        for (_, place, _, at), term in zip(same, terms, strict=True):
            place.store(self.e, at, term)
        self.by_direction([one for one in each if one[1].spread.directions])

    def by_direction(self, stores: Sequence[tuple[Array, Memory, Index, Index]]) -> None:
        """Works out entries for every direction, all of them before the first one is written.

        Args:
            stores: Each an array [any unit], where it goes, the index of the entry and the index of its place.
        """
        if not stores:
            return
        with self.e.loop(self.directions) as d:
            outer, self.e.direction = self.e.direction, d
            terms = [a.at(self.e, index) for a, _, index, _ in stores]
            for (_, place, _, at), term in zip(stores, terms, strict=True):
                place.store(self.e, at, term)
            self.e.direction = outer


def _rolled(inputs: Sequence[Array]) -> bool:
    """Whether a matrix made of arrays entry by entry can be worked out in loops."""
    return bool(inputs) and all(a.rolled if a.matrix else a.size == 1 for a in inputs)


Rule = Callable[[Lowering, Equation, list[Array]], list[Array]]
"""What emits an equation: from its operands to its results."""


def any_lane(e: Emitter, found: Value) -> Value:
    """Whether a truth value holds in any lane.

    Args:
        e: Where the instructions go.
        found: The truth value.

    Returns:
        The same for all lanes.
    """
    if not isinstance(found.type, ir.VectorType):
        return found
    fn = e.function(f"llvm.vector.reduce.or.v{e.lanes}i1", ir.IntType(1), [found.type])
    return e.builder.call(fn, [found])
