"""What importing the library sets in JAX."""

import os
import subprocess
import sys
from pathlib import Path


def test_the_environment_stays_the_user_s() -> None:
    code = "import os; before = dict(os.environ); import rwjax.setup_jax; print(before == dict(os.environ))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "True"


FOLDERS = """
import importlib, os, pwd, sys
from rwjax import cache_folder
import jax
named, shared, home = sys.argv[1:]
def set_up(**variables):
    for name in ("JAX_COMPILATION_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        os.environ.pop(name, None)
    os.environ |= variables
    jax.config.update("jax_compilation_cache_dir", variables.get("JAX_COMPILATION_CACHE_DIR"))
    try:
        if "rwjax.setup_jax" in sys.modules:
            importlib.reload(sys.modules["rwjax.setup_jax"])
        importlib.import_module("rwjax.setup_jax")
        print(jax.config.jax_compilation_cache_dir)
    except ValueError as error:
        print(error)
pwd.getpwuid = {}.__getitem__  # nobody has an entry
set_up()
set_up(XDG_CACHE_HOME=home)
set_up(XDG_CACHE_HOME=shared)
set_up(JAX_COMPILATION_CACHE_DIR=shared)
set_up(JAX_COMPILATION_CACHE_DIR=named)
cache_folder.WRITES_BETWEEN_TRIMS = 1
jax.jit(lambda x: x + 1.0)(2.0)
"""


def test_programs_are_kept_where_only_the_user_can_write_and_up_to_a_limit(tmp_path: Path) -> None:
    named, shared, home = (tmp_path / name for name in ("named", "shared", "home"))
    for folder in (named, shared, home):
        folder.mkdir()
    (shared / "rwjax").mkdir()
    shared.chmod(0o777)
    old, new = (named / f"traced-free_run-{n:064x}" for n in range(2))
    for path, used in ((old, 100.0), (new, 200.0)):
        path.touch()
        os.truncate(path, 600_000_000)  # takes no space on the disk
        os.utime(path, (used, used))
    done = subprocess.run(
        [sys.executable, "-c", FOLDERS, *map(str, (named, shared, home))], capture_output=True, text=True, check=True
    )
    nowhere, own, left_out, refused, there = done.stdout.splitlines()
    assert (nowhere, own, left_out, there) == ("None", f"{home}/rwjax", "None", str(named))
    assert refused.startswith(f"JAX_COMPILATION_CACHE_DIR: {shared}: holds programs")
    (note,) = done.stderr.splitlines()
    assert note.startswith(f"rwjax: note: programs are compiled anew: {shared}/rwjax: holds programs")
    assert new.exists() and not old.exists() and any(named.glob("jit_*-cache"))
