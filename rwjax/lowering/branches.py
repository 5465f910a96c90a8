"""Choices of a jaxpr as branches: what no lane asks for is not worked out."""

from collections.abc import Iterator, Sequence

import numpy as np

from rwjax.lowering.arrays import Array, Entries, Lazy, Spread
from rwjax.lowering.elementwise import Operation, emit
from rwjax.lowering.emitter import Emitter, Term, Unsupported, Value, kind_of
from rwjax.lowering.flow import Equation, Program, flattened, result_spreads
from rwjax.lowering.lower import Lowering, any_lane


def _cond(self: Lowering, q: Equation, inputs: list[Array]) -> list[Array]:
    """Both sides of a choice, each worked out where a lane takes it, and for every lane the results of its own side."""
    e, (which, *given) = self.e, inputs
    if len(q.params["branches"]) != 2:
        raise Unsupported("a choice among more than two")
    if which.spread.directions:
        raise Unsupported("a choice that differs over directions")
    one = Operation("ne", "ii", "b", {})
    yes = e.value(emit(e, one, [which.at(e, ()), 0]), "b")
    no = emit(e, Operation("not", "b", "b", {}), [yes])
    on_no, on_yes = (
        _side(self, flattened(branch), given, q, e.value(wanted, "b"))
        for branch, wanted in zip(q.params["branches"], (no, yes), strict=True)
    )
    return [_chosen(e, yes, *sides) for sides in zip(on_no, on_yes, strict=True)]


def _side(self: Lowering, branch: Program, given: Sequence[Array], q: Equation, wanted: Value) -> list[Array]:
    """Results of one side; they have no meaning where no lane wants it."""
    known = {id(v): a for v, a in zip(branch.inputs, given, strict=True)}
    if not branch.equations:
        return [self.read(v, known) for v in branch.outputs]
    e, spreads = self.e, result_spreads(branch, [a.spread for a in given])
    kinds = [(aval.shape, kind_of(aval.dtype), s) for aval, s in zip(q.avals, spreads, strict=True)]
    places = {k: self.allocate(*kind) for k, kind in enumerate(kinds) if kind[2].directions}
    with e.branch(any_lane(e, wanted)) as handed:
        self.all_of(branch.equations, known)
        found = [self.read(v, known) for v in branch.outputs]
        self.put([(found[k], place) for k, place in places.items()])
        for a, (shape, kind, spread) in zip(found, kinds, strict=True):
            if not spread.directions:
                handed += _values(e, a, shape, kind, spread)
    left = iter(handed)
    return [places[k] if k in places else _entries(*kind, left) for k, kind in enumerate(kinds)]


def _values(e: Emitter, a: Array, shape: tuple[int, ...], kind: str, spread: Spread) -> list[Value]:
    """The entries of an array as values of LLVM."""
    if not a.few:
        raise Unsupported("a choice between long arrays")
    terms = [a.at(e, index) for index in np.ndindex(shape)]
    return [e.vector(term, kind) if spread.lanes else e.value(term, kind) for term in terms]


def _entries(shape: tuple[int, ...], kind: str, spread: Spread, left: Iterator[Value]) -> Array:
    terms = np.empty(shape, object)
    for index in np.ndindex(shape):
        terms[index] = next(left)
    return Entries(terms, kind, spread)


def _chosen(e: Emitter, yes: Value, on_no: Array, on_yes: Array) -> Array:
    """Entries of one of two arrays, lane by lane."""
    of = Operation("select_n", "b" + 2 * on_no.kind, on_no.kind, {})
    spread = on_no.spread | on_yes.spread | Spread(lanes=e.is_vector(yes))

    def entry(e: Emitter, index: tuple[Term, ...]) -> Term:
        return emit(e, of, [yes, on_no.at(e, index), on_yes.at(e, index)])

    return Lazy(on_no.shape, on_no.kind, spread, entry)


BRANCHES = {"cond": _cond}
"""Rule of a choice that is not known before the program runs."""
