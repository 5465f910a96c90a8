"""`rwjax predict`, as a user calls it."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from tests.cli.shell import DEMO, Shell, program


def test_predict_without_outputs_starts_at_rest_at_zero(tmp_path: Path) -> None:
    rows = "\n".join(f"{0.01 * k:.2f},{0.5 if k > 20 else 0}" for k in range(100))
    (tmp_path / "u.csv").write_text(f"time_s,voltage_V\n{rows}\n")
    done = program("predict", str(DEMO / "rig.toml"), "u.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "time_s,yaw_rad,yaw_rad_s"
    assert [float(v) for v in lines[21].split(",")] == [0.2, 0.0, 0.0]
    assert float(lines[-1].split(",")[1]) > 0.0


def test_of_several_logs_the_errors_are_told_and_no_file_is_written(shell: Shell) -> None:
    rows = (DEMO / "triangle.csv").read_text().splitlines(keepends=True)
    (shell.folder / "triangle.csv").write_text("".join(rows[: len(rows) // 3]))
    rig, logs = str(DEMO / "rig.toml"), [str(DEMO / "square.csv"), "triangle.csv"]
    alone = [shell("predict", rig, log)[2] for log in logs]
    code, out, err = shell("predict", rig, *logs)
    assert code == 0, err
    errors = [next(line for line in text.splitlines() if "RMS error" in line).removeprefix("note: ") for text in alone]
    *told, over_all = out.splitlines()
    assert told == [f"{name}.csv: {e}" for name, e in zip(("square", "triangle"), errors, strict=True)]
    number = re.compile(r"RMS error (\S+) rad of a signal of RMS (\S+) rad")
    each = np.array([number.search(line).groups() for line in told], float)
    texts = [(shell.folder / log).read_text() for log in logs]
    samples = [sum(line[0].isdigit() for line in text.splitlines()) for text in texts]
    assert samples[0] > 2 * samples[1] and over_all.startswith("all samples together: yaw_rad: ")
    together = np.sqrt(np.average(each**2, axis=0, weights=samples))
    assert np.array(number.search(over_all).groups(), float) == pytest.approx(together, rel=1e-3)
    kept = shell("predict", rig, *logs, str(DEMO / "mixed.csv"))[1].splitlines()
    assert kept[:2] == told and kept[2].startswith("mixed.csv (kept for validation): yaw_rad: ")
    assert kept[4] == kept[2].replace("mixed.csv (kept for validation)", "those kept for validation together")
    code, _, err = shell("predict", rig, *logs, "-o", "both.csv")
    assert code == 2 and "-o and --json are for one log" in err
    assert not (shell.folder / "both.csv").exists()


def test_all_of_several_logs_are_followed_in_segments_where_one_has_to_be(shell: Shell) -> None:
    gravity = "viscous = 0.01\n[axis.gravity]\ntorque = 1.5\n"
    text = (DEMO / "rig.toml").read_text()
    (shell.folder / "rig.toml").write_text(re.sub("viscous = .*\n", gravity, text))
    for name, angle in (("hangs", 0.0), ("stands", math.pi)):
        rows = "\n".join(f"{0.01 * k:.2f},0,{angle}" for k in range(2000))
        (shell.folder / f"{name}.csv").write_text(f"time_s,voltage_V,yaw_rad\n{rows}\n")
    said = [shell("predict", "rig.toml", *logs)[2] for logs in (["hangs.csv"], ["hangs.csv", "stands.csv"])]
    assert ["runs are followed in segments" in err for err in said] == [False, True]


def test_a_log_whose_run_goes_beyond_any_rig_takes_nothing_from_the_others(shell: Shell) -> None:
    rows = "\n".join(f"{0.01 * k:.2f},0,0" for k in range(100))
    (shell.folder / "rest.csv").write_text(f"time_s,voltage_V,yaw_rad\n{rows}\n")
    text = (DEMO / "rig.toml").read_text()
    (shell.folder / "rig.toml").write_text(re.sub("viscous = .*", "viscous = -2.2", text))
    code, out, err = shell("predict", "rig.toml", str(DEMO / "square.csv"), "rest.csv")
    assert out.splitlines()[0] == "rest.csv: yaw_rad: RMS error 0 rad of a signal of RMS 0 rad"
    *_, why, said = err.splitlines()
    assert code == 2 and said.startswith("rwjax: 1 of 2 logs have no prediction")
    assert why.startswith("note: rig.toml: ") and "its free run on square.csv goes beyond" in why
    code, _, err = shell("predict", "rig.toml", "rest.csv", "./rest.csv")
    assert code == 2 and "named 2 times" in err
