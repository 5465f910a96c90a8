"""Commands [V] at 100 Hz that a person would run on a rig; every one starts with a short rest."""

import numpy as np

TICK = 0.01  # s


def command(kind: str, length: float, top: float, rng: np.random.Generator) -> np.ndarray:
    """Command of a kind (square, multisine, triangle, stair, coast, prbs, mixed), `length` seconds, within `top` volts."""
    t = np.arange(round(length / TICK)) * TICK
    rest = rng.uniform(0.52, 0.8)
    s = np.maximum(t - rest, 0.0)
    if kind == "square":
        u = top * rng.uniform(0.7, 1.0) * np.sign(np.sin(2 * np.pi * s / rng.uniform(2.5, 5.0) + 1e-9))
    elif kind == "multisine":
        f = np.array([0.13, 0.29, 0.53, 0.97, 1.7]) * rng.uniform(0.8, 1.2)
        u = sum(np.sin(2 * np.pi * k * s + rng.uniform(0, 2 * np.pi)) for k in f)
        u = top * u / np.max(np.abs(u))
    elif kind == "triangle":
        u = top * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * s / rng.uniform(5.0, 8.0)))
    elif kind == "stair":
        level = rng.permutation(np.linspace(-1.0, 1.0, 9))
        u = top * level[np.minimum((s / length * 9).astype(int), 8)]
    elif kind == "coast":
        u = (
            top
            * rng.uniform(0.6, 1.0)
            * np.where(np.mod(s, 5.0) < 2.0, np.where(np.mod(s, 10.0) < 5.0, 1.0, -1.0), 0.0)
        )
    elif kind == "prbs":
        level = rng.choice([-1.0, 1.0], size=200) * rng.uniform(0.4, 1.0, size=200)
        u = top * level[(s / rng.uniform(0.3, 0.7)).astype(int)]
    elif kind == "mixed":
        half = length / 2
        first, second = (command(k, half, top, rng) for k in ("square", "multisine"))
        u = np.resize(np.concatenate([first, second]), len(t))
    else:
        raise ValueError(kind)
    return np.round(np.where(t >= rest, u, 0.0), 3)
