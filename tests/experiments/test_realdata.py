"""Measured rigs: what their published analyses found."""

from dataclasses import replace
from pathlib import Path

import pytest

from experiments.dcmotor import run as dcmotor_run
from experiments.emps import run as emps_run
from experiments.realdata import dcmotor, emps
from rwjax import read_log, read_rig
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.fitting.fit import fit


def test_emps_four_terms(realdata: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RWJAX_REALDATA", str(realdata))
    base = read_rig(Path(emps_run.__file__).with_name("rig.toml"))
    log = read_log(emps(tmp_path)[0], base)
    four = replace(
        base,
        numbers=base.numbers | {"axis.friction.coulomb": 10.0},
        effects={"axis.bias_torque": {"T": 0.0}},
        free=(*base.free, "axis.friction.coulomb", "axis.bias_torque.T"),
    )
    found = fit(four, [log]).rig
    assert emps_run.rmse_mm(found, log) < 2.8
    assert found.values["axis.inertia"] == pytest.approx(95.1089, rel=0.05)  # published
    assert found.values["axis.bias_torque.T"] == pytest.approx(3.1648, rel=0.1)


@pytest.mark.slow
def test_dead_zone_or_dry_friction_of_a_geared_motor(
    realdata: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RWJAX_REALDATA", str(realdata))
    base = read_rig(Path(dcmotor_run.__file__).with_name("rig.toml"))
    found = diagnose(base, [read_log(dcmotor(tmp_path), base)])
    assert found.verdict == "ambiguous"
    assert {found.effects, *found.alternatives} >= {("drive.deadzone",), ("wheel.coulomb",)}
    assert "drive.deadzone" in found.next_experiment and "wheel.coulomb" in found.next_experiment
    assert any("no command lies between" in remark and "and 4 V" in remark for remark in found.remarks)
