"""The sim-to-real gap: how large, where, which missing effect, how far it shrinks, and the verdict."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
