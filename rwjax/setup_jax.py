"""Float64 and the persistent compilation cache; imported before anything that computes with JAX."""

import os

import jax
from platformdirs import user_cache_dir

jax.config.update("jax_enable_x64", True)
if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
    jax.config.update("jax_compilation_cache_dir", user_cache_dir("rwjax"))
jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
