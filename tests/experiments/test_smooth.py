"""What the smooth solver costs: the newcomer's script solves the library's problem, and the yardsticks know the truth."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

pytest.importorskip("numba", reason="the separate simulator needs the extra `experiments`")

from experiments.smooth import against_newcomer, gradients, newcomer, rigs, run
from experiments.smooth.creep import LASTS, SHARE, creep, crept, unloaded
from rwjax import Exact, Log, Smooth, parse_rig
from rwjax.fitting.problem import pose
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of

PLATFORM = """kind = "platform"
[drive]
gain = 0.4
[axis]
inertia = 0.2
[axis.friction]
{friction}
[fit]
free = ["axis.inertia"]
"""


def test_the_newcomer_begins_where_the_library_does() -> None:
    for case, rig in (("demo", rigs.demo().rig), ("emps", rigs.with_four_terms())):
        names = against_newcomer.NAMES[case]
        assert {names[short]: value for short, value in newcomer.START[case].items()} == {
            name: rig.values[name] for name in rig.free
        }


def test_the_newcomer_reads_the_demo_as_the_library_does() -> None:
    log = rigs.demo().train[0]
    t, u, y = newcomer.load("demo", [str(rigs.ROOT / "data" / "demo" / log.name)])
    assert np.array_equal(t, log.time) and np.array_equal(u[0], log.command)
    assert np.allclose(y[0], log.outputs["yaw_rad"], rtol=1e-12)


@pytest.mark.slow  # the separate simulator is compiled
def test_the_exact_yardstick_leaves_less_than_a_count_of_the_true_numbers_alone() -> None:
    trial = rigs.demo()
    right = against_newcomer.known("demo", trial)
    count = 2.0 * np.pi / 2048
    assert against_newcomer.exactly("demo", right, trial) < count
    assert against_newcomer.exactly("demo", right | {"coulomb": 1.01 * right["coulomb"]}, trial) > 3.0 * count


@pytest.mark.parametrize("case", ["demo", "emps"])
def test_the_newcomers_field_is_the_plants_smooth_field(case: str) -> None:
    rig = rigs.demo().rig if case == "demo" else rigs.with_four_terms()
    structure = structure_of(rig)
    plant, rng = plant_of(structure, jnp.asarray(theta_of(rig, structure))), np.random.default_rng(0)
    width = jnp.asarray(newcomer.WIDTH[case])
    for w in (-0.3, -1e-3, 0.0, 2e-3, 1.0):
        volts, x = jnp.asarray(rng.normal()), jnp.array([rng.normal(), w])
        ours = plant.with_smooth_friction(jnp.zeros(()), tuple(x), volts, width)
        theirs = newcomer.FIELDS[case](0.0, x, (newcomer.START[case], lambda t, volts=volts: volts))
        assert np.allclose(ours, theirs, rtol=1e-6, atol=1e-9)


@pytest.mark.slow  # the smooth simulation is compiled
def test_a_stuck_axis_creeps_by_the_closed_form_and_not_at_all_with_exact_stick() -> None:
    rig = parse_rig(PLATFORM.format(friction="coulomb = 0.3"))
    loaded = replace(rig, effects={"axis.bias_torque": {"T": 0.05}})
    assert unloaded(loaded).effects == {}
    assert creep(loaded, Exact()) == 0.0
    assert creep(loaded, Smooth(width=0.01)) == pytest.approx(crept(0.01, SHARE, LASTS), rel=1e-3)


@pytest.mark.slow  # sensitivities are compiled
def test_a_wrong_derivative_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = parse_rig(PLATFORM.format(friction="viscous = 0.1"))
    t = 0.01 * np.arange(200)
    log = Log("run", t, np.sin(t), {"yaw_rad": 0.1 * t**2}, {"yaw_rad": 0.0}, {}, False, None, 0.0)
    assert gradients.gradients(rig, [log], Exact()) == (0.0, 0.0)
    structure = structure_of(rig)
    number = np.array([structure.names.index("axis.inertia")])
    own, secant = gradients.slopes(pose(structure, [log]), theta_of(rig, structure), number)
    assert own == pytest.approx(secant, rel=1e-5)
    right = gradients.residual_jacobian
    monkeypatch.setattr(gradients, "residual_jacobian", lambda e, log: 1.2 * right(e, log))
    assert gradients.gradients(rig, [log], Exact()) == (0.0, 1.0)


def test_errors_are_those_from_the_truth_or_else_from_the_exact_solver() -> None:
    solvers = {
        "exact": {"numbers": {"a": [2.0, 0.1], "b": [-1.0, None]}},
        "1": {"numbers": {"a": [2.2, 0.4], "b": [-1.5, 0.1]}},
    }
    relative, standard = run.errors({"truth": {}, "solvers": solvers}, "1")
    assert relative == pytest.approx([0.1, 0.5]) and standard == pytest.approx([2.0])
    relative, standard = run.errors({"truth": {"a": 2.0, "b": -1.0}, "solvers": solvers}, "1")
    assert relative == pytest.approx([0.1, 0.5]) and standard == pytest.approx([0.5, 5.0])


@pytest.mark.slow  # every kind compiles programs of its own, for the simulation of its logs too
@pytest.mark.parametrize("kind", rigs.KINDS)
def test_a_simulated_rig_lacks_nothing(kind: str) -> None:
    trial = rigs.simulated(kind, 0)
    right = trial.rig.with_values(trial.truth)
    floor = run.floors(right, trial.held_out)
    assert run.over_floor(right, trial.held_out, Exact(), floor) < 1.3
    dry = next(name for name in trial.truth if "coulomb" in name)
    wrong = right.with_values({dry: 1.2 * trial.truth[dry]})
    assert run.over_floor(wrong, trial.held_out, Exact(), floor) > 1.5


@pytest.mark.slow  # fits one rig by every solver
def test_a_line_of_the_campaign_holds_what_the_table_prints(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run, "FACTORS", (1.0,))
    line = run.answer({"index": 3, "group": "platform", "number": 1})
    found = line["solvers"]
    assert not any("error" in one for one in found.values())
    assert found["exact"]["creep"] == 0.0 < found["1"]["creep"]
    assert all(run.errors(line, name)[0] == pytest.approx([0.0] * 5, abs=0.02) for name in ("exact", "1"))
    run.tables([line])
    assert "| platform | smooth x 1 | 1 |" in capsys.readouterr().out


@pytest.mark.slow  # sensitivities of a reaction rig are compiled
def test_fine_steps_make_the_smooth_derivatives_follow_the_sum_of_squares() -> None:
    trial = rigs.simulated("reaction", 0)
    rig = trial.rig.with_values(trial.truth)
    structure = structure_of(rig)
    theta = theta_of(rig, structure)
    numbers = np.flatnonzero([name in rig.free for name in structure.names])
    theta[numbers] *= 1.05
    solver = Smooth(rtol=1e-9, atol=1e-11).suited(rig, trial.train)
    own, secant = gradients.slopes(pose(structure, trial.train, solver=solver), theta, numbers)
    assert own == pytest.approx(secant, rel=1e-4)
