"""Questions about logs that contradict the rig file's own numbers so far that a fit would only bend the numbers."""

from rwjax import setup_jax as setup_jax
