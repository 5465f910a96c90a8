"""Numbers that follow from others, `[fit.tied]`: formulas read, checked and evaluated."""

import ast
import math
import operator
import warnings
from collections.abc import Collection, Mapping
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np

from rwjax.errors import RigError, nearest, no_name
from rwjax.kinds import COEFFICIENTS, KEYS, NUMBERS, POLYNOMIAL
from rwjax.rig.document import number, shown
from rwjax.rig.effect_section import effect_parameters, rig_value

_OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "abs")
"""Functions of one number that a formula may hold."""


@cache
def _parsed(text: str) -> ast.expr:
    """The tree of a formula; `RigError` with the rest of a sentence where it is none."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(text.strip(), mode="eval").body
        _check(tree)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise RigError("is no formula") from None
    return tree


def _check(node: ast.AST) -> None:
    """Raises `ValueError` for anything but arithmetic of numbers and names."""
    if isinstance(node, ast.BinOp | ast.UnaryOp):
        if type(node.op) not in _OPERATORS:
            raise ValueError
        for part in (node.left, node.right) if isinstance(node, ast.BinOp) else (node.operand,):
            _check(part)
    elif isinstance(node, ast.Call):
        if _name(node.func) not in FUNCTIONS or len(node.args) != 1 or node.keywords:
            raise ValueError
        _check(node.args[0])
    elif not isinstance(node, ast.Name | ast.Attribute):
        if not isinstance(node, ast.Constant) or type(node.value) not in (int, float):
            raise ValueError
    elif not _name(node):
        raise ValueError


def _name(node: ast.AST) -> str:
    """A dotted name, "" for anything else."""
    if isinstance(node, ast.Attribute):
        before = _name(node.value)
        return f"{before}.{node.attr}" if before else ""
    return node.id if isinstance(node, ast.Name) else ""


def names_in(formula: str) -> tuple[str, ...]:
    """Names of the numbers from which a formula makes another one.

    Args:
        formula: The formula.

    Returns:
        The names, each once.

    Raises:
        RigError: It is no formula.
    """

    def within(node: ast.AST) -> list[str]:
        if isinstance(node, ast.Name | ast.Attribute):
            return [_name(node)]
        parts = node.args if isinstance(node, ast.Call) else ast.iter_child_nodes(node)
        return [name for part in parts for name in within(part)]

    return tuple(dict.fromkeys(within(_parsed(formula))))


def evaluate(formula: str, values: Mapping[str, Any], functions: ModuleType = np) -> Any:
    """What a formula makes of numbers.

    Args:
        formula: The formula.
        values: Values of the names in it [SI].
        functions: Module with the `FUNCTIONS`, that of the values' arrays.

    Returns:
        The result [SI].
    """

    def of(node: ast.AST) -> Any:
        if isinstance(node, ast.BinOp):
            exponent = node.right.value if isinstance(node.right, ast.Constant) else of(node.right)
            right = exponent if isinstance(node.op, ast.Pow) else of(node.right)
            return _OPERATORS[type(node.op)](of(node.left), right)
        if isinstance(node, ast.UnaryOp):
            return _OPERATORS[type(node.op)](of(node.operand))
        if isinstance(node, ast.Call):
            return getattr(functions, _name(node.func))(of(node.args[0]))
        return functions.float64(node.value) if isinstance(node, ast.Constant) else values[_name(node)]

    return of(_parsed(formula))


def completed(tied: Mapping[str, str], values: Mapping[str, float]) -> dict[str, float]:
    """Numbers with those that follow from others.

    Args:
        tied: Formulas by the name of the number, each behind those on which it depends.
        values: All numbers [SI], the others' values as they are.

    Returns:
        All numbers [SI].
    """
    found = dict(values)
    with np.errstate(all="ignore"):
        for name, formula in tied.items():
            found[name] = float(evaluate(formula, {n: np.float64(v) for n, v in found.items()}))
    return found


def with_constants(formula: str, values: Mapping[str, float]) -> str:
    """A formula with numbers in the place of some names.

    Args:
        formula: The formula.
        values: Values [SI] by the names to replace.

    Returns:
        The formula without these names.
    """

    class Replaced(ast.NodeTransformer):
        def visit(self, node: ast.AST) -> Any:
            known = _name(node) in values
            return ast.Constant(float(values[_name(node)])) if known else self.generic_visit(node)

    return ast.unparse(Replaced().visit(ast.parse(formula.strip(), mode="eval").body))


def tied_section(
    stated: Mapping[str, Any], table: Mapping[str, Any], kind: str
) -> tuple[dict[str, str], dict[str, float]]:
    """The table `[fit.tied]` of a rig file.

    Args:
        stated: Unchecked values of the file's numbers by name, `EFFECT.PARAMETER` for those of effects.
        table: Formulas by name, unchecked.
        kind: Kind of the rig.

    Returns:
        The formulas, each behind those on which it depends, and the numbers that they make [SI].

    Raises:
        RigError: For a name that the rig lacks, anything but a formula, a circle, and a result that no such number may be.
    """
    effects = {name.rpartition(".")[0] for name in stated if name not in NUMBERS}
    of_effects = [
        f"{e}.{p}" for e, known in (effect_parameters(kind) if effects else {}).items() if e in effects for p in known
    ]
    able = [*(n for n, kinds in KEYS.items() if kind in kinds and n in NUMBERS), *of_effects]
    able += [name for name in COEFFICIENTS if name in stated]
    for name, formula in table.items():
        key = f"fit.tied.{name}"
        if name not in able:
            raise RigError(f"`{key}`: a `{kind}` rig has no `{name}`; the nearest is `{nearest(name, able)}`")
        if not isinstance(formula, str):
            raise RigError(
                f'`{key}` is {shown(formula)}; it has to be a formula in quotes, such as "axis.inertia * 9.0"'
            )
        if wrong := no_name(formula):
            raise RigError(f"`{key}` {wrong}")
        _check_names(key, formula, {*stated, *table}, able)
    order = _in_order(table)
    return order, _values(order, stated)


def _check_names(key: str, formula: str, held: Collection[str], able: Collection[str]) -> None:
    """`RigError` for anything but a formula of numbers that the file holds."""
    try:
        names = names_in(formula)
    except RigError as error:
        raise RigError(
            f'`{key}` {error}: "{formula}"; write numbers and names with + - * / ** ( ) and {", ".join(FUNCTIONS)}'
        ) from None
    for name in (name for name in names if name not in held):
        if name in able:
            raise RigError(f"`{key}` takes `{name}`, which has no value in this file; give it one")
        raise RigError(f"`{key}` takes `{name}`, no number of this file; the nearest is `{nearest(name, held)}`")


def _in_order(table: Mapping[str, str]) -> dict[str, str]:
    """The formulas, each behind those on which it depends; `RigError` for a circle."""
    order: dict[str, str] = {}

    def place(name: str, way: tuple[str, ...]) -> None:
        if name in way:
            circle = " from ".join(f"`{n}`" for n in (*way[way.index(name) :], name))
            raise RigError(f"`fit.tied` goes in a circle: {circle}; give one of them a value of its own")
        for other in names_in(table[name]):
            if other in table and other not in order:
                place(other, (*way, name))
        order.setdefault(name, table[name])

    for name in table:
        place(name, ())
    return order


def _values(order: Mapping[str, str], stated: Mapping[str, Any]) -> dict[str, float]:
    """What the formulas make of the file's values [SI]; `RigError` where no such number may be that."""
    needed = dict.fromkeys(name for formula in order.values() for name in names_in(formula) if name not in order)
    known, found = {name: number(name, stated[name]) for name in needed}, {}
    for name, formula in order.items():
        value = completed({name: formula}, known | found)[name]
        if not math.isfinite(value):
            raise RigError(
                f'`fit.tied.{name}`: "{formula}" is no finite number with the values of this file; change one of them'
            )
        found[name] = rig_value(name, value, f"fit.tied.{name}")
    return found


def with_tied(stated: dict[str, Any], found: Mapping[str, float]) -> None:
    """Puts numbers that follow from others among the values of a file.

    Args:
        stated: Values by dotted name; those of the numbers are replaced or added.
        found: The numbers [SI].
    """
    for name, value in found.items():
        if name in COEFFICIENTS:
            stated[POLYNOMIAL] = [
                value if n == name else v for n, v in zip(COEFFICIENTS, stated[POLYNOMIAL], strict=True)
            ]
        else:
            stated[name] = value
