"""A random command of the length and the largest voltage of another one."""

import numpy as np

from experiments.blind.cases import TRAINING
from experiments.blind.commands import TICK, command

FAMILIES = (*TRAINING, "mixed")
"""Commands that the simulator's own cases are made of."""
RIVAL = 211  # apart from other random numbers of a case


def random_command(beside: np.ndarray, seed: int) -> tuple[str, np.ndarray]:
    """A family and a command of it [V] as long as `beside`, with the same largest size, reproducible by the seed."""
    rng, top = np.random.default_rng([seed, RIVAL]), float(np.max(np.abs(beside)))
    if top == 0.0:
        raise ValueError("a command that is 0 throughout has no rival")
    while True:
        family = str(rng.choice(FAMILIES))
        volts = command(family, len(beside) * TICK, top, rng)
        if np.any(volts):  # a short one may rest throughout
            return family, np.round(volts * (top / np.max(np.abs(volts))), 3)
