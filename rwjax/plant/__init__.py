"""The equations of motion of every kind of rig, with ports for effects; it knows nothing of logs."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
