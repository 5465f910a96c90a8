"""Law: what a free-form law of a coordinate explains of the missing torque, with and without a name."""

import pytest

from rwjax.diagnosis.hypothesis import NOTHING, Hypothesis
from rwjax.diagnosis.localise.law import law_left, laws
from tests.diagnosis.several_runs import run_of, searched

DRY, DRAG = (Hypothesis((name,)) for name in ("axis.coulomb", "axis.quadratic_drag"))
FRICTION = {"axis.coulomb": {"M_c": 0.06}}


@pytest.mark.slow
def test_a_law_of_the_rate_is_seen_until_the_friction_is_added() -> None:
    fits = searched([run_of(k, FRICTION) for k in range(3)], DRY, DRAG).fits
    before, after = (laws(fits, e, ["yaw_rate", "time"]) for e in (NOTHING, DRY))
    assert before["yaw_rate"].explains > 30.0 * before["yaw_rate"].chance > 0.0
    assert after["yaw_rate"].explains < 0.1 * before["yaw_rate"].explains
    left = law_left(fits, DRY, NOTHING, "axis.coulomb")
    assert left is not None and left < 0.1
    other = law_left(fits, DRAG, NOTHING, "axis.quadratic_drag")  # of the same coordinate, and of another form
    assert other is not None and other > 0.5


@pytest.mark.parametrize("names", [pytest.param(["load"], marks=pytest.mark.slow), ["voltage", "nothing"]])
def test_a_coordinate_that_no_log_tells_has_no_law(names: list[str]) -> None:
    fits = searched([run_of(0, FRICTION)], DRY).fits
    assert [*laws(fits, DRY, names)] == [name for name in names if name == "voltage"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["drive.lag", "sensor.delay", "axis.presliding"])
def test_where_the_measured_motion_is_not_all_of_the_plants_there_is_no_law(name: str) -> None:
    one = Hypothesis((name,))
    fits = searched([run_of(0, FRICTION)], one).fits
    assert laws(fits, one, ["voltage"]) == {} and law_left(fits, one, NOTHING, name) is None
