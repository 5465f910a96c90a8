"""The recorder: what it leaves on disk when all goes well, and when anything does not."""

import errno
import os
import resource
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import serial
from scipy.linalg import expm

from experiments.testbed.campaign import RIG, TRUTH, bench
from experiments.testbed.plant import Testbed
from firmware.simavr.avr import F_CPU, Avr, build
from firmware.simavr.bench import Bench
from firmware.simavr.protocol_simavr import Serial, url
from rwjax.errors import InputError
from rwjax.link import frames, messages, recorder
from rwjax.link.play_experiment import play
from rwjax.link.port import LinkError
from rwjax.link.recorder import Raw, listen, record
from rwjax.link.session import Session
from rwjax.link.stream import stretches
from rwjax.logs.read import read_log
from rwjax.planning.experiment import Experiment
from rwjax.rig.model import Rig
from rwjax.rig.read import read_rig
from tests.boards import need_simavr
from tests.link.ports import HELLO, Scripted, stream, wire
from tests.link.stubborn import Stubborn

SQUARE = Experiment("square", 2.0, 0.0, 1.0, 2.0)


@pytest.fixture(scope="module")
def testbed() -> Bench:
    need_simavr()
    return bench(TRUTH)


def wheel(volts: np.ndarray, late: float) -> np.ndarray:
    """The wheel's angle [rad] at 100 Hz under commands that act `late`: the linear motor, solved exactly."""
    K, R, L, b, J = TRUTH.K, TRUTH.R, TRUTH.L, TRUTH.b, TRUTH.J
    field = np.zeros((4, 4))  # angle, rate, current, voltage
    field[:3] = [[0, 1, 0, 0], [0, -b / J, K / J, 0], [0, -K / L, -R / L, 1 / L]]
    before, after = expm(field * late), expm(field * (0.01 - late))
    state, angles = np.zeros(4), []
    for v in volts:
        angles.append(state[0])
        state = before @ state
        state[3] = v
        state = after @ state
    return np.array(angles)


def test_a_recorded_experiment_is_what_the_motor_did_to_a_count(testbed: Bench, tmp_path: Path) -> None:
    """From the compiled law of the board through pulses, motor, edges, interrupts, frames and disk to the log."""
    rig = read_rig(RIG)
    experiment = Experiment("multisine", 2.2, 0.1, 3.0, 6.0)
    done = record(url(testbed), rig, tmp_path / "run.csv", {"experiment": experiment.words()}, play(experiment, rig))
    assert done.failure is None and done.remarks == [] and done.logs == [tmp_path / "run.csv"]
    log = read_log(done.logs[0], rig)
    assert len(log.time) == 659 and np.ptp(log.command) > 3.5 and (log.command[:60] == 0.0).all()
    assert log.notes["experiment"] == "multisine, 2.2 V about 0.1 V, period 3 s, 6 s" and log.notes["rig"] == "testbed"
    assert len(log.notes["firmware"]) == 8 and "date" in log.notes
    angle = log.outputs["wheel_rad"] - log.outputs["wheel_rad"][0]
    count = 2 * np.pi / 2048
    assert (
        np.abs(angle - wheel(log.command, 0.003)).max() < 1.5 * count
    )  # half a count at either end, and the tick's 6 us


@pytest.mark.slow
def test_two_recordings_of_the_same_board_are_equal_to_the_bit(tmp_path: Path) -> None:
    need_simavr()
    rig = read_rig(RIG)
    for name in ("a", "b"):
        record(url(bench(TRUTH)), rig, tmp_path / f"{name}.csv", {}, play(SQUARE, rig))
    assert (tmp_path / "a.raw").read_bytes() == (tmp_path / "b.raw").read_bytes()
    assert len((tmp_path / "a.raw").read_bytes()) > 10_000


@pytest.mark.slow
def test_a_run_is_whole_though_every_answer_is_lost(
    testbed: Bench, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    whole = messages.message
    monkeypatch.setattr(messages, "message", lambda frame: None if frame.type == 0x83 else whole(frame))
    rig = read_rig(RIG)
    done = record(url(testbed), rig, tmp_path / "run.csv", {"experiment": "square"}, play(SQUARE, rig))
    assert done.failure is None and len(read_log(done.logs[0], rig).time) == 259


@pytest.mark.slow
@pytest.mark.parametrize("kind", [messages.ARM, messages.PLAY, messages.DISARM])
def test_a_command_that_is_lost_is_sent_once_more(
    testbed: Bench, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kind: int
) -> None:
    sent, write = [], Serial.write

    def lossy(port: Serial, data: bytes) -> int:
        kinds = [frame.type for frame in frames.Decoder().feed(data)]
        sent.extend(kinds)
        return len(data) if kinds == [kind] and sent.count(kind) == 1 else write(port, data)

    monkeypatch.setattr(Serial, "write", lossy)
    rig = read_rig(RIG)
    done = record(url(testbed), rig, tmp_path / "run.csv", {"experiment": "square"}, play(SQUARE, rig))
    assert done.failure is None and len(read_log(done.logs[0], rig).time) == 259
    assert sent.count(kind) == (3 if kind == messages.DISARM else 2)  # the last DISARM leaves


def test_a_board_that_is_disarmed_meanwhile_is_said_to_be(testbed: Bench, tmp_path: Path) -> None:
    def meddling(session: Session, sample: messages.Sample) -> None:
        if sample.playing and sample.state == messages.ARMED:
            session.send(messages.DISARM)

    rig = read_rig(RIG)
    done = record(url(testbed), rig, tmp_path / "run.csv", {}, play(SQUARE, rig), meddling)
    assert str(done.failure) == "the board has stopped the experiment: it is disarmed"


def test_a_fault_ends_an_experiment_and_its_log_is_kept(tmp_path: Path) -> None:
    need_simavr()
    rig, on = read_rig(RIG), bench(TRUTH)

    def empty(session: Session, sample: messages.Sample) -> None:
        if sample.playing and sample.tick % 50 == 0:
            on.avr.battery(8_000.0)

    notes = {"experiment": LONG.words()}
    done = record(url(on), rig, tmp_path / "run.csv", notes, play(LONG, rig), empty)
    assert str(done.failure) == "the board has stopped the experiment: battery low"
    played = len(read_log(done.logs[0], rig).time)
    assert read_log(done.logs[0], rig).notes["ended"] == f"early, after {played / 100:g} s of 9.6 s"
    assert 90 < len(read_log(done.logs[0], rig).time) < 160  # half a second of it below 9 V
    on.run(on.avr.cycle + F_CPU // 20)
    assert on.widths == (1500.0, 1500.0)


LONG = Experiment("square", 2.0, 0.0, 1.0, 9.0)


def is_neutral_and_kept(on: Bench, done: recorder.Recorded, folder: Path) -> None:
    """Half a second later the ESCs get neutral pulses, and the log holds what came while the wheel was driven."""
    assert on.widths != (1500.0, 1500.0)  # it was being driven
    on.run(on.avr.cycle + F_CPU // 2)
    assert on.widths == (1500.0, 1500.0)
    assert done.logs == [folder / "run.csv"]
    assert 100 <= len(read_log(done.logs[0], read_rig(RIG)).time) < 200


def playing_for(samples: int):
    """Whether so many samples of a run have come, for `watch` to ask."""
    seen = []

    def enough(sample: messages.Sample) -> bool:
        seen.append(sample)
        return sum(s.playing for s in seen) >= samples

    return enough


def test_a_cable_that_is_pulled_out_while_the_wheel_is_driven_ends_in_neutral(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    need_simavr()
    on, rig, enough = bench(TRUTH), read_rig(RIG), playing_for(120)

    def pulled(*_: object) -> bytes:
        raise serial.SerialException("device reports readiness to read but returned no data")

    def out(session: Session, sample: messages.Sample) -> None:
        if enough(sample):
            monkeypatch.setattr(Serial, "read", pulled)
            monkeypatch.setattr(Serial, "write", pulled)

    done = record(url(on), rig, tmp_path / "run.csv", {"experiment": "square"}, play(LONG, rig), out)
    assert str(done.failure).endswith(": the port is gone; is the cable plugged in?")
    is_neutral_and_kept(on, done, tmp_path)


def test_a_disk_that_is_full_while_the_wheel_is_driven_ends_in_neutral(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    need_simavr()
    on, rig, enough = bench(TRUTH), read_rig(RIG), playing_for(120)

    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    def filled(session: Session, sample: messages.Sample) -> None:
        if enough(sample):
            monkeypatch.setattr(recorder.os, "write", full)

    done = record(url(on), rig, tmp_path / "run.csv", {"experiment": "square"}, play(LONG, rig), filled)
    assert str(done.failure).endswith("run.raw: No space left on device; what came before is kept")
    is_neutral_and_kept(on, done, tmp_path)


def test_a_board_that_resets_while_the_wheel_is_driven_ends_in_neutral(tmp_path: Path) -> None:
    need_simavr()
    on, rig, enough = Bench(Avr(build("hang", "-DHANG_ON_CLEAR")), Testbed(TRUTH)), read_rig(RIG), playing_for(120)

    def hang(session: Session, sample: messages.Sample) -> None:
        if enough(sample):
            session.send(messages.CLEAR)

    done = record(url(on), rig, tmp_path / "run.csv", {"experiment": "square"}, play(LONG, rig), hang)
    assert on.avr.resets == 1 and str(done.failure).endswith("in the middle of the session (cause: the watchdog)")
    on.run(on.avr.cycle + F_CPU // 20)
    assert on.widths == (1500.0, 1500.0)
    assert 100 <= len(read_log(done.logs[0], rig).time) < 200


def test_ctrl_c_disarms_and_keeps_the_log(testbed: Bench, tmp_path: Path) -> None:
    rig, seen = read_rig(RIG), []

    def impatient(session: Session, sample: messages.Sample) -> None:
        seen.append(sample)
        if sample.playing and sum(s.playing for s in seen) == 150:
            raise KeyboardInterrupt

    done = record(url(testbed), rig, tmp_path / "run.csv", {}, play(SQUARE, rig), impatient)
    assert isinstance(done.failure, KeyboardInterrupt)
    assert len(read_log(done.logs[0], rig).time) >= 150
    testbed.run(testbed.avr.cycle + F_CPU // 20)
    assert testbed.widths == (1500.0, 1500.0)


@pytest.mark.parametrize(("end", "cause"), [("unplugged", "device reports readiness"), ("gone", "Input/output error")])
def test_an_unplugged_cable_keeps_what_came(scripted, tmp_path: Path, end: str, cause: str) -> None:
    sent = stream(range(200))
    scripted(Scripted([*sent, wire(HELLO, 0)[:9]], end))
    done = record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(None))
    assert str(done.failure) == "scripted: the port is gone; is the cable plugged in?"
    assert done.failure and cause in str(done.failure.__cause__)
    assert (tmp_path / "run.raw").read_bytes() == b"".join(sent) + wire(HELLO, 0)[:9]
    assert len(read_log(done.logs[0], read_rig(RIG)).time) == 200


def test_whatever_ends_a_recording_comes_after_its_log(scripted, tmp_path: Path) -> None:
    def broken(session: Session, sample: messages.Sample) -> None:
        if sample.tick == 50:
            raise ZeroDivisionError

    scripted(Scripted(stream(range(200))))
    done = record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(None), broken)
    assert isinstance(done.failure, ZeroDivisionError) and done.logs == [tmp_path / "run.csv"]
    assert len(read_log(done.logs[0], read_rig(RIG)).time) == 51


@pytest.mark.parametrize(
    ("port", "said"),
    [
        (Stubborn(samples_every=None), "scripted: the board is silent for 1 s; is it on?"),
        (Stubborn(samples_every=None, acks_every=1), "scripted: the board answers and has sent no sample for 1 s"),
        (Stubborn(samples_every=90), "only 3 of the 100 samples of 1 s have come in more than twice that time"),
    ],
    ids=("greets", "acknowledges", "slow"),
)
def test_a_board_that_sends_no_samples_ends_the_recording(scripted, tmp_path: Path, port: Stubborn, said: str) -> None:
    scripted(port)
    done = record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(1.0))
    assert str(done.failure) == said and done.logs == [] and port.now < 5.0
    assert port.heard[-1][1] == messages.DISARM and (tmp_path / "run.raw").stat().st_size > 0


def test_listening_without_an_end_ends_with_the_samples(scripted, tmp_path: Path) -> None:
    port = scripted(Stubborn(acks_every=7))

    def falls_silent(session: Session, sample: messages.Sample) -> None:
        if sample.tick == 3000:
            port.every["samples"] = None

    done = record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(None), falls_silent)
    assert str(done.failure) == "scripted: the board answers and has sent no sample for 1 s"
    assert len(read_log(done.logs[0], read_rig(RIG)).time) == 3000


def test_a_note_stays_one_note_whatever_it_holds(scripted, tmp_path: Path) -> None:
    scripted(Scripted(stream(range(200))))
    sly = {"why": "because\nrole: validate\nadd axis.inertia: 9", "run\nrole: validate #": "a\u2028role: validate\x85b"}
    rig = replace(read_rig(RIG), name="x\rrole: validate\x1b[2J")
    done = record("port", rig, tmp_path / "run.csv", sly, listen(1.0))
    notes = read_log(done.logs[0], rig)
    assert not notes.validate and not notes.notes.keys() & {"role", "add axis.inertia"}
    lines = (tmp_path / "run.notes").read_text().splitlines()
    assert len(lines) == 4 and lines[0] == r"why: because\nrole: validate\nadd axis.inertia: 9"
    assert lines[3] == r"rig: x\rrole: validate\x1b[2J"


def test_a_board_that_starts_anew_is_not_armed_again(scripted, tmp_path: Path) -> None:
    again = stream(range(50), HELLO._replace(nonce=8, reset_cause=8))
    port = scripted(Scripted([*stream(range(100)), *again]))
    done = record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(None))
    assert str(done.failure).endswith("has started anew in the middle of the session (cause: the watchdog)")
    kinds = [frame.type for frame in frames.Decoder().feed(port.written)]
    assert kinds[-1] == messages.DISARM and messages.ARM not in kinds


def test_where_nothing_came_nothing_stays(scripted, tmp_path: Path) -> None:
    scripted(Scripted([]))
    with pytest.raises(LinkError, match="no board of the testbed answers"):
        record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(1.0))
    assert list(tmp_path.iterdir()) == []


def test_where_a_board_was_never_told_to_play_nothing_stays(scripted, tmp_path: Path) -> None:
    (tmp_path / "other.raw").write_bytes(b"precious")
    scripted(Stubborn("arm"))
    rig = read_rig(RIG)
    with pytest.raises(LinkError, match="the board does not arm"):
        record("port", rig, tmp_path / "run.csv", {"experiment": SQUARE.words()}, play(SQUARE, rig))
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"precious"]


class Damaging(Stubborn):
    """Plays, and nothing that it says from then on arrives whole."""

    def say(self, *said: messages.Message) -> None:
        super().say(*said)
        if self.playing:
            self.pieces[-1] = self.pieces[-1][:-1] + b"\x01\0"


class BrownOut(Stubborn):
    """Starts anew when it is told to play."""

    def obey(self, kind: int) -> None:
        super().obey(kind)
        if kind == messages.PLAY:
            self.playing, self.state = False, messages.DISARMED
            self.say(self.hello._replace(nonce=8, reset_cause=4))


@pytest.mark.parametrize(
    ("port", "said"),
    [
        (Damaging(), "sent no sample for 1 s"),
        (BrownOut(), "started anew in the middle of the session (cause: a brown-out)"),
        (Stubborn("begin"), "the board does not begin the experiment"),
    ],
    ids=("damages", "browns out", "does not begin"),
)
def test_once_a_board_was_told_to_play_every_byte_stays(scripted, tmp_path: Path, port: Stubborn, said: str) -> None:
    scripted(port)
    rig = read_rig(RIG)
    done = record("port", rig, tmp_path / "run.csv", {"experiment": SQUARE.words()}, play(SQUARE, rig))
    assert str(done.failure).endswith(said) and done.logs == []
    assert {path.name for path in tmp_path.iterdir()} == {"run.raw", "run.notes"}
    assert (tmp_path / "run.raw").stat().st_size > 100  # what the board said of itself, and each frame since


def test_what_ends_a_recording_is_told_though_its_stream_is_gone(scripted, tmp_path: Path) -> None:
    rig = read_rig(RIG)

    def broken(session: Session, sample: messages.Sample) -> None:
        if sample.playing:
            (tmp_path / "run.raw").unlink()
            raise ZeroDivisionError

    scripted(Stubborn())
    done = record("port", rig, tmp_path / "run.csv", {"experiment": SQUARE.words()}, play(SQUARE, rig), broken)
    assert isinstance(done.failure, ZeroDivisionError) and "run.raw: cannot be read" in done.remarks[0]


def test_what_was_played_stays_though_it_is_too_short_for_a_log(scripted, tmp_path: Path) -> None:
    port, rig = scripted(Stubborn()), read_rig(RIG)

    def faulty(session: Session, sample: messages.Sample) -> None:
        if sample.playing:
            port.state = messages.FAULT

    done = record("port", rig, tmp_path / "run.csv", {"experiment": SQUARE.words()}, play(SQUARE, rig), faulty)
    assert str(done.failure).startswith("the board has stopped the experiment") and done.logs == []
    assert {path.name for path in tmp_path.iterdir()} == {"run.raw", "run.notes"}


@pytest.mark.parametrize("name", ("run.raw", "run.notes", "run.csv", "run-1.csv"))
def test_a_recording_never_replaces_another(scripted, tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"precious")
    scripted(Scripted(stream(range(20))))
    with pytest.raises(InputError, match=f"{name}: exists already; a recording never replaces another"):
        record("port", read_rig(RIG), tmp_path / "run.csv", {}, listen(1.0))
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"precious"]


def test_a_board_set_up_for_another_rig_is_refused_before_anything_is_sent(scripted, tmp_path: Path) -> None:
    port = scripted(Scripted(stream(range(200), HELLO._replace(pulse_neutral=2000))))
    said = r"testbed: `neutral_us` is 1500, and the board's neutral pulse lasts 1000 us; correct the rig file or"
    with pytest.raises(InputError, match=said):
        record("port", read_rig(RIG), tmp_path / "run.csv", {}, play(SQUARE, read_rig(RIG)))
    kinds = {frame.type for frame in frames.Decoder().feed(port.written)}
    assert kinds == {messages.ASK, messages.DISARM} and list(tmp_path.iterdir()) == []


def test_bytes_are_handed_over_before_the_next_read(tmp_path: Path) -> None:
    """The thesis's listing closes its log file before the first line is written."""
    raw = Raw(tmp_path / "run.raw")
    for k, piece in enumerate(stream(range(20))):
        raw.write(piece)
        assert (tmp_path / "run.raw").read_bytes().count(b"\0") == k + 1
    raw.close()


def test_a_full_disk_ends_the_recording_and_keeps_what_fitted(tmp_path: Path) -> None:
    """A limit on the size of files stands for the disk."""
    code = f"""
import pathlib, resource, signal
from rwjax.link import recorder
from rwjax.rig.model import Rig
from rwjax.rig.read import read_rig
from tests.link.ports import Scripted, stream
port = Scripted(stream(range(400)))
recorder.open_port = lambda _: port
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))
done = recorder.record("port", read_rig({str(RIG)!r}), pathlib.Path({str(tmp_path)!r}) / "run.csv", {{}}, recorder.listen(None))
print(done.failure, "|", len(port.pieces) > 0, "|", len(done.logs))
"""
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY and signal.SIGXFSZ
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=_paths())
    assert out.stdout.endswith("File too large; what came before is kept | True | 1\n"), out
    kept = (tmp_path / "run.raw").read_bytes()
    (found,), _ = stretches(kept)
    assert len(kept) == 5000 and len(found.tick) == kept.count(b"\0") - 1
    assert len(read_log(tmp_path / "run.csv", read_rig(RIG)).time) == len(found.tick)


@pytest.mark.slow
def test_killed_recorders_lose_nothing_that_is_whole() -> None:
    out = subprocess.run([sys.executable, "-m", "tests.link.killed", "5"], capture_output=True, text=True, env=_paths())
    assert out.returncode == 0 and out.stdout.startswith("5 recorders killed: "), out


def _paths() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


def test_an_esc_that_by_its_board_turns_one_way_is_not_armed_for_a_reversal(scripted, tmp_path: Path) -> None:
    port, rig = scripted(Scripted(stream(range(200), HELLO._replace(pulse_min=3000)))), read_rig(RIG)
    done = record("port", rig, tmp_path / "run.csv", {}, play(SQUARE, rig))
    assert "2 V about 0 V: the pulses reach 0 to 10 V; this ESC turns one way: add an offset" in str(done.failure)
    assert messages.ARM not in {frame.type for frame in frames.Decoder().feed(port.written)}


def test_the_real_thing_over_a_pseudo_terminal(tmp_path: Path) -> None:
    """The one test with the wall's clock in it: where the machine keeps the host silent for 200 ms the board gives up, rightly, and
    it is tried again."""
    need_simavr()
    rig, tries = read_rig(RIG), iter(range(4))
    done = over_a_pseudo_terminal(rig, tmp_path / f"{next(tries)}.csv")
    while "silence of the host" in str(done.failure) and (k := next(tries, None)):
        done = over_a_pseudo_terminal(rig, tmp_path / f"{k}.csv")
    assert done.failure is None and done.remarks == []
    log = read_log(done.logs[0], rig)
    angle = log.outputs["wheel_rad"] - log.outputs["wheel_rad"][0]
    assert np.abs(angle - wheel(log.command, 0.003)).max() < 1.5 * 2 * np.pi / 2048


def over_a_pseudo_terminal(rig: Rig, path: Path) -> recorder.Recorded:
    serve = subprocess.Popen(
        [sys.executable, "-m", "experiments.testbed.serve"], stdout=subprocess.PIPE, text=True, env=_paths()
    )
    try:
        assert serve.stdout
        port = serve.stdout.readline().strip()
        return record(port, rig, path, {}, play(Experiment("square", 1.0, 0.0, 1.0, 1.0), rig))
    finally:
        serve.kill()
        serve.communicate()
