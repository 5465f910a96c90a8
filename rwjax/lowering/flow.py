"""A jaxpr as a flat list of equations, and over what its values differ."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, Literal, Var

from rwjax.lowering.arrays import SAME, Spread

CALLS = {
    "jit": "jaxpr",
    "pjit": "jaxpr",
    "closed_call": "call_jaxpr",
    "core_call": "call_jaxpr",
    "custom_jvp_call": "call_jaxpr",
}
"""Primitives that call a program, and the name under which they hold it."""
CALLS |= {"custom_vjp_call": "call_jaxpr", "remat2": "jaxpr", "checkpoint": "jaxpr", "custom_lin": "jaxpr"}


class Constant(NamedTuple):
    """A constant of a jaxpr in the place of a variable."""

    value: Any


ONE_BY_ONE = ("scan", "while", "cond", "empty")
"""Primitives that are not looked for among those that were worked out before."""
ABSENT = object()
"""An operand of a loop that nothing in it asks for, in the place of a variable."""


class Equation(NamedTuple):
    """A primitive and what it is applied to.

    Attributes:
        name: Name of the primitive.
        params: Its parameters.
        inputs: Names of variables, literals or constants.
        outputs: Names of variables with their shapes.
        avals: Shape and type of each output.
    """

    name: str
    params: dict[str, Any]
    inputs: list
    outputs: list
    avals: list


@dataclass(frozen=True, eq=False)
class Program:
    """Equations in the order in which they are worked out.

    Attributes:
        inputs: Names of the arguments.
        equations: The equations, none of them a call.
        outputs: Names of the results.
    """

    inputs: list
    equations: list[Equation]
    outputs: list


@lru_cache(maxsize=512)
def flattened(closed: ClosedJaxpr | Jaxpr) -> Program:
    """A jaxpr with all calls written out, and without what nothing needs.

    Args:
        closed: The jaxpr.

    Returns:
        Its equations.
    """
    jaxpr = closed.jaxpr if isinstance(closed, ClosedJaxpr) else closed
    constants = closed.consts if isinstance(closed, ClosedJaxpr) else []
    equations: list[Equation] = []
    names = {v: object() for v in jaxpr.invars}
    outputs = _written_out(jaxpr, constants, names, equations)
    return _needed(_without_repeats(Program([names[v] for v in jaxpr.invars], equations, outputs)))


def _written_out(jaxpr: Jaxpr, constants: Sequence, names: dict[Var, Any], equations: list[Equation]) -> list:
    names |= {v: Constant(c) for v, c in zip(jaxpr.constvars, constants, strict=True)}

    def read(v: Any) -> Any:
        return v if isinstance(v, Literal) else names[v]

    for eqn in jaxpr.eqns:
        name, inputs = eqn.primitive.name, [read(v) for v in eqn.invars]
        if name == "platform_index":
            names[eqn.outvars[0]] = Constant(_of_processor(eqn.params["platforms"]))
            continue
        if (inner := _called(name, eqn.params, inputs)) is not None:
            body = inner.jaxpr if isinstance(inner, ClosedJaxpr) else inner
            held = inner.consts if isinstance(inner, ClosedJaxpr) else []
            given = inputs[1:] if name == "cond" else inputs
            found = _written_out(body, held, dict(zip(body.invars, given, strict=True)), equations)
            names |= dict(zip(eqn.outvars, found, strict=True))
            continue
        outputs = [object() for _ in eqn.outvars]
        names |= dict(zip(eqn.outvars, outputs, strict=True))
        equations.append(Equation(name, _counted(eqn.params), inputs, outputs, [v.aval for v in eqn.outvars]))
    return [read(v) for v in jaxpr.outvars]


def _counted(params: dict[str, Any]) -> dict[str, Any]:
    """Parameters of a primitive; of a scan with how many operands stay and are handed on, which JAX 0.11 keeps as trees."""
    if "ft_in" not in params:
        return params
    stays, handed_on, _ = params["ft_in"].unpack()
    return params | {"num_consts": len(stays), "num_carry": len(handed_on)}


def _without_repeats(program: Program) -> Program:
    """The equations without those that work out the same once more."""
    known: dict[Any, list[Equation]] = {}
    stands_for: dict[int, Any] = {}
    kept = []

    def name(v: Any) -> Any:
        if isinstance(v, Literal) and not np.ndim(v.val):
            value = np.asarray(v.val)
            return ("literal", value.dtype, value.tobytes())  # which tells -0.0 from 0.0
        return id(stands_for.get(id(v), v))

    for q in program.equations:
        inputs = [stands_for.get(id(v), v) for v in q.inputs]
        if q.name not in ONE_BY_ONE:
            alike = known.setdefault((q.name, *map(name, q.inputs)), [])
            if (same := next((one for one in alike if _same(one, q)), None)) is not None:
                stands_for |= zip(map(id, q.outputs), same.outputs, strict=True)
                continue
            alike.append(q)
        kept.append(q._replace(inputs=inputs))
    return Program(program.inputs, kept, [stands_for.get(id(v), v) for v in program.outputs])


def _same(one: Equation, other: Equation) -> bool:
    """Whether two equations of one primitive with the same operands have the same parameters and results."""

    def written(params: dict[str, Any]) -> dict[str, Any]:
        return {k: id(v) if hasattr(v, "eqns") else repr(v) for k, v in params.items()}

    avals = zip(one.avals, other.avals, strict=True)
    alike = all((a.shape, a.dtype) == (b.shape, b.dtype) for a, b in avals)
    return alike and written(one.params) == written(other.params)


def invariant(program: Program, moving: Sequence) -> tuple[list[Equation], list[Equation]]:
    """The equations that do not depend on some variables, and all others.

    Args:
        program: The program.
        moving: Names of the variables.

    Returns:
        Both, in order.
    """
    depends = {id(v) for v in moving}
    still, rest = [], []
    for q in program.equations:
        if any(id(v) in depends for v in q.inputs):
            depends |= {id(v) for v in q.outputs}
            rest.append(q)
        else:
            still.append(q)
    return still, rest


def _called(name: str, params: dict[str, Any], inputs: Sequence) -> ClosedJaxpr | Jaxpr | None:
    """The program that a primitive stands for: that of a call, or the branch that is known when the program is lowered."""
    if name in CALLS:
        return params[CALLS[name]]
    if name == "cond" and isinstance(inputs[0], Constant | Literal):
        index = inputs[0].value if isinstance(inputs[0], Constant) else inputs[0].val
        return params["branches"][min(max(int(index), 0), len(params["branches"]) - 1)]
    return None


def _of_processor(platforms: Sequence[tuple[str, ...] | None]) -> int:
    """Number of the branch that is meant for a processor, or else for any platform."""
    return next(k for k, names in enumerate(platforms) if names is None or "cpu" in names)


def _needed(program: Program) -> Program:
    """The equations on which a result depends, loops without the operands that nothing in them asks for."""
    wanted = {id(v) for v in program.outputs}
    kept = []
    for equation in reversed(program.equations):
        if any(id(v) in wanted for v in equation.outputs):
            trimmed = _with_absent(equation)
            kept.append(trimmed)
            wanted |= {id(v) for v in trimmed.inputs}
    return replace(program, equations=kept[::-1])


def _with_absent(equation: Equation) -> Equation:
    """A loop whose operands are absent that nothing in it uses; any other equation as it is."""
    p = equation.params
    if equation.name == "scan":
        parts = [flattened(p["jaxpr"])]
        first, last, inner = p["num_consts"], p["num_consts"] + p["num_carry"], parts[0].inputs
    elif equation.name == "while":
        test, body = parts = [flattened(p["cond_jaxpr"]), flattened(p["body_jaxpr"])]
        first, last = p["cond_nconsts"] + p["body_nconsts"], len(equation.inputs)
        inner = [*test.inputs[: p["cond_nconsts"]], *body.inputs]
    else:
        return equation
    used = {id(v) for part in parts for v in part.outputs}
    used |= {id(v) for part in parts for q in part.equations for v in q.inputs}
    kept = zip(equation.inputs, inner, strict=True)
    handed = range(first, last)  # what is handed on from turn to turn stays
    return equation._replace(inputs=[v if k in handed or id(i) in used else ABSENT for k, (v, i) in enumerate(kept)])


def spreads(program: Program, given: Sequence[Spread]) -> dict[int, Spread]:
    """Over what the variables of a program differ.

    Args:
        program: The program.
        given: Over what its arguments differ.

    Returns:
        The spread of each variable by the `id` of its name; what is not listed is the same everywhere.
    """
    found = {id(v): s for v, s in zip(program.inputs, given, strict=True)}
    for equation in program.equations:
        inputs = [found.get(id(v), SAME) for v in equation.inputs]
        for v, s in zip(equation.outputs, _of_equation(equation, inputs), strict=True):
            found[id(v)] = s
    return found


def result_spreads(program: Program, given: Sequence[Spread]) -> list[Spread]:
    """Over what the results of a program differ.

    Args:
        program: The program.
        given: Over what its arguments differ.

    Returns:
        One spread for each result.
    """
    return list(_result_spreads(program, tuple(given)))


@lru_cache(maxsize=512)
def _result_spreads(program: Program, given: tuple[Spread, ...]) -> tuple[Spread, ...]:
    found = spreads(program, given)
    return tuple(found.get(id(v), SAME) for v in program.outputs)


def carried_spreads(
    body: Program, consts: Sequence[Spread], carry: Sequence[Spread], rest: Sequence[Spread]
) -> list[Spread]:
    """Over what the values differ that a loop hands on.

    Args:
        body: Body of the loop: from what stays, what is handed on and all else to what is handed on and all else.
        consts: Over what the values differ that stay.
        carry: The same of what is handed on, when the loop begins.
        rest: The same of all else.

    Returns:
        The same of what is handed on, in all turns.
    """
    carry = list(carry)
    while True:
        found = result_spreads(body, [*consts, *carry, *rest])[: len(carry)]
        joined = [a | b for a, b in zip(carry, found, strict=True)]
        if joined == carry:
            return carry
        carry = joined


def _of_equation(equation: Equation, inputs: Sequence[Spread]) -> list[Spread]:
    p = equation.params
    if equation.name == "scan":
        consts, carry = inputs[: p["num_consts"]], inputs[p["num_consts"] :][: p["num_carry"]]
        xs, body = inputs[p["num_consts"] + p["num_carry"] :], flattened(p["jaxpr"])
        carry = carried_spreads(body, consts, carry, xs)
        return [*carry, *result_spreads(body, [*consts, *carry, *xs])[len(carry) :]]
    if equation.name == "while":
        n, m = p["cond_nconsts"], p["body_nconsts"]
        carry = carried_spreads(flattened(p["body_jaxpr"]), inputs[n : n + m], inputs[n + m :], [])
        goes_on = result_spreads(flattened(p["cond_jaxpr"]), [*inputs[:n], *carry])[0]
        return [s | goes_on for s in carry]
    if equation.name == "cond":
        sides = [result_spreads(flattened(branch), inputs[1:]) for branch in p["branches"]]
        return [inputs[0] | Spread(*map(any, zip(*each, strict=True))) for each in zip(*sides, strict=True)]
    joined = SAME
    for s in {*inputs}:
        joined |= s
    return [joined] * len(equation.outputs)
