"""Float64, loops as one kernel, and the persistent compilation cache; imported before anything that computes with JAX."""

import os

import jax
from platformdirs import user_cache_dir

WHOLE_LOOPS = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=1000000000000"
"""A loop's body as one function: else every step of a simulation starts some twenty kernels, which takes longer than what they
compute. XLA reads its flags once, when it is first used; set later, loops are slower and give the same."""


def _with_whole_loops(flags: str) -> str:
    """XLA's flags with this one before a user's own, of which the last counts. The name of a file of flags stays what it is."""
    return flags if WHOLE_LOOPS in flags or flags[:1] not in ("", "-") else f"{WHOLE_LOOPS} {flags}".strip()


os.environ["XLA_FLAGS"] = _with_whole_loops(os.environ.get("XLA_FLAGS", "").strip())
jax.config.update("jax_enable_x64", True)
if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
    jax.config.update("jax_compilation_cache_dir", user_cache_dir("rwjax"))
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
