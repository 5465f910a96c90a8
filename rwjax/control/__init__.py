"""Control of the axis, designed on the identified plant: gain regions, closed loops, slews, sizing."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
