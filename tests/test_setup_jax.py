"""What importing the library sets in JAX."""

import os
import subprocess
import sys

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
