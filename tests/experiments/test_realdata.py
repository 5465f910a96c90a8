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
def test_dead_zone_or_dry_friction_leads_on_a_geared_motor_and_neither_is_claimed(
    realdata: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RWJAX_REALDATA", str(realdata))
    base = read_rig(Path(dcmotor_run.__file__).with_name("rig.toml"))
    found = diagnose(base, [read_log(dcmotor(tmp_path), base)])
    gap = found.gaps[found.signal]
    assert gap.after < 0.3 * gap.before and gap.after > 10.0 * gap.floor  # a part stays, and one run tells no agreement
    assert found.verdict == "unknown"
    first, second, third = found.ranking[:3]
    assert {first.effect, second.effect} == {"drive.deadzone", "wheel.coulomb"}
    assert min(first.probability, second.probability) > 0.01 > 1e9 * third.probability
