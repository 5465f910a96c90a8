"""The live view: its numbers, and that it draws."""

from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from rwjax.link import messages
from rwjax.link.monitor import View, table
from rwjax.link.session import Session
from tests.link.ports import RIG, SAMPLE, Scripted, stream, wrapped


def drawn(view: View) -> str:
    console = Console(width=80)
    with console.capture() as capture:
        console.print(table(view))
    return capture.get()


def test_angles_and_rates_are_in_radians_also_through_a_wrap() -> None:
    view, session = View(RIG), Session(Scripted([]))
    assert view.rate("axis") is None and "waiting" in drawn(view)
    for k in range(40):
        moved = {"count_1": wrapped(2**31 - 50 + 4 * k), "count_2": -8 * k}
        view(session, SAMPLE._replace(tick=(2**32 - 20 + k) % 2**32, pulse_1=3150, **moved))
    assert view.rate("axis") == pytest.approx(400 / 2048 * 2 * np.pi)
    assert view.rate("wheel") == pytest.approx(-800 / 1024 * 2 * np.pi)
    assert view.angle("wheel") == pytest.approx(-8 * 39 / 1024 * 2 * np.pi)
    assert view.volts() == pytest.approx(1.5)


def test_it_shows_state_faults_battery_and_losses() -> None:
    view = View(RIG)
    session = Session(Scripted(stream([0, 1, 5])), watch=view)
    session.greet()
    while session.samples()[-1].tick < 5:
        pass
    assert "3 frames here" in drawn(view) and "disarmed" in drawn(view) and "12.00 V" in drawn(view)
    view(session, SAMPLE._replace(state=messages.FAULT, faults=6, missed=17))
    assert "fault: over the speed limit, battery low" in drawn(view) and "17" in drawn(view)


def test_a_rig_may_have_any_name() -> None:
    """`[/]` closes markup that nobody opened, and a terminal obeys what comes after an escape."""
    assert "[/] [red]\\x1b[2J\\n" in drawn(View(replace(RIG, name="[/] [red]\x1b[2J\n")))
