"""Gain regions by the slowest pole and by the closed form: the same answer, and at which speed. `python -m experiments.control.regions [PLANTS]`.

PLANTS random plants of each kind (10⁴ by default) with a random pair of PD gains each. The sign of the slowest pole plus sigma has to
be what the closed form says. Loops whose slowest pole lies closer to the edge than `NEAR` of their matrix's norm are left out and
counted: there rounding decides. The speed is that of a grid of gains on each of many plants.
"""

import sys
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from experiments.control.random_loops import FAMILIES, Loops
from experiments.speed.table import machine, show, timed
from rwjax.control.linear import Linear
from rwjax.control.loop_polynomial import LoopPolynomial, pd_loop
from rwjax.control.over_gains import gain_grid, over_gains, over_plants
from rwjax.control.poles import largest_modulus, pd_matrix, slowest_pole
from rwjax.control.sampled_loop import sampled_loop, stacked_loops
from rwjax.control.stability import share_of_plants, share_of_sampled, stable, stable_sampled

NEAR = 1e-9
"""Distance from the edge, as a share of the matrix's norm (in a sampled loop of |z| = 1), below which rounding may decide."""
PERIOD, LATE, SMOOTH = 0.01, 0.013, 0.02  # s, of the sampled loops
ROUNDS, PLANTS = 5, 100
GRID, FINE = 40, 400  # values of each gain for the speed of the slowest pole, and of the closed form


class Agreement(NamedTuple):
    """Loops that were judged both ways: how many, how many of them stable, left out at the edge, and judged otherwise."""

    loops: int
    stable: int
    left_out: int
    otherwise: int


def agreement(loops: Loops) -> Agreement:
    """Continuous loops, judged by their slowest pole and by the closed form."""
    slowest, size = _slowest_and_size(loops.gains, loops.plants)
    closed = [
        bool(stable(pd_loop(plant), *gains[:, None], sigma=loops.sigma)[0])
        for plant, gains in zip(loops.transfers.each(), loops.gains, strict=True)
    ]
    return _compared(np.asarray(slowest + loops.sigma), NEAR * np.asarray(size), np.array(closed))


@jax.jit
@jax.vmap
def _slowest_and_size(gains: jax.Array, plant: Linear) -> tuple[jax.Array, jax.Array]:
    """Real part of the slowest pole [1/s], and the norm of the closed loop's matrix, with which rounding grows."""
    return slowest_pole(gains, plant), jnp.linalg.norm(pd_matrix(gains, plant))


def sampled(loops: Loops) -> list[LoopPolynomial]:
    """The same plants in a sampled loop, late and filtered."""
    return [sampled_loop(plant, PERIOD, LATE, SMOOTH) for plant in loops.transfers.each()]


def sampled_agreement(loops: Loops) -> Agreement:
    """Sampled loops, judged by the largest modulus of their poles and by the closed form."""
    each, radius = sampled(loops), np.exp(-loops.sigma * PERIOD)
    largest = jax.jit(jax.vmap(largest_modulus))(loops.gains, stacked_loops(each))
    closed = [
        bool(stable_sampled(loop, *g[:, None], radius=radius)[0]) for loop, g in zip(each, loops.gains, strict=True)
    ]
    return _compared(np.asarray(largest) - radius, np.full(len(each), NEAR), np.array(closed))


def _compared(distance: np.ndarray, near: np.ndarray, closed: np.ndarray) -> Agreement:
    clear = np.abs(distance) > near
    return Agreement(
        len(closed), int(closed.sum()), int(np.sum(~clear)), int(np.sum(((distance < 0.0) != closed)[clear]))
    )


def speed(loops: Loops, is_sampled: bool) -> tuple[float, float]:
    """Seconds for one pair of gains on one plant, by the slowest pole and by the closed form; best of some rounds."""
    axis, fine = (np.linspace(0.0, 100.0, count) for count in (GRID, FINE))
    grid = gain_grid(axis, axis)
    if is_sampled:
        plants, criterion = stacked_loops(sampled(loops)), partial(over_plants, largest_modulus)
        closed = partial(share_of_sampled, plants, fine, fine, np.exp(-loops.sigma * PERIOD))
    else:
        plants, criterion = loops.plants, partial(over_plants, slowest_pole)
        closed = partial(share_of_plants, loops.transfers, fine, fine, loops.sigma)
    ways = (lambda: np.asarray(over_gains(criterion, grid, plants)), closed)
    for way in ways:
        way()  # compile
    rounds = [[timed(way)[0] for way in ways] for _ in range(ROUNDS)]
    first, second = np.min(rounds, axis=0) / (np.array([GRID, FINE]) ** 2 * len(loops.gains))
    return float(first), float(second)


def main(count: int) -> None:
    """Prints a line for each kind of loop."""
    print(machine())
    cases = [(name, draw, False) for name, draw in FAMILIES.items()]
    cases.append(("sampled, the thesis's rig", FAMILIES["order 3, the thesis's rig"], True))
    rows = []
    for seed, (name, draw, is_sampled) in enumerate(cases):
        judge = sampled_agreement if is_sampled else agreement
        found = judge(draw(np.random.default_rng(seed), count))
        ours, closed = speed(draw(np.random.default_rng(100 + seed), PLANTS), is_sampled)
        counts = (str(n) for n in found)
        rows.append([name, *counts, f"{1.0 / ours:.2g}", f"{1.0 / closed:.2g}", f"{ours / closed:.2g}"])
    head = (
        "loop",
        "loops",
        "of them stable",
        "at the edge",
        "judged otherwise",
        "pairs/s by poles",
        "by closed form",
        "times as fast",
    )
    show(
        f"random loops judged both ways; speed with {GRID**2} and {FINE**2} pairs of gains on {PLANTS} plants",
        head,
        rows,
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
