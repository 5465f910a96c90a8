"""Exponentials, logarithms and powers of doubles, side by side, each within 1 or 2 units in the last place.

Results below 2^-1022 come out rounded to the spacing of denormal numbers, or as 0 where the processor flushes them.
"""

import struct

from rwjax.lowering.lanes import Lanes, fast_two_sum, head, polynomial, two_sum

LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # fdlibm's e_log.c; the first has 32 bits
ROUNDS = 1.5 * 2.0**52  # added to a small number, it leaves the nearest integer in the last bits
ONE = 1023 << 52  # bits of 1.0
SIGN = -(1 << 63)  # bits of -0.0
NAN = float("nan")
INF = float("inf")
# exp(r) - 1 = r + r² Q(r) within 2^-60 of itself for |r| <= ln(2)/2: a minimax polynomial by Remez's exchange, the first fixed
Q = (
    0.5,
    0.16666666666666677,
    0.04166666666666669,
    0.008333333333321659,
    0.0013888888888870163,
    0.00019841269886092846,
    2.4801587356086035e-05,
    2.7557244216601285e-06,
    2.755724559380067e-07,
    2.5109041547934533e-08,
    2.092375678052295e-09,
)
# log(1 + f) from s = f / (2 + f): fdlibm's e_log.c (Sun Microsystems, 1993), Lg1 to Lg7
LOG = (
    6.666666666666735130e-01,
    3.999999999940941908e-01,
    2.857142874366239149e-01,
    2.222219843214978396e-01,
    1.818357216161805012e-01,
    1.531383769920937332e-01,
    1.479819860511658591e-01,
)
# (3/2) log(1 + f) / s, from s⁴ on: fdlibm's e_pow.c (Sun Microsystems, 2004), L1 to L6
LOG_OF_POWER = (
    5.99999999999994648725e-01,
    4.28571428578550184252e-01,
    3.33333329818377432918e-01,
    2.72728123808534006489e-01,
    2.30660745775561754067e-01,
    2.06975017800338417784e-01,
)


def exp(x: Lanes) -> Lanes:
    """e^x within 1 unit in the last place.

    Args:
        x: Exponent.

    Returns:
        The power of e.
    """
    n, r, low = _reduced(_clamped(x, 1400.0))
    return _scaled(1.0 + (r + (low + r * r * polynomial(r, Q))), n.bits())


def exp2(x: Lanes) -> Lanes:
    """2^x within 1 unit in the last place.

    Args:
        x: Exponent.

    Returns:
        The power of 2.
    """
    x = _clamped(x, 2000.0)
    n = x + ROUNDS
    return _scaled(_of_two(x - (n - ROUNDS), x.constant(0.0)), n.bits())


def _clamped(x: Lanes, most: float) -> Lanes:
    """Within ±`most`; NaN stays."""
    x = (x > most).where(most, x)
    return (x < -most).where(-most, x)


def _reduced(x: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """X = n ln 2 + r + low with |r| <= ln(2)/2; n comes with `ROUNDS` added."""
    n = x * 1.4426950408889634 + ROUNDS
    count = n - ROUNDS
    high, low = x - count * LN2_HIGH, count * LN2_LOW
    r = high - low
    return n, r, (high - r) - low


def _of_two(high: Lanes, low: Lanes) -> Lanes:
    """2^(high + low) for |high| <= 1/2; with ln 2 in two parts as in fdlibm's e_pow.c."""
    t = head(high + low, 32)
    u = t * 6.93147182464599609375e-01
    v = (low - (t - high)) * 6.93147180559945286227e-01 + t * -1.90465429995776804525e-09
    r = u + v
    return 1.0 + (r + ((v - (r - u)) + r * r * polynomial(r, Q)))


def _power_of_two(n: Lanes) -> Lanes:
    """2^n, from the last bits of n."""
    return ((n << 52) + ONE).double()


def _scaled(y: Lanes, n: Lanes) -> Lanes:
    """Y 2^n for |n| <= 2044, in two steps so that each factor is a normal number; n by its last bits."""
    half = n >> 1
    return y * _power_of_two(half) * _power_of_two(n - half)


def _expm1(x: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """(e^x - 1) 2^-n as a sum of two doubles, and n as the last bits of an integer; |x| < 1400."""
    n, r, low = _reduced(x)
    rest = low + r * r * polynomial(r, Q)
    high, less = fast_two_sum(r, rest)
    shrunk = _power_of_two(-((n > ROUNDS + 64.0).where(ROUNDS + 64.0, n)).bits())
    total, lost = two_sum(1.0 - shrunk, high)
    return total, lost + less, n.bits()


def expm1(x: Lanes) -> Lanes:
    """e^x - 1 within 1 unit in the last place, also near 0.

    Args:
        x: Exponent.

    Returns:
        The power of e less 1.
    """
    clamped = _clamped(x, 800.0)
    high, low, n = _expm1((clamped < -40.0).where(-40.0, clamped))
    return x.equals(0.0).where(x, _scaled(high + low, n))


def tanh(x: Lanes) -> Lanes:
    """Hyperbolic tangent within 1.5 units in the last place.

    Args:
        x: Any number.

    Returns:
        Its hyperbolic tangent.
    """
    size = abs(x)
    high, low, n = _expm1((size > 22.0).where(44.0, size + size))
    scale = _power_of_two(n)
    high, low = high * scale, low * scale
    below, lost = two_sum(2.0, high)
    ratio = high / below
    ratio = ratio + (low - ratio * (lost + low)) * (0.5 - 0.5 * ratio)  # 1/below to first order
    return (ratio.bits() | (x.bits() & SIGN)).double()


def logistic(x: Lanes) -> Lanes:
    """1/(1 + e^-x) within 1.5 units in the last place.

    Args:
        x: Any number.

    Returns:
        Its logistic function.
    """
    n, r, low = _reduced(_clamped(-abs(x), 1400.0))
    rest = r + (low + r * r * polynomial(r, Q))
    small, less = (_scaled(part, n.bits()) for part in fast_two_sum(1.0, rest))
    below, lost = fast_two_sum(1.0, small)
    lost = lost + less
    left = x < 0.0
    ratio = left.where(small, 1.0) / below
    return ratio + (left.where(less, 0.0) - ratio * lost) * left.where(1.0 - ratio, ratio)


def _exponent_and_rest(x: Lanes, least: float) -> tuple[Lanes, Lanes]:
    """X = 2^k m for positive x, with m from `least` to twice that; k is a double."""
    bits = _bits(least)
    tiny = x < 2.0**-1022
    moved = tiny.where(x * 2.0**54, x).bits() + (ONE - bits)
    m = ((moved & ((1 << 52) - 1)) + bits).double()
    k = ((moved >> 52) | _bits(2.0**52)).double() - tiny.where(2.0**52 + 1023.0 + 54.0, 2.0**52 + 1023.0)
    return k, m


def _bits(number: float) -> int:
    """The 64 bits of a double, as an integer."""
    return struct.unpack("<q", struct.pack("<d", number))[0]


def log(x: Lanes) -> Lanes:
    """Natural logarithm within 1 unit in the last place.

    Args:
        x: Any number; below 0 there is no logarithm.

    Returns:
        Its logarithm.
    """
    k, m = _exponent_and_rest(x, 0.5**0.5)
    return _at_the_ends(x, _log(k, m, None))


def _log(k: Lanes, m: Lanes, correction: Lanes | None) -> Lanes:
    """K ln 2 + log(m) + correction, as in fdlibm's e_log.c."""
    f = m - 1.0
    half = 0.5 * f * f
    s = f / (2.0 + f)
    z = s * s
    R = z * polynomial(z, LOG)
    low = k * LN2_LOW if correction is None else k * LN2_LOW + correction
    return ((s * (half + R) + low) - half) + f + k * LN2_HIGH


def _at_the_ends(x: Lanes, y: Lanes) -> Lanes:
    """The logarithm y of x, also for infinite, zero, negative and missing x."""
    y = (x < INF).where(y, x)  # infinity and NaN
    return (x > 0.0).where(y, x.equals(0.0).where(-INF, x.nan().where(x, NAN)))


def log1p(x: Lanes) -> Lanes:
    """log(1 + x) within 1 unit in the last place, also near 0.

    Args:
        x: Any number; below -1 there is no logarithm.

    Returns:
        The logarithm of 1 + x.
    """
    u, lost = two_sum(1.0, x)
    k, m = _exponent_and_rest(u, 0.5**0.5)
    y = _at_the_ends(u, _log(k, m, lost / u))
    return x.equals(0.0).where(x, y)


def _log2_in_two(x: Lanes) -> tuple[Lanes, Lanes]:
    """Base-2 logarithm of positive x as a sum of two doubles, the first of 21 bits: fdlibm's e_pow.c."""
    k, m = _exponent_and_rest(x, 0.75**0.5)
    large = m > 1.5**0.5
    around = large.where(1.5, x.constant(1.0))
    u, v = m - around, 1.0 / (m + around)
    s = u * v
    s1 = head(s, 32)
    t1 = head(m + around, 32)
    s2 = v * ((u - s1 * t1) - s1 * (m - (t1 - around)))
    square = s * s
    r = square * square * polynomial(square, LOG_OF_POWER) + s2 * (s1 + s)
    square = s1 * s1
    t1 = head(3.0 + square + r, 32)
    t2 = r - ((t1 - 3.0) - square)
    u, v = s1 * t1, s2 * t1 + t2 * s
    p1 = head(u + v, 32)
    p2 = v - (p1 - u)
    z1 = 9.61796700954437255859e-01 * p1
    z2 = (
        -7.02846165095275826516e-09 * p1
        + p2 * 9.61796693925975554329e-01
        + large.where(1.35003920212974897128e-08, p1.constant(0.0))
    )
    base = large.where(5.84962487220764160156e-01, p1.constant(0.0))
    high = head(((z1 + z2) + base) + k, 32)
    return high, z2 - (((high - k) - base) - z1)


def power(x: Lanes, y: Lanes) -> Lanes:
    """x^y within 1 unit in the last place, with the special cases of C99.

    Args:
        x: Base; if negative, y has to be an integer.
        y: Exponent.

    Returns:
        The power.
    """
    size = abs(x)
    log1, log2 = _log2_in_two(size)
    y0 = _clamped(y, 2.0**65)
    y1 = head(y0, 32)
    p1, p2 = _clamped(y1 * log1, 2000.0), _clamped((y0 - y1) * log1 + y0 * log2, 1.0)
    n = (p1 + p2) + ROUNDS
    result = _scaled(_of_two(p1 - (n - ROUNDS), p2), n.bits())
    return _power_at_the_ends(x, y, result)


def _power_at_the_ends(x: Lanes, y: Lanes, result: Lanes) -> Lanes:
    """|x|^y with x^y's sign, also for infinite, zero, negative and missing numbers."""
    size, whole = abs(x), _is_whole(abs(y))
    result = ((x < 0.0) & ~whole).where(NAN, result)
    ends = size.equals(0.0) | size.equals(INF)
    vanishes = size.equals(0.0) ^ (y < 0.0)
    result = ends.where(vanishes.where(0.0, x.constant(INF)), result)
    odd = whole & ~_is_whole(0.5 * abs(y))
    sign = odd.where(x.bits() & SIGN, x.bits().constant(0))
    result = (result.bits() | sign).double()
    result = (x.nan() | y.nan()).where(NAN, result)
    return (x.equals(1.0) | y.equals(0.0)).where(1.0, result)


def _is_whole(size: Lanes) -> Lanes:
    """Where a number that is not negative is an integer."""
    limited = (size > 2.0**52).where(2.0**52, size)
    return ((limited + 2.0**52) - 2.0**52).equals(limited)
