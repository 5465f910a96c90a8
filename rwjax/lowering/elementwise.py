"""What primitives of JAX do to single numbers, as instructions."""

import operator
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir

from rwjax.lowering import functions
from rwjax.lowering.emitter import TYPES, Emitter, Term, Unsupported

COMPARED = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!="}
NUMBERS = {"add": "fadd", "add_any": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
WHOLE = {"add": "add", "add_any": "add", "sub": "sub", "mul": "mul", "div": "sdiv", "rem": "srem"}
LOGIC = {"and": "and_", "or": "or_", "xor": "xor"}
OF_PYTHON = {
    "add": operator.add,
    "add_any": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    **{name: getattr(operator, name) for name in COMPARED},
}
"""Operations on two numbers of Python that are worked out when the program is lowered."""
FUNCTIONS = (
    "exp",
    "exp2",
    "expm1",
    "log",
    "log1p",
    "sin",
    "cos",
    "tan",
    "tanh",
    "logistic",
    "pow",
    "sign",
    "max",
    "min",
)
"""Functions of `rwjax.lowering.functions`, by the names of JAX's primitives."""
NAMES = {"max": "maximum", "min": "minimum"}


class Operation(NamedTuple):
    """A primitive applied to single numbers.

    Attributes:
        name: Its name.
        kinds: Kinds of its operands.
        result: Kind of its result.
        params: Its parameters.
    """

    name: str
    kinds: str
    result: str
    params: dict[str, Any]


def is_elementwise(name: str) -> bool:
    """Whether a primitive is lowered here.

    Args:
        name: Name of the primitive.

    Returns:
        True where `emit` knows it.
    """
    return name in RULES


def emit(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    """Emits a primitive.

    Args:
        e: Where to.
        of: The primitive.
        terms: Its operands.

    Returns:
        Its result.
    """
    if of.name in OF_PYTHON and not any(isinstance(term, ir.Value) for term in terms):
        with np.errstate(all="ignore"):
            return OF_PYTHON[of.name](*terms)
    return RULES[of.name](e, of, terms)


def _arithmetic(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    kind, (a, b) = of.kinds[0], terms
    if kind == "f" and (found := _trivial(of.name, a, b)) is not None:
        return found
    if kind == "f" and of.name == "div" and (inverse := e.inverse(b)) is not None:
        return e.builder.fmul(*e.alike("ff", a, inverse))
    if kind == "b":
        return getattr(e.builder, {"add": "or_", "mul": "and_"}[of.name])(*e.alike("bb", *terms))
    if kind == "i" and of.name in ("div", "rem"):
        return _whole_division(e, of.name, *terms)
    if kind == "f" and of.name not in NUMBERS:
        raise Unsupported(f"{of.name} of numbers with fractions")
    names = NUMBERS if kind == "f" else WHOLE
    return getattr(e.builder, names[of.name])(*e.alike(kind * 2, *terms))


def _whole_division(e: Emitter, name: str, a: Term, b: Term) -> Term:
    """Quotient or rest of whole numbers as JAX has them; the processor stops at 0, and at the lowest number by -1."""
    by_zero, by_minus = (_compared(e, Operation("eq", "ii", "b", {}), [b, k]) for k in (0, -1))
    kept = emit(e, Operation("or", "bb", "b", {}), [by_zero, by_minus])
    one, quotient = Operation("select_n", "bii", "i", {}), name == "div"
    safe = _selected(e, one, [kept, b, 1])
    found = getattr(e.builder, WHOLE[name])(*e.alike("ii", a, safe))
    negative = e.builder.neg(e.alike("ii", a, b)[0]) if quotient else 0
    return _selected(e, one, [by_zero, _selected(e, one, [by_minus, found, negative]), -1 if quotient else a])


def _trivial(name: str, a: Term, b: Term) -> Term | None:
    """A sum with 0, a product with 1; None for any other."""
    for one, other in ((a, b), (b, a)):
        if isinstance(one, ir.Value):
            continue
        if one == {"add": 0.0, "add_any": 0.0, "mul": 1.0}.get(name):
            return other
    return a if name in ("sub", "div") and not isinstance(b, ir.Value) and b == {"sub": 0.0, "div": 1.0}[name] else None


def _compared(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    sign, (a, b) = COMPARED[of.name], e.alike(of.kinds, *terms)
    if of.kinds[0] == "f":
        return (e.builder.fcmp_unordered if sign == "!=" else e.builder.fcmp_ordered)(sign, a, b)
    return (e.builder.icmp_signed if of.kinds[0] == "i" else e.builder.icmp_unsigned)(sign, a, b)


def _logic(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    return getattr(e.builder, LOGIC[of.name])(*e.alike(of.kinds, *terms))


def _not(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    return e.builder.not_(e.alike(of.kinds, *terms)[0])


def _negative(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    (a,) = e.alike(of.kinds, *terms)
    return e.builder.fneg(a) if of.kinds == "f" else e.builder.neg(a)


def _selected(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    which, no, yes = terms
    if of.kinds[0] == "i":
        which = _compared(e, Operation("ne", "ii", "b", {}), [which, 0])
    if not isinstance(which, ir.Value):
        return yes if which else no
    if yes is no or (not isinstance(yes, ir.Value) and not isinstance(no, ir.Value) and yes == no):
        return yes
    chosen, a, b = e.alike("b" + of.kinds[1:], which, yes, no)
    return e.builder.select(chosen, a, b)


def _clamped(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    low, value, high = terms
    most = emit(e, Operation("max", of.kinds[:2], of.result, {}), [low, value])
    return emit(e, Operation("min", of.kinds[:2], of.result, {}), [most, high])


def _extreme(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    values = e.alike(of.kinds, *terms)
    if of.kinds[0] == "f":
        return functions.call(e.builder, NAMES[of.name], *values)
    if of.kinds[0] == "b":
        return (e.builder.or_ if of.name == "max" else e.builder.and_)(*values)
    return e.intrinsic({"max": "smax", "min": "smin"}[of.name], *values)


def _sign(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    (a,) = e.alike(of.kinds, *terms)
    if of.kinds == "f":
        return functions.call(e.builder, "sign", a)
    below, above = e.alike("ii", -1, 1) if not e.is_vector(a) else (e.vector(-1, "i"), e.vector(1, "i"))
    return e.intrinsic("smin", e.intrinsic("smax", a, below), above)


def _function(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    return functions.call(e.builder, of.name, *e.alike(of.kinds, *terms))


def _of_llvm(name: str) -> Callable:
    def rule(e: Emitter, of: Operation, terms: list[Term]) -> Term:
        return e.intrinsic(name, e.alike(of.kinds, *terms)[0])

    return rule


def _absolute(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    (a,) = e.alike(of.kinds, *terms)
    if of.kinds == "f":
        return e.intrinsic("fabs", a)
    return e.intrinsic("smax", a, e.builder.neg(a))


def _rounded(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    to_even = int(of.params["rounding_method"]) == 1
    return e.intrinsic("roundeven" if to_even else "round", e.alike("f", *terms)[0])


def _whole_power(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    (a,), n = e.alike(of.kinds, *terms), of.params["y"]
    one = e.vector(1.0, "f") if e.is_vector(a) else e.constant(1.0, "f")
    found, square, left = None, a, abs(n)
    while left:
        if left & 1:
            found = square if found is None else e.builder.fmul(found, square)
        left >>= 1
        if left:
            square = e.builder.fmul(square, square)
    found = one if found is None else found
    return e.builder.fdiv(one, found) if n < 0 else found


def _power(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    """A power; by products where the program itself gives a small whole number as the exponent."""
    base, exponent = terms
    if isinstance(exponent, ir.Value) or exponent not in (1.0, 2.0, 3.0):
        return _function(e, of, terms)
    return _whole_power(e, Operation("integer_pow", "f", "f", {"y": int(exponent)}), [base])


def _square(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    return _arithmetic(e, Operation("mul", of.kinds * 2, of.result, {}), [terms[0], terms[0]])


def _one_minus_square(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    (a,) = e.alike(of.kinds, *terms)
    one = e.vector(1.0, "f") if e.is_vector(a) else e.constant(1.0, "f")
    return e.builder.fmul(e.builder.fadd(one, a), e.builder.fsub(one, a))


def _converted(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    term: Any = terms[0]
    given, wanted = of.kinds, of.result
    if given == wanted:
        return term
    if not isinstance(term, ir.Value):
        return {"f": float, "i": int, "b": bool}[wanted](term)
    kind = TYPES[wanted]
    target = ir.VectorType(kind, e.lanes) if e.is_vector(term) else kind
    if wanted == "b":
        zero = e.vector(0, given) if e.is_vector(term) else e.constant(0, given)
        compare = e.builder.fcmp_unordered if given == "f" else e.builder.icmp_signed
        return compare("!=", term, zero)
    if given == "b":
        return (e.builder.uitofp if wanted == "f" else e.builder.zext)(term, target)
    if wanted == "f":
        return e.builder.sitofp(term, target)
    suffix = f"v{e.lanes}i64.v{e.lanes}f64" if e.is_vector(term) else "i64.f64"
    (value,) = e.alike("f", term)
    return e.builder.call(e.function(f"llvm.fptosi.sat.{suffix}", target, [value.type]), [value])


def _finite(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    (a,) = e.alike("f", *terms)
    bound = e.vector(float("inf"), "f") if e.is_vector(a) else e.constant(float("inf"), "f")
    return e.builder.fcmp_ordered("<", e.intrinsic("fabs", a), bound)


def _root(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    root = e.intrinsic("sqrt", e.alike("f", *terms)[0])
    if of.name == "sqrt":
        return root
    one = e.vector(1.0, "f") if e.is_vector(root) else e.constant(1.0, "f")
    return e.builder.fdiv(one, root)


def _same(e: Emitter, of: Operation, terms: list[Term]) -> Term:
    return terms[0]


RULES: dict[str, Callable[[Emitter, Operation, list[Term]], Term]] = {
    **dict.fromkeys((*NUMBERS, "rem"), _arithmetic),
    **dict.fromkeys(COMPARED, _compared),
    **dict.fromkeys(LOGIC, _logic),
    **dict.fromkeys(("max", "min"), _extreme),
    **dict.fromkeys((name for name in FUNCTIONS if name not in ("max", "min", "sign")), _function),
    **dict.fromkeys(("sqrt", "rsqrt"), _root),
    **dict.fromkeys(("copy", "copy_p", "optimization_barrier", "stop_gradient"), _same),
    "not": _not,
    "neg": _negative,
    "select_n": _selected,
    "clamp": _clamped,
    "sign": _sign,
    "abs": _absolute,
    "floor": _of_llvm("floor"),
    "ceil": _of_llvm("ceil"),
    "round": _rounded,
    "integer_pow": _whole_power,
    "pow": _power,
    "square": _square,
    "one_minus_square": _one_minus_square,
    "convert_element_type": _converted,
    "is_finite": _finite,
}
"""Rule of each primitive by its name."""
