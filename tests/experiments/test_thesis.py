"""The regenerated logs of the thesis and what they must show."""

from pathlib import Path

import numpy as np

from experiments.thesis import regenerate
from rwjax import read_log, read_rig

DATA = Path(__file__).parents[2] / "data" / "thesis"


def test_the_logs_are_what_the_script_writes(tmp_path: Path) -> None:
    angle = regenerate.coast_down()
    regenerate.write(tmp_path / "coast_down.csv", np.zeros(len(angle)), angle)
    assert (tmp_path / "coast_down.csv").read_text() == (DATA / "coast_down.csv").read_text()
    assert {path.stem for path in DATA.glob("*.csv")} == {"coast_down", *regenerate.commands()}


def test_the_platform_stays_put_below_its_dead_band() -> None:
    dead = regenerate.FRICTION(0.0) / regenerate.GAIN
    assert 4.0 < dead < 4.4
    assert np.all(regenerate.platform(np.full(300, 0.99 * dead)) == 0.0)
    assert regenerate.platform(np.full(300, 1.01 * dead))[-1] > 0.0


def test_the_label_travels_with_every_log() -> None:
    rig = read_rig(DATA / "platform.toml")
    for path in DATA.glob("*.csv"):
        assert "not measured" in read_log(path, rig).notes["note"]
