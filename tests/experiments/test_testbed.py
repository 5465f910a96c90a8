"""How a diagnosis of the simulated testbed is scored."""

import pytest

pytest.importorskip("numba", reason="the simulated testbed needs the extra `experiments`")

from experiments.testbed.run import judged, row

LAG, BIAS, ESC = ["drive.lag"], ["drive.bias"], ["drive.deadzone", "drive.lag", "drive.supply_sag"]


@pytest.mark.parametrize(
    ("case", "verdict", "effects", "alternatives", "said"),
    [
        ("none", "none", [], [], "named"),
        ("none", "unknown", [], [], "wrong"),  # says that something is missing
        ("none", "unknown", LAG, [], "wrong"),
        ("none", "effect", LAG, [], "wrong"),
        ("none", "ambiguous", LAG, [BIAS], "wrong"),
        ("drive.lag", "effect", LAG, [], "named"),
        ("drive.lag", "ambiguous", LAG, [BIAS], "named, with rivals"),
        ("drive.lag", "ambiguous", BIAS, [LAG], "among the rivals"),
        ("drive.lag", "unknown", LAG, [], "not named"),  # helps, and is not claimed
        ("drive.lag", "unknown", [], [], "not named"),
        ("drive.lag", "none", [], [], "not named"),
        ("drive.lag", "effect", BIAS, [], "wrong"),
        ("drive.lag", "effect", LAG + BIAS, [], "named, and more"),
        ("drive.lag", "ambiguous", LAG + BIAS, [BIAS], "named, and more"),
        ("esc", "effect", LAG, [], "partly"),
        ("esc", "effect", ESC, [], "named"),
    ],
)
def test_the_score_follows_the_verdict(
    case: str, verdict: str, effects: list[str], alternatives: list[list[str]], said: str
) -> None:
    assert judged(case, {"verdict": verdict, "effects": effects, "alternatives": alternatives}) == said


def test_a_row_says_that_effects_help_where_they_are_not_named() -> None:
    found = {"verdict": "unknown", "effects": BIAS, "alternatives": [], "gap": {"closed": 0.82}}
    seconds = {"record_s": 92.0, "diagnose_s": 264.0}
    assert row("esc", found | seconds) == "| esc | not named | unknown: drive.bias help | 82 % | 92 + 264 s |"
