"""Colours and axis labels."""

from matplotlib.colors import is_color_like

from rwjax.diagnosis.words import UNIT
from rwjax.kinds import HALVES, half_column
from rwjax.report.style import AFTER, AXIS_LABEL, BEFORE, FLOOR, MEASURED


def test_every_output_has_a_label_with_its_unit() -> None:
    assert UNIT.keys() <= AXIS_LABEL.keys()
    for name, unit in UNIT.items():
        assert AXIS_LABEL[name].endswith(f"[{unit}]")


def test_the_second_half_of_a_two_axis_rig_is_told_from_the_first() -> None:
    for half in range(len(HALVES)):
        assert AXIS_LABEL[half_column("current_A", half)] == f"{half + 1}: {AXIS_LABEL['current_A']}"


def test_the_colours_differ() -> None:
    colours = {MEASURED, BEFORE, AFTER, FLOOR}
    assert len(colours) == 4 and all(map(is_color_like, colours))
