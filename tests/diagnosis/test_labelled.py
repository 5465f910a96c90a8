"""Every verdict is reached on a labelled case of the repository, with the names of its label."""

import json
import re
from pathlib import Path

import pytest

from rwjax import diagnose, read_logs, read_rig

CASES = Path(__file__).parents[2] / "data" / "labelled"
VERDICTS = ("none", "effect", "ambiguous", "unknown")


def truth_of(verdict: str) -> dict:
    """The label of a case."""
    return json.loads((CASES / verdict / "truth.json").read_text())


@pytest.mark.parametrize(
    "verdict", ["none", *(pytest.param(name, marks=pytest.mark.slow) for name in ("effect", "ambiguous", "unknown"))]
)
def test_the_verdict_and_the_names_are_those_of_the_label(verdict: str) -> None:
    truth = truth_of(verdict)
    rig = read_rig(CASES / verdict / "rig.toml")
    found = diagnose(rig, read_logs(sorted((CASES / verdict).glob("*.csv")), rig))
    assert found.verdict == verdict
    named = {found.effects, *found.alternatives}
    if verdict in ("none", "effect"):
        assert named == {tuple(truth["effects"])}
    elif verdict == "ambiguous":  # the truth and what is the same thing in this rig, each alone
        (missing,) = truth["effects"]
        assert named == {(name,) for name in (missing, *truth["same_as"][missing])}
    else:
        assert truth["outside"] and not truth["effects"]
        gap = found.gaps[found.signal]
        assert gap.after > 1.25 * gap.floor


def test_the_commands_that_made_the_cases_are_written_beside_them() -> None:
    text = (CASES / "README.md").read_text()
    made = re.findall(r"--kind (\S+) --effect (\S+) --seed (\d+)(?: --amplitude (\S+))? -o data/labelled/(\S+)", text)
    assert {folder for *_, folder in made} == {*VERDICTS}
    for kind, effect, seed, amplitude, folder in made:
        truth = truth_of(folder)
        said = (truth["kind"], truth["effect"], truth["seed"], truth["amplitude"])
        assert said == (kind, effect, int(seed), float(amplitude or 1.0))
