"""The plant moved through time: steps, stick and slip, logs on a grid, free runs and their sensitivities, compiled programs."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
