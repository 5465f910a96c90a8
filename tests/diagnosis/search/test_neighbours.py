"""Neighbours: hypotheses with one name more or one exchanged."""

from rwjax.diagnosis.hypothesis import Hypothesis
from rwjax.diagnosis.search.neighbours import exchanges, extensions

NAMES = ("axis.coulomb", "axis.stribeck", "drive.lag")


def names(found: list[Hypothesis]) -> list[set[str]]:
    return [{*e.names} for e in found]


def test_an_extension_for_every_further_name() -> None:
    assert names(extensions(NAMES, Hypothesis())) == [{name} for name in NAMES]
    assert names(extensions(NAMES, Hypothesis(("drive.lag",)))) == [{"drive.lag", name} for name in NAMES[:2]]
    assert extensions(NAMES[:1], Hypothesis(("axis.coulomb",))) == []


def test_what_includes_plain_dry_friction_takes_its_place() -> None:
    assert names(extensions(NAMES, Hypothesis(("axis.coulomb",)))) == [{"axis.stribeck"}, {"axis.coulomb", "drive.lag"}]
    assert names(extensions(NAMES, Hypothesis(("axis.stribeck",)))) == [{"axis.stribeck", "drive.lag"}]


def test_every_member_is_exchanged_for_every_other_name() -> None:
    assert names(exchanges(NAMES, Hypothesis(("drive.lag",)))) == [{"axis.coulomb"}, {"axis.stribeck"}]
    found = names(exchanges(NAMES, Hypothesis(("axis.coulomb", "drive.lag"))))
    assert found == [{"drive.lag", "axis.stribeck"}, {"axis.coulomb", "axis.stribeck"}]


def test_what_includes_dry_friction_is_exchanged_for_it_and_another_name() -> None:
    found = names(exchanges(NAMES, Hypothesis(("axis.stribeck",))))
    assert found == [{"axis.coulomb"}, {"drive.lag"}, {"drive.lag", "axis.coulomb"}]
