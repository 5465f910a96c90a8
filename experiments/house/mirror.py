"""Rules of the tests: one file for each module, and nothing private touched."""

import ast

from experiments.house.tree import Finding, Module, Tree

NAMEDTUPLE = {"_replace", "_asdict", "_fields", "_make", "_field_defaults"}  # public, whatever their names look like


def untested_modules(tree: Tree) -> list[Finding]:
    """Modules without a test file of their own at the same place below `tests/`."""
    return [
        Finding(module.path, 1, f"has no {mirror}")
        for module in tree.package.values()
        if not module.is_package and module.path != "rwjax/__main__.py"
        for folder, _, file in [module.path.removeprefix("rwjax/").rpartition("/")]
        for mirror in ["/".join(filter(None, ("tests", folder, f"test_{file}")))]
        if not (tree.root / mirror).exists()
    ]


def private_in_tests(tree: Tree) -> list[Finding]:
    """Tests that touch what begins with an underscore: imported, as an attribute, or by its name in a string."""
    found = []
    for module in tree.tests.values():
        foreign = _foreign(module)
        for node in ast.walk(module.tree):
            match node:
                case ast.ImportFrom(module=str(source), names=names) if source.startswith("rwjax"):
                    touched = [alias.name for alias in names if _is_private(alias.name)]
                case ast.Attribute(value=owner, attr=attr) if _is_private(attr) and ast.unparse(owner) not in (
                    *foreign,
                    "self",
                    "cls",
                ):
                    touched = [ast.unparse(node)]
                case ast.Call(func=f, args=args) if ast.unparse(f).rpartition(".")[2] in (
                    "setattr",
                    "getattr",
                    "delattr",
                ):
                    texts = [a.value for a in args[:2] if isinstance(a, ast.Constant) and isinstance(a.value, str)]
                    ours = not any(text.split(".")[0] in foreign for text in [ast.unparse(args[0]), *texts])
                    touched = [text for text in texts if ours and _is_private(text.rpartition(".")[2])]
                case _:
                    continue
            found += [Finding(module.path, node.lineno, f"touches {name}") for name in touched]
    return found


def _foreign(module: Module) -> set[str]:
    """Names by which a test knows modules of other projects: their underscores are theirs."""
    plain = [a for node in ast.walk(module.tree) if isinstance(node, ast.Import) for a in node.names]
    return {a.asname or a.name for a in plain if not a.name.startswith("rwjax")}


def _is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name not in NAMEDTUPLE
