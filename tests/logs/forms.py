"""The same measurements as files of every form, and the rig whose `[columns]` says what they mean."""

import gzip
import io

import numpy as np
import polars as pl
from scipy.io import savemat

from rwjax.rig.read import parse_rig

RIG = parse_rig("""kind = "platform"
drive.gain = 1
axis.inertia = 1
[columns]
time_s = { column = "ms", unit = "ms" }
voltage_V = { column = "pwm", scale = "12 V / 255" }
yaw_rad = { column = "angle", unit = "deg", sign = -1, offset = 3 }
yaw_rad_s = { column = "rpm", unit = "rpm" }
""")
k = np.arange(50)
MEASURED = {
    "ms": 10 * k,
    "pwm": np.where(k // 10 % 2, 255, -128),
    "angle": np.round(30.0 * np.sin(k / 7.0), 3),
    "rpm": np.round(7.0 * np.cos(k / 7.0), 3),
}
SI = {
    "time_s": k / 100.0,
    "voltage_V": MEASURED["pwm"] * (12.0 / 255.0),
    "yaw_rad": -np.deg2rad(MEASURED["angle"] - 3.0),
    "yaw_rad_s": MEASURED["rpm"] * (np.pi / 30.0),
}
"""What they are in the units of rwjax's columns, by the definitions of the degree and the turn."""


def text(separator: str = ",", decimal: str = ".", quote: str = "", ending: str = "\n") -> str:
    """The measurements as text, beside them a column of words."""
    values = zip(*(v.tolist() for v in MEASURED.values()), strict=True)
    rows = [[*MEASURED, "state"], *([*map(str, row), "on"] for row in values)]
    cells = ([f"{quote}{cell.replace('.', decimal)}{quote}" for cell in row] for row in rows)
    return ending.join([*(separator.join(row) for row in cells), ""])


def _saved(save) -> bytes:
    file = io.BytesIO()
    save(file)
    return file.getvalue()


FORMS = {
    "plain.csv": text().encode(),
    "semicolons.csv": text(";", ",").encode(),
    "tabs.tsv": text("\t", ",").encode(),
    "bars.txt": text("|", ending="\r\n").encode(),
    "quoted.csv": text(",", ",", '"').encode(),
    "mark.csv": b"\xef\xbb\xbf" + text(";", ",").encode(),
    "utf16.csv": text(";", ",").encode("utf-16"),
    "latin.csv": text(";", ",").replace("on", "20 °C").encode("latin-1"),
    "excel.csv": b"sep=;\r\n" + text(";", ",", ending="\r\n").encode(),
    "packed.csv.gz": gzip.compress(text().encode()),
    "run.parquet": _saved(lambda file: pl.DataFrame(MEASURED).write_parquet(file)),
    "run.npz": _saved(lambda file: np.savez(file, **MEASURED)),
    "run.mat": _saved(lambda file: savemat(file, MEASURED)),
    "struct.mat": _saved(lambda file: savemat(file, {"data": MEASURED, "Ts": 0.01})),
}
"""Contents by the names of files."""
