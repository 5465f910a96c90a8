"""Numbers that follow from others: formulas, their order, what is refused, and files with them."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from rwjax import RigError, parse_rig, write_rig
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.rig.tied import completed, evaluate, names_in, tied_section, with_constants, with_tied

FILE = """
kind = "platform"
[drive]
gain = 0.4
[axis]
inertia = 0.1
[axis.friction]
viscous = 0.02
[axis.gravity]
{gravity}
[fit]
free = ["axis.inertia"]
[fit.tied]
{tied}
"""


def file(*tied: str, gravity: str = "angle = 0.1") -> str:
    return FILE.format(tied="\n".join(tied), gravity=gravity)


TIED = '"axis.gravity.torque" = "axis.inertia * 9.0"'


@pytest.mark.parametrize(
    ("formula", "exact"),
    [
        ("a.b + 2 * c", 5.0),
        ("-((a.b - c) ** 2) / 4", -1.0),
        ("sqrt(a.b * 3) + abs(-c)", 4.0),
        ("exp(log(c)) + sin(0) + cos(0)", 2.0),
        ("2 ** a.b", 8.0),
    ],
)
def test_a_formula_is_arithmetic_with_names(formula: str, exact: float) -> None:
    values = {"a.b": 3.0, "c": 1.0}
    assert evaluate(formula, values) == pytest.approx(exact, rel=1e-15)
    assert {*names_in(formula)} <= {*values}
    assert evaluate(with_constants(formula, values), {}) == pytest.approx(exact, rel=1e-15)


def test_slopes_go_through_a_formula() -> None:
    slope = jax.grad(lambda x: evaluate("x ** 2 * sqrt(x) + 3 / x", {"x": x}, jnp))(jnp.asarray(2.0))
    assert float(slope) == pytest.approx(2.5 * 2.0**1.5 - 0.75, rel=1e-14)


def test_a_number_follows_wherever_it_stands_in_the_table() -> None:
    table = {"axis.friction.coulomb": "0.1 * axis.gravity.torque", "axis.gravity.torque": "9 * axis.inertia"}
    order, found = tied_section({"axis.inertia": 0.2}, table, "platform")
    assert [*order] == ["axis.gravity.torque", "axis.friction.coulomb"]
    assert found == pytest.approx({"axis.gravity.torque": 1.8, "axis.friction.coulomb": 0.18})
    assert completed(order, {"axis.inertia": 1.0})["axis.friction.coulomb"] == pytest.approx(0.9)


def test_a_coefficient_of_a_polynomial_takes_its_place() -> None:
    stated = {"axis.friction.polynomial": [1.0, 2.0, 3.0, 4.0]}
    with_tied(stated, {"axis.friction.b1": 7.0, "axis.inertia": 0.1})
    assert stated == {"axis.friction.polynomial": [1.0, 2.0, 7.0, 4.0], "axis.inertia": 0.1}


def test_a_file_may_leave_the_number_out_and_its_value_counts_for_nothing() -> None:
    for gravity in ("angle = 0.1", "torque = 55.0\nangle = 0.1"):
        rig = parse_rig(file(TIED, gravity=gravity))
        assert rig.numbers["axis.gravity.torque"] == pytest.approx(0.9)
        assert parse_rig(write_rig(rig)) == rig
        assert rig.with_values({"axis.inertia": 0.2}).values["axis.gravity.torque"] == pytest.approx(1.8)
        assert "(= axis.inertia * 9.0)" in str(rig)


def test_a_plant_takes_it_from_the_others_and_not_from_the_vector() -> None:
    rig = parse_rig(file(TIED))
    structure = structure_of(rig)
    theta = theta_of(rig, structure)
    k = structure.names.index("axis.gravity.torque")

    def torque(theta):
        return plant_of(structure, theta).numbers["axis.gravity.torque"]

    theta[k], theta[structure.names.index("axis.inertia")] = math.nan, 0.3
    assert float(torque(jnp.asarray(theta))) == pytest.approx(2.7)
    slope = np.asarray(jax.grad(torque)(jnp.asarray(theta)))
    assert dict(zip(structure.names, slope, strict=True))["axis.inertia"] == pytest.approx(9.0)


def test_a_number_of_an_effect_follows_and_leads() -> None:
    text = file('"axis.gravity.torque" = "axis.spring.k / 2"', '"axis.spring.T_0" = "0.1 * axis.gravity.torque"')
    rig = parse_rig(text + '[effects."axis.spring"]\nk = 0.6')
    assert rig.effects["axis.spring"]["T_0"] == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("tied", "said"),
    [
        ('"axis.gravity.torque" = "axis.inertai * 9.0"', "no number of this file; the nearest is `axis.inertia`"),
        ('"axis.gravity.torque" = "axis.friction.coulomb"', "which has no value in this file; give it one"),
        ('"axis.gravity.torqe" = "1.0"', "the nearest is `axis.gravity.torque`"),
        ('"axis.gravity.torque" = "axis.inertia 9.0"', "is no formula"),
        ('"axis.gravity.torque" = "tan(axis.inertia)"', "is no formula"),
        ('"axis.gravity.torque" = "axis.inertia if 1 else 2"', "is no formula"),
        ('"axis.gravity.torque" = "\'a\' * 3"', "is no formula"),
        ('"axis.gravity.torque" = 9.0', "has to be a formula in quotes"),
        ('"axis.inertia" = "2.0"', "`fit.free` names `axis.inertia`, which follows from others"),
        ('"axis.gravity.torque" = "axis.gravity.torque + 1"', "goes in a circle"),
        (
            '"axis.gravity.torque" = "axis.friction.coulomb"\n"axis.friction.coulomb" = "axis.gravity.torque"',
            "goes in a circle: `axis.gravity.torque` from `axis.friction.coulomb` from `axis.gravity.torque`",
        ),
        ('"axis.friction.coulomb" = "axis.inertia - 1"', "has to be zero or positive"),
        ('"axis.gravity.torque" = "1e15 * axis.inertia"', "lies between"),
        ('"axis.gravity.torque" = "1 / (axis.inertia - 0.1)"', "no finite number"),
        ('"axis.gravity.torque" = "sqrt(-axis.inertia)"', "no finite number"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(tied: str, said: str) -> None:
    with pytest.raises(RigError) as error:
        parse_rig(file(tied, gravity="angle = 0.1\ntorque = 0.5"))
    assert said in str(error.value) and "\n" not in str(error.value)
