"""Values of a compiled function, one number or several side by side, with the operators of numbers.

Doubles and integers are told apart by their type. No operation may be reordered, contracted or approximated: what comes out is
the same, bit by bit, on every vector unit.
"""

from typing import Any, NamedTuple, TypeAlias

from llvmlite import ir

DOUBLE, INTEGER, BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
Value: TypeAlias = Any  # an `ir.Value`, of whose members llvmlite declares no types
Operand: TypeAlias = "Lanes | float | int"


class Lanes(NamedTuple):
    """A value of a function that is being written; Python's numbers become constants in each lane."""

    builder: ir.IRBuilder
    value: Value

    @property
    def count(self) -> int | None:
        """Number of lanes, None for a single number."""
        return self.value.type.count if isinstance(self.value.type, ir.VectorType) else None

    @property
    def element(self) -> ir.Type:
        """Type of one lane."""
        return self.value.type if self.count is None else self.value.type.element

    def constant(self, number: float | int, element: ir.Type | None = None) -> "Lanes":
        """The same number in as many lanes.

        Args:
            number: What stands in each lane [1].
            element: Type of one lane, of this value's by default.

        Returns:
            The constant.
        """
        element = element or self.element
        return Lanes(self.builder, ir.Constant(shaped(element, self.count), _spread(number, self.count)))

    def _both(self, for_doubles: str, for_integers: str, a: Operand, b: Operand) -> "Lanes":
        x, y = (v.value if isinstance(v, Lanes) else self.constant(v).value for v in (a, b))
        return Lanes(self.builder, getattr(self.builder, for_doubles if self.element == DOUBLE else for_integers)(x, y))

    def __add__(self, other: Operand) -> "Lanes":  # type: ignore[override]
        return self._both("fadd", "add", self, other)

    def __radd__(self, other: Operand) -> "Lanes":
        return self._both("fadd", "add", other, self)

    def __sub__(self, other: Operand) -> "Lanes":
        return self._both("fsub", "sub", self, other)

    def __rsub__(self, other: Operand) -> "Lanes":
        return self._both("fsub", "sub", other, self)

    def __mul__(self, other: Operand) -> "Lanes":  # type: ignore[override]
        return self._both("fmul", "mul", self, other)

    def __rmul__(self, other: Operand) -> "Lanes":  # type: ignore[override]
        return self._both("fmul", "mul", other, self)

    def __truediv__(self, other: Operand) -> "Lanes":
        return self._both("fdiv", "sdiv", self, other)

    def __rtruediv__(self, other: Operand) -> "Lanes":
        return self._both("fdiv", "sdiv", other, self)

    def __neg__(self) -> "Lanes":
        return Lanes(
            self.builder, self.builder.fneg(self.value) if self.element == DOUBLE else self.builder.neg(self.value)
        )

    def __abs__(self) -> "Lanes":
        return (self.bits() & ((1 << 63) - 1)).double()

    def __invert__(self) -> "Lanes":
        return Lanes(self.builder, self.builder.not_(self.value))

    def __and__(self, other: Operand) -> "Lanes":
        return self._both("", "and_", self, other)

    def __or__(self, other: Operand) -> "Lanes":
        return self._both("", "or_", self, other)

    def __xor__(self, other: Operand) -> "Lanes":
        return self._both("", "xor", self, other)

    def __lshift__(self, other: Operand) -> "Lanes":
        return self._both("", "shl", self, other)

    def __rshift__(self, other: Operand) -> "Lanes":
        """Moved right, with zeros from the left."""
        return self._both("", "lshr", self, other)

    def __lt__(self, other: Operand) -> "Lanes":  # type: ignore[override]
        return self._compared("<", other)

    def __le__(self, other: Operand) -> "Lanes":  # type: ignore[override]
        return self._compared("<=", other)

    def __gt__(self, other: Operand) -> "Lanes":  # type: ignore[override]
        return self._compared(">", other)

    def __ge__(self, other: Operand) -> "Lanes":  # type: ignore[override]
        return self._compared(">=", other)

    def _compared(self, how: str, other: Operand) -> "Lanes":
        y = other.value if isinstance(other, Lanes) else self.constant(other).value
        compare = self.builder.fcmp_ordered if self.element == DOUBLE else self.builder.icmp_signed
        return Lanes(self.builder, compare(how, self.value, y))

    def equals(self, other: Operand) -> "Lanes":
        """Where both are equal numbers.

        Args:
            other: The other value.

        Returns:
            A bit for each lane.
        """
        return self._compared("==", other)

    def nan(self) -> "Lanes":
        """Where this is no number.

        Returns:
            A bit for each lane.
        """
        return Lanes(self.builder, self.builder.fcmp_unordered("uno", self.value, self.value))

    def bits(self) -> "Lanes":
        """The 64 bits of each double.

        Returns:
            Them as integers.
        """
        return Lanes(self.builder, self.builder.bitcast(self.value, shaped(INTEGER, self.count)))

    def double(self) -> "Lanes":
        """The doubles that have these 64 bits each.

        Returns:
            The doubles.
        """
        return Lanes(self.builder, self.builder.bitcast(self.value, shaped(DOUBLE, self.count)))

    def where(self, yes: Operand, no: Operand) -> "Lanes":
        """One of two values by this bit.

        Args:
            yes: Value where the bit is set.
            no: Value where it is not.

        Returns:
            The chosen ones, lane by lane.
        """
        known = yes if isinstance(yes, Lanes) else no
        x, y = (v if isinstance(v, Lanes) else self.constant(v, _element(known)) for v in (yes, no))
        return Lanes(self.builder, self.builder.select(self.value, x.value, y.value))


def _element(value: Operand) -> ir.Type:
    return value.element if isinstance(value, Lanes) else DOUBLE


def _spread(number: float | int, count: int | None) -> float | int | list:
    return number if count is None else [number] * count


def shaped(element: ir.Type, count: int | None) -> ir.Type:
    """Type of so many values side by side.

    Args:
        element: Type of one.
        count: How many, None for a single one outside a vector.

    Returns:
        The type.
    """
    return element if count is None else ir.VectorType(element, count)


def packed(builder: ir.IRBuilder, kind: ir.LiteralStructType, parts: "tuple[Lanes, ...]") -> Value:
    """Several values as one, so that a function can return them.

    Args:
        builder: Where they are packed.
        kind: Type of the whole.
        parts: The values, in order.

    Returns:
        The whole.
    """
    whole = ir.Constant(kind, ir.Undefined)
    for k, part in enumerate(parts):
        whole = builder.insert_value(whole, part.value, k)
    return whole


def polynomial(x: Lanes, coefficients: tuple[float, ...]) -> Lanes:
    """A polynomial, summed in pairs, pairs of pairs and so on (Estrin): its parts do not wait for each other.

    Args:
        x: Argument.
        coefficients: From the constant up [1].

    Returns:
        Its values.
    """
    terms: list[Operand] = [*coefficients]
    while len(terms) > 1:
        pairs = [low + high * x for low, high in zip(terms[::2], terms[1::2], strict=False)]
        terms = [*pairs, *terms[2 * len(pairs) :]]
        x = x * x if len(terms) > 1 else x
    return terms[0] if isinstance(terms[0], Lanes) else x.constant(terms[0])


def two_sum(a: Operand, b: Lanes) -> tuple[Lanes, Lanes]:
    """A sum and what rounding took from it, exactly (Knuth).

    Args:
        a: One summand.
        b: The other.

    Returns:
        The rounded sum, and what is missing.
    """
    total = a + b
    rest = total - a
    return total, (a - (total - rest)) + (b - rest)


def fast_two_sum(a: Operand, b: Lanes) -> tuple[Lanes, Lanes]:
    """A sum and what rounding took from it, exactly if b is not the larger one (Dekker).

    Args:
        a: The larger summand.
        b: The smaller one.

    Returns:
        The rounded sum, and what is missing.
    """
    total = a + b
    return total, b - (total - a)


def head(x: Lanes, dropped: int = 27) -> Lanes:
    """The value with its last bits set to zero, so that a product of two heads is exact.

    Args:
        x: A double.
        dropped: How many of its 53 bits are dropped.

    Returns:
        The double towards zero from it with so many bits less.
    """
    return (x.bits() & -(1 << dropped)).double()


def two_product(a: Lanes, b: Lanes) -> tuple[Lanes, Lanes]:
    """A product and what rounding took from it.

    Args:
        a: One factor.
        b: The other.

    Returns:
        The rounded product, and what is missing, to 2^-50 of itself.
    """
    a1, b1 = head(a), head(b)
    a2, b2 = a - a1, b - b1
    total = a * b
    return total, ((a1 * b1 - total) + a1 * b2 + a2 * b1) + a2 * b2
