"""The forms of the experiment: what an Arduino would have printed, and a plain message where the data are absent."""

import numpy as np
import pytest

import rwjax
from experiments.columns.run import ARDUINO, MOTOR, arduino, main


def test_the_arduinos_form_reads_back(tmp_path) -> None:
    t = np.arange(50) * 0.01
    run = {"t": t, "u": np.where(t > 0.1, 6.0, 0.0), "angle": 720.0 * t}
    log = rwjax.read_log(arduino(tmp_path, run), rwjax.parse_rig(MOTOR + ARDUINO))
    assert log.time == pytest.approx(t) and log.command == pytest.approx(run["u"], abs=12.0 / 255.0)
    assert log.outputs["wheel_rad"] == pytest.approx(np.deg2rad(run["angle"]), abs=2.0 * np.pi / 2400.0)


def test_without_the_data_nothing_is_shown(monkeypatch, tmp_path, capsys) -> None:
    monkeypatch.setenv("RWJAX_REALDATA", str(tmp_path / "none"))
    main()
    assert "real data not found" in capsys.readouterr().out
