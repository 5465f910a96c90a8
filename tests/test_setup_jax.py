"""What importing the library sets in JAX."""

import os
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import pytest

from rwjax.setup_jax import WHOLE_LOOPS


@pytest.mark.parametrize(
    ("own", "kept"),
    [
        ("", WHOLE_LOOPS),
        (WHOLE_LOOPS, WHOLE_LOOPS),
        ("--xla_cpu_enable_fast_math=false", f"{WHOLE_LOOPS} --xla_cpu_enable_fast_math=false"),
        (WHOLE_LOOPS.replace("1000000000000", "0"), f"{WHOLE_LOOPS} {WHOLE_LOOPS.replace('1000000000000', '0')}"),
        ("/path/of/flags", "/path/of/flags"),
    ],
    ids=["none", "of a parent process", "others", "another threshold, which counts", "a file"],
)
def test_flags_that_a_user_has_set_stay(own: str, kept: str) -> None:
    code = "import os, rwjax.setup_jax; print(os.environ['XLA_FLAGS'])"
    call = [sys.executable, "-c", code]
    assert subprocess.check_output(call, env=os.environ | {"XLA_FLAGS": own}, text=True).strip() == kept


def test_a_loop_is_compiled_as_one_function() -> None:
    def loop(x: jax.Array) -> jax.Array:
        return jax.lax.scan(lambda c, _: (c + 0.01 * jnp.sin(c), c), x, length=1000)[1]

    program = jax.jit(loop).lower(jnp.ones(64)).compile()
    assert "xla_cpu_small_call" in program.as_text()


FOLDERS = """
import importlib, os, pwd, sys
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
