"""Plan files: what is written reads back equal, and what cannot be read is one line."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rwjax import InputError
from rwjax.planning.experiment import SHAPES, Experiment
from rwjax.planning.files import NUMBERS, ROLES, Plan, Run, clear_plan, read_plan, replaced, write_next, write_plan

NUMBER = st.floats(-1e3, 1e3)
SECONDS = st.integers(4, 2000).map(lambda ticks: ticks / 100)
EXPERIMENT = st.builds(
    Experiment, st.sampled_from(tuple(SHAPES)), NUMBER, NUMBER, SECONDS, SECONDS, st.sampled_from(tuple(NUMBERS))
)
DIGITS = NUMBER.map(lambda value: float(f"{value:.4g}"))
WORDS = st.text(st.characters(exclude_categories=("C", "Z"), include_characters=" "), max_size=20)
RUN = st.builds(
    Run,
    name=st.text("abcXYZ_-019", min_size=1, max_size=12),
    experiment=EXPERIMENT,
    role=st.sampled_from(ROLES),
    why=WORDS,
    tells_apart=st.lists(WORDS, max_size=3).map(tuple),
    reaches=st.dictionaries(st.sampled_from(("yaw_rad", "wheel_rad_s")), DIGITS),
    angle_range=st.none() | st.tuples(DIGITS, DIGITS),
)
PLAN = st.builds(
    Plan,
    rig=WORDS,
    limits=st.dictionaries(st.sampled_from(("voltage_V", "yaw_rad")), DIGITS),
    runs=st.lists(RUN, min_size=1, max_size=3, unique_by=lambda run: run.name).map(tuple),
)


ONE, OTHER = (Run(name, Experiment("square", 1.0, 0.0, 1.0, 1.0), "train", "", (), {}) for name in ("one", "other"))


@given(plan=PLAN)
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_plan_reads_back_equal(plan: Plan, tmp_path: Path) -> None:
    assert read_plan(write_plan(tmp_path, plan)) == plan == read_plan(tmp_path)
    for run in plan.runs:
        lines = [line for line in (tmp_path / f"{run.name}.csv").read_text().splitlines() if not line.startswith("#")]
        columns = [*run.experiment.command(), *([run.experiment.enabled()] if run.experiment.switches else [])]
        assert lines[0] == f"time_s,{run.experiment.input}" + ",enabled" * run.experiment.switches
        assert np.array_equal(np.array([line.split(",") for line in lines[1:]], float), np.column_stack(columns))


@given(plan=PLAN)
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_plan_as_it_was_written_may_be_replaced_and_one_by_hand_may_not(plan: Plan, tmp_path: Path) -> None:
    path = write_plan(tmp_path, plan)
    assert replaced(tmp_path, plan.rig) is None
    assert replaced(tmp_path, plan.rig + "x") == f"the plan of rig `{plan.rig}` and its runs"
    own = path.read_text()
    path.write_text(own.replace("\n[[runs]]", "\n# mine\n[[runs]]", 1))
    with pytest.raises(InputError, match="is not as `rwjax plan` wrote it, and would be replaced"):
        replaced(tmp_path, plan.rig)
    before = {each.name: each.read_bytes() for each in tmp_path.iterdir()}
    clear_plan(tmp_path)
    assert {each.name: each.read_bytes() for each in tmp_path.iterdir()} == before
    path.write_text(own)
    clear_plan(tmp_path)
    assert replaced(tmp_path, plan.rig) is None


GOOD = """schema = "rwjax.plan/1"
rig = "testbed"
[[runs]]
name = "one"
kind = "square"
amplitude_V = 2.0
period_s = 4.0
length_s = 8.0
"""


def test_a_plan_by_hand_needs_little(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(GOOD)
    (run,) = read_plan(tmp_path).runs
    assert run == Run("one", Experiment("square", 2.0, 0.0, 4.0, 8.0), "train", "", (), {})


def test_the_plan_in_the_documentation_can_be_read(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "docs" / "files.md").read_text()
    example = text.partition("## Plan\n")[2].partition("```toml\n")[2].partition("```")[0]
    (tmp_path / "plan.toml").write_text(example)
    plan = read_plan(tmp_path)
    assert plan.rig == "testbed" and plan.runs[0].experiment == Experiment("triangle", 3.11, 0.0, 16.0, 16.0)


def test_no_run_of_an_earlier_plan_stays_beside_the_next_one(tmp_path: Path) -> None:
    (tmp_path / "notes.csv").write_text("mine")
    write_plan(tmp_path, Plan("rig", {}, (ONE, OTHER)))
    write_plan(tmp_path, Plan("rig", {}, (OTHER,)))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["notes.csv", "other.csv", "plan.toml"]


LOG = "# rig: a\ntime_s,voltage_V,yaw_rad\n0.0,1.0,0.0\n"
ROWS = "0.0,1.0,0.0\n0.01,2.0,0.0\n"
LOGS = {
    "own": LOG.encode(),
    "foreign": b"t;pos1\n0;1\n",
    "bare": b"0.0,1.0\n0.01,2.0\n",
    "empty cells first": f",,\ntime_s,voltage_V,yaw_rad\n{ROWS}".encode(),
    "unnamed readings": f"time_s,voltage_V,\n{ROWS}".encode(),
    "fewer names than columns": f"time_s,voltage_V\n{ROWS}".encode(),
    "voltage measured beside the goal": f"time_s,goal_rad,voltage_V\n{ROWS}".encode(),
    "notes alone": b"# by hand: axis stuck, repeat\n",
    "UTF-16": LOG.encode("utf-16"),
    "nothing": b"",
}


@pytest.mark.parametrize("content", LOGS.values(), ids=LOGS)
@pytest.mark.parametrize("earlier", [(ONE,), (ONE, OTHER)], ids=["of a new run", "of an earlier run"])
def test_what_no_plan_wrote_is_never_replaced(tmp_path: Path, content: bytes, earlier: tuple[Run, ...]) -> None:
    write_plan(tmp_path, Plan("rig", {}, earlier))
    (tmp_path / "other.csv").write_bytes(content)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(InputError) as error:
        write_plan(tmp_path, Plan("rig", {}, (ONE, OTHER)))
    assert str(error.value) == (
        f"{tmp_path / 'other.csv'}: is not the CSV of a run that a plan here wrote, and would be replaced; "
        "write the plan into another folder, or move that file"
    )
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    clear_plan(tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"other.csv": content}


def test_a_plan_that_was_changed_by_hand_stays_with_its_runs(tmp_path: Path) -> None:
    plan = write_plan(tmp_path, Plan("rig", {}, (ONE,)))
    before = (tmp_path / "one.csv").read_bytes()
    for text in (plan.read_text().replace("amplitude_V = 1.0", "amplitude_V = 2.0"), "rig ="):
        plan.write_text(text)
        for run in (ONE, OTHER):
            with pytest.raises(InputError, match=r"plan\.toml: is not as `rwjax plan` wrote it, and would be replaced"):
                write_plan(tmp_path, Plan("rig", {}, (run,)))
        assert plan.read_text() == text and (tmp_path / "one.csv").read_bytes() == before
        assert sorted(path.name for path in tmp_path.iterdir()) == ["one.csv", "plan.toml"]


def test_a_run_whose_lines_end_otherwise_is_still_the_plans(tmp_path: Path) -> None:
    write_plan(tmp_path, Plan("rig", {}, (ONE,)))
    written = (tmp_path / "one.csv").read_bytes()
    (tmp_path / "one.csv").write_bytes(b"\xef\xbb\xbf" + written.replace(b"\n", b"\r\n"))  # an editor's, or git's
    clear_plan(tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_folder_in_the_place_of_a_run_or_of_the_plan_stays(tmp_path: Path) -> None:
    write_plan(tmp_path, Plan("rig", {}, (ONE, OTHER)))
    (tmp_path / "one.csv").unlink()
    (tmp_path / "one.csv").mkdir()
    clear_plan(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["one.csv"]
    (tmp_path / "next").write_text("mine")
    clear_plan(tmp_path / "next")
    assert (tmp_path / "next").read_text() == "mine"


def test_a_switched_run_of_an_earlier_plan_is_replaced(tmp_path: Path) -> None:
    coast = Experiment("coast-down", 1.0, 0.0, 1.0, 2.0, "goal_rad")
    for length in (1.0, 2.0):
        write_plan(tmp_path, Plan("rig", {}, (Run("one", replace(coast, length=length), "train", "", (), {}),)))
    assert (tmp_path / "one.csv").read_text().splitlines()[-1].startswith("2.6,")


@pytest.mark.parametrize("edited", ["schema = 1\n", "rig ="])
def test_an_edited_plan_of_the_next_experiment_stays_and_the_new_one_lies_beside_it(
    tmp_path: Path, edited: str
) -> None:
    own = write_next(tmp_path, Plan("rig", {}, (ONE,)))
    assert own is not None
    own.write_text(edited)
    csv = (tmp_path / "next" / "one.csv").read_bytes()
    for run in (ONE, OTHER):  # the second takes the place of the first
        assert write_next(tmp_path, Plan("rig", {}, (run,))) == tmp_path / "next_2" / "plan.toml"
        assert read_plan(tmp_path / "next_2").runs == (run,)
    assert write_next(tmp_path, None) is None
    assert [path.name for path in tmp_path.iterdir()] == ["next"]
    assert own.read_text() == edited and (tmp_path / "next" / "one.csv").read_bytes() == csv


@pytest.mark.parametrize("log", ["next.csv", "next.raw", "next.notes"])
def test_the_next_experiment_gets_a_name_that_no_log_beside_it_has(tmp_path: Path, log: str) -> None:
    plan = Plan("a", {}, (Run("next", Experiment("square", 2.0, 0.0, 4.0, 8.0), "train", "", (), {}),))
    (tmp_path / "next").mkdir()
    (tmp_path / "next" / log).write_text(LOG)
    for _ in range(2):  # its own CSV of before is no log
        write_next(tmp_path, plan)
        assert [run.name for run in read_plan(tmp_path / "next").runs] == ["next_2"]
    assert {path.name for path in (tmp_path / "next").iterdir()} == {log, "next_2.csv", "plan.toml"}
    assert (tmp_path / "next" / log).read_text() == LOG


def test_runs_beside_logs_get_names_of_their_own_that_are_not_too_long(tmp_path: Path) -> None:
    names = ("a", "a_2", "b" * 100, "b" * 98 + "_2")
    (tmp_path / "next").mkdir()
    for name in ("a", "b" * 100):
        (tmp_path / "next" / f"{name}.csv").write_text(LOG)
    write_next(tmp_path, Plan("a", {}, tuple(replace(ONE, name=name) for name in names)))
    runs = read_plan(tmp_path / "next").runs
    assert [run.name for run in runs] == ["a_3", "a_2", "b" * 98 + "_3", "b" * 98 + "_2"]


def test_the_plan_of_an_earlier_diagnosis_does_not_stay(tmp_path: Path) -> None:
    assert write_next(tmp_path, None) is None and not (tmp_path / "next").exists()
    plan = Plan("a", {}, (Run("next", Experiment("square", 2.0, 0.0, 4.0, 8.0), "train", "", (), {}),))
    written = write_next(tmp_path, plan)
    assert written is not None and written == tmp_path / "next" / "plan.toml" and read_plan(tmp_path / "next") == plan
    assert write_next(tmp_path, None) is None and not written.exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("rwjax.plan/1", "x", 'no `schema = "rwjax.plan/1"`; is this a plan that `rwjax plan` wrote?'),
        ('rig = "testbed"', "", "no `rig`; write rig ="),
        ("= 2.0", "= two", "not valid TOML: "),
        ('"square"', '"chirp"', "run `one`: `kind` is 'chirp'; it has to be one of coast-down, square, triangle,"),
        ('"one"', '"../one"', "run 1: `name` is '../one'; its log gets this name: letters, digits,"),
        ("amplitude_V", "amplitude", "run `one`: unknown key `amplitude`; the nearest valid one is `amplitude_V`"),
        ("amplitude_V = 2.0\n", "", "run `one`: `amplitude_V` is missing; it has to be a finite number"),
        ("= 2.0", "= inf", "run `one`: `amplitude_V` is inf; it has to be a finite number"),
        ("= 4.0", "= 0.01", "run `one`: `period_s` is 0.01; it lies between 0.04 and 3600 s"),
        ("length_s", 'role = "test"\nlength_s', "run `one`: `role` is 'test'; it has to be one of train, validate"),
        (
            "length_s",
            "way_rad = [1.0]\nlength_s",
            "run `one`: `way_rad` is [1.0]; it has to be two numbers, the lowest",
        ),
        ("length_s", "way_rad = [0, inf]\nlength_s", "run `one`: `way_rad` is inf; it has to be a finite number"),
        ("= 8.0", "= 1e307", "run `one`: `length_s` is 1e+307; it lies between 0.04 and 3600 s"),
        ("= 8.0", "= 3601", "run `one`: `length_s` is 3601; it lies between 0.04 and 3600 s"),
        ("= 4.0", f"= 1{400 * '0'}", "run `one`: `period_s` is inf; it has to be a finite number"),
        ("= 2.0", f"= 0x{3900 * 'f'}", "run `one`: `amplitude_V` is inf; it has to be a finite number"),
        ("= 2.0", f"= [0x{3900 * 'f'}]", "run `one`: `amplitude_V` is a number of thousands of digits; it has to be"),
        ("= 2.0", '= "2"', "run `one`: `amplitude_V` is '2'; it has to be a number"),
        ("= 4.0", '= "4"', "run `one`: `period_s` is '4'; it has to be a number"),
        ("= 2.0", "= true", "run `one`: `amplitude_V` is True; it has to be a number"),
        ("= 2.0", "= 1e300", "run `one`: `amplitude_V` is 1e+300; it lies between -1e+06 and 1e+06 V"),
        ("length_s", "offset_V = -1e300\nlength_s", "run `one`: `offset_V` is -1e+300; it lies between"),
        ("length_s", "way_rad = [0, 1e300]\nlength_s", "run `one`: `way_rad` is 1e+300; it lies between -1e+09"),
        ("length_s", "reaches.yaw_rad = 1e300\nlength_s", "run `one`: `reaches.yaw_rad` is 1e+300; it lies between"),
        (
            "[[runs]]",
            "limits.yaw_rad = 1e300\n[[runs]]",
            "limits: `yaw_rad` is 1e+300; it lies between -1e+09 and 1e+09",
        ),
        ("[[runs]]", r'limits."a\nb" = 1' + "\n[[runs]]", r"a name in `limits` holds `\n`, which is not printed;"),
        ('"testbed"', r'"a\u001b[31m"', r"`rig` holds `\x1b`, which is not printed; write it in letters"),
        ("length_s", r'why = "a\nrole: validate"' + "\nlength_s", r"run `one`: `why` holds `\n`, which is not printed"),
        ("length_s", f'why = "{256 * "a"}"\nlength_s', "run `one`: `why` has 256 characters; 255 at most"),
        ("length_s", "why = 3\nlength_s", "run `one`: `why` is 3; it has to be a text in quotes"),
        (
            "length_s",
            r'tells_apart = ["\r"]' + "\nlength_s",
            r"run `one`: a name in `tells_apart` holds `\r`, which is",
        ),
        (
            "length_s",
            r'reaches."\u2028" = 1' + "\nlength_s",
            r"run `one`: a name in `reaches` holds `\u2028`, which is",
        ),
        ('"one"', '".."', "run 1: `name` is '..'; its log gets this name: letters, digits,"),
        ('"one"', f'"{101 * "a"}"', "run 1: `name` is 'aaa"),
        ("[[runs]]", "#" + 4_000 * "x" + "\n[[runs]]", "not valid TOML: 4001 characters on one line, 4000 at most"),
        ("[[runs]]", "[runs]", "holds no runs; write each under a header [[runs]]"),
        ("[[runs]]", GOOD[GOOD.index("[[runs]]") :] + "[[runs]]", "two runs are called `one`; each needs a name"),
    ],
)
def test_a_plan_that_cannot_be_read_is_one_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(GOOD.replace(old, new, 1))
    with pytest.raises(InputError) as error:
        read_plan(path)
    assert str(error.value).startswith(f"{path}: {said}") and "\n" not in str(error.value)
