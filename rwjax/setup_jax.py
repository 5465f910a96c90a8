"""Float64, loops as one kernel, and the persistent compilation cache; imported before anything that computes with JAX."""

import os

import jax
from platformdirs import user_cache_dir

WHOLE_LOOPS = "--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=1000000000000"
"""A loop's body as one function: else every step of a simulation starts some twenty kernels, which takes longer than what they
compute. XLA reads its flags once, when it is first used; set later, loops are slower and no different."""

flags = os.environ.get("XLA_FLAGS", "")
if "xla_backend_extra_options" not in flags:
    os.environ["XLA_FLAGS"] = f"{flags} {WHOLE_LOOPS}".strip()

jax.config.update("jax_enable_x64", True)
if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
    jax.config.update("jax_compilation_cache_dir", user_cache_dir("rwjax"))
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
