"""Experiments to record: commands, how far they move a rig, and the plan files that board and table share."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
