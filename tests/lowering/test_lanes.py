"""Operators of lanes against Python's numbers, exact sums and products against fractions."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from llvmlite import ir

from rwjax.lowering.lanes import Lanes, fast_two_sum, head, polynomial, two_product, two_sum
from tests.lowering.compiled import compiled_body

NUMBER = st.floats(-1e100, 1e100, allow_subnormal=False).filter(lambda x: x == 0.0 or abs(x) > 1e-100)
DONE: dict[str, Callable[..., np.ndarray]] = {}


def _run(name: str, of: Callable[..., Lanes], *x: float) -> float:
    """What a few operations give, in each of four lanes the same."""

    def body(builder: ir.IRBuilder, *values: ir.Value) -> ir.Value:
        return of(*(Lanes(builder, value) for value in values)).value

    if name not in DONE:
        DONE[name] = compiled_body(body, len(x), 4)
    (found,) = {float(v) for v in DONE[name](*(np.full(4, v) for v in x))}
    return found


@given(NUMBER, NUMBER)
def test_operators_are_those_of_numbers(a: float, b: float) -> None:
    assert (
        _run("arithmetic", lambda x, y: 2.0 - (x + 1.0) * -y + abs(x) - 0.5 * y, a, b)
        == 2.0 - (a + 1.0) * -b + abs(a) - 0.5 * b
    )
    assert _run("quotient", lambda x, y: (x / 3.0) + 3.0 / (1.0 + abs(y)), a, b) == (a / 3.0) + 3.0 / (1.0 + abs(b))
    chosen = _run("choice", lambda x, y: ((x < y) | x.equals(0.0)).where(1.0, (x >= 2.0 * y).where(y, 3.0)), a, b)
    assert chosen == (1.0 if a < b or a == 0.0 else b if a >= 2.0 * b else 3.0)
    shared = float((np.array(a).view(np.int64) & np.array(b).view(np.int64)).view(float))
    assert _run("and, not", lambda x, y: (x.bits() & ~(x.bits() ^ y.bits())).double(), a, b) == shared
    assert _run("or", lambda x, y: ((x.bits() | y.bits()) ^ (x.bits() ^ y.bits())).double(), a, b) == shared


@given(st.floats(-4.0, 4.0))
def test_a_polynomial_has_its_values(x: float) -> None:
    for count in range(1, 12):
        coefficients = tuple(1.0 / (k + 1.0) for k in range(count))
        found = _run(f"polynomial {count}", lambda v, c=coefficients: polynomial(v, c), x)
        terms = [c * x**k for k, c in enumerate(coefficients)]
        assert found == pytest.approx(sum(terms), abs=1e-14 * sum(map(abs, terms)))


@given(NUMBER, NUMBER)
def test_a_sum_and_its_rest_are_exact(a: float, b: float) -> None:
    large, small = sorted((a, b), key=abs, reverse=True)
    exact = Fraction(a) + Fraction(b)
    assert Fraction(_run("sum", lambda x, y: two_sum(x, y)[0], a, b)) == Fraction(a + b)
    assert Fraction(_run("rest", lambda x, y: two_sum(x, y)[1], a, b)) == exact - Fraction(a + b)
    assert Fraction(_run("fast rest", lambda x, y: fast_two_sum(x, y)[1], large, small)) == exact - Fraction(a + b)


@given(NUMBER, NUMBER)
def test_a_product_and_its_rest(a: float, b: float) -> None:
    exact = Fraction(a) * Fraction(b)
    rest = Fraction(_run("lost", lambda x, y: two_product(x, y)[1], a, b))
    assert abs(Fraction(a * b) + rest - exact) <= abs(exact) / 2**100
    assert Fraction(_run("heads", lambda x, y: head(x) * head(y), a, b)) == Fraction(_run("head", head, a)) * Fraction(
        _run("head", head, b)
    )
    assert 0.0 <= abs(a) - abs(_run("head", head, a)) <= abs(a) * 2.0**-25
