"""Exponentials, logarithms and powers against numpy's extended precision and the special cases of C99."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.lowering.compiled import OLD, compiled, ulps

COUNT = 40_000
EDGES = np.array(
    [
        0.0,
        5e-324,
        1e-310,
        2.0**-1022,
        1e-20,
        0.5,
        0.75**0.5,
        2.0**-0.5,
        1.0,
        2.0**0.5,
        22.0,
        44.0,
        708.3,
        708.4,
        745.2,
        1e308,
        np.inf,
    ]
)
EDGES = np.concatenate([EDGES, -EDGES, [709.78, 709.79, np.nan]])
TINY = 2.0**-1022


def _extended(name: str, *x: np.ndarray) -> np.ndarray:
    one = np.longdouble(1.0)
    known = {"pow": np.power, "logistic": lambda x: one / (one + np.exp(-x))}
    with np.errstate(all="ignore"):
        return known.get(name, getattr(np, name, None))(*(v.astype(np.longdouble) for v in x))


def _drawn(name: str) -> np.ndarray:
    """Arguments over all magnitudes, over where a result is finite, and near 0 and 1."""
    rng = np.random.default_rng(1)
    size = 10.0 ** rng.uniform(-20.0, 3.0, COUNT)
    any_sign = size * rng.choice([-1.0, 1.0], COUNT)
    if name.startswith("log") and name != "logistic":
        huge = 10.0 ** rng.uniform(-308.0, 308.0, COUNT)
        return np.concatenate([huge, size, rng.uniform(-0.99, 2.0, COUNT), 1.0 + 1e-3 * any_sign, EDGES])
    return np.concatenate([any_sign, rng.uniform(-1.0, 1.0, COUNT), rng.uniform(-745.0, 710.0, COUNT), EDGES])


BOUNDS = {"exp": 1.0, "exp2": 1.0, "expm1": 1.5, "log": 1.0, "log1p": 1.0, "tanh": 1.5, "logistic": 1.5}


@pytest.mark.parametrize("name", BOUNDS)
def test_everywhere_within_the_stated_units_in_the_last_place(name: str) -> None:
    x = _drawn(name)
    assert np.max(ulps(compiled(name, 1)(x), _extended(name, x))) < BOUNDS[name]


def test_powers_within_one_unit_in_the_last_place() -> None:
    rng = np.random.default_rng(2)
    near = 1.0 + rng.choice([-1.0, 1.0], COUNT) * 10.0 ** rng.uniform(-15.0, -1.0, COUNT)
    x = np.concatenate([np.exp(rng.uniform(-5.0, 5.0, COUNT)), 10.0 ** rng.uniform(-308.0, 308.0, COUNT), near])
    y = rng.uniform(-708.0, 709.0, len(x)) / np.log(x)
    y[:COUNT] = rng.uniform(-4.0, 4.0, COUNT)
    assert np.max(ulps(compiled("pow", 2)(x, y), _extended("pow", x, y))) < 1.0


def test_powers_of_small_integers_are_exact() -> None:
    x, y = (v.ravel() for v in np.meshgrid(np.arange(-40.0, 41.0), np.arange(0.0, 9.0)))
    exact = [float(int(a) ** int(b)) for a, b in zip(x, y, strict=True)]
    assert np.array_equal(compiled("pow", 2)(x, y), exact)


def test_special_powers_are_those_of_c99() -> None:
    odd = [1.0, 3.0, 2.0**52 + 1.0, 2.0**53 - 1.0, -1.0, -5.0]
    x = np.concatenate([EDGES, [-2.0, 2.0, -3.5]])
    y = np.concatenate([EDGES, odd, [2.0, 2.5, 2.0**53, 2.0**54, 2.0**52 - 0.5, 1e300]])
    x, y = (v.ravel() for v in np.meshgrid(x, y))
    found, exact = compiled("pow", 2)(x, y), _extended("pow", x, y)
    assert np.max(ulps(found, exact)) < 1.0
    kept = ~np.isnan(found) & ~((np.abs(found) < TINY) & (found != 0.0))
    assert np.array_equal(np.signbit(found)[kept], np.signbit(exact)[kept])


@pytest.mark.parametrize(
    ("name", "x", "exact"),
    [
        ("exp", [0.0, -0.0, np.inf, -np.inf, 1000.0, -1000.0], [1.0, 1.0, np.inf, 0.0, np.inf, 0.0]),
        ("exp2", [-3.0, 0.0, 1023.0, 1024.0, -1022.0], [0.125, 1.0, 2.0**1023, np.inf, TINY]),
        ("expm1", [0.0, -0.0, np.inf, -np.inf], [0.0, -0.0, np.inf, -1.0]),
        ("log", [1.0, 0.0, -0.0, np.inf, -1.0, -np.inf], [0.0, -np.inf, -np.inf, np.inf, np.nan, np.nan]),
        ("log1p", [0.0, -0.0, -1.0, np.inf, -2.0], [0.0, -0.0, -np.inf, np.inf, np.nan]),
        ("tanh", [0.0, -0.0, np.inf, -np.inf, 30.0], [0.0, -0.0, 1.0, -1.0, 1.0]),
        ("logistic", [0.0, np.inf, -np.inf], [0.5, 1.0, 0.0]),
    ],
)
def test_special_values(name: str, x: list[float], exact: list[float]) -> None:
    found = compiled(name, 1)(np.array([*x, np.nan]))
    expected = np.array([*exact, np.nan])
    assert np.array_equal(found, expected, equal_nan=True)
    signed = ~np.isnan(expected)
    assert np.array_equal(np.signbit(found)[signed], np.signbit(expected)[signed])


@given(arrays(float, 9, elements=st.floats(-750.0, 750.0)))
def test_tanh_is_odd_and_the_logistic_functions_of_both_signs_add_up(x: np.ndarray) -> None:
    tanh, logistic = compiled("tanh", 1), compiled("logistic", 1)
    assert np.array_equal(tanh(-x), -tanh(x))
    assert logistic(x) + logistic(-x) == pytest.approx(np.ones(9), abs=2.5e-16)


@given(arrays(float, 9, elements=st.floats(min_value=5e-324, allow_infinity=False)))
def test_squares_and_roots_by_powers_and_by_arithmetic(x: np.ndarray) -> None:
    root = compiled("pow", 2)(x, np.full(9, 0.5))
    assert np.max(ulps(root, np.sqrt(x.astype(np.longdouble)))) < 1.0
    assert np.array_equal(compiled("pow", 2)(x, np.ones(9)), x)


@pytest.mark.parametrize("unit", ["", OLD])
def test_where_the_processor_flushes_normal_results_stay_and_others_become_zero(unit: str) -> None:
    for name, x in (("exp", np.linspace(-760.0, -700.0, 997)), ("exp2", np.linspace(-1080.0, -1000.0, 997))):
        plain, flushed = compiled(name, 1)(x), compiled(name, 1, unit=unit, flush=True)(x)
        assert np.array_equal(flushed, np.where(plain < TINY, 0.0, plain))
        assert np.count_nonzero(plain < TINY) > 100


def test_a_logarithm_undoes_python_s_power_of_two() -> None:
    x = np.array([math.ldexp(1.0, k) for k in range(-1074, 1024)])
    assert np.max(ulps(compiled("log", 1)(x), np.arange(-1074, 1024) * np.log(np.longdouble(2.0)))) < 1.0
