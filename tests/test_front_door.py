"""The front door `rwjax`: light to import, every name there, and no module that breaks when it is imported first."""

import ast
import inspect
import json
import os
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import rwjax

ROOT = Path(__file__).parents[1]
HEAVY = {"jax", "jaxlib", "numpy", "scipy", "matplotlib", "typer", "rich", "equinox"}
NAMES = [name for name in rwjax.__all__ if name != "__version__"]


def python(code: str, *arguments: str) -> str:
    """What a fresh process prints."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT), "MPLBACKEND": "svg"},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_import_brings_nothing_heavy() -> None:
    code = "import sys; before = set(sys.modules); import rwjax; print(*(set(sys.modules) - before))"
    found = python(code).split()
    assert "rwjax" in found and not HEAVY & {name.split(".")[0] for name in found}
    assert [name for name in found if name.startswith("rwjax.")] == []


def test_reading_a_rig_brings_no_jax_of_its_own() -> None:
    assert python("import sys, rwjax; rwjax.RigError, rwjax.Log; print('jax' in sys.modules)") == "False\n"


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_is_there_and_says_what_it_is(name: str) -> None:
    found = getattr(rwjax, name)
    assert found.__name__ == name and (inspect.getdoc(found) or "").strip()
    assert name in dir(rwjax)


def test_an_unknown_name_is_said() -> None:
    with pytest.raises(AttributeError, match="^module `rwjax` has no attribute `fits`$"):
        rwjax.fits  # noqa: B018
    with pytest.raises(ImportError):
        from rwjax import fits  # noqa: F401


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse((ROOT / "rwjax" / "__init__.py").read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = {}
    for line in block.body:
        assert isinstance(line, ast.ImportFrom) and line.level == 1 and line.module
        seen |= {alias.asname: f"rwjax.{line.module}" for alias in line.names if alias.asname == alias.name}
    assert list(seen) == NAMES
    for name, module in seen.items():
        assert getattr(import_module(module), name) is getattr(rwjax, name)


def test_the_wheel_tells_type_checkers_that_the_package_is_typed() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert settings["packages"] == ["rwjax"] and (ROOT / "rwjax" / "py.typed").exists()


EVERY_FIRST = """
import importlib, json, os, sys
import numpy, scipy.optimize, scipy.signal, scipy.stats, jax, jax.numpy, equinox, diffrax, optimistix
import matplotlib, matplotlib.figure, matplotlib.pyplot, jinja2, rich.progress, rich.live, typer, tomlkit, threadpoolctl, platformdirs

def first(name):
    backend = matplotlib.rcParams["backend"], matplotlib.get_backend()
    importlib.import_module(name)
    assert (matplotlib.rcParams["backend"], matplotlib.get_backend()) == backend, "it changes matplotlib's backend"
    computes = hasattr(importlib.import_module(".".join(name.split(".")[:2])), "setup_jax")
    assert jax.config.jax_enable_x64 or not computes, "it leaves JAX in single precision"

wrong, running, waiting = {}, {}, sys.argv[1:]
while waiting or running:
    while waiting and len(running) < (os.cpu_count() or 1):
        name, (read, write) = waiting.pop(), os.pipe()
        pid = os.fork()
        if pid == 0:
            try:
                first(name)
            except BaseException as error:
                os.write(write, repr(error).encode())
            os._exit(0)
        os.close(write)
        running[pid] = name, read
    pid, _ = os.wait()
    name, read = running.pop(pid)
    if said := os.read(read, 10_000).decode():
        wrong[name] = said
    os.close(read)
print(json.dumps(wrong))
"""
"""Imports every module named in the arguments first, each in a process of its own that has the libraries already."""


def modules() -> list[str]:
    """Every module of the package, the rooms among them."""
    files = [file.relative_to(ROOT).with_suffix("") for file in (ROOT / "rwjax").rglob("*.py")]
    return sorted({".".join(file.parts).removesuffix(".__init__") for file in files} - {"rwjax.__main__"})


@pytest.mark.slow  # half a minute of the processor
def test_every_module_can_be_imported_first() -> None:
    assert len(modules()) > 100
    assert json.loads(python(EVERY_FIRST, *modules())) == {}
