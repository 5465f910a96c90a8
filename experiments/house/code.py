"""Rules of the package's code: length of functions, effects and limits in their places, an empty root."""

import ast
import re

from experiments.house.tree import Finding, Function, Module, Tree, functions

LONGEST_FUNCTION = 50  # lines of code, docstring and comments not counted
ROOT_MODULES = 7  # kinds, types, errors, text_files, cache_folder, setup_jax and the entry point `__main__`
DIAGNOSIS = ("rwjax/diagnosis/", "rwjax/diagnose/")  # the second before the rooms
RIG_FILE_SECTIONS = {
    "axis.gravity"
}  # an effect of the base equations, and the section of the file that holds its numbers
LIMITS_LIVE_IN = ("settings.py", "thresholds.py")  # the second before the rooms


def long_functions(tree: Tree) -> list[Finding]:
    """Functions of more than `LONGEST_FUNCTION` lines of code."""
    return [
        Finding(module.path, node.lineno, f"{name} has {count} lines of code")
        for module, name, node in functions(tree)
        if (count := code_length(module, node)) > LONGEST_FUNCTION
    ]


def code_length(module: Module, node: Function) -> int:
    """Lines of code of a function from `def` on, without its docstring."""
    lines = {n for n in module.code_lines if node.lineno <= n <= (node.end_lineno or 0)}
    if ast.get_docstring(node) is not None:
        doc = node.body[0]
        lines -= set(range(doc.lineno, (doc.end_lineno or 0) + 1))
    return len(lines)


def effect_mentions(tree: Tree) -> list[Finding]:
    """Effects named outside `rwjax/effects`: by their names in a string of the code, or by their classes."""
    names = "|".join(map(re.escape, sorted(set(tree.effects) - RIG_FILE_SECTIONS)))
    word = re.compile(rf"(?<![\w.])({names})(?!\w)") if names else None
    classes = set(tree.effects.values())
    found = []
    for module in tree.package.values():
        if word is None or module.name.split(".")[1:2] == ["effects"]:
            continue
        docs = _docstrings(module.tree)
        for node in ast.walk(module.tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
                found += [Finding(module.path, node.lineno, f"names `{name}`") for name in word.findall(node.value)]
            elif isinstance(node, ast.ImportFrom) and "effects" in (node.module or ""):
                found += [
                    Finding(module.path, node.lineno, f"imports {a.name}") for a in node.names if a.name in classes
                ]
            elif isinstance(node, ast.Attribute) and node.attr in classes:
                found.append(Finding(module.path, node.lineno, f"takes {ast.unparse(node)}"))
    return found


def stray_limits(tree: Tree) -> list[Finding]:
    """Numbers that modules of the diagnosis set for themselves, outside its settings."""
    return [
        Finding(module.path, node.lineno, f"sets {', '.join(ast.unparse(t) for t in targets)}")
        for module in tree.package.values()
        if module.path.startswith(DIAGNOSIS) and not module.path.endswith(LIMITS_LIVE_IN)
        for node in module.tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and _is_number(node.value)
        for targets in [node.targets if isinstance(node, ast.Assign) else [node.target]]
    ]


def _is_number(node: ast.expr) -> bool:
    match node:
        case ast.Constant(value):
            return isinstance(value, int | float) and not isinstance(value, bool)
        case ast.UnaryOp(operand=operand):
            return _is_number(operand)
        case ast.BinOp(left=left, right=right):
            return _is_number(left) and _is_number(right)
        case ast.Tuple(elts=parts) | ast.List(elts=parts):
            return any(map(_is_number, parts))
        case ast.Dict(values=parts):
            return any(map(_is_number, parts))
    return False


def crowded_root(tree: Tree) -> list[Finding]:
    """Modules that lie in the package's root, if they are more than `ROOT_MODULES`."""
    found = root_modules(tree)
    return (
        [Finding(m.path, 1, f"is one of {len(found)} in the root") for m in found] if len(found) > ROOT_MODULES else []
    )


def root_modules(tree: Tree) -> list[Module]:
    """Modules beside the package's `__init__`."""
    return [m for m in tree.package.values() if m.name.count(".") == 1 and not m.is_package]


def _docstrings(tree: ast.AST) -> set[int]:
    """Identities of the string nodes that are docstrings, those below an assignment included."""
    bodies = (getattr(node, "body", None) for node in ast.walk(tree))
    return {
        id(statement.value)
        for body in bodies
        if isinstance(body, list)
        for statement in body
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
    }
