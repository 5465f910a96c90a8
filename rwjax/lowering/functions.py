"""Mathematical functions of compiled programs: one function of a module for each name and number of lanes.

No library offers exponentials or sines of whole vectors that round alike everywhere. These give the same bits on every vector
unit, lane by lane the same as for a single number. They need neither fused multiplication nor a library at run time.
"""

from collections.abc import Callable

from llvmlite import ir

from rwjax.lowering import angles, exponentials
from rwjax.lowering.lanes import DOUBLE, Lanes, Value, packed, shaped

Body = Callable[..., Lanes | tuple[Lanes, Lanes]]


def maximum(a: Lanes, b: Lanes) -> Lanes:
    """The larger number, NaN if one is NaN; of 0 and -0 the second.

    Args:
        a: One number.
        b: The other.

    Returns:
        The larger one.
    """
    return a.nan().where(a, (a > b).where(a, b))


def minimum(a: Lanes, b: Lanes) -> Lanes:
    """The smaller number, NaN if one is NaN; of 0 and -0 the second.

    Args:
        a: One number.
        b: The other.

    Returns:
        The smaller one.
    """
    return a.nan().where(a, (a < b).where(a, b))


def sign(x: Lanes) -> Lanes:
    """1 above zero, -1 below; zeros of both signs and NaN stay.

    Args:
        x: Any number.

    Returns:
        Its sign.
    """
    return (x > 0.0).where(1.0, (x < 0.0).where(-1.0, x))


def _intrinsic(name: str) -> Body:
    """A function that LLVM turns into one instruction of every processor on which JAX runs (SSE4.1 and later)."""

    def body(x: Lanes) -> Lanes:
        full = f"llvm.{name}.{'' if x.count is None else f'v{x.count}'}f64"
        kind = ir.FunctionType(x.value.type, [x.value.type])
        known = x.builder.module.globals.get(full) or ir.Function(x.builder.module, kind, full)
        return Lanes(x.builder, x.builder.call(known, [x.value]))

    return body


BODIES: dict[str, Body] = {
    "exp": exponentials.exp,
    "exp2": exponentials.exp2,
    "expm1": exponentials.expm1,
    "log": exponentials.log,
    "log1p": exponentials.log1p,
    "pow": exponentials.power,
    "tanh": exponentials.tanh,
    "logistic": exponentials.logistic,
    "sine_and_cosine": angles.sine_and_cosine,
    "tan": angles.tan,
    "maximum": maximum,
    "minimum": minimum,
    "sign": sign,
    "floor": _intrinsic("floor"),
    "ceil": _intrinsic("ceil"),
    "round_even": _intrinsic("roundeven"),
}
SHORT = ("maximum", "minimum", "sign", "floor", "ceil", "round_even")
"""Functions of few instructions, which stand where they are called: a call has all other values moved to memory."""
PARTS = {"sin": ("sine_and_cosine", 0), "cos": ("sine_and_cosine", 1)}  # a sine beside its cosine costs nothing
PAIRS = {whole for whole, _ in PARTS.values()}
NAMES = (*BODIES, *PARTS)


def call(builder: ir.IRBuilder, name: str, *operands: Value) -> Value:
    """Calls a mathematical function, which is written into the module at its first call.

    Args:
        builder: Where the call is to stand.
        name: One of `NAMES`.
        operands: Doubles, or vectors of as many doubles each.

    Returns:
        The function's value, of its operands' type; for `sine_and_cosine` both.
    """
    whole, part = PARTS.get(name, (name, None))
    found = builder.call(_function(builder.module, whole, operands), operands)
    return found if part is None else builder.extract_value(found, part)


def _function(module: ir.Module, name: str, operands: tuple[Value, ...]) -> ir.Function:
    """The function `rwjax.<name>.<lanes>`, written if the module does not have it."""
    kind = operands[0].type
    lanes = kind.count if isinstance(kind, ir.VectorType) else 1
    if kind != shaped(DOUBLE, lanes if lanes > 1 else None) or any(operand.type != kind for operand in operands):
        raise TypeError(
            f"{name} takes doubles, or vectors of two or more doubles; got {', '.join(str(o.type) for o in operands)}"
        )
    full = f"rwjax.{name}.{lanes}"
    if full in module.globals:
        return module.globals[full]
    pair = ir.LiteralStructType([kind, kind])
    function = ir.Function(module, ir.FunctionType(pair if name in PAIRS else kind, [kind] * len(operands)), full)
    function.linkage = "internal"
    for attribute in ("nounwind", "readnone"):  # calls of the same operands are one call
        function.attributes.add(attribute)
    if name in SHORT:
        function.attributes.add("alwaysinline")
    inner = ir.IRBuilder(function.append_basic_block())
    found = BODIES[name](*(Lanes(inner, argument) for argument in function.args))
    if isinstance(found, Lanes):
        inner.ret(found.value)
    else:
        inner.ret(packed(inner, pair, found))
    return function
