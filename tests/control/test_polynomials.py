"""Where the roots of polynomials lie, against the roots themselves."""

import jax.numpy as jnp
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rwjax.control.polynomials import disc, hurwitz, mapped, shift, within_sector

CORNER = 1e-3  # roots nearer than this to a limit, several of them together, are not told from it

real = st.floats(-3.0, 2.0)
pair = st.tuples(st.floats(-3.0, 2.0), st.floats(0.01, 5.0))


def polynomial(reals: list[float], pairs: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    roots = np.array([*map(complex, reals), *(x + s * 1j * y for x, y in pairs for s in (1.0, -1.0))])
    return np.real(np.poly(roots)), roots


@given(st.lists(real, min_size=1, max_size=3), st.lists(pair, max_size=2), st.floats(0.0, 1.0), st.floats(0.05, 0.95))
def test_roots_are_where_the_tests_say(
    reals: list[float], pairs: list[tuple[float, float]], sigma: float, damping: float
) -> None:
    c, roots = polynomial(reals, pairs)
    order = len(c) - 1
    for distance, found in (
        (-roots.real, hurwitz([*jnp.asarray(c)])),
        (-roots.real - sigma, hurwitz(mapped(shift(order, sigma), [*jnp.asarray(c)]))),
        (-roots.real - damping * np.abs(roots), within_sector([*jnp.asarray(c)], damping)),
        (1.0 + sigma - np.abs(1.0 + roots), hurwitz(mapped(disc(order, 1.0 + sigma), [*jnp.asarray(c)]))),
    ):
        if np.min(np.abs(distance)) > CORNER:
            assert bool(found) == bool(np.all(distance > 0.0))
