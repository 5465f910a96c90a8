"""The rules of `experiments.house` find what they should, in trees that break one each and in one that breaks none."""

from pathlib import Path

import pytest

from experiments.house.circles import cycles, module_edges, room_edges
from experiments.house.prose import sentences, wide_cells
from experiments.house.rules import RULES
from experiments.house.tree import Tree

GOOD = '''"""A module."""


def torque(w: float, axis: str) -> float:
    """Torque of the axis.

    Args:
        w: yaw rate [rad/s].
        axis: which axis.

    Returns:
        Torque [N m].
    """
    return 0.1 * w
'''
EFFECT = '''"""Effects."""


class Coulomb:
    """Dry friction."""

    name: str = "axis.coulomb"
'''


def tree(root: Path, **files: str) -> Tree:
    """A checkout of a good module, an effect and its tests, and of what is given: `a__b` is the file `a/b.py`, `a__INIT` its `__init__`."""
    given = {"rwjax__fitting__good": GOOD, "rwjax__effects__axis": EFFECT}
    given |= {"tests__fitting__test_good": "", "tests__effects__test_axis": ""} | files
    for name, text in given.items():
        path = (root / name.replace("__", "/").replace("INIT", "__init__")).with_suffix(".py")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return Tree(root)


def breaches(found: Tree) -> dict[str, list[str]]:
    """What each rule says of a tree, but for the modules whose tests are missing."""
    said = {rule: [f.what for f in check(found)] for rule, check in RULES.items()}
    return {rule: what for rule, what in said.items() if what and rule != "modules without a mirrored test"}


def test_a_good_tree_breaks_no_rule(tmp_path: Path) -> None:
    found = tree(tmp_path)
    assert {rule: check(found) for rule, check in RULES.items()} == {rule: [] for rule in RULES}


@pytest.mark.parametrize("lines, broken", [(49, False), (50, True)])
def test_long_functions(tmp_path: Path, lines: int, broken: bool) -> None:
    body = "\n\n    # a comment\n".join(["    x = 1"] * lines)
    said = breaches(tree(tmp_path, rwjax__fitting__long=f'def f() -> None:\n    """Some\n\n    lines."""\n{body}\n'))
    assert said == ({"long functions": ["f has 51 lines of code"]} if broken else {})


@pytest.mark.parametrize(
    "code, what",
    [
        ('X = "axis.coulomb"\n', "names `axis.coulomb`"),
        ('X = "add axis.coulomb: it is dry"\n', "names `axis.coulomb`"),
        ('X = "axis.coulomb.M_c"\n', "names `axis.coulomb`"),
        ("from rwjax.effects.axis import Coulomb\n", "imports Coulomb"),
        ("from rwjax.effects import axis\nX = axis.Coulomb\n", "takes axis.Coulomb"),
        ('"""Like `axis.coulomb`."""\n', None),
        ('X = "axis.coulombs", "axis.friction.coulomb"\n', None),
    ],
)
def test_effects_outside_their_room(tmp_path: Path, code: str, what: str | None) -> None:
    said = breaches(tree(tmp_path, rwjax__control__law=code))
    assert said == ({} if what is None else {"effects named outside effects/": [what]})


def test_limits_of_the_diagnosis(tmp_path: Path) -> None:
    files = {
        "rwjax__diagnosis__settings": "NEEDED = 5.0\n",
        "rwjax__diagnosis__gap": 'FAR, NEAR = -3.0, "x"\nNAME = "a"\n',
    }
    assert breaches(tree(tmp_path, **files)) == {"limits outside the diagnosis settings": ["sets (FAR, NEAR)"]}


def test_modules_in_the_root(tmp_path: Path) -> None:
    said = breaches(tree(tmp_path, **{f"rwjax__m{k}": "" for k in range(8)}))
    assert said == {"modules in the root": ["is one of 8 in the root"] * 8}


def test_circles_through_types_and_functions(tmp_path: Path) -> None:
    files = {
        "rwjax__a__one": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from rwjax.b.two import X\n",
        "rwjax__b__two": "def f() -> None:\n    from ..a import one\n",
        "rwjax__b__three": "import rwjax.b.two\n",
    }
    found = tree(tmp_path, rwjax__a__INIT="", **files)
    assert cycles(module_edges(found)) == [["rwjax.a.one", "rwjax.b.two"]]
    assert cycles(room_edges(found)) == [["rwjax.a", "rwjax.b"]]
    assert breaches(found)["imports in a circle"] == [
        "imports rwjax.b.two, which comes back to it",
        "imports rwjax.a.one, which comes back to it",
    ]


@pytest.mark.parametrize(
    "old, new, lacks",
    [
        ("        axis: which axis.\n", "", "Args axis"),
        ("rate [rad/s]", "rate", "unit of w"),
        ("    Returns:\n        Torque [N m].\n", "", "Returns, unit of what it returns"),
        ("    Returns:\n        Torque [N m].\n", "    Returns:\n        Torque.\n", "unit of what it returns"),
        ("w: float, axis: str", "*, w: 'Float[Array, \" n\"]', axis: str", None),
        (
            "        w: yaw rate [rad/s].\n",
            "        w: yaw rate, as long\n            as it is finite [rad/s].\n",
            None,
        ),
        (
            "        w: yaw rate [rad/s].\n        axis: which axis.\n",
            "        w, axis: yaw rate [rad/s] and its axis.\n",
            None,
        ),
    ],
)
def test_docstrings(tmp_path: Path, old: str, new: str, lacks: str | None) -> None:
    assert old in GOOD
    said = breaches(tree(tmp_path, rwjax__fitting__good=GOOD.replace(old, new)))
    assert said == (
        {} if lacks is None else {"public functions not fully documented": [f"torque does not document: {lacks}"]}
    )


def test_a_method_is_documented_by_the_class_that_asks_for_it(tmp_path: Path) -> None:
    method = GOOD.split('"""A module."""\n\n\n')[1].replace("torque(", "torque(self, ").replace("\n", "\n    ").rstrip()
    port = f'class Port:\n    """A port."""\n\n    {method}\n'
    code = "class Drag(Port):\n    def torque(self, w: float, axis: str) -> float:\n        return w\n"
    files = {"rwjax__effects__ports": port, "rwjax__effects__drag": code}
    assert breaches(tree(tmp_path, **files)) == {}
    files["rwjax__effects__ports"] = port.replace("Port", "Other")
    assert list(breaches(tree(tmp_path, **files))) == ["public functions not fully documented"]


@pytest.mark.parametrize(
    "code, what",
    [
        ("from rwjax.fitting.good import _hidden\n", ["touches _hidden"]),
        ("x = law._gain\n", ["touches law._gain"]),
        ('monkeypatch.setattr(law, "_gain", 1.0)\n', ["touches _gain"]),
        ('monkeypatch.setattr("rwjax.fitting.good._gain", 1.0)\n', ["touches rwjax.fitting.good._gain"]),
        ('import os\nx = os._exit\nmonkeypatch.setattr(os, "_exit", 1)\nmonkeypatch.setattr("os._exit", 1)\n', None),
        ("x = law._replace(kp=1.0)\ny = law.__doc__\n", None),
    ],
)
def test_private_members(tmp_path: Path, code: str, what: list[str] | None) -> None:
    said = breaches(tree(tmp_path, tests__fitting__test_good=code))
    assert said == ({} if what is None else {"tests that touch private members": what})


def test_modules_without_a_test(tmp_path: Path) -> None:
    found = tree(tmp_path, rwjax__link__line="", rwjax__kinds="", rwjax__link__INIT="", tests__link__test_other="")
    said = [f.what for f in RULES["modules without a mirrored test"](found)]
    assert said == ["has no tests/test_kinds.py", "has no tests/link/test_line.py"]


def test_prose() -> None:
    page = "# A head. One\n\nOne two three. Four `x.y` [five](a.b)!\n\n- six 0.5 seven\n- eight\n\n```\nno. No. No.\n```\n| a | b. C |\n"
    assert sentences(page) == ["One two three.", "Four `x.y` five!", "six 0.5 seven", "eight"]
    assert wide_cells(f"| a | {'b' * 200} |\n| a | {'b' * 201} |\n") == 1
