"""Sines against numpy's extended precision and, next to multiples of π/2, against exact integers."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.lowering.compiled import OLD, compiled, ulps

COUNT = 40_000
DIGITS = 400


def _pi() -> Fraction:
    """π by Machin's formula, to 400 digits."""

    def arctan(n: int) -> Fraction:
        power, total, k = 10**DIGITS // n, 0, 1
        while power:
            total += power // k if k % 4 == 1 else -(power // k)
            power, k = power // n**2, k + 2
        return Fraction(total, 10**DIGITS)

    return 16 * arctan(5) - 4 * arctan(239)


PI = _pi()


def _angles() -> np.ndarray:
    rng = np.random.default_rng(3)
    sign = rng.choice([-1.0, 1.0], COUNT)
    everyday = [
        rng.uniform(-8.0, 8.0, COUNT),
        rng.uniform(-1e5, 1e5, COUNT),
        sign * 10.0 ** rng.uniform(-20.0, 5.0, COUNT),
    ]
    large = sign[:8000] * 10.0 ** rng.uniform(5.0, 308.0, 8000)
    edges = [0.0, 5e-324, 1e-310, 0.5, 1e5, np.nextafter(1e5, 2e5), 2.0**1023, np.inf, np.nan]
    return np.concatenate([*everyday, large, edges])


@pytest.mark.parametrize(("name", "bound"), [("sin", 1.0), ("cos", 1.0), ("tan", 2.0)])
def test_everywhere_within_the_stated_units_in_the_last_place(name: str, bound: float) -> None:
    x = _angles()
    with np.errstate(invalid="ignore"):
        exact = getattr(np, name)(x.astype(np.longdouble))
    assert np.max(ulps(compiled(name, 1)(x), exact)) < bound


def test_next_to_multiples_of_a_quarter_turn() -> None:
    """There x - n π/2 is the sine or cosine itself, up to its sign."""
    turns = [*range(1, 63662, 7), *range(63663, 5_000_000, 3331)]
    x = np.array([float(n * PI / 2) for n in turns])
    exact = np.array([float(Fraction(value) - n * PI / 2) for n, value in zip(turns, x.tolist(), strict=True)])
    assert np.max(np.abs(exact)) < 1e-9  # so that its sine is itself
    found = np.where(np.array(turns) % 2 == 1, -compiled("cos", 1)(x), compiled("sin", 1)(x))
    sign = np.where(np.array(turns) // 2 % 2 == 1, -1.0, 1.0)
    assert np.max(ulps(sign * found, exact)) <= 1.0


@pytest.mark.parametrize("x", [6381956970095103.0 * 2.0**797, 5.319372648326541e255])
@pytest.mark.parametrize("unit", ["", OLD])
def test_the_hardest_angles(x: float, unit: str) -> None:
    """The doubles closest to a multiple of π/2 (Muller et al., Handbook of Floating-Point Arithmetic, 2nd edition, table 11.1)."""
    turns = round(Fraction(x) * 2 / PI)
    away = Fraction(x) - turns * PI / 2
    assert abs(away) < 1e-17
    name = "cos" if turns % 2 else "sin"
    found = compiled(name, 1, unit=unit)(np.array([x]))
    assert abs(abs(found[0]) - abs(float(away))) <= np.spacing(abs(float(away)))


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_large_angle_beside_small_ones_changes_none_of_them(x: float) -> None:
    small = np.array([0.1, -2.0, 3.0, 99.0, 1e-9, -0.0, 7.0])
    for name in ("sin", "cos", "tan"):
        alone, beside = compiled(name, 1)(small), compiled(name, 1)(np.array([*small, x]))
        assert beside[:7].tobytes() == alone.tobytes()
        assert beside[7] == compiled(name, 1, lanes=None)(np.array([x]))[0]


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_the_circle_has_radius_one_and_its_symmetries(x: float) -> None:
    sine, cosine = (compiled(name, 1)(np.array([x, -x])) for name in ("sin", "cos"))
    assert sine[0] ** 2 + cosine[0] ** 2 == pytest.approx(1.0, abs=4e-16)
    assert sine[0] == -sine[1] and cosine[0] == cosine[1]


def test_signs_of_zero_and_no_numbers() -> None:
    x = np.array([0.0, -0.0, np.inf, -np.inf, np.nan])
    for name in ("sin", "tan"):
        found = compiled(name, 1)(x)
        assert np.array_equal(found, [0.0, 0.0, np.nan, np.nan, np.nan], equal_nan=True)
        assert np.signbit(found[:2]).tolist() == [False, True]
    assert np.array_equal(compiled("cos", 1)(x), [1.0, 1.0, np.nan, np.nan, np.nan], equal_nan=True)
