"""Primitives of JAX that move entries of arrays and change none."""

from collections.abc import Callable
from math import prod

import numpy as np
from llvmlite import ir

from rwjax.lowering.arrays import Array, Index, Lazy, Spread
from rwjax.lowering.emitter import Emitter, Term, Unsupported, Value, kind_of
from rwjax.lowering.flow import Equation

Rule = Callable[[Emitter, Equation, list[Array]], list[Array]]


def lazy(equation: Equation, inputs: list[Array], of: Callable[[Emitter, Index], Term]) -> list[Array]:
    """The one result of an equation, worked out entry by entry where it is asked for.

    Args:
        equation: The equation.
        inputs: Its operands [any unit].
        of: What emits an entry.

    Returns:
        The result [any unit].
    """
    spread = Spread()
    for array in inputs:
        spread |= array.spread
    (aval,) = equation.avals
    return [Lazy(aval.shape, kind_of(aval.dtype), spread, of)]


def _broadcast(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, axes = inputs[0], q.params["broadcast_dimensions"]

    def of(e: Emitter, index: Index) -> Term:
        return a.at(e, tuple(0 if n == 1 else index[k] for k, n in zip(axes, a.shape, strict=True)))

    return lazy(q, inputs, of)


def unravelled(e: Emitter, place: Term, shape: tuple[int, ...]) -> Index:
    """Index of an entry by its number in the order of C.

    Args:
        e: Where the instructions go.
        place: The number.
        shape: Shape of the array.

    Returns:
        The index.
    """
    found: list[Term] = []
    for k, n in enumerate(shape):
        below = prod(shape[k + 1 :])
        if n == 1:
            found.append(0)
        elif not isinstance(place, ir.Value):
            found.append(place // below % n)
        else:
            part = place if below == 1 else e.builder.udiv(*e.alike("ii", place, below))
            found.append(part if prod(shape[:k]) == 1 else e.builder.urem(*e.alike("ii", part, n)))
    return tuple(found)


def _split_axis(a: tuple[int, ...], b: tuple[int, ...]) -> bool:
    """Whether two shapes are the same but for axes of length 1."""
    return [n for n in a if n != 1] == [n for n in b if n != 1]


def _reshaped(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    from rwjax.lowering.arrays import flat

    a, shape = inputs[0], q.avals[0].shape

    def of(e: Emitter, index: Index) -> Term:
        if _split_axis(a.shape, shape):
            left = iter([i for i, n in zip(index, shape, strict=True) if n != 1])
            return a.at(e, tuple(0 if n == 1 else next(left) for n in a.shape))
        return a.at(e, unravelled(e, flat(e, index, shape), a.shape))

    return lazy(q, inputs, of)


def _squeezed(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a = inputs[0]
    axes = {axis % max(len(a.shape), 1) for axis in q.params["dimensions"]}

    def of(e: Emitter, index: Index) -> Term:
        left = iter(index)
        return a.at(e, tuple(0 if axis in axes else next(left) for axis in range(len(a.shape))))

    return lazy(q, inputs, of)


def _expanded(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, axes = inputs[0], {*q.params["dimensions"]}
    return lazy(q, inputs, lambda e, index: a.at(e, tuple(i for k, i in enumerate(index) if k not in axes)))


def _sliced(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, first = inputs[0], q.params["start_indices"]
    step = q.params["strides"] or (1,) * len(first)

    def of(e: Emitter, index: Index) -> Term:
        return a.at(e, tuple(e.add(e.times(i, d), k) for i, d, k in zip(index, step, first, strict=True)))

    return lazy(q, inputs, of)


def _transposed(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, axes = inputs[0], q.params["permutation"]
    return lazy(q, inputs, lambda e, index: a.at(e, tuple(index[axes.index(k)] for k in range(len(axes)))))


def _reversed(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, axes = inputs[0], q.params["dimensions"]

    def of(e: Emitter, index: Index) -> Term:
        back = (
            e.add(n - 1, e.times(i, -1)) if k in axes else i
            for k, (i, n) in enumerate(zip(index, a.shape, strict=True))
        )
        return a.at(e, tuple(back))

    return lazy(q, inputs, of)


def choose(e: Emitter, kind: str, which: Value | bool, yes: Term, no: Term) -> Term:
    """One of two terms.

    Args:
        e: Where the instructions go.
        kind: Their kind.
        which: Which one.
        yes: The term where it is true.
        no: The term where it is not.

    Returns:
        The term.
    """
    if not isinstance(which, ir.Value):
        return yes if which else no
    chosen, a, b = e.alike("b" + kind * 2, which, yes, no)
    return e.builder.select(chosen, a, b)


def below(e: Emitter, i: Term, bound: Term) -> Value | bool:
    """Whether one whole number is less than another.

    Args:
        e: Where the instructions go.
        i: The number.
        bound: The other one.

    Returns:
        The answer.
    """
    if not isinstance(i, ir.Value) and not isinstance(bound, ir.Value):
        return bool(i < bound)
    return e.builder.icmp_signed("<", *e.alike("ii", i, bound))


def _joined(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    axis = q.params["dimension"]
    parts = [a for a in inputs if a.size]
    ends = np.cumsum([a.shape[axis] for a in parts]).tolist()

    def of(e: Emitter, index: Index) -> Term:
        i = index[axis]
        found: Term | None = None
        for part, end in zip(parts[::-1], ends[::-1], strict=True):
            begin = end - part.shape[axis]
            if not isinstance(i, ir.Value):
                if begin <= i < end:
                    return part.at(e, (*index[:axis], i - begin, *index[axis + 1 :]))
                continue
            own = e.within(e.add(i, -begin), part.shape[axis] - 1)
            here = part.at(e, (*index[:axis], own, *index[axis + 1 :]))
            found = here if found is None else choose(e, part.kind, below(e, i, end), here, found)
        assert found is not None
        return found

    return lazy(q, inputs, of)


def _stacked(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    axis = q.params["axis"]

    def of(e: Emitter, index: Index) -> Term:
        i, rest = index[axis], (*index[:axis], *index[axis + 1 :])
        if not isinstance(i, ir.Value):
            return inputs[i].at(e, rest)
        found = inputs[-1].at(e, rest)
        for k in range(len(inputs) - 2, -1, -1):
            found = choose(e, inputs[k].kind, below(e, i, k + 1), inputs[k].at(e, rest), found)
        return found

    return lazy(q, inputs, of)


def _split(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, axis, begin, found = inputs[0], q.params["axis"], 0, []
    for aval, size in zip(q.avals, q.params["sizes"], strict=True):

        def of(e: Emitter, index: Index, begin: int = begin) -> Term:
            return a.at(e, (*index[:axis], e.add(index[axis], begin), *index[axis + 1 :]))

        found.append(Lazy(aval.shape, a.kind, a.spread, of))
        begin += size
    return found


def _unstacked(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, axis, found = inputs[0], q.params["axis"], []
    for k, aval in enumerate(q.avals):

        def of(e: Emitter, index: Index, k: int = k) -> Term:
            return a.at(e, (*index[:axis], k, *index[axis:]))

        found.append(Lazy(aval.shape, a.kind, a.spread, of))
    return found


def _counted(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    axis, kind = q.params["dimension"], kind_of(q.avals[0].dtype)

    def of(e: Emitter, index: Index) -> Term:
        i = index[axis]
        if kind == "i":
            return i
        if not isinstance(i, ir.Value):
            return float(i)
        return e.builder.sitofp(i, ir.VectorType(ir.DoubleType(), e.lanes) if e.is_vector(i) else ir.DoubleType())

    return lazy(q, inputs, of)


def _window(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, starts = inputs[0], inputs[1:]

    def of(e: Emitter, index: Index) -> Term:
        begins = [e.within(s.at(e, ()), n - w) for s, n, w in zip(starts, a.shape, q.avals[0].shape, strict=True)]
        return a.at(e, tuple(e.add(i, b) for i, b in zip(index, begins, strict=True)))

    return lazy(q, inputs, of)


def _updated(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, new, starts = inputs[0], inputs[1], inputs[2:]

    def of(e: Emitter, index: Index) -> Term:
        begins = [e.within(s.at(e, ()), n - w) for s, n, w in zip(starts, a.shape, new.shape, strict=True)]
        return _replaced(e, a, new, index, [e.add(i, e.times(b, -1)) for i, b in zip(index, begins, strict=True)])

    return lazy(q, inputs, of)


def _replaced(e: Emitter, a: Array, new: Array, index: Index, own: list[Term]) -> Term:
    """An entry of an array of which a window is replaced; `own` is its index in the window, which may lie outside."""
    inside: Value | bool = True
    for i, n in zip(own, new.shape, strict=True):
        for test in (below(e, i, n), below(e, -1, i)):
            if isinstance(test, ir.Value) and isinstance(inside, ir.Value):
                inside = e.builder.and_(*e.alike("bb", inside, test))
            elif isinstance(test, ir.Value):
                inside = test if inside else False
            else:
                inside = inside if test else False
    if inside is False:
        return a.at(e, index)
    held = new.at(e, tuple(e.within(i, n - 1) for i, n in zip(own, new.shape, strict=True)))
    return held if inside is True else choose(e, a.kind, inside, held, a.at(e, index))


def _gathered(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, places = inputs
    n, sizes = q.params["dimension_numbers"], q.params["slice_sizes"]
    shared = (*n.operand_batching_dims,)
    window = [k for k in range(len(a.shape)) if k not in (*n.collapsed_slice_dims, *shared)]

    def of(e: Emitter, index: Index) -> Term:
        batch = [i for k, i in enumerate(index) if k not in n.offset_dims]
        place: list[Term] = [0] * len(a.shape)
        for k, axis in enumerate(n.start_index_map):
            place[axis] = e.within(places.at(e, (*batch, k)), a.shape[axis] - sizes[axis])
        for axis, of_places in zip(shared, n.start_indices_batching_dims, strict=True):
            place[axis] = batch[of_places]
        for axis, k in zip(window, n.offset_dims, strict=True):
            place[axis] = e.add(place[axis], index[k])
        return a.at(e, tuple(place))

    return lazy(q, inputs, of)


def _scattered(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, places, new = inputs
    n = q.params["dimension_numbers"]
    window = [k for k in range(len(a.shape)) if k not in n.inserted_window_dims]
    if n.operand_batching_dims or places.shape != (len(n.scatter_dims_to_operand_dims),):
        raise Unsupported("scatter of several windows")

    def of(e: Emitter, index: Index) -> Term:
        place: list[Term] = [0] * len(a.shape)
        for k, axis in enumerate(n.scatter_dims_to_operand_dims):
            place[axis] = places.at(e, (k,))
        own = [e.add(i, e.times(p, -1)) for i, p in zip(index, place, strict=True)]
        block = Lazy(
            tuple(new.shape[n.update_window_dims[window.index(k)]] if k in window else 1 for k in range(len(a.shape))),
            a.kind,
            new.spread,
            lambda e, at: new.at(e, tuple(at[k] for k in window)),
        )
        return _replaced(e, a, block, index, own)

    return lazy(q, inputs, of)


def _padded(e: Emitter, q: Equation, inputs: list[Array]) -> list[Array]:
    a, filling = inputs
    if any(interior for _, _, interior in q.params["padding_config"]):
        raise Unsupported("pad between entries")
    low = [int(first) for first, _, _ in q.params["padding_config"]]

    def of(e: Emitter, index: Index) -> Term:
        around = Lazy(q.avals[0].shape, a.kind, filling.spread, lambda e, _: filling.at(e, ()))
        return _replaced(e, around, a, index, [e.add(i, -k) for i, k in zip(index, low, strict=True)])

    return lazy(q, inputs, of)


RULES: dict[str, Rule] = {
    "broadcast_in_dim": _broadcast,
    "reshape": _reshaped,
    "squeeze": _squeezed,
    "expand_dims": _expanded,
    "slice": _sliced,
    "transpose": _transposed,
    "rev": _reversed,
    "concatenate": _joined,
    "stack": _stacked,
    "split": _split,
    "unstack": _unstacked,
    "iota": _counted,
    "dynamic_slice": _window,
    "dynamic_update_slice": _updated,
    "gather": _gathered,
    "scatter": _scattered,
    "pad": _padded,
}
"""Rule of each primitive by its name."""
