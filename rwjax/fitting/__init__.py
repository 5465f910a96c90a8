"""Estimation of numbers from logs by free-run least squares, with its uncertainty, and the free run of a fitted rig."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
