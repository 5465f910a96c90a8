"""A jaxpr worked out by numpy: for numbers that are needed once, for which to make machine code would take longer."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from jax.extend.core import ClosedJaxpr, Literal

from rwjax.lowering.emitter import Unsupported
from rwjax.lowering.flow import Constant, Equation, flattened


def worked_out(closed: ClosedJaxpr, arguments: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Results of a jaxpr.

    Args:
        closed: The jaxpr.
        arguments: Its arguments [any unit].

    Returns:
        Its results [any unit].

    Raises:
        Unsupported: It holds a primitive that is not worked out here.
    """
    program = flattened(closed)
    known = {id(v): np.asarray(a) for v, a in zip(program.inputs, arguments, strict=True)}

    def read(v: Any) -> np.ndarray:
        if isinstance(v, Literal | Constant):
            return np.asarray(v.val if isinstance(v, Literal) else v.value)
        return known[id(v)]

    with np.errstate(all="ignore"):
        for q in program.equations:
            if q.name not in RULES:
                raise Unsupported(f"the primitive `{q.name}`")
            found = RULES[q.name](q, *map(read, q.inputs))
            known |= zip(map(id, q.outputs), found if isinstance(found, list) else [found], strict=True)
    return [read(v) for v in program.outputs]


def _elementwise(function: Callable[..., Any]) -> Callable[..., np.ndarray]:
    def rule(q: Equation, *operands: np.ndarray) -> np.ndarray:
        return np.asarray(function(*operands), q.avals[0].dtype)

    return rule


def _broadcast(q: Equation, a: np.ndarray) -> np.ndarray:
    shape = np.ones(len(q.avals[0].shape), int)
    shape[list(q.params["broadcast_dimensions"])] = a.shape
    return np.broadcast_to(a.reshape(shape), q.avals[0].shape)


def _sliced(q: Equation, a: np.ndarray) -> np.ndarray:
    p = q.params
    step = p["strides"] or (1,) * a.ndim
    return a[tuple(map(slice, p["start_indices"], p["limit_indices"], step))]


def _counted(q: Equation) -> np.ndarray:
    (aval,), axis = q.avals, q.params["dimension"]
    along = np.arange(aval.shape[axis], dtype=aval.dtype)
    return np.broadcast_to(along.reshape([-1 if k == axis else 1 for k in range(len(aval.shape))]), aval.shape)


def _split(q: Equation, a: np.ndarray) -> list[np.ndarray]:
    return np.split(a, np.cumsum(q.params["sizes"])[:-1], axis=q.params["axis"])


def _reshaped(q: Equation, a: np.ndarray) -> np.ndarray:
    if q.params["dimensions"] is not None:
        raise Unsupported("a reshape that also transposes")
    return a.reshape(q.avals[0].shape)


def _squeezed(q: Equation, a: np.ndarray) -> np.ndarray:
    return a.reshape(q.avals[0].shape)


def _transposed(q: Equation, a: np.ndarray) -> np.ndarray:
    return a.transpose(q.params["permutation"])


def _joined(q: Equation, *operands: np.ndarray) -> np.ndarray:
    return np.concatenate(operands, axis=q.params["dimension"])


def _stacked(q: Equation, *operands: np.ndarray) -> np.ndarray:
    return np.stack(operands, axis=q.params["axis"])


def _selected(q: Equation, which: np.ndarray, *cases: np.ndarray) -> np.ndarray:
    return np.asarray(np.choose(np.broadcast_to(which, cases[0].shape).astype(int), cases))


def _whole_power(q: Equation, a: np.ndarray) -> np.ndarray:
    return np.asarray(a ** q.params["y"])


RULES: dict[str, Callable[..., Any]] = {
    **{name: _elementwise(getattr(np, name)) for name in ("sign", "exp", "log", "log1p", "expm1", "sin", "cos", "tan")},
    **{name: _elementwise(getattr(np, name)) for name in ("tanh", "sqrt", "floor", "ceil", "square")},
    **dict.fromkeys(("add", "add_any"), _elementwise(np.add)),
    **dict.fromkeys(("convert_element_type", "copy"), _elementwise(np.asarray)),
    "squeeze": _squeezed,
    "reshape": _reshaped,
    "sub": _elementwise(np.subtract),
    "mul": _elementwise(np.multiply),
    "div": _elementwise(np.true_divide),
    "pow": _elementwise(np.power),
    "max": _elementwise(np.maximum),
    "min": _elementwise(np.minimum),
    "neg": _elementwise(np.negative),
    "abs": _elementwise(np.abs),
    "eq": _elementwise(np.equal),
    "ne": _elementwise(np.not_equal),
    "lt": _elementwise(np.less),
    "le": _elementwise(np.less_equal),
    "gt": _elementwise(np.greater),
    "ge": _elementwise(np.greater_equal),
    "integer_pow": _whole_power,
    "select_n": _selected,
    "broadcast_in_dim": _broadcast,
    "slice": _sliced,
    "iota": _counted,
    "split": _split,
    "transpose": _transposed,
    "concatenate": _joined,
    "stack": _stacked,
}
"""What works out each primitive, by its name."""
