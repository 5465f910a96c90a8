"""The benchmark of control against its peers and a C program. `python -m experiments.control.speed [region|plants|loops …]`.

Contenders of a table run in interleaved rounds; ratios are medians of the ratios round by round, times the best of all rounds.
"""

import sys
from collections.abc import Callable

import jax
import numpy as np

from experiments.control import c_limit, peers
from experiments.control.problem import LIMIT, PERIOD, SIGMA, SMOOTH, gains, reference, rig
from experiments.speed.lowering import XLA, by_xla
from experiments.speed.table import machine, race, ratio, show
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import LoopPolynomial, pd_loop
from rwjax.control.polynomials import shift
from rwjax.control.stability import share_of_plants, stable
from rwjax.control.sweep import step_responses
from rwjax.control.transfer import transfer
from rwjax.plant.from_rig import structure_of, theta_of

SAME = 1e-9
"""Share by which the squared errors of loops that take the same steps may differ."""


def rounds(contenders: dict[str, tuple[Callable[[], object], int]], quick: tuple[str, ...]) -> dict[str, list[float]]:
    """Seconds per item of every contender in interleaved rounds; those not `quick` run in the first ones only."""
    calls = {name: call for name, (call, _) in contenders.items()}
    raced = race(calls, slow=[name for name in calls if name not in quick], repeats=5)
    return {name: [spent / contenders[name][1] for spent in times] for name, times in raced.times.items()}


def report(title: str, unit: str, times: dict[str, list[float]], ours: str, notes: dict[str, str]) -> None:
    """A table: time per item, and how many times ours each takes."""
    rows = [
        [name, f"{1e9 * min(t):.3g} ns", f"{ratio(t, times[ours]):.3g}", notes.get(name, "")]
        for name, t in times.items()
    ]
    show(title, ("contender", f"per {unit}", "times ours", ""), rows)


def moved(loop: LoopPolynomial) -> LoopPolynomial:
    """The loop with its poles moved by sigma, as C wants it."""
    return loop.mapped(shift(loop.order, SIGMA))


def region() -> None:
    """10⁶ gain pairs of a cubic."""
    plant = transfer(linearised(rig(dry=False)))
    loop, axis = pd_loop(plant), np.linspace(0.0, 100.0, 1000)
    m, out = moved(loop), np.zeros(len(axis) ** 2, np.uint8)
    few = np.random.default_rng(0).uniform(0.0, 100.0, (2, 100_000))

    def in_c() -> np.ndarray:
        c_limit.library().region_grid(len(axis), len(axis), axis, axis, m.base, *m.gains, out)
        return out

    def here() -> np.ndarray:
        return stable(loop, axis[:, None], axis[None, :], sigma=SIGMA)

    assert np.array_equal(here().ravel(), in_c().astype(bool))
    own = np.array([stable(loop, few[0, k : k + 1], few[1, k : k + 1], sigma=SIGMA)[0] for k in range(300)])
    for peer in (peers.roots_loop, peers.control_loop, peers.eigenvalues):
        assert np.array_equal(peer(plant, few[0, :300], few[1, :300], SIGMA), own)
    some = {"roots": few[:, :2000], "control": few[:, :200], "eigenvalues": few}
    times = rounds(
        {
            "rwjax, `stable`": (here, len(axis) ** 2),
            "C, one core": (in_c, len(axis) ** 2),
            "numpy, batched eigenvalues": (lambda: peers.eigenvalues(plant, *some["eigenvalues"], SIGMA), 100_000),
            "thesis: a loop of `numpy.roots`": (lambda: peers.roots_loop(plant, *some["roots"], SIGMA), 2000),
            "a loop of python-control": (lambda: peers.control_loop(plant, *some["control"], SIGMA), 200),
        },
        ("rwjax, `stable`", "C, one core"),
    )
    report("10⁶ gain pairs", "pair", times, "rwjax, `stable`", {"C, one core": "same answer for all pairs"})


def plants() -> None:
    """10⁴ gain pairs for each of 10³ plants."""
    structure, rng, axis = structure_of(rig(dry=False)), np.random.default_rng(1), np.linspace(0.0, 100.0, 100)
    theta = theta_of(rig(dry=False), structure)
    drawn = transfer(linearised(rig(dry=False), thetas=theta * np.exp(rng.normal(0.0, 0.1, (1000, len(theta))))))
    m = moved(pd_loop(drawn))
    kp, kd = (np.ascontiguousarray(v.ravel()) for v in np.meshgrid(axis, axis, indexing="ij"))
    parts = [np.ascontiguousarray(p) for p in (m.base, m.gains[:, 0], m.gains[:, 1])]
    out = np.zeros(len(kp), np.uint16)

    def in_c() -> np.ndarray:
        c_limit.library().region_count(len(kp), kp, kd, len(drawn.num), *parts, out)
        return out

    def here() -> np.ndarray:
        return share_of_plants(drawn, axis, axis, SIGMA)

    assert np.array_equal(np.round(1000 * here()).ravel(), in_c())
    times = rounds(
        {"rwjax, `share_of_plants`": (here, 10**7), "C, blocked, one core": (in_c, 10**7)},
        ("rwjax, `share_of_plants`", "C, blocked, one core"),
    )
    report(
        "10⁴ pairs times 10³ plants",
        "pair and plant",
        times,
        "rwjax, `share_of_plants`",
        {"C, blocked, one core": "same counts"},
    )


def loops() -> None:
    """10 s of the nonlinear closed loop at 100 Hz, four steps of the plant a sample; the C program needs vectors of 512 bits."""
    wave, (kp, kd) = reference(), gains(1600)
    laws = [Controller(p, kd=d, filter_time=SMOOTH, voltage_limit=LIMIT) for p, d in zip(kp, kd, strict=True)]
    p = c_limit.of_rig()
    E, P, Q = (np.array(getattr(p, name)).reshape(4, 4) for name in ("E", "P1", "P2"))
    ours, numba = "rwjax, `sweep`, two threads", "numba, two threads"
    rungs, scipy = "numba, Runge-Kutta steps of 1 ms, two threads", "scipy, `solve_ivp` each period"

    def here() -> object:
        return jax.block_until_ready(step_responses(rig(), laws, wave[None], since=500))

    same: dict[str, Callable[[], np.ndarray]] = {numba: lambda: peers.numba_sweep(wave, kp, kd, E, P, Q)}
    if c_limit.available():
        same["C, eight loops a vector, one thread"] = lambda: c_limit.sweep(wave, kp, kd, 1)
        same["C, two threads"] = lambda: c_limit.sweep(wave, kp, kd, 2)
    smooth: dict[str, Callable[[], np.ndarray]] = {rungs: lambda: peers.numba_runge_kutta(wave, kp, kd)}
    pick = np.arange(0, len(kp), len(kp) // 8)
    own = [np.sum((wave - np.asarray(run_rig(rig(), laws[k], wave, LoopTiming()).angle)) ** 2) * PERIOD for k in pick]
    off = {name: np.max(np.abs(call()[pick] / own - 1.0)) for name, call in (same | smooth).items()}
    assert max(off[name] for name in same) < SAME, off
    off[scipy] = np.max(np.abs(np.array([peers.scipy_loop(wave, kp[k], kd[k]) for k in pick[:3]]) / own[:3] - 1.0))
    quick: dict[str, Callable[[], object]] = {ours: here, f"rwjax, `sweep`, {XLA}": by_xla(here), **same}
    slow = {name: (call, len(kp)) for name, call in smooth.items()}
    slow[scipy] = (lambda: peers.scipy_loop(wave, kp[700], kd[700]), 1)
    times = rounds({name: (call, len(kp)) for name, call in quick.items()} | slow, tuple(quick))
    widths = {
        rungs: f"sign smoothed over {peers.SMOOTH_SIGN:g} rad/s; ",
        scipy: f"sign smoothed over {peers.WIDTH:g} rad/s; ",
    }
    notes = {name: f"{widths.get(name, '')}squared error within {share:.0e}" for name, share in off.items()}
    report("10 s closed loops, 1600 gain pairs", "loop", times, ours, notes)
    takes = ", ".join(f"{ratio(times[ours], times[name]):.2f} times {name}" for name in quick if name != ours)
    print(f"rwjax takes {takes}")


PARTS = {"region": region, "plants": plants, "loops": loops}


def main(parts: list[str]) -> None:
    """Runs the parts in order."""
    if unknown := [part for part in parts if part not in PARTS]:
        sys.exit(f"unknown part {', '.join(unknown)}; parts are {', '.join(PARTS)}")
    print(machine())
    for part in parts or PARTS:
        PARTS[part]()


if __name__ == "__main__":
    main(sys.argv[1:])
