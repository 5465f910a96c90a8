"""What is kept on the fields of an effect."""

from rwjax.effects import axis
from rwjax.effects.parameter import parameters


def test_starts_are_counted_from_their_origin_and_none_is_the_null() -> None:
    high, low = (parameters(axis.EndStop)[name] for name in ("high", "low"))
    sizes = {"span": 2.0, "highest": 1.5, "lowest": -0.5}
    found = list(zip(high.begin(sizes), low.begin(sizes), strict=True))
    assert found[:3] == [(1.494, -1e6), (1e6, -0.494), (1.494, -0.494)]
