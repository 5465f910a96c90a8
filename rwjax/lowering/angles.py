"""Sine, cosine and tangent of doubles, side by side, each within 1 or 2 units in the last place at every angle.

Angles up to 1e5 rad are reduced to a quarter turn with π/2 in three parts (Cody and Waite). Larger ones are multiplied by as many
bits of 2/π as they need (Payne and Hanek), one lane after the other, behind a test that hardly ever holds.
"""

from llvmlite import ir

from rwjax.lowering.lanes import (
    DOUBLE,
    INTEGER,
    Lanes,
    Value,
    fast_two_sum,
    packed,
    polynomial,
    shaped,
    two_product,
    two_sum,
)

PI_HALF = (
    float.fromhex("0x1.921fb54440000p+0"),
    float.fromhex("0x1.68c234c4c0000p-39"),
    float.fromhex("0x1.98a2e03707345p-77"),
)
HIGH, LOW = float.fromhex("0x1.921fb54442d18p+0"), float.fromhex("0x1.1a62633145c07p-54")  # π/2 in two parts
LARGEST = 1e5  # rad; times 2/π it is below 2^16, so that its product with a part of 36 bits is exact
ROUNDS = 1.5 * 2.0**52  # added to a small number, it leaves the nearest integer in the last bits
INF = float("inf")
# fdlibm's k_sin.c and k_cos.c (Sun Microsystems, 1993): S1 to S6, C1 to C6
SINE = (
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
)
COSINE = (
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
)
# 2/π: 64 zeros, then 1216 bits after the point
TWO_OVER_PI = int(
    "a2f9836e4e441529fc2757d1f534ddc0db6295993c439041fe5163abdebbc561b7246e3a424dd2e006492eea09d1921cfe1deb1cb129a73e"
    "e88235f52ebb4484e99c7026b45f7e413991d639835339f49c845f8bbdf9283b1ff897ffde05980fef2f118b5a0a6d1f6d367ecf27cb09b7"
    "4f463f669e5fea2d7527bac7ebe5f17b3d0739f78a5292ea6bfb5fb11f8d5d0856033046fc7b6bab",
    16,
)
WORDS = [TWO_OVER_PI >> 64 * k & (1 << 64) - 1 for k in reversed(range(20))]


def sine_and_cosine(x: Lanes) -> tuple[Lanes, Lanes]:
    """Sine and cosine, each within 1 unit in the last place.

    Args:
        x: Angle [rad].

    Returns:
        The sine and the cosine.
    """
    sine, cosine = _in_two(x)
    return sine[0] + sine[1], cosine[0] + cosine[1]


def tan(x: Lanes) -> Lanes:
    """Tangent within 2 units in the last place.

    Args:
        x: Angle [rad].

    Returns:
        Its tangent.
    """
    (sine, more), (cosine, rest) = (fast_two_sum(*parts) for parts in _in_two(x))
    ratio = sine / cosine
    return x.equals(0.0).where(x, ratio + (more - ratio * rest) / cosine)


def _in_two(x: Lanes) -> tuple[tuple[Lanes, Lanes], tuple[Lanes, Lanes]]:
    """Sine and cosine, each as a sum of two doubles."""
    n, y, low = _reduced(abs(x))
    z = y * y
    v = z * y
    sine = y, low + (v * polynomial(z, SINE) - 0.5 * z * low)
    half = 0.5 * z
    first = 1.0 - half
    cosine = first, ((1.0 - first) - half) + (z * z * polynomial(z, COSINE) - y * low)
    odd = (n & 1).equals(1)
    minus_sine = (x.bits() ^ (n << 62)) & -(1 << 63)
    minus_cosine = ((n + 1) << 62) & -(1 << 63)
    of_sine = tuple(_signed(odd.where(c, s), minus_sine) for s, c in zip(sine, cosine, strict=True))
    of_cosine = tuple(_signed(odd.where(s, c), minus_cosine) for s, c in zip(sine, cosine, strict=True))
    return (of_sine[0], of_sine[1]), (of_cosine[0], of_cosine[1])


def _signed(x: Lanes, sign: Lanes) -> Lanes:
    return (x.bits() ^ sign).double()


def _reduced(x: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """X = n π/2 + y + low with |y| <= π/4, for x >= 0; n by its last bits."""
    turns = x * (2.0 / 3.141592653589793) + ROUNDS
    count = turns - ROUNDS
    y, lost = two_sum(x - count * PI_HALF[0], -(count * PI_HALF[1]))
    lost = lost - count * PI_HALF[2]
    total, low = two_sum(y, lost)
    large = (x > LARGEST) & (x < INF)
    return _with_large_angles(x, large, (turns.bits(), total, low))


def _with_large_angles(x: Lanes, large: Lanes, found: tuple[Lanes, Lanes, Lanes]) -> tuple[Lanes, Lanes, Lanes]:
    """What was found, with the lanes of large angles replaced."""
    builder, before = x.builder, x.builder.block
    any_large = (
        large.value
        if x.count is None
        else builder.icmp_unsigned(
            "!=", builder.bitcast(large.value, ir.IntType(x.count)), ir.Constant(ir.IntType(x.count), 0)
        )
    )
    with builder.if_then(any_large, likely=False):
        exact = builder.call(_large_angles(builder.module, x.count), [large.where(x, LARGEST).value])
        parts = [Lanes(builder, builder.extract_value(exact, k)) for k in range(3)]
        chosen = [large.where(new, old).value for new, old in zip(parts, found, strict=True)]
        inside = builder.block
    merged = []
    for old, new in zip(found, chosen, strict=True):
        phi = builder.phi(new.type)
        phi.add_incoming(old.value, before)
        phi.add_incoming(new, inside)
        merged.append(Lanes(builder, phi))
    return merged[0], merged[1], merged[2]


def _large_angles(module: ir.Module, count: int | None) -> ir.Function:
    """The function that reduces angles above `LARGEST`, once in each module for each number of lanes; off the common way."""
    name = f"rwjax.large_angles.{count or 1}"
    if name in module.globals:
        return module.globals[name]
    parts = ir.LiteralStructType([shaped(INTEGER, count), shaped(DOUBLE, count), shaped(DOUBLE, count)])
    function = ir.Function(module, ir.FunctionType(parts, [shaped(DOUBLE, count)]), name)
    function.linkage = "internal"
    for attribute in ("cold", "noinline", "nounwind"):
        function.attributes.add(attribute)
    x = Lanes(ir.IRBuilder(function.append_basic_block()), function.args[0])
    x.builder.ret(packed(x.builder, parts, _payne_hanek(x) if count is None else _each_lane(x)))
    return function


def _each_lane(x: Lanes) -> tuple[Lanes, ...]:
    """The reduction of large angles, one lane after the other."""
    builder, one = x.builder, _large_angles(x.builder.module, None)
    wholes = [x.bits().constant(0).value, x.constant(0.0).value, x.constant(0.0).value]
    for lane in range(x.count or 1):
        place = ir.Constant(ir.IntType(32), lane)
        found = builder.call(one, [builder.extract_element(x.value, place)])
        wholes = [
            builder.insert_element(whole, builder.extract_value(found, k), place) for k, whole in enumerate(wholes)
        ]
    return tuple(Lanes(builder, whole) for whole in wholes)


def _payne_hanek(x: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """X = n π/2 + y + low with |y| <= π/4, for 2^16 < x < infinity; n by its last bits.

    With x = m 2^e, of 2/π only 192 bits matter: those before stand for whole turns, those behind for less than 2^-126 of a
    quarter turn. A double comes no closer to a multiple of π/2 than 2^-62 (Muller, Elementary Functions, 3rd edition, 11.4).
    """
    builder, bits = x.builder, x.bits()
    mantissa = (bits & ((1 << 52) - 1)) | (1 << 52)
    window = _bits_of_two_over_pi(builder, (bits >> 52) - (1075 + 2 - 64))
    wide = ir.IntType(192)
    product = Lanes(builder, builder.mul(builder.zext(mantissa.value, wide), window))  # 2 bits of n, then its fraction
    fraction = product << 2
    negative = fraction < 0
    n = Lanes(builder, builder.trunc((product >> 190).value, INTEGER)) + negative.where(1, bits.constant(0))
    size = Lanes(builder, builder.trunc((negative.where(-fraction, fraction) >> 64).value, ir.IntType(128)))
    zeros = Lanes(builder, builder.ctlz(size.value, ir.Constant(ir.IntType(1), 0)))
    size = size << zeros
    high = Lanes(builder, builder.sitofp(builder.trunc((size >> 75).value, INTEGER), DOUBLE))
    low = Lanes(builder, builder.sitofp(builder.trunc((size >> 22 & ((1 << 53) - 1)).value, INTEGER), DOUBLE))
    scale = ((1023 - 53 - Lanes(builder, builder.trunc(zeros.value, INTEGER))) << 52).double()
    high, low = high * scale, low * (scale * 2.0**-53)
    y, lost = two_product(high, x.constant(HIGH))
    y, lost = two_sum(y, lost + (high * LOW + low * HIGH))
    return n, negative.where(-y, y), negative.where(-lost, lost)


def _bits_of_two_over_pi(builder: ir.IRBuilder, begin: Lanes) -> Value:
    """192 bits of 2/π with 64 zeros before it, from this place on."""
    kind = ir.ArrayType(INTEGER, len(WORDS))
    table: Value = ir.GlobalVariable(builder.module, kind, "rwjax.two_over_pi")
    table.linkage, table.global_constant = "internal", True
    table.initializer = ir.Constant(kind, WORDS)
    first, wide = begin >> 6, ir.IntType(256)
    window = ir.Constant(wide, 0)
    for k in range(4):
        place = builder.gep(table, [ir.Constant(INTEGER, 0), (first + k).value], inbounds=True, source_etype=kind)
        word = builder.zext(builder.load(place, typ=INTEGER), wide)
        window = builder.or_(window, builder.shl(word, ir.Constant(wide, 64 * (3 - k))))
    window = builder.shl(window, builder.zext((begin & 63).value, wide))
    return builder.trunc(builder.lshr(window, ir.Constant(wide, 64)), ir.IntType(192))
