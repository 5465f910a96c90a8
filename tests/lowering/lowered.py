"""A function of JAX as machine code, with rows of its arguments in lanes."""

from collections.abc import Callable

import jax
import numpy as np

from rwjax.lowering.arrays import Spread
from rwjax.lowering.program import Lowered, build

LANES = 8


def agrees(function: Callable, *arguments: np.ndarray, within: float = 1e-13) -> bool:
    """Whether a function of rows is the same by machine code and by JAX: rows in lanes, and one row that all lanes share."""
    wanted = [np.asarray(a) for a in jax.tree.leaves(jax.vmap(function)(*arguments))]
    one, rows = [a[0] for a in arguments], len(arguments[0])
    by_lane = Lowered(build(function, one, [Spread(lanes=True)] * len(one), LANES))(arguments, rows=rows)
    alone = Lowered(build(function, one, [Spread()] * len(one), LANES))(one)
    pairs = [*zip(by_lane, wanted, strict=True), *((a, b[0]) for a, b in zip(alone, wanted, strict=True))]
    return all(np.allclose(a, b, rtol=within, atol=within, equal_nan=True) for a, b in pairs)
