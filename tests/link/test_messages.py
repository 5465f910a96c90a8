"""Messages between host and board: commands as bytes, and what a board says in words."""

import pytest

from rwjax.link import messages
from rwjax.link.frames import Decoder, Frame
from rwjax.link.messages import MESSAGES, Ack, Hello, Sample, command, message, reset_causes
from tests.link.ports import HELLO, SAMPLE


@pytest.mark.parametrize(("cause", "said"), [(1, False), (5, False), (4, True), (8, True), (2, False), (9, True)])
def test_a_slow_supply_at_power_on_is_no_brown_out(cause: int, said: bool) -> None:
    assert messages.unwanted_reset(HELLO._replace(reset_cause=cause)) == said


@pytest.mark.parametrize(("bit", "said"), [*enumerate(("power-on", "the reset line", "a brown-out", "the watchdog"))])
def test_the_bits_of_a_start_are_those_of_the_processor(bit: int, said: str) -> None:
    """PORF, EXTRF, BORF and WDRF of MCUSR (data sheet of the ATmega328P)."""
    assert reset_causes(HELLO._replace(reset_cause=1 << bit)) == said


def test_every_state_and_every_fault_has_a_number_of_its_own() -> None:
    numbers = {name.lower(): getattr(messages, name) for name in ("DISARMED", "ARMING", "ARMED", "FAULT")}
    assert numbers == {name: k for k, name in enumerate(messages.STATES)}
    assert [*messages.FAULTS] == [1 << k for k in range(len({*messages.FAULTS.values()}))]
    assert messages.RESULTS[0] == "done" and messages.RESULTS[messages.NOT_NOW] == "not in this state"


def test_the_causes_of_a_start_are_told_in_words() -> None:
    assert reset_causes(HELLO._replace(reset_cause=9)) == "power-on, the watchdog"
    assert reset_causes(HELLO._replace(reset_cause=0)) == "unknown"


def test_a_command_is_a_frame_of_its_values() -> None:
    (frame,) = Decoder().feed(command(messages.ARM, 513, 0x01020304))
    assert frame == Frame(messages.ARM, 513, bytes([4, 3, 2, 1]))


@pytest.mark.parametrize("said", [HELLO, SAMPLE._replace(count_1=-5, tick=2**32 - 1), Ack(2, messages.PLAY, 5)])
def test_what_a_board_says_is_read_back(said: Hello | Sample | Ack) -> None:
    kind = next(kind for kind, (which, _) in MESSAGES.items() if isinstance(said, which))
    assert message(Frame(kind, 0, MESSAGES[kind][1].pack(*said))) == said


def test_what_this_version_does_not_know_is_none() -> None:
    layout = MESSAGES[0x82][1]
    assert message(Frame(0x84, 0, b"")) is None
    assert message(Frame(0x82, 0, layout.pack(*SAMPLE) + b"1")) is None  # longer than it has to be
    assert message(Frame(0x82, 0, layout.pack(*SAMPLE._replace(state=4)))) is None
    assert message(Frame(0x83, 0, MESSAGES[0x83][1].pack(1, 2, 7))) is None
