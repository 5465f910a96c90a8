"""Loops, sums and products of a jaxpr as instructions."""

from collections.abc import Callable, Sequence
from math import prod

import numpy as np
from llvmlite import ir

from rwjax.lowering import elementwise, movement
from rwjax.lowering.arrays import UNROLLED, Array, Entries, Index, Lazy, Memory, Spread, entries_of
from rwjax.lowering.emitter import Emitter, Loop, Term, Unsupported, Value, kind_of
from rwjax.lowering.flow import Equation, Program, carried_spreads, flattened, invariant, result_spreads
from rwjax.lowering.lower import LOOKED_UP, Lowering, Rule, Unset, any_lane


def _ready(self: Lowering, arrays: Sequence[Array], body: Program, inputs: Sequence) -> list[Array]:
    """What stays the same in a loop: in memory where it depends on directions, is looked up or is multiplied as a matrix in the loop."""
    sought = {id(q.inputs[0]) for q in body.equations if q.name in LOOKED_UP}
    multiplied = {id(v) for q in body.equations if q.name == "dot_general" for v in q.inputs}
    found = []
    for v, array in zip(inputs, arrays, strict=True):
        moves = array.spread.directions or (id(v) in sought and not array.few)
        if array.matrix and id(v) in multiplied and not self.again_and_again:
            found.append(self.placed(array))
        else:
            found.append(self.in_memory(array) if moves else array)
    return found


MOST_HANDED = 144
"""Entries of an array that a loop hands on from turn to turn at most, each a value of its own."""


def _sliced(array: Array, turn: Term) -> Array:
    """What a turn of a loop gets of an array."""
    return Lazy(array.shape[1:], array.kind, array.spread, lambda e, index: array.at(e, (turn, *index)))


class _Handed:
    """What a loop hands on from turn to turn: in registers, or in memory where it depends on directions.

    A loop of few turns has `matrices` in memory as well, and works them out in loops.
    """

    def __init__(
        self, lowering: Lowering, first: Sequence[Array], spread: Sequence[Spread], matrices: bool = False
    ) -> None:
        self.lowering, self.spread, self.matrices, e = lowering, spread, matrices, lowering.e
        self.places: dict[int, Memory] = {}
        self.shapes, self.kinds = [a.shape for a in first], [a.kind for a in first]
        values, stores = [], []
        for k, (array, s) in enumerate(zip(first, spread, strict=True)):
            if s.directions or (matrices and array.matrix):
                self.places[k] = lowering.allocate(array.shape, array.kind, s)
                stores.append((array, self.places[k]))
            elif array.size > MOST_HANDED:
                raise Unsupported("a loop that hands on a long array")
            else:
                values += self._values(array, s)
        if stores:
            lowering.put(stores)
        self.first = values
        self.e = e

    def _values(self, array: Array, s: Spread) -> list[Value]:
        e, terms = self.lowering.e, entries_of(self.lowering.e, array).terms.ravel()
        return [e.vector(t, array.kind) if s.lanes else e.value(t, array.kind) for t in terms]

    def arrays(self, values: Sequence[Value]) -> list[Array]:
        """What is handed on as arrays."""
        left, found = iter(values), []
        for k, (shape, kind, s) in enumerate(zip(self.shapes, self.kinds, self.spread, strict=True)):
            if k in self.places:
                found.append(self.places[k])
                continue
            terms = np.empty(prod(shape), object)
            for j in range(len(terms)):
                terms[j] = next(left)
            found.append(Entries(terms.reshape(shape), kind, s))
        return found

    def ended(self, arrays: Sequence[Array], more: Sequence[tuple[Array, Memory]], before: Index = ()) -> list[Value]:
        """Values at the end of a turn; what depends on directions is written, together with what else the turn gives out.

        Args:
            arrays: What is handed on.
            more: What else is written.
            before: Index of the turn in the places of that.

        Returns:
            The values in registers.
        """
        lowering = self.lowering
        values = [v for k, a in enumerate(arrays) if k not in self.places for v in self._values(a, self.spread[k])]
        lowering.put([(a, place) for a, place in more if not place.spread.directions], before)
        rolled = {k: place for k, place in self.places.items() if self.matrices and place.matrix}
        matrices = [(lowering.copied(arrays[k]), place) for k, place in rolled.items()]
        stores = [
            (arrays[k], place, index, index)
            for k, place in self.places.items()
            if k not in rolled
            for index in np.ndindex(*place.shape)
        ]
        for a, place in more:
            if place.spread.directions and a.few:
                stores += [(a, place, index, (*before, *index)) for index in np.ndindex(*a.shape)]
            elif place.spread.directions:
                lowering.put([(a, place)], before)
        lowering.by_direction(stores)
        lowering.put(matrices)
        return values


def _scan(self: Lowering, q: Equation, inputs: list[Array]) -> list[Array]:
    p, e, body = q.params, self.e, flattened(q.params["jaxpr"])
    n, m = p["num_consts"], p["num_carry"]
    if p["length"] == 0:
        nothing = (Entries(np.empty(aval.shape, object), kind_of(aval.dtype)) for aval in q.avals[m:])
        return [*inputs[n : n + m], *nothing]
    outer, self.again_and_again = self.again_and_again, self.again_and_again or p["length"] > UNROLLED
    inputs = _ready(self, inputs[:n], body, body.inputs[:n]) + inputs[n:]
    consts, first, xs = inputs[:n], inputs[n : n + m], inputs[n + m :]
    xs = [self.in_memory(a) if a.spread.directions else a for a in xs]
    spread = carried_spreads(body, [a.spread for a in consts], [a.spread for a in first], [a.spread for a in xs])
    of_results = result_spreads(body, [*(a.spread for a in consts), *spread, *(a.spread for a in xs)])
    known = {id(v): a for v, a in zip(body.inputs, consts, strict=False)}
    still, moving = invariant(body, body.inputs[n:])
    self.all_of(still, known)
    handed = _Handed(self, first, spread, matrices=not self.again_and_again)
    places = [self.room(v, aval, s) for v, aval, s in zip(q.outputs[m:], q.avals[m:], of_results[m:], strict=True)]
    loop = Loop(e, p["length"], handed.first)
    turn = loop.turn if not p["reverse"] else e.builder.sub(e.constant(p["length"] - 1, "i"), loop.turn)
    given = [_sliced(a, turn) for a in xs]
    given = [entries_of(e, a) if a.few and not a.spread.directions else a for a in given]
    known |= {id(v): a for v, a in zip(body.inputs[n:], [*handed.arrays(loop.carried), *given], strict=True)}
    self.all_of(moving, known)
    found = [self.read(v, known) for v in body.outputs]
    values = handed.ended(found[:m], list(zip(found[m:], places, strict=True)), (turn,))
    self.again_and_again = outer
    return [*handed.arrays(loop.close(values)), *places]


def _while(self: Lowering, q: Equation, inputs: list[Array]) -> list[Array]:
    """A loop that goes on while any lane wants to; the others keep what they have."""
    p, e = q.params, self.e
    n, m = p["cond_nconsts"], p["body_nconsts"]
    test, body = flattened(p["cond_jaxpr"]), flattened(p["body_jaxpr"])
    of_test, consts, first = inputs[:n], inputs[n : n + m], inputs[n + m :]
    consts = _ready(self, consts, body, body.inputs[:m])
    spread = carried_spreads(body, [a.spread for a in consts], [a.spread for a in first], [])
    wants = result_spreads(test, [*(a.spread for a in of_test), *spread])[0]
    spread = [s | wants for s in spread]
    if wants.directions or any(s.directions for s in spread):
        raise Unsupported("the derivative of a loop without a fixed end")
    long = {k: by for k, a in enumerate(first) if not (a.few and wants.lanes) and (by := _updating(body, m, k))}
    if long and wants.lanes:
        raise Unsupported("a long array in a loop whose end differs from run to run")
    rooms = {k: self.room(q.outputs[k], q.avals[k], spread[k]) for k in long}
    self.put([(first[k], place) for k, place in rooms.items() if not isinstance(first[k], Unset)])
    short = [k for k in range(len(first)) if k not in long]
    handed = _Handed(self, [first[k] for k in short], [spread[k] for k in short])

    def whole(values: Sequence[Value]) -> list[Array]:
        found: dict[int, Array] = dict(zip(short, handed.arrays(values), strict=True)) | rooms
        return [found[k] for k in range(len(first))]

    def wanted(values: Sequence[Value]) -> Value:
        return e.value(self.run(test, [*of_test, *whole(values)])[0].at(e, ()), "b")

    most = e.builder.select(any_lane(e, wanted(handed.first)), e.constant(2**62, "i"), e.constant(0, "i"))
    loop = Loop(e, most, handed.first)
    mine = wanted(loop.carried)
    known = {id(v): a for v, a in zip(body.inputs, [*consts, *whole(loop.carried)], strict=True)}
    outer, self.again_and_again = self.again_and_again, True
    self.all_of(body.equations, known)
    self.again_and_again = outer
    for k, place in rooms.items():
        _, new, start, *_ = (self.read(v, known) for v in long[k].inputs)
        self.put([(_sliced(new, 0), place)], (e.within(start.at(e, ()), place.shape[0] - 1),))
    after = handed.ended([self.read(body.outputs[k], known) for k in short], [])
    kept = [_kept(e, mine, new, old) for new, old in zip(after, loop.carried, strict=True)]
    return whole(loop.close(kept, any_lane(e, wanted(kept))))


def _updating(body: Program, consts: int, k: int) -> Equation | None:
    """The equation by which a loop writes one row of an array and leaves the others; None where it changes it otherwise."""
    held = body.inputs[consts + k]
    found = next((q for q in body.equations if any(v is body.outputs[k] for v in q.outputs)), None)
    users = [q for q in body.equations if any(v is held for v in q.inputs)]
    if found is None or found.name != "dynamic_update_slice" or found.inputs[0] is not held or users != [found]:
        return None
    return found


def _kept(e: Emitter, mine: Value, new: Value, old: Value) -> Value:
    """What a lane hands on: the new value where it takes this turn."""
    if not isinstance(mine.type, ir.VectorType):
        return new
    return e.builder.select(mine, new, old)


def _sum(name: str) -> Callable:
    def rule(self: Lowering, q: Equation, inputs: list[Array]) -> list[Array]:
        a, axes = inputs[0], q.params["axes"]
        of = elementwise.Operation(name, a.kind * 2, a.kind, {})
        shape = tuple(a.shape[k] for k in axes)

        def full(index: Index, inner: Index) -> Index:
            left, own = iter(index), dict(zip(axes, inner, strict=True))
            return tuple(own[k] if k in own else next(left) for k in range(len(a.shape)))

        def entry(e: Emitter, index: Index) -> Term:
            if prod(shape) <= 100:
                terms = [a.at(e, full(index, inner)) for inner in np.ndindex(*shape)]
                found = terms[0]
                for term in terms[1:]:
                    found = elementwise.emit(e, of, [found, term])
                return found
            if len(shape) != 1:
                raise Unsupported("a sum over several long axes")
            first = a.at(e, full(index, (0,)))
            loop = Loop(e, shape[0] - 1, [e.vector(first, a.kind) if a.spread.lanes else e.value(first, a.kind)])
            term = a.at(e, full(index, (e.add(loop.turn, 1),)))
            return loop.close([elementwise.emit(e, of, [loop.carried[0], term])])[0]

        return movement.lazy(q, inputs, entry)

    return rule


def _running(self: Lowering, q: Equation, inputs: list[Array]) -> list[Array]:
    a, e = inputs[0], self.e
    if len(a.shape) != 1 or q.params["axis"] != 0:
        raise Unsupported("a running sum over one of several axes")
    place = self.allocate(a.shape, a.kind, a.spread)
    n = a.shape[0]

    def whole() -> None:
        zero = e.vector(0.0, a.kind) if a.spread.lanes else e.constant(0.0, a.kind)
        loop = Loop(e, n, [zero])
        turn = loop.turn if not q.params["reverse"] else e.builder.sub(e.constant(n - 1, "i"), loop.turn)
        found = elementwise.emit(
            e, elementwise.Operation("add", a.kind * 2, a.kind, {}), [loop.carried[0], a.at(e, (turn,))]
        )
        place.store(e, (turn,), found)
        loop.close([found])

    if a.spread.directions:
        with e.loop(self.directions) as d:
            outer, e.direction = e.direction, d
            whole()
            e.direction = outer
    else:
        whole()
    return [place]


def _product(self: Lowering, q: Equation, inputs: list[Array]) -> list[Array]:
    a, b = inputs
    (of_a, of_b), (shared_a, shared_b) = q.params["dimension_numbers"]
    own_a = [k for k in range(len(a.shape)) if k not in (*of_a, *shared_a)]
    own_b = [k for k in range(len(b.shape)) if k not in (*of_b, *shared_b)]
    inner = [a.shape[k] for k in of_a]
    if prod(inner) > 100:
        raise Unsupported("a product over a long axis")
    if not self.again_and_again:
        a, b = (self.placed(m) if m.matrix else m for m in inputs)

    def full(
        own: list[int], of: Sequence[int], shared: Sequence[int], mine: Index, batch: Index, j: Index, rank: int
    ) -> Index:
        place = (
            dict(zip(own, mine, strict=True)) | dict(zip(of, j, strict=True)) | dict(zip(shared, batch, strict=True))
        )
        return tuple(place[k] for k in range(rank))

    def entry(e: Emitter, index: Index) -> Term:
        batch, rest = index[: len(shared_a)], index[len(shared_a) :]
        found: Term | None = None
        for j in np.ndindex(*inner):
            left = a.at(e, full(own_a, of_a, shared_a, rest[: len(own_a)], batch, j, len(a.shape)))
            right = b.at(e, full(own_b, of_b, shared_b, rest[len(own_a) :], batch, j, len(b.shape)))
            term = elementwise.emit(e, elementwise.Operation("mul", "ff", "f", {}), [left, right])
            found = (
                term
                if found is None
                else elementwise.emit(e, elementwise.Operation("add", "ff", "f", {}), [found, term])
            )
        return 0.0 if found is None else found

    found = movement.lazy(q, inputs, entry)
    if found[0].matrix and a.matrix and b.matrix and not self.again_and_again:
        found[0].rolled = True
        return [self.placed(found[0])]
    return found


def _unset(self: Lowering, q: Equation, inputs: list[Array]) -> list[Array]:
    (aval,) = q.avals
    return [Unset(aval.shape, kind_of(aval.dtype), Spread(), lambda e, index: 0.0)]


def _first_extreme(sign: str) -> Callable:
    def rule(self: Lowering, q: Equation, inputs: list[Array]) -> list[Array]:
        a, (axis,) = inputs[0], q.params["axes"]

        def entry(e: Emitter, index: Index) -> Term:
            best, place = a.at(e, (*index[:axis], 0, *index[axis:])), 0
            for k in range(1, a.shape[axis]):
                term = a.at(e, (*index[:axis], k, *index[axis:]))
                better = elementwise.emit(e, elementwise.Operation(sign, a.kind * 2, "b", {}), [term, best])
                best, place = movement.choose(e, a.kind, better, term, best), movement.choose(e, "i", better, k, place)
            return place

        if a.shape[axis] > 100:
            raise Unsupported("the place of an extreme along a long axis")
        return movement.lazy(q, inputs, entry)

    return rule


LOOPS: dict[str, Rule] = {
    "scan": _scan,
    "while": _while,
    "empty": _unset,
    "cumsum": _running,
    "dot_general": _product,
    "reduce_sum": _sum("add"),
    "reduce_min": _sum("min"),
    "reduce_max": _sum("max"),
    "reduce_or": _sum("or"),
    "reduce_and": _sum("and"),
    "argmax": _first_extreme("gt"),
    "argmin": _first_extreme("lt"),
}
"""Rule of each primitive that is a loop, a sum or a product, by its name."""
