"""The plan of a fleet: patterns, tables, and what is wrong with either."""

import os
import re
from pathlib import Path

import pytest

from rwjax.errors import InputError
from rwjax.fleet.plan import Job, read_plan


def laid(folder: Path, *paths: str) -> None:
    """Makes empty files."""
    for path in paths:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text("")


def plan_of(folder: Path, text: str) -> Path:
    """Writes a plan."""
    (folder / "fleet.toml").write_text(text)
    return folder / "fleet.toml"


def test_a_pattern_names_rigs_and_sessions(tmp_path: Path) -> None:
    laid(
        tmp_path,
        "logs/b/2026-02/2.csv",
        "logs/b/2026-02/1.csv",
        "logs/b/2026-01/1.csv",
        "logs/a x/2026-01/1.csv",
        "logs/b/note.txt",
    )
    text = 'command = "fit"\nrig = "rigs/{rig}.toml"\nlogs = "logs/{rig}/{when}/*.csv"\n[options]\nforce = true\nsegments = 2\n'
    found = read_plan(plan_of(tmp_path, text))
    assert (found.command, found.options) == ("fit", {"force": True, "segments": 2})
    assert [(job.rig, job.when, job.rig_file, [Path(log).name for log in job.logs]) for job in found.jobs] == [
        ("a x", "2026-01", str(tmp_path / "rigs/a x.toml"), ["1.csv"]),
        ("b", "2026-01", str(tmp_path / "rigs/b.toml"), ["1.csv"]),
        ("b", "2026-02", str(tmp_path / "rigs/b.toml"), ["1.csv", "2.csv"]),
    ]


def test_rig_files_without_logs_are_named(tmp_path: Path) -> None:
    laid(tmp_path, "rig.r1.toml", "rig.r6.toml", "rig.r8.toml", "logs/r1/1.csv", "logs/r2/1.csv")
    found = read_plan(plan_of(tmp_path, 'command = "check"\nrig = "rig.{rig}.toml"\nlogs = "logs/{rig}/*.csv"\n'))
    assert [job.rig for job in found.jobs] == ["r1", "r2"] and found.unlogged == ("r6", "r8")
    laid(tmp_path, "r1.toml")
    beside = read_plan(plan_of(tmp_path, 'command = "check"\nrig = "{rig}1.toml"\nlogs = "logs/{rig}1/*.csv"\n'))
    assert beside.unlogged == ("rig.r",)
    (tmp_path / "fleet.toml").rename(tmp_path / "fleet1.toml")  # the plan is as the pattern says, and no rig file
    assert read_plan(tmp_path / "fleet1.toml").unlogged == ("rig.r",)


def test_places_may_stand_within_a_name_and_again(tmp_path: Path) -> None:
    laid(tmp_path, "r[1]/r[1]_7.csv", "r[1]/r2_7.csv", "r2/r2_8.csv")
    found = read_plan(plan_of(tmp_path, 'command = "check"\nrig = "rig.toml"\nlogs = "{rig}/{rig}_{when}.csv"\n'))
    assert [(job.rig, job.when) for job in found.jobs] == [("r2", "8"), ("r[1]", "7")]


def test_signs_of_a_pattern_in_the_plans_own_folder_are_none(tmp_path: Path) -> None:
    laid(tmp_path, "f*[1]{rig}/a.csv", "fx1/b.csv")
    found = read_plan(plan_of(tmp_path / "f*[1]{rig}", 'command = "fit"\nrig = "rig.toml"\nlogs = "{rig}.csv"\n'))
    assert [job.rig for job in found.jobs] == ["a"]


def test_a_name_that_is_no_text_is_escaped(tmp_path: Path) -> None:
    with open(os.fsencode(tmp_path) + b"/a\xff.csv", "w"):
        pass
    (job,) = read_plan(plan_of(tmp_path, 'command = "fit"\nrig = "rig.toml"\nlogs = "{rig}.csv"\n')).jobs
    assert job.rig == "a\\udcff" and job.inputs().split(" ")[1]


def test_a_table_names_them_line_by_line(tmp_path: Path) -> None:
    (tmp_path / "fleet.csv").write_text(
        "rig,when,rig_file,log\n7,2026-02,x.toml,b.csv\n7,2026-01,x.toml,a.csv\n7,2026-02,x.toml,a.csv\n"
    )
    found = read_plan(
        plan_of(tmp_path, 'command = "diagnose"\ntable = "fleet.csv"\n[options]\nonly = ["axis.stribeck"]\n')
    )
    at = [str(tmp_path / name) for name in ("a.csv", "b.csv", "x.toml")]
    assert found.jobs == (Job("7", "2026-01", at[2], (at[0],)), Job("7", "2026-02", at[2], (at[1], at[0])))


def test_inputs_tell_a_file_that_has_changed(tmp_path: Path) -> None:
    laid(tmp_path, "x.toml", "a.csv")
    job = Job("x", "", str(tmp_path / "x.toml"), (str(tmp_path / "a.csv"),))
    before = job.inputs()
    os.utime(tmp_path / "a.csv", ns=(0, 1))
    assert job.inputs() != before
    (tmp_path / "a.csv").unlink()
    assert job.inputs().endswith(" ")


RIGHT = 'rig = "rig.toml"\nlogs = "{rig}.csv"\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("command = ", "is no TOML"),
        (RIGHT, '`command` is None; write command = "fit"'),
        ('command = "fitt"\n' + RIGHT, "`command` is 'fitt'; write"),
        ('command = "fit"\ncomand = 1\n' + RIGHT, "unknown key `comand`; the nearest valid one is `command`"),
        ('kind = "wheel"\n[wheel]\ninertia = 1e-4\n', "is a rig file, not a plan; write a plan that names it"),
        ('kind = "wheel"\ncommand = "fit"\n' + RIGHT, "unknown key `kind`; the nearest"),
        ('command = "fit"\nlogs = "{rig}.csv"\n', "`rig` is missing; write rig ="),
        ('command = "fit"\nrig = "rig.toml"\nlogs = "*.csv"\n', '`logs` is "*.csv"; it has to hold {rig}'),
        ('command = "fit"\n' + RIGHT, "no file is as `logs` says"),
        ('command = "fit"\ntable = "no.csv"\n', "no.csv: cannot be read as a table"),
        ('command = "fit"\ntable = "no.csv"\n' + RIGHT, "`table` stands beside `rig` or `logs`"),
        ('command = "check"\n' + RIGHT + "[options]\nforce = true\n", "`check` has no option `force`; it has none"),
        ('command = "fit"\n' + RIGHT + "[options]\nforce = 1\n", "`options.force` is 1; write true or false"),
        ('command = ["fit"]\n' + RIGHT, "`command` is ['fit']; write"),
        (
            'command = "fit"\n' + RIGHT + "[options]\nsegments = nan\n",
            "`options.segments` is nan; write a positive number",
        ),
        ('command = "diagnose"\n' + RIGHT + "[options]\nonly = [2026-01-01]\n", "which is no effect; nearest"),
        (
            'command = "diagnose"\n' + RIGHT + '[options]\nonly = ["axis.strib"]\n',
            "holds 'axis.strib', which is no effect; nearest `axis.stribeck`",
        ),
        ('command = "fit"\noptions = 3\n' + RIGHT, "`options` is not a table"),
        (
            'command = "check"\nshared = ["axis.inertia"]\n' + RIGHT,
            "`check` estimates no numbers that rigs could share",
        ),
        ('command = "fit"\nshared = ["axis.coulomb.M_e"]\n' + RIGHT, "which is no number; nearest `axis.coulomb.M_c`"),
        ('command = "fit"\nrig = "rig.toml"\nlogs = ["a"]\n', "`logs` is ['a']; write one pattern as a text"),
        ('command = "fit"\nshared = "axis.inertia"\n' + RIGHT, "`shared` is 'axis.inertia'; write a list of numbers"),
        (
            'command = "fit"\nshared = ["axis.inertias"]\n' + RIGHT,
            "`shared` holds 'axis.inertias', which is no number; nearest `axis.inertia`",
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=re.escape(said)) as raised:
        read_plan(plan_of(tmp_path, text))
    assert "\n" not in str(raised.value) and "fleet.toml" in str(raised.value)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("rig,log\na,b\n", "has no column `rig_file`"),
        ("rig,rig_file,log\na,,b\n", "fleet.csv:2: a field is empty"),
        ("rig,rig_file,log\n", "has no line"),
        ("rig,rig_file,log\na,x,1\na,y,2\n", "fleet.csv:3: rig `a` has two rig files"),
    ],
)
def test_a_table_that_is_wrong_is_named_with_its_line(table: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "fleet.csv").write_text(table)
    with pytest.raises(InputError, match=re.escape(said)):
        read_plan(plan_of(tmp_path, 'command = "fit"\ntable = "fleet.csv"\n'))
