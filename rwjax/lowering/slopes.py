"""Values of a function and their derivatives, as machine code: the lanes are the arguments by which it is differentiated."""

from collections.abc import Callable, Sequence

import jax
import numpy as np
from jaxtyping import Array

from rwjax.lowering.arrays import Spread
from rwjax.lowering.kept import lowered

SAME, OF_LANE = Spread(), Spread(lanes=True)


def with_slopes(
    name: str,
    key: object,
    function: Callable[..., Sequence[Array]],
    z: np.ndarray,
    fixed: Sequence[np.ndarray],
    keep: bool,
) -> tuple[list[np.ndarray], list[np.ndarray]] | None:
    """Values of a function and their derivatives by its first argument, forward.

    Args:
        name: Name under which the program is kept.
        key: What it depends on besides the shapes of its arguments.
        function: From `z` and what is fixed to a sequence of arrays.
        z: Where `(k,)` [1].
        fixed: Further arguments, by which nothing is differentiated [any unit].
        keep: Whether it may be kept on disk: whether the library's source and the key determine it.

    Returns:
        The values [any unit], and their derivatives with a last axis `k`; None where the program runs through XLA.
    """

    def along(z: Array, dz: Array, *fixed: Array) -> tuple[Array, ...]:
        values, moved = jax.jvp(lambda z: tuple(function(z, *fixed)), (z,), (dz,))
        return *values, *moved

    given = [SAME, OF_LANE, *[SAME] * len(fixed)]
    program = lowered(name, key, along, [z, z, *fixed], given, keep)
    if program is None:
        return None
    found = program([z, np.eye(len(z)), *fixed], rows=len(z))
    half = len(found) // 2
    return [value[0, ...] for value in found[:half]], [np.moveaxis(slope, 0, -1) for slope in found[half:]]
