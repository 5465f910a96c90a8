"""Programs of arrays as machine code against JAX: any primitive, lanes, directions, vector units, threads, denormal numbers."""

import ctypes
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rwjax.lowering.arrays import Spread
from rwjax.lowering.program import Lowered, assembled, build
from tests.lowering.compiled import OLD

SAME, OF_LANE, OF_DIRECTION = Spread(), Spread(lanes=True), Spread(directions=True)
LANES = 8
ROWS = (1, 7, 8, 19)


def lowered(function: Callable, arguments: Sequence, given_: Sequence[Spread], features: str = "") -> Lowered:
    return Lowered(build(function, arguments, given_, LANES, features))


def by_run(function: Callable, x: np.ndarray, *shared: np.ndarray) -> list[np.ndarray]:
    """A function of each row of an array, lowered with rows in lanes."""
    program = lowered(function, [x[0], *shared], [OF_LANE, *[SAME] * len(shared)])
    return program([x, *shared], rows=len(x))


def close(found: Sequence[np.ndarray], wanted: Sequence, within: float = 1e-13) -> None:
    """The same numbers; what does not differ over runs or directions has no axis for them."""
    for a, b in zip(found, jax.tree.leaves(wanted), strict=True):
        b = np.asarray(b)
        a = a[:, None] if a.ndim == b.ndim - 1 and a.shape == (b.shape[0], *b.shape[2:]) else a
        a = np.broadcast_to(a, b.shape)
        size = np.max(np.abs(b[np.isfinite(b)]), initial=1e-300)
        assert np.allclose(a, b, rtol=within, atol=within * size, equal_nan=True)


def _window(x):
    return jax.lax.dynamic_slice(x, (jnp.argmax(x) - 1,), (3,)) + x[jnp.argmin(x)]


def _scan(x):
    def step(carry, given_):
        a, b = carry
        return (jnp.where(given_ > 0.0, a + given_, a * 0.5), b - a * given_), (a * b, jnp.maximum(a, given_))

    return jax.lax.scan(step, (x[0], jnp.zeros(2) + x[1]), x, reverse=True)


def _while(x):
    return jax.lax.while_loop(
        lambda c: c[0] < 50.0, lambda c: (c[0] * 2.0 + 1.0, c[1] + 1), (jnp.abs(x[0]), jnp.asarray(0))
    )


def _matrices(x):
    """Powers and their like: matrices that change places, that are zero by structure, and that are divided by the turn's number."""
    a = jnp.where(np.tri(5, dtype=bool), jnp.outer(x[:5], x[1:]), 0.0)

    def turn(k, both):
        left, right = both
        return right, jnp.eye(5) + (a @ left) / (7.0 - k) - right.T / 4.0

    left, right = jax.lax.fori_loop(0, 5, turn, (jnp.eye(5), 0.1 * a))
    return (left @ right)[1], right, (jnp.stack([x[:3], x[3:]]).T @ x.reshape(2, 3)), (left @ x[:5])


PROGRAMS = {
    "sums and products": lambda x: (
        jnp.sum(x),
        jnp.outer(x, x) @ x,
        jnp.stack([x[:3], x[3:]]) @ jnp.stack([x[:3], x[3:]]).T,
    ),
    "cumulative": lambda x: (jnp.cumsum(x), jnp.cumsum(x[::-1])[::-1]),
    "moved": lambda x: (
        jnp.concatenate([x[2:], x[:2]]),
        x.reshape(2, 3).T,
        jnp.pad(x, (1, 2), constant_values=7.0),
        x[None, ::2],
    ),
    "extremes": lambda x: (jnp.max(x), jnp.min(x), jnp.argmax(x), jnp.argmin(x), jnp.clip(x, -0.5, 0.5)),
    "chosen": lambda x: (
        jnp.where(x > 0.0, x, -x),
        jnp.where(jnp.any(x > 1.0) | ~jnp.all(x > -2.0), x, 0.0),
        jnp.sign(x),
    ),
    "looked up": lambda x: (x[np.arange(6)[::-1] % 4], _window(x), jnp.asarray(x).at[jnp.argmax(x)].set(9.0)),
    "whole numbers": lambda x: (
        jnp.round(x).astype(int) % 3 * 2 - 1,
        jnp.floor(x).astype(int),
        jnp.ceil(x),
        (x > 0.0).astype(float),
    ),
    "functions": lambda x: (
        jnp.exp(x),
        jnp.sin(x) + jnp.cos(x),
        jnp.tanh(x),
        jnp.log1p(jnp.abs(x)),
        jnp.abs(x) ** 0.3,
        x**3,
        x**-2,
    ),
    "loop over time": _scan,
    "loop that ends by itself": _while,
    "matrices": _matrices,
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_runs_side_by_side_are_those_of_jax(name: str) -> None:
    every = np.random.default_rng(2).normal(size=(max(ROWS), 6)) * 1.5
    program, wanted = lowered(PROGRAMS[name], [every[0]], [OF_LANE]), jax.vmap(PROGRAMS[name])
    for rows in ROWS:
        close(program([every[:rows]], rows=rows), wanted(every[:rows]))


@pytest.mark.parametrize("name", PROGRAMS)
def test_one_run_is_that_of_jax(name: str) -> None:
    x = np.random.default_rng(3).normal(size=6)
    close(lowered(PROGRAMS[name], [x], [SAME])([x]), PROGRAMS[name](jnp.asarray(x)))


@pytest.mark.parametrize(
    "name", [n for n in PROGRAMS if n not in ("whole numbers", "loop that ends by itself", "extremes")]
)
def test_directions_of_derivatives_are_those_of_jax(name: str) -> None:
    rng = np.random.default_rng(5)
    x, d = rng.normal(size=(11, 6)), rng.normal(size=(5, 6))

    def moved(x, d):
        found, change = jax.jvp(PROGRAMS[name], (x,), (d,))
        numbers = [c for c in jax.tree.leaves(change) if c.dtype == float]
        return *jax.tree.leaves(found), *numbers

    found = lowered(moved, [x[0], d[0]], [OF_LANE, OF_DIRECTION])([x, d], rows=11, directions=5)
    values = len(jax.tree.leaves(PROGRAMS[name](jnp.asarray(x[0]))))
    close(found[:values], jax.vmap(PROGRAMS[name])(x))
    both = jax.vmap(jax.vmap(lambda x, d: moved(x, d)[values:], (0, None)), (None, 0))(x, d)
    close([np.broadcast_to(a, b.shape) for a, b in zip(found[values:], both, strict=True)], both)


UNARY = {
    "abs": jnp.abs, "negative": jnp.negative, "exp": jnp.exp, "tanh": jnp.tanh, "sin": jnp.sin, "square": jnp.square,
    "sign": jnp.sign, "root": lambda a: jnp.sqrt(jnp.abs(a)), "sum": lambda a: a + jnp.sum(a), "running sum": jnp.cumsum,
    "turned": lambda a: a[::-1], "rolled": lambda a: jnp.roll(a, 2), "extreme": lambda a: a - jnp.max(a),
    "looked up": lambda a: a[jnp.argmax(a) * jnp.asarray([1, 0, 0, 1]) % 4], "halved": lambda a: a / 3.0,
    "time": lambda a: jax.lax.scan(lambda c, v: (0.5 * c + v, c - v), a[0], a)[1],
}  # fmt: skip
BINARY = {
    "plus": jnp.add, "minus": jnp.subtract, "times": jnp.multiply, "larger": jnp.maximum, "smaller": jnp.minimum,
    "chosen": lambda a, b: jnp.where(a < b, b, a * 0.25), "with row": lambda a, b: jnp.asarray(a).at[1].set(b[2]),
}  # fmt: skip
STEP = st.tuples(st.sampled_from([*UNARY, *BINARY]), st.integers(0, 9), st.integers(0, 9))


@settings(max_examples=settings().max_examples // 2)  # each is compiled twice
@given(st.lists(STEP, min_size=1, max_size=8), st.sampled_from(ROWS), st.integers(0, 2**31))
def test_programs_at_random_are_those_of_jax(steps: list[tuple[str, int, int]], rows: int, seed: int) -> None:
    def program(x, c):
        known = [x, c]
        for name, j, k in steps:
            a, b = known[j % len(known)], known[k % len(known)]
            known.append(jnp.clip(UNARY[name](a) if name in UNARY else BINARY[name](a, b), -50.0, 50.0))
        return known[-1], known[len(known) // 2]

    rng = np.random.default_rng(seed)
    x, c = rng.uniform(-2.0, 2.0, (rows, 4)), rng.uniform(-2.0, 2.0, 4)
    close(
        by_run(program, x, c), jax.vmap(program, (0, None))(x, c), 1e-9
    )  # a clipped chain multiplies rounding by up to 1e4


EACH = {
    "numbers": lambda x: (
        jnp.exp2(x),
        jnp.expm1(x),
        jnp.tan(x),
        jax.lax.rsqrt(jnp.abs(x)),
        jax.lax.logistic(x),
        jnp.round(x),
    ),
    "logic": lambda x: (
        (x > 0.0) ^ (x < 1.0),
        (x > 0.0) & (x < 1.0),
        ~(x > 0.0) | (x > 2.0),
        jnp.where(x > 0.0, 1, 2) > 1,
    ),
    "whole": lambda x: (
        jnp.abs(jnp.round(x).astype(int)),
        jnp.sign(jnp.round(x).astype(int)),
        jnp.maximum(jnp.round(x).astype(int), 0),
    ),
    "powers": lambda x: (x**0, x**5, x**-3, jnp.square(x), jnp.abs(x) ** x, jnp.log(jnp.abs(x)), jnp.sqrt(jnp.abs(x))),
}


@pytest.mark.parametrize("name", EACH)
def test_operations_of_single_numbers_are_those_of_jax(name: str) -> None:
    x = np.random.default_rng(8).normal(size=(9, 5)) * 2.0
    close(by_run(EACH[name], x), jax.vmap(EACH[name])(x))


def test_whole_numbers_divide_as_in_jax_and_never_stop_the_process() -> None:
    a, b = (g.ravel() for g in np.meshgrid([-(2**63), 2**63 - 1, -7, 0, 7], [-1, 0, 1, 2, -3]))
    found = by_run(
        lambda x: (jax.lax.div(x[0], x[1]), jax.lax.rem(x[0], x[1]), jax.lax.div(x[0], 3)), np.stack([a, b], axis=1)
    )
    assert np.array_equal(found[0], jax.lax.div(a, b)) and np.array_equal(found[1], jax.lax.rem(a, b))
    assert np.array_equal(found[2], jax.lax.div(a, np.full_like(a, 3)))


ODD = np.array([0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 2.5, 1e300, -1e-300])


def test_not_a_number_and_infinities_go_where_they_go_in_jax() -> None:
    a, b = (g.ravel() for g in np.meshgrid(ODD, ODD))

    def program(x):
        a, b = x
        return (
            *(jnp.maximum(a, b), jnp.minimum(a, b), jnp.clip(a, b, 1.0), jnp.where(a < b, a, b), a + b, a * b, a / b),
            *(a < b, a <= b, a == b, a != b, a >= b, jnp.isfinite(a), jnp.abs(a), jnp.sign(a), jnp.sqrt(a), a - b),
            *(jnp.max(x), jnp.min(x), jnp.sum(x)),
        )

    with np.errstate(all="ignore"):
        close(by_run(program, np.stack([a, b], axis=1)), jax.vmap(program)(np.stack([a, b], axis=1)))


def test_operations_with_nothing_to_do_keep_not_a_number() -> None:
    x = np.array([[np.nan], [np.inf], [-3.0]])
    found = by_run(lambda x: (x * 0.0, 0.0 * x + 1.0, x - x, x * 1.0, x + 0.0, x / 1.0), x)
    close(found, jax.vmap(lambda x: (x * 0.0, 0.0 * x + 1.0, x - x, x * 1.0, x + 0.0, x / 1.0))(x))


def test_numbers_below_the_normal_range_are_zero_and_the_process_keeps_its_own() -> None:
    x = np.array([[5e-324], [2.0**-1022], [1e-300]])
    found = by_run(lambda x: (x * 0.5, x * 1e-20), x)[:2]
    assert np.array_equal(found[0].ravel(), [0.0, 0.0, 5e-301])
    assert not found[1].any()
    assert np.float64(2.0**-1022) * 0.5 > 0.0  # numbers of numpy and of Python as before
    assert _control_word() & 0x8040 == 0


def _control_word() -> int:
    """The rounding and flushing bits of this thread, by the C library."""
    environment = (ctypes.c_byte * 64)()
    ctypes.CDLL("libm.so.6").fegetenv(environment)
    return int.from_bytes(bytes(environment)[28:32], "little")


@pytest.mark.parametrize(
    "features", [OLD, *(pytest.param(some, marks=pytest.mark.slow) for some in ("-avx512f", "-avx512f,-fma"))]
)
@pytest.mark.parametrize("name", PROGRAMS)
def test_older_vector_units_give_the_same_bytes(name: str, features: str) -> None:
    x = np.random.default_rng(4).normal(size=(16, 6))
    both = [lowered(PROGRAMS[name], [x[0]], [OF_LANE], f)([x], rows=16) for f in ("", features)]
    for a, b in zip(*both, strict=True):
        assert a.tobytes() == b.tobytes()


def test_two_threads_give_the_same_bytes_as_one() -> None:
    x = np.random.default_rng(6).normal(size=(64, 8, 6))
    program = lowered(PROGRAMS["loop over time"], [x[0, 0]], [OF_LANE])
    one = [program([a], rows=8) for a in x]
    with ThreadPoolExecutor(2) as pool:
        two = list(pool.map(lambda a: program([a], rows=8), x))
    assert all(p.tobytes() == q.tobytes() for a, b in zip(one, two, strict=True) for p, q in zip(a, b, strict=True))


def test_products_of_large_matrices_are_loops() -> None:
    def written(n: int) -> int:
        product = jax.make_jaxpr(lambda a, b: (a @ b + a) @ b)(np.ones((n, n)), np.ones((n, n)))
        return assembled(product, [OF_LANE, OF_LANE], LANES)[0].count(" fmul ")

    assert written(3) == 2 * 3**3
    assert written(7) == 2 * 7


def test_what_all_runs_share_may_follow_from_a_loop_of_theirs() -> None:
    def program(x, c):
        (last, sums), seen = jax.lax.scan(lambda k, v: ((k[0] + 1.0, k[1] + v * x), k[0] * v), (c, x), jnp.arange(3.0))
        return last, jnp.sin(last) * 2.0, sums, seen, c, c

    x, c = np.linspace(-1.0, 1.0, 9), np.array(0.3)
    found = by_run(program, x, c)
    wanted = jax.vmap(program, (0, None))(x, c)
    close(found, wanted)


def test_a_result_may_be_given_twice_and_be_an_argument_or_a_constant() -> None:
    x = np.random.default_rng(1).normal(size=(9, 3))
    close(by_run(lambda x: (x * 2.0, x, x * 2.0, jnp.ones(3)), x)[:3], (x * 2.0, x, x * 2.0))
    close(lowered(lambda x: (x, x + 1.0, x, jnp.ones(3)), [x], [SAME])([x]), (x, x + 1.0, x, np.ones(3)))
