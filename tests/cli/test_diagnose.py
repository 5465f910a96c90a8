"""`rwjax diagnose`, as a user calls it."""

import json
from pathlib import Path

import pytest

from rwjax import read_rig
from tests.cli.shell import DEMO, LOGS, program


def test_diagnose_names_what_the_demo_lacks_and_writes_everything(tmp_path: Path) -> None:
    done = program("diagnose", str(DEMO / "rig.toml"), *LOGS, "-o", "out", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer == json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert (answer["schema"], answer["verdict"], answer["effects"]) == (
        "rwjax.diagnosis/1",
        "effect",
        ["axis.stribeck"],
    )
    assert (answer["where"]["subsystem"], answer["where"]["coordinate"]) == ("axis", "yaw_rate")
    assert answer["held_out"] == "marked"
    assert answer["gap"]["signal"] == "yaw_rad"
    assert answer["gap"]["after"] < answer["gap"]["floor"]  # its own form of friction: nothing is left
    assert sum(r["probability"] for r in answer["ranking"]) == pytest.approx(1.0)
    rig = read_rig(tmp_path / "out" / "corrected.toml")
    corrected = rig.values
    assert corrected["axis.inertia"] == pytest.approx(0.228, rel=1e-3)  # what make_demo.py simulates
    true = {"M_c": 0.45, "M_e": 0.3, "v_s": 0.35, "n": 1.5}
    assert {name: corrected[f"axis.stribeck.{name}"] for name in true} == pytest.approx(true, rel=5e-3)
    assert {*rig.free} == {"axis.inertia", "axis.friction.viscous", *(f"axis.stribeck.{name}" for name in true)}
    told = answer["drift"][-1]["effect_numbers"]
    assert {name: one["value"] for name, one in told.items()} == {
        f"axis.stribeck.{n}": corrected[f"axis.stribeck.{n}"] for n in true
    }
    assert [one["unit"] for one in told.values()] == ["N m", "N m", "rad/s", ""]
    assert all(one["standard_error"] == rig.standard_error[name] for name, one in told.items())
    page = (tmp_path / "out" / "report.html").read_text()
    assert "http" not in page.replace("http://www.w3.org", "").replace("https://www.w3.org", "").replace(
        "http://purl.org", ""
    ).replace("http://creativecommons.org", "").replace("https://matplotlib.org", "")
    assert page.index("The rig lacks Stribeck friction") < page.index("<svg")
