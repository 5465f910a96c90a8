"""Rule of the docstrings: every argument, what is returned, and the unit of every number."""

import ast
import re
from collections.abc import Iterator
from typing import NamedTuple

from experiments.house.tree import Finding, Function, Module, Tree, functions_of


class Public(NamedTuple):
    """A public function or method with its module, qualified name and class."""

    module: Module
    name: str
    node: Function
    cls: ast.ClassDef | None


def public_functions(tree: Tree) -> list[Public]:
    """Public functions, and public methods of public classes. Commands, which their modules are named after,
    are left out: their docstring is the text of `--help`, and their options carry the words."""
    return [
        Public(module, name, node, cls)
        for module in tree.package.values()
        for name, node, cls in functions_of(module.tree, "")
        if not any(part.startswith(("_", "<")) for part in name.split(".")) and module.name != f"rwjax.cli.{name}"
    ]


def _decorators(node: Function) -> set[str]:
    return {ast.unparse(d).split("(")[0].rpartition(".")[2] for d in node.decorator_list}


def _documented_above(tree: Tree, cls: ast.ClassDef, name: str, seen: tuple[str, ...] = ()) -> bool:
    """Whether a base class documents the method of this name, for all who define it."""
    for base in (ast.unparse(b).split("[")[0].rpartition(".")[2] for b in cls.bases):
        for above in tree.classes.get(base, []) if base not in seen else []:
            own = next((m for m in above.body if isinstance(m, Function) and m.name == name), None)
            if own is not None and ast.get_docstring(own):
                return True
            if _documented_above(tree, above, name, (*seen, base)):
                return True
    return False


SECTION = re.compile(
    r"^(Args|Returns|Yields|Raises|Source|Sources|Attributes|Note|Notes|Example|Examples|References):", re.M
)
UNIT = re.compile(r"\[[^\]]+\]")
NUMBER = re.compile(
    r"^(float|complex|Scalar|Vector|Matrix|Array|(np|numpy)\.ndarray|(jax|jnp)\.Array|ArrayLike)$|^(Float|Inexact|Complex)\["
)
HOLDERS = re.compile(r"^(tuple|list|Sequence|Iterable|Iterator|Generator)\[")


def _sections(doc: str) -> dict[str, str]:
    """Text of a docstring by section; the summary and what follows it under an empty name."""
    heads = [*SECTION.finditer(doc)]
    found = {"": doc[: heads[0].start()] if heads else doc}
    ends = [*(head.start() for head in heads[1:]), len(doc)]
    for head, end in zip(heads, ends[: len(heads)], strict=True):
        found[head[1]] = doc[head.end() : end]
    return found


def _holds_numbers(annotation: ast.expr | None) -> bool:
    """Whether a type is a floating-point number or array, or a sequence of such."""
    match annotation:
        case None:
            return False
        case ast.Constant(str(text)):
            try:
                return _holds_numbers(ast.parse(text, mode="eval").body)
            except SyntaxError:
                return False
        case ast.BinOp(left=left, right=right):
            return _holds_numbers(left) or _holds_numbers(right)
        case ast.Subscript(slice=inside) if HOLDERS.match(ast.unparse(annotation)):
            return any(map(_holds_numbers, inside.elts)) if isinstance(inside, ast.Tuple) else _holds_numbers(inside)
    return bool(NUMBER.match(ast.unparse(annotation)))


def lacks_of(tree: Tree, public: Public) -> Iterator[tuple[str, str]]:
    """What the docstring of a function does not say: the kind of the lack, and which."""
    node, doc = public.node, ast.get_docstring(public.node) or ""
    decorators = _decorators(node)
    if decorators & {"overload", "override", "setter"}:
        return
    if public.cls is not None and _documented_above(tree, public.cls, node.name):
        return
    sections = _sections(doc)
    every = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    arguments = every[1:] if public.cls is not None and "staticmethod" not in decorators else every
    entries = {
        m[1]: m[2]
        for m in re.finditer(
            r"^ {4}\*{0,2}`?(\w+)`?[^:\n]*:(.*(?:\n {5,}.*|\n(?=\n {5}))*)", sections.get("Args", ""), re.M
        )
    }
    # `kp, kd: gains` documents both
    for m in re.finditer(
        r"^ {4}((?:`?\*{0,2}\w+`?, )+`?\*{0,2}\w+`?)[^:\n]*:(.*(?:\n {5,}.*)*)", sections.get("Args", ""), re.M
    ):
        entries |= {name.strip("`* "): m[2] for name in m[1].split(",")}
    for argument in arguments:
        if argument.arg.startswith("_"):
            continue
        if argument.arg not in entries:
            yield "Args", argument.arg
        said = entries.get(argument.arg) or "".join(re.findall(rf"`{argument.arg}`[^`]*", doc))
        if _holds_numbers(argument.annotation) and not UNIT.search(said):
            yield "unit of", argument.arg
    returns = None if node.returns is None else ast.unparse(node.returns)
    if returns in (None, "None", "NoReturn", "Never", "Self") or decorators & {"property", "cached_property"}:
        return
    section = sections.get("Returns", "") + sections.get("Yields", "")
    if not section:
        yield "Returns", ""
    if _holds_numbers(node.returns) and not UNIT.search(section + sections[""].split("\n\n")[0]):
        yield "unit of", "what it returns"


def undocumented(tree: Tree) -> list[Finding]:
    """Public functions whose docstring leaves out an argument, what is returned, or a unit."""
    found = []
    for public in public_functions(tree):
        lacks = [f"{kind} {what}".strip() for kind, what in lacks_of(tree, public)]
        if lacks:
            found.append(
                Finding(public.module.path, public.node.lineno, f"{public.name} does not document: {', '.join(lacks)}")
            )
    return found
