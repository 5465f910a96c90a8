"""Functions of few numbers with many values, whose derivative is worked out once, by forward mode."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float


def with_jacobian(function: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """A function that hands JAX its whole Jacobian, worked out side by side with its value.

    So it can be differentiated by forward and by reverse mode, though a loop in it may know forward mode alone; and a solver that
    applies the Jacobian several times does not go through the loop again. The cost grows with the numbers.

    Args:
        function: From numbers `(p,)` to values of any shape.

    Returns:
        The same function, for numbers `(p,)`.
    """

    @jax.custom_jvp
    def wrapped(x: Float[Array, " p"]) -> Array:
        return function(x)

    @wrapped.defjvp
    def _(primals: tuple[Array], tangents: tuple[Array]) -> tuple[Array, Array]:
        (x,), (dx,) = primals, tangents
        y, columns = jax.vmap(lambda e: jax.jvp(function, (x,), (e,)), out_axes=(None, -1))(jnp.eye(len(x)))
        return y, columns @ dx

    return wrapped
