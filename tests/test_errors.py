"""Errors of unusable input, what they show of it, and the nearest valid name."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rwjax
from rwjax.errors import (
    LONGEST_LINE,
    RIGHT,
    InputError,
    LogError,
    RigError,
    alike,
    counted,
    in_two_digits,
    nearest,
    no_name,
    one_line,
    printable,
    refuses_other_types,
)
from rwjax.export.targets import export
from rwjax.rig.model import Rig
from tests.systems import platform, record


@pytest.mark.parametrize("error", [InputError, RigError, LogError])
def test_a_message_stays_on_one_line(error: type[InputError]) -> None:
    assert str(error("a\nb\r\nc")) == r"a\nb\r\nc" and isinstance(error(""), ValueError)


def test_a_message_about_megabytes_is_short_and_soon_there() -> None:
    name = "x\x1b" * 5_000_000
    said = str(InputError(f"unknown key `{name}`; the nearest valid one is `{nearest(name, ['yaw_rad', 'time_s'])}`"))
    assert len(said) < 2000 and "\x1b" not in said
    assert said.startswith("unknown key `x") and "`; the nearest valid one is `" in said


def test_the_nearest_name_is_found_however_unlike() -> None:
    assert nearest("inerta", ["friction", "inertia", "gravity"]) == "inertia"
    assert nearest("x", ["friction"]) == "friction"


@pytest.mark.parametrize(
    ("name", "slip"),
    [("yaw_count", True), ("yaw_counts", True), ("temperature_C", False), ("yaw_m", False), ("", False)],
)
def test_only_what_may_be_a_typing_mistake_is_alike(name: str, slip: bool) -> None:
    assert alike(name, ["time_s", "yaw_counts"]) == slip


def test_a_name_without_end_is_compared_by_its_beginning() -> None:
    assert alike(100 * "x" + 1000 * "y", [100 * "x"]) and nearest(100 * "x" + 1000 * "y", ["y", 100 * "x"]) == 100 * "x"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Küche, 3 µs − ok", "Küche, 3 µs − ok"),
        ("a\nrole: validate", r"a\nrole: validate"),
        ("\x1b[31mred", r"\x1b[31mred"),
        ("abc\u202ecba", r"abc\u202ecba"),
        ("run\udcff.csv", r"run\udcff.csv"),
        ("a\u2028b\x85c", r"a\u2028b\x85c"),
    ],
)
def test_what_is_not_printed_is_escaped_and_the_rest_stays(text: str, shown: str) -> None:
    assert printable(text) == shown


@given(st.text(alphabet=st.characters(), max_size=50))
def test_any_text_is_one_printable_line_that_can_be_encoded(text: str) -> None:
    shown = printable(text)
    assert shown.isprintable() and len(shown.splitlines()) <= 1
    assert shown.encode("utf-8").decode("utf-8") == shown


@given(st.integers(0, 3 * LONGEST_LINE), st.sampled_from("a\x1b\n"))
def test_a_long_line_keeps_its_begin_and_its_end(length: int, letter: str) -> None:
    line = one_line(f"begin{letter * length}end")
    assert len(line) <= LONGEST_LINE + 3 and line.startswith("begin") and line.endswith("end")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("yaw testbed [/] $\\alpha$ é", ""),
        (255 * "x", ""),
        (256 * "x", "has 256 characters; 255 at most"),
        ("a\nrole: validate", r"holds `\n`, which is not printed; write it in letters, digits, signs and blanks"),
        ("\u202ea", r"holds `\u202e`, which is not printed; write it in letters, digits, signs and blanks"),
    ],
)
def test_a_name_is_one_line_of_printed_characters(text: str, why: str) -> None:
    assert no_name(text) == why


def test_one_thing_is_no_several() -> None:
    said = [counted(1, "sample"), counted(3, "sample"), counted(0, "stretch", "es")]
    assert said == ["1 sample", "3 samples", "0 stretches"]


def test_a_large_number_in_two_digits_is_written_out() -> None:
    said = {170.4: "170", 99.9: "100", 1.0449: "1", 0.0123: "0.012", 123456.0: "120000", 4.81e7: "4.8e+07"}
    assert [in_two_digits(value) for value in said] == [*said.values()]


RUN = record(0.01 * np.arange(50), np.zeros(50), {"yaw_rad": np.zeros(50)})
BY_RIG: tuple[Callable[..., Any], ...] = (
    export,
    rwjax.region,
    rwjax.simulate,
    rwjax.sweep,
    rwjax.tune,
    rwjax.write_rig,
)
BY_LOGS: tuple[Callable[..., Any], ...] = (
    rwjax.compare,
    rwjax.diagnose,
    rwjax.fit,
    rwjax.questions,
)


@pytest.mark.parametrize("function", [*BY_RIG, *BY_LOGS, rwjax.predict], ids=lambda function: function.__name__)
def test_what_takes_a_rig_says_of_anything_else_what_it_has_to_be(function: Callable[..., Any]) -> None:
    words = "`; it has to be a rig, as `rwjax.read_rig(path)` returns it"
    for other in ("rig.toml", Path("rig.toml"), RUN, [RUN]):
        with pytest.raises(InputError) as refused:
            function(other)
        assert str(refused.value) == f"{function.__name__}: `rig` is a `{type(other).__name__}{words}"


@pytest.mark.parametrize("function", BY_LOGS, ids=lambda function: function.__name__)
@pytest.mark.parametrize(
    ("logs", "said"),
    [
        (RUN, "is a `Log`"),
        ("run.csv", "is a `str`"),
        (platform(), "is a `Rig`"),
        (["run.csv"], "holds a `str`"),
        (None, "is a `NoneType`"),
    ],
)
def test_what_takes_logs_says_of_anything_else_what_it_has_to_be(
    function: Callable[..., Any], logs: object, said: str
) -> None:
    for arguments, named in (((platform(), logs), {}), ((platform(),), {"logs": logs})):
        with pytest.raises(InputError) as refused:
            function(*arguments, **named)
        assert str(refused.value) == f"{function.__name__}: `logs` {said}; it {RIGHT['Logs']}"


def test_one_log_and_a_solver_are_looked_at_too() -> None:
    with pytest.raises(InputError, match="^predict: `log` is a `list`; it has to be a log, as "):
        rwjax.predict(platform(), [RUN])  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="^fit: `solver` is the class `Smooth`; it has to be a solver, "):
        rwjax.fit(platform(), [RUN], solver=rwjax.Smooth)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("function", [rwjax.read_rig, rwjax.read_diagnosis, rwjax.read_log], ids=lambda f: f.__name__)
@pytest.mark.parametrize("other", [{}, None, 3, b"rig.toml"], ids=lambda other: type(other).__name__)
def test_what_takes_a_path_says_of_anything_else_what_it_has_to_be(function: Callable[..., Any], other: object) -> None:
    more = (platform(),) if function is rwjax.read_log else ()
    with pytest.raises(InputError, match=r"`; it has to be a path, as a text or a `pathlib\.Path`$") as refused:
        function(other, *more)
    assert f" is a `{type(other).__name__}`; " in str(refused.value)


def test_what_is_right_goes_by_the_type_of_an_argument_and_not_by_its_name() -> None:
    @refuses_other_types
    def begun(start: str, path: float) -> str:
        return f"{start} {path}"

    assert begun("w", 2.0) == "w 2.0"
    with pytest.raises(InputError, match="^begun: `start` is a `dict`; it has to be a text$"):
        begun({"w": 2.0}, 1.0)  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("other", [3, [("time_s", np.zeros(2))], None])
def test_what_takes_columns_says_of_anything_else_what_it_has_to_be(other: object, tmp_path: Path) -> None:
    with pytest.raises(InputError) as raised:
        rwjax.write_log(tmp_path / "run.csv", other)  # pyright: ignore[reportArgumentType]
    said = f"write_log: `columns` is a `{type(other).__name__}`; it has to be columns by name, as {{name: array}}"
    assert str(raised.value) == said


def test_what_takes_other_things_by_name_is_not_told_of_columns() -> None:
    @refuses_other_types
    def many(loads: Mapping[str, float]) -> int:
        return len(loads)

    assert many([1.0, 2.0]) == 2  # pyright: ignore[reportArgumentType]


def test_an_array_may_be_whatever_holds_numbers() -> None:
    @refuses_other_types
    def length(time: np.ndarray) -> int:
        return len(time)

    assert length(np.zeros(2)) == length([0.0, 1.0]) == 2  # pyright: ignore[reportArgumentType]
    for other in ("0, 1", 2.0, {0.0: 1.0}):
        with pytest.raises(InputError) as refused:
            length(other)  # pyright: ignore[reportArgumentType]
        assert str(refused.value) == f"length: `time` is a `{type(other).__name__}`; it has to be an array of numbers"


def test_files_and_a_rig_that_have_changed_places_are_told_apart() -> None:
    with pytest.raises(InputError, match="^read_logs: `rig` is a `list`; it has to be a rig, as "):
        rwjax.read_logs(platform(), ["run.csv"])  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="^folds: `logs` is a `Log`; it has to be a list of logs"):
        rwjax.folds(RUN)  # pyright: ignore[reportArgumentType]


def test_a_function_that_looks_at_its_arguments_is_still_itself() -> None:
    @refuses_other_types
    def named(rig: Rig, number: float = 1.0) -> str:
        """Words."""
        return f"{rig.name} {number}"

    assert named(platform(), number=2.0).endswith(" 2.0") and named.__doc__ == "Words."
