"""Ways to identify a rig's free numbers from logs, and their comparison on the same held-out data."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
