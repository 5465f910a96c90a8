"""`rwjax predict`, as a user calls it."""

from pathlib import Path

from tests.cli.shell import DEMO, program


def test_predict_without_outputs_starts_at_rest_at_zero(tmp_path: Path) -> None:
    rows = "\n".join(f"{0.01 * k:.2f},{0.5 if k > 20 else 0}" for k in range(100))
    (tmp_path / "u.csv").write_text(f"time_s,voltage_V\n{rows}\n")
    done = program("predict", str(DEMO / "rig.toml"), "u.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "time_s,yaw_rad,yaw_rad_s"
    assert [float(v) for v in lines[21].split(",")] == [0.2, 0.0, 0.0]
    assert float(lines[-1].split(",")[1]) > 0.0
