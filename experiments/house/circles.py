"""Rule of the imports: none go in a circle, also none for types alone."""

import ast

from experiments.house.tree import Finding, Module, Tree


def imports(tree: Tree, module: Module) -> dict[str, int]:
    """Modules of the package that a module imports anywhere, also for types alone, each with a line."""
    found = {}
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            named = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = module.name.split(".")
                parts = parts[: len(parts) - node.level + module.is_package]
                base = ".".join([*parts, *([base] if base else [])])
            named = [f"{base}.{a.name}" if f"{base}.{a.name}" in tree.package else base for a in node.names]
        else:
            continue
        found |= {name: node.lineno for name in named if name in tree.package and name != module.name}
    return found


def module_edges(tree: Tree) -> dict[str, list[str]]:
    """What each module imports."""
    return {name: list(imports(tree, module)) for name, module in tree.package.items()}


def room_edges(tree: Tree) -> dict[str, list[str]]:
    """What the modules of each room, and each module of the root, import from elsewhere."""
    found: dict[str, list[str]] = {}
    for name, others in module_edges(tree).items():
        room = _room(name)
        found.setdefault(room, []).extend({_room(other) for other in others} - {room})
    return found


def _room(name: str) -> str:
    return ".".join(name.split(".")[:2])


def cycles(edges: dict[str, list[str]]) -> list[list[str]]:
    """Groups that import each other in a circle (strongly connected components, Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    groups = []

    def visit(v: str) -> None:
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in edges[v]:
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            cut = stack.index(v)
            groups.append(sorted(stack[cut:]))
            del stack[cut:]

    for name in edges:
        if name not in index:
            visit(name)
    return sorted(group for group in groups if len(group) > 1)


def cyclic_modules(tree: Tree) -> list[Finding]:
    """Modules in a circle of imports, those for types alone included."""
    return [
        Finding(tree.package[name].path, line, f"imports {other}, which comes back to it")
        for group in cycles(module_edges(tree))
        for name in group
        for other, line in imports(tree, tree.package[name]).items()
        if other in group
    ]
