"""All methods on the same logs."""

import json

import pytest

from rwjax.methods.comparison import METHODS, compare
from rwjax.report.comparison import table, write_figure
from tests.methods.logs import FREE, axis_log
from tests.systems import platform


def test_the_comparison_judges_all_methods_on_the_same_held_out_run(tmp_path) -> None:
    truth = platform(free=FREE)
    logs = [axis_log(truth), axis_log(truth, seed=1, validate=True)]
    found = compare(truth.with_values({"axis.inertia": 0.12}), logs)
    assert [row.method.name for row in found.rows] == [method.name for method in METHODS]
    assert found.held_out == "marked"
    rms = {row.method.name: row.rms.get("yaw_rad") for row in found.rows}
    assert rms["two-stage"] is None  # no coast-down in these logs, and the row says so
    assert "needs a coast-down" in " ".join(found.rows[-1].notes)
    assert rms["end-to-end"] == pytest.approx(3e-4, rel=0.1)  # the noise
    assert rms["end-to-end"] < rms["weak form"] < rms["equation error"]
    assert found.floor["yaw_rad"] == pytest.approx(3e-4, rel=0.1)
    assert json.loads(json.dumps(found.json(), allow_nan=False))["schema"] == "rwjax.comparison/1"
    assert f"{found}\n" == table(found)
    assert all(f" {method.name} " in str(found) for method in METHODS)
    assert write_figure(found, tmp_path / "c.png").stat().st_size > 10_000
