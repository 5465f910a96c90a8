"""What is installed: nothing that the lock does not name by its hash, and everything that the package imports."""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions
from itertools import chain
from pathlib import Path

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def named(requirements: list[str]) -> set[str]:
    """Names of the packages that requirements ask for."""
    return {normal(found[0]) for line in requirements if (found := re.match(r"[\w.-]+", line))}


def test_every_locked_package_has_one_version_and_hashes() -> None:
    lines = (ROOT / "requirements.lock").read_text().replace("\\\n", " ").splitlines()
    packages = [line for line in lines if re.match(r"\w", line)]
    assert all(re.match(r"[\w.-]+(\[\w+\])?==\S+( +--hash=sha256:[0-9a-f]{64})+$", line) for line in packages)
    wanted = {*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["dev"]}
    assert named(packages) >= named([*wanted])
    assert "--require-hashes -r requirements.lock" in (ROOT / "Makefile").read_text()


def test_the_package_imports_nothing_that_a_user_does_not_get() -> None:
    extras = (PROJECT["optional-dependencies"][name] for name in ("data", "fleet", "link", "mujoco"))
    given = named([*PROJECT["dependencies"], *chain.from_iterable(extras)])
    homes = packages_distributions()
    for path in (ROOT / "rwjax").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                names = [node.module]
            for name in {name.partition(".")[0] for name in names} - sys.stdlib_module_names - {"rwjax"}:
                assert given & {normal(home) for home in homes[name]}, f"{path}: imports {name}"
