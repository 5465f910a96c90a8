"""The library: the order of effects, and what one effect says of others."""

import ast
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path

import pytest

import rwjax
from rwjax.effects import library, rig_terms
from rwjax.effects.effect import Effect, FittedRig
from rwjax.effects.library import (
    BY_NAME,
    EFFECTS,
    dry_numbers,
    included_in,
    included_numbers,
    limit_numbers,
    models,
    null_of_optional,
    of_kind,
    same_groups,
    shown_in,
    special_cases,
    thresholds,
    unit_of_number,
)
from rwjax.effects.parameter import parameters
from rwjax.effects.shown import COASTING, DWELLING, FAST, LEVELS, SLOW
from rwjax.kinds import KINDS, NUMBERS, of_half

ORDER = """
axis.viscous axis.coulomb axis.stribeck axis.quadratic_drag axis.asymmetric_friction axis.presliding axis.angle_friction
axis.load_friction axis.friction_drift axis.imbalance axis.spring axis.bias_torque axis.backlash axis.flexible_coupling
axis.end_stop axis.periodic_torque wheel.coulomb wheel.drag wheel.cogging motor.heating motor.saturation
motor.current_limit drive.deadzone drive.delay drive.lag drive.rate_limit drive.saturation drive.bias
drive.asymmetric_gain drive.supply_sag drive.curvature sensor.scale sensor.eccentricity sensor.delay
sensor.missed_counts sensor.clock
""".split()


def of_the_first(names: Iterable[str]) -> list[str]:
    """The names of the effects above, or of numbers of theirs, on one axis or on a half; not of effects that came later."""
    found = []
    for name in names:
        own = of_half(name)
        base = name if own is None else own[1]
        if base in ORDER or base.rpartition(".")[0] in ORDER:
            found.append(name)
    return found


def groups_of_the_first(groups: Iterable[Iterable[str]]) -> list[tuple[str, ...]]:
    """Groups without effects that came later, those left with two names or more."""
    return [kept for group in groups if len(kept := tuple(of_the_first(group))) > 1]


def test_tables_and_ties_keep_their_order() -> None:
    """An effect that is added takes its place among these, which keep theirs: ties are broken by this order."""
    assert [effect.name for effect in EFFECTS if effect.name in ORDER] == ORDER


def test_a_kind_of_rig_has_the_effects_of_its_parts() -> None:
    parts = {kind: {name.partition(".")[0] for name in of_kind(kind)} for kind in KINDS}
    assert parts["wheel"] == {"wheel", "motor", "drive", "sensor"}
    assert parts["platform"] == {"axis", "drive", "sensor"}
    assert parts["reaction"] == parts["wheel"] | parts["platform"]
    assert parts["two_axis"] >= {"yaw", "pitch", "wheel_2", "sensor"} and "axis" not in parts["two_axis"]


def test_optional_numbers_and_units_by_name() -> None:
    assert null_of_optional("axis.stribeck.n") == 2.0 and null_of_optional("pitch.quadratic_drag.p") == 2.0
    assert null_of_optional("axis.stribeck.M_c") is None is null_of_optional("axis.inertia")
    units = [unit_of_number(name) for name in ("axis.stribeck.v_s", "axis.stribeck.n", "wheel.inertia", "yaw.spring.k")]
    assert units == ["rad/s", "", "kg m2", "N m/rad"]


def test_what_effects_include_and_what_their_limits_are() -> None:
    assert {*of_the_first(name for name in BY_NAME if included_in(name) == "axis.coulomb")} == {
        "axis.stribeck",
        "axis.asymmetric_friction",
        "axis.presliding",
    }
    assert included_in("parameter.axis.inertia") == "" == included_in("axis.coulomb")
    assert special_cases("axis.backlash") == {"axis.flexible_coupling"}
    assert special_cases("axis.presliding") == {"axis.coulomb"} and special_cases("axis.viscous") == set()
    assert special_cases("axis.imbalance") == {"parameter.axis.gravity.torque", "parameter.axis.gravity.angle"}
    assert models(["axis.inertia", "axis.friction.b3"], "axis.coulomb") and models(["axis.friction.b2"], "axis.viscous")
    assert not models(["axis.inertia", "axis.friction.static"], "axis.coulomb")
    assert not models(["pitch.friction.coulomb"], "yaw.coulomb") and models(["yaw.friction.coulomb"], "yaw.coulomb")


def test_numbers_that_are_one_thing_in_several_effects() -> None:
    level = ("axis.coulomb.M_c", "axis.stribeck.M_c", "axis.asymmetric_friction.M_c", "axis.presliding.M_c")
    halves = [tuple(name.replace("axis.", f"{axis}.") for name in level) for axis in ("yaw", "pitch")]
    assert groups_of_the_first(included_numbers()) == [level, *halves]
    assert groups_of_the_first(limit_numbers()) == [
        (f"axis.flexible_coupling.{n}", f"axis.backlash.{n}") for n in ("s", "k", "c")
    ]


BIAS = ["axis.asymmetric_friction", "axis.bias_torque"]
CURVE = {"drive.curvature.c": -0.1, "drive.curvature.p": 0.0, "drive.curvature.u_1": 3.0}
LATE, SAG = ["drive.delay", "sensor.delay"], ["drive.supply_sag", "drive.curvature"]


@pytest.mark.parametrize(
    ("kind", "names", "numbers", "groups"),
    [
        ("wheel", (), {}, []),
        ("reaction", (), {}, [BIAS]),
        ("platform", (), {}, [[*BIAS, "drive.bias"], LATE, SAG]),
        ("platform", ("drive.deadzone",), {}, [BIAS, LATE, SAG]),
        ("platform", ("drive.curvature",), CURVE, [[*BIAS, "drive.bias"], LATE, SAG]),
        ("platform", ("drive.curvature",), CURVE | {"drive.curvature.c": 0.1}, [[*BIAS, "drive.bias"], LATE]),
        ("platform", ("drive.curvature",), CURVE | {"drive.curvature.p": 0.4}, [[*BIAS, "drive.bias"], LATE]),
        ("platform", ("drive.supply_sag",), {"drive.supply_sag.m": 0.05}, [[*BIAS, "drive.bias"], LATE, SAG]),
        ("platform", ("drive.supply_sag",), {"drive.supply_sag.m": 0.9}, [[*BIAS, "drive.bias"], LATE]),
        ("two_axis", (), {}, [[f"{axis}.{name[5:]}" for name in BIAS] for axis in ("yaw", "pitch")]),
    ],
)
def test_effects_that_no_log_of_a_kind_of_rig_tells_apart(
    kind: str, names: tuple[str, ...], numbers: dict[str, float], groups: list[list[str]]
) -> None:
    found = same_groups(FittedRig(kind, frozenset(names), numbers))
    assert [sorted(group) for group in groups_of_the_first(found)] == [sorted(group) for group in groups]


@pytest.mark.parametrize(
    ("run", "names"),
    [
        (COASTING, "axis.viscous axis.coulomb axis.quadratic_drag axis.asymmetric_friction wheel.coulomb wheel.drag"),
        (FAST, "drive.delay drive.lag drive.rate_limit axis.flexible_coupling sensor.delay sensor.clock"),
        (SLOW, "axis.coulomb axis.stribeck axis.presliding axis.angle_friction axis.imbalance wheel.cogging"),
        (
            LEVELS,
            "drive.deadzone drive.saturation drive.curvature drive.asymmetric_gain drive.supply_sag motor.saturation",
        ),
        (DWELLING, "axis.stribeck axis.presliding axis.backlash drive.deadzone"),
    ],
)
def test_what_a_run_shows_keeps_its_order(run: str, names: str) -> None:
    """Plans list these: an effect that is added takes its place among them."""
    assert [name for name in shown_in(run, "reaction") if name in ORDER] == names.split()
    assert {*shown_in(run, "wheel")} == {name for name in shown_in(run, "reaction") if not name.startswith("axis.")}


def test_numbers_of_dry_friction_give_levels_and_no_others() -> None:
    every = [*NUMBERS, *(f"{name}.{number}" for name, effect in BY_NAME.items() for number in parameters(effect))]
    named = ("friction.coulomb", "friction.static", "friction.b3", ".M_c", ".M_e")
    known = {name for name in every if name in NUMBERS or name.rpartition(".")[0] in BY_NAME}
    found = dry_numbers(every)
    assert {name for name in known if name.endswith(named)} <= found
    assert not {"axis.asymmetric_friction.d", "axis.spring.T_0", "axis.friction.b2", "axis.gravity.torque"} & found
    assert {"axis.load_friction.mu", "yaw.load_friction.mu"} <= found  # a level in proportion to the load
    assert dry_numbers(["axis.stribeck.v_s"]) == set()


def test_the_threshold_of_a_command() -> None:
    assert "drive.deadzone.u_0" in thresholds("wheel") and "drive_2.deadzone.u_0" in thresholds("two_axis")


def texts(tree: ast.AST) -> Iterator[str]:
    """Every text in a module's code but for its docstrings."""
    docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.value


def test_no_other_room_names_an_effect() -> None:
    """What an effect needs of the rest of the library stands in its class, so that a new one is one class."""
    rooms = Path(rwjax.__file__).parent
    classes = {effect.__name__ for effect in BY_NAME.values()}
    for path in sorted(rooms.rglob("*.py")):
        if path.parent == rooms / "effects":
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        named = [text for text in texts(tree) if text in BY_NAME or text.rpartition(".")[0] in BY_NAME]
        given = [a.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for a in node.names]
        assert named == [] and not classes & {*given}, path


def test_every_effect_class_of_the_room_is_known_or_a_term_of_the_rig_file() -> None:
    for path in Path(library.__file__).parent.glob("*.py"):
        module = import_module(f"rwjax.effects.{path.stem}")
        own = [c for c in vars(module).values() if isinstance(c, type) and c.__module__ == module.__name__]
        final = [
            c for c in own if issubclass(c, Effect) and c is not Effect and not getattr(c, "__abstractmethods__", ())
        ]
        assert module is rig_terms or {*final} <= {*BY_NAME.values()}, path
