"""The mutants of a module: its source with one small mistake each, such as `<` for `<=`, or a statement left out.

Not changed are docstrings, annotations, imports, the wording of messages (texts in a `raise` or with a blank in them), formats of
printed numbers, and the keyword `strict` of `zip`, which asserts what the lines above it see to.
"""

import ast
import copy
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
TURNED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
}
COMPUTED: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
}
"""What stands for an operator. Of any other, as `a | b`, which joins tables, sets and types too, `a` stays."""
SYMMETRIC = {"max", "maximum", "min", "minimum"}
"""Functions of which the order of the arguments says nothing."""
CONDITIONS = {"test", "ifs"}
"""Fields of a syntax tree that hold a condition."""


class Mutant(NamedTuple):
    """A module with one mistake: its path, the line and the words of the change, and its whole source."""

    path: str
    line: int
    change: str
    source: str


class Place(NamedTuple):
    """A part of a syntax tree: the field in which it stands, its line, whether it speaks to a user, and what puts another there."""

    node: ast.AST
    field: str
    line: int
    speaks: bool
    put: Callable[[Any], None]


def mutants(path: str, text: str) -> list[Mutant]:
    """Every mutant of a module's source that is another program, in the order of the source."""
    tree = ast.parse(text)
    found = {ast.unparse(tree): Mutant(path, 0, "", "")}
    for place in list(_places(tree, 0, False)):
        for other in _others(place):
            place.put(other)
            change = f"{_words(place.node)} -> {_words(other)}"
            source = ast.unparse(tree)
            found.setdefault(source, Mutant(path, place.line, change, source))
            place.put(place.node)
    return [mutant for mutant in found.values() if mutant.change]


def _words(node: ast.AST) -> str:
    text = " ".join(ast.unparse(node).split())
    return text if len(text) <= 70 else text[:69] + "…"


def _places(node: ast.AST, line: int, speaks: bool) -> Iterator[Place]:
    """All parts below a node that may be changed."""
    speaks = speaks or isinstance(node, ast.Raise)
    for field, value in ast.iter_fields(node):
        for i, child in enumerate(value if isinstance(value, list) else [value]):
            if not isinstance(child, ast.AST) or _is_kept(field, child):
                continue

            def put(other: Any, field: str = field, value: Any = value, i: int = i) -> None:
                if isinstance(value, list):
                    value[i] = other
                else:
                    setattr(node, field, other)

            place = Place(child, field, getattr(child, "lineno", line), speaks, put)
            yield place
            yield from _places(child, place.line, speaks)


def _is_kept(field: str, node: ast.AST) -> bool:
    """Whether a part is never changed."""
    match node:
        case ast.Import() | ast.ImportFrom() | ast.Expr(value=ast.Constant(value=str())):
            return True
        case ast.If(test=ast.Name(id="TYPE_CHECKING")) | ast.keyword(arg="strict"):
            return True
    return field in ("annotation", "returns", "format_spec")


def _others(place: Place) -> Iterator[Any]:
    """What may stand in a place by mistake."""
    node = place.node
    if place.field in CONDITIONS and not isinstance(node, ast.Compare | ast.UnaryOp):
        yield ast.UnaryOp(ast.Not(), node)
    match node:
        case ast.stmt():
            yield from _other_statements(node)
        case ast.Constant():
            yield from _other_constants(node.value, place.speaks)
        case ast.Compare():
            for table in (COMPARED, TURNED):
                for i, op in enumerate(node.ops):
                    if type(op) in table:
                        yield _with(node, ops=[*node.ops[:i], table[type(op)](), *node.ops[i + 1 :]])
        case ast.BoolOp():
            yield _with(node, op=ast.Or() if isinstance(node.op, ast.And) else ast.And())
        case ast.UnaryOp():
            yield node.operand
        case ast.BinOp():
            yield _with(node, op=COMPUTED[type(node.op)]()) if type(node.op) in COMPUTED else node.left
        case ast.Slice():
            for bound in ("lower", "upper"):
                if (given := getattr(node, bound)) is not None:
                    yield _with(node, **{bound: None})
                    yield _with(node, **{bound: ast.BinOp(given, ast.Add(), ast.Constant(1))})
        case ast.Call():
            yield from _other_calls(node)


def _other_statements(node: ast.stmt) -> Iterator[ast.stmt]:
    match node:
        case ast.Return(value=ast.expr() as value) if not _is_none(value):
            yield ast.Return(ast.Constant(None))
        case ast.Expr() | ast.Raise() | ast.Delete():
            yield ast.Pass()
        case ast.AugAssign():
            yield ast.Pass()
            if type(node.op) in COMPUTED:
                yield _with(node, op=COMPUTED[type(node.op)]())
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
            yield ast.Pass()
        case ast.Break():
            yield ast.Continue()
        case ast.Continue():
            yield ast.Break()


def _other_constants(value: Any, speaks: bool) -> Iterator[ast.Constant]:
    match value:
        case bool():
            yield ast.Constant(not value)
        case int():
            yield ast.Constant(value + 1)
        case float():
            yield ast.Constant(1.1 * value if value else 1.0)
        case str() if not speaks and " " not in value and any(map(str.isalpha, value)):
            yield ast.Constant(value + "X")


def _other_calls(node: ast.Call) -> Iterator[ast.Call]:
    name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    first, second, *rest = [*node.args, None, None]
    if second is not None and name not in SYMMETRIC and not any(isinstance(a, ast.Starred) for a in (first, second)):
        yield _with(node, args=[second, first, *rest[:-2]])
    for i, keyword in enumerate(node.keywords):
        if keyword.arg not in (None, "strict"):
            yield _with(node, keywords=[*node.keywords[:i], *node.keywords[i + 1 :]])


def _with(node: ast.AST, **changes: Any) -> Any:
    other = copy.copy(node)
    for name, value in changes.items():
        setattr(other, name, value)
    return other


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None
