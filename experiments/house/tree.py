"""A checkout as the rules see it: its modules parsed and never imported, its pages of documentation as text."""

import ast
import io
import tokenize
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

Function = ast.FunctionDef | ast.AsyncFunctionDef


class Finding(NamedTuple):
    """A breach of a rule: file below the root, line, and what is wrong."""

    path: str
    line: int
    what: str

    @property
    def room(self) -> str:
        """Room of the package, or of the tests, in which the file lies; `root` for a file in none."""
        parts = self.path.split("/")
        return parts[1] if len(parts) > 2 else "root"


@dataclass(frozen=True)
class Module:
    """A parsed source file: its path below the root, its dotted name, its text and tree."""

    path: str
    name: str
    text: str
    tree: ast.Module

    @property
    def is_package(self) -> bool:
        """Whether it is an `__init__.py`."""
        return self.path.endswith("__init__.py")

    @cached_property
    def code_lines(self) -> frozenset[int]:
        """Lines that hold code, those of a docstring among them."""
        skipped = {
            tokenize.COMMENT,
            tokenize.NL,
            tokenize.NEWLINE,
            tokenize.INDENT,
            tokenize.DEDENT,
            tokenize.ENDMARKER,
        }
        tokens = tokenize.generate_tokens(io.StringIO(self.text).readline)
        return frozenset(n for t in tokens if t.type not in skipped for n in range(t.start[0], t.end[0] + 1))


@dataclass(frozen=True)
class Tree:
    """A checkout: the modules of the package and of its tests, and the pages of its documentation."""

    root: Path

    def _modules(self, folder: str) -> dict[str, Module]:
        found = {}
        for file in sorted((self.root / folder).rglob("*.py")):
            path = file.relative_to(self.root).as_posix()
            name = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
            text = file.read_text()
            found[name] = Module(path, name, text, ast.parse(text))
        return found

    @cached_property
    def package(self) -> dict[str, Module]:
        """Modules of `rwjax` by dotted name."""
        return self._modules("rwjax")

    @cached_property
    def tests(self) -> dict[str, Module]:
        """Modules of the tests by dotted name."""
        return self._modules("tests")

    @cached_property
    def pages(self) -> dict[str, str]:
        """README and docs, text by path."""
        files = [self.root / "README.md", *sorted((self.root / "docs").rglob("*.md"))]
        return {file.relative_to(self.root).as_posix(): file.read_text() for file in files if file.exists()}

    @cached_property
    def classes(self) -> dict[str, list[ast.ClassDef]]:
        """Classes of the package by simple name."""
        found = defaultdict(list)
        for module in self.package.values():
            for node in ast.walk(module.tree):
                if isinstance(node, ast.ClassDef):
                    found[node.name].append(node)
        return found

    @cached_property
    def effects(self) -> dict[str, str]:
        """Name of every effect, such as `axis.coulomb`, and its class."""
        found = {}
        for module in self.package.values():
            if module.name.startswith("rwjax.effects."):
                for node in ast.walk(module.tree):
                    if isinstance(node, ast.ClassDef) and (name := _effect_name(node)):
                        found[name] = node.name
        return found


def _effect_name(cls: ast.ClassDef) -> str | None:
    for node in cls.body:
        target = (
            node.target
            if isinstance(node, ast.AnnAssign)
            else node.targets[0]
            if isinstance(node, ast.Assign)
            else None
        )
        if isinstance(target, ast.Name) and target.id == "name" and isinstance(value := node.value, ast.Constant):
            return value.value if isinstance(value.value, str) and "." in value.value else None
    return None


def functions(tree: Tree) -> Iterator[tuple[Module, str, Function]]:
    """Every function and method of the package with its qualified name."""
    for module in tree.package.values():
        yield from ((module, name, node) for name, node, _ in functions_of(module.tree, ""))


def functions_of(
    node: ast.AST, prefix: str, cls: ast.ClassDef | None = None
) -> Iterator[tuple[str, Function, ast.ClassDef | None]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, Function):
            yield f"{prefix}{child.name}", child, cls
            yield from functions_of(child, f"{prefix}{child.name}.<locals>.")
        elif isinstance(child, ast.ClassDef):
            yield from functions_of(child, f"{prefix}{child.name}.", child)
        else:
            yield from functions_of(child, prefix, cls)
