"""Parts that a rig may have beside its base equations: one class each, which says everything about itself."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
