"""The peers and the C program of the benchmark of control do what the library does; so does the trial on the simulator's rig."""

import numpy as np
import pytest

pytest.importorskip("numba", reason="the peers and the separate simulator need the extra `experiments`")

from experiments.control import c_limit, holds, pays, peers
from experiments.control.problem import LIMIT, PERIOD, SIGMA, SMOOTH, gains, reference, rig
from rwjax import parse_rig
from rwjax.control.closed_loop import run_rig
from rwjax.control.controller import Controller, LoopTiming
from rwjax.control.linear import linearised
from rwjax.control.loop_polynomial import pd_loop
from rwjax.control.stability import stable
from rwjax.control.transfer import transfer

WAVE, (KP, KD) = reference(), gains(64)
PICK = [0, 9, 30, 63]


def own(k: int) -> float:
    run = run_rig(rig(), Controller(KP[k], kd=KD[k], filter_time=SMOOTH, voltage_limit=LIMIT), WAVE, LoopTiming())
    return float(np.sum((WAVE - np.asarray(run.angle)) ** 2) * PERIOD)


# the C program is a peer of the benchmark, not of the library: without a compiler there is nothing to compare with
@pytest.mark.slow
@pytest.mark.skipif(not c_limit.available(), reason="the C peer of the benchmark needs gcc and AVX-512")
def test_c_and_numba_run_the_same_loops() -> None:
    costs = np.array([own(k) for k in PICK])
    p = c_limit.of_rig()
    E, P, Q = (np.array(getattr(p, name)).reshape(4, 4) for name in ("E", "P1", "P2"))
    assert c_limit.sweep(WAVE, KP, KD, 1)[PICK] == pytest.approx(costs, rel=1e-9)
    assert peers.numba_sweep(WAVE, KP, KD, E, P, Q)[PICK] == pytest.approx(costs, rel=1e-9)


def test_solvers_with_a_smooth_sign_come_close() -> None:
    assert peers.scipy_loop(WAVE[:300], KP[30], KD[30]) == pytest.approx(
        float(
            np.sum(
                (
                    WAVE[:300]
                    - np.asarray(
                        run_rig(
                            rig(), Controller(KP[30], kd=KD[30], filter_time=SMOOTH, voltage_limit=LIMIT), WAVE[:300]
                        ).angle
                    )
                )
                ** 2
            )
            * PERIOD
        ),
        rel=0.01,
    )


def test_every_peer_finds_the_same_region() -> None:
    plant = transfer(linearised(rig(dry=False)))
    kp, kd = np.random.default_rng(4).uniform(0.0, 100.0, (2, 200))
    found = stable(pd_loop(plant), kp, kd, sigma=SIGMA)
    for peer in (peers.roots_loop, peers.control_loop, peers.eigenvalues):
        assert np.array_equal(peer(plant, kp, kd, SIGMA), found)


@pytest.mark.parametrize("name", ["nothing", "Coulomb friction"])
def test_the_trial_on_the_simulator_is_the_library_s_loop(name: str) -> None:
    truth = pays.CASES[name]
    model = parse_rig(
        'kind = "reaction"\n[motor]\ntorque_constant = 0.0182\nresistance = 0.83\ninductance = 0.0641\nfriction = 4.07e-6\n[wheel]\n'
        f"inertia = 1.24e-4\n[axis]\ninertia = {truth.I}\n[axis.friction]\nviscous = {truth.viscous}\ncoulomb = {truth.coulomb}"
    )
    law = Controller(40.0, 10.0, 10.0, 0.02, 0.3, np.radians(0.2), 10.0)
    steps = np.repeat([0.3, -0.1], 300)
    numbers = np.array([*law[:7]], float)
    angle, _ = pays.simulated_rig(steps, numbers, -1.0, truth.array())
    ours = np.asarray(run_rig(model, law, steps, LoopTiming(counts=pays.COUNTS)).angle)
    assert np.max(np.abs(angle - ours)) < 0.5 * 2.0 * np.pi / pays.COUNTS  # a count read earlier or later moves on


@pytest.mark.parametrize("kind", ["platform", pytest.param("reaction", marks=pytest.mark.slow)])
def test_the_limit_of_all_plants_drawn_is_beyond_the_true_one(kind: str) -> None:
    found = holds.limits(kind, holds.FIRST_SEED)
    assert found.drawn > max(found.fitted, found.true)
    assert found.fitted == pytest.approx(found.true, rel=1e-3)
