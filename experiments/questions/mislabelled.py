"""What `rwjax fit` makes of 24 inputs that say other than what they hold.

`python -m experiments.questions.mislabelled` simulates a platform and a wheel to which nothing is missing, turns their logs or rig files
into what a user would give by mistake, and fits each. An answer is

* asked: a question before the fit, which ends with status 2;
* refused: one line that names file, line or key, with status 2;
* right: numbers as from the right input, within 5 %;
* crashed: any other status;
* doubted: other numbers, with a note that the model does not explain the logs;
* absurd: other numbers without a word.
"""

import argparse
import io
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl

from experiments.blind.cases import make_case, write_case
from experiments.speed.table import show

SEEDS = {"platform": 7, "wheel": 11}
WITHIN = 0.05  # of a number from the right input
OUTCOMES = ("asked", "refused", "crashed", "right", "doubted", "absurd")
Files = dict[str, str]  # text by the file's name: rig.toml and logs


@dataclass(frozen=True)
class Mislabelled:
    """An input that says other than what it holds, on one kind of rig."""

    kind: str
    change: Callable[[Files], Files]


def in_logs(change: Callable[[str], str]) -> Callable[[Files], Files]:
    """The same change of every log's text."""
    return lambda files: {name: text if name == "rig.toml" else change(text) for name, text in files.items()}


def in_rig(old: str, new: str) -> Callable[[Files], Files]:
    """The rig file with a pattern replaced."""
    return lambda files: files | {"rig.toml": re.sub(old, new, files["rig.toml"], count=1)}


def column(name: str, change: Callable[[pl.Expr], pl.Expr], called: str | None = None) -> Callable[[Files], Files]:
    """Every log with one column changed, and renamed where it is called otherwise."""

    def changed(text: str) -> str:
        marks = "".join(line for line in text.splitlines(keepends=True) if line.startswith("#"))
        frame = pl.read_csv(io.StringIO(text), comment_prefix="#")
        frame = frame.with_columns(change(pl.col(name).cast(pl.Float64)).alias(name)).rename({name: called or name})
        return marks + frame.write_csv(float_precision=9)

    return in_logs(changed)


def swapped(text: str) -> str:
    """A log with the heads of its last two columns exchanged."""
    head, *rest = text.split("\ntime_s") if text.startswith("#") else ("", text.removeprefix("time_s"))
    first, body = rest[0].split("\n", 1)
    names = first.lstrip(",").split(",")
    names[-1], names[-2] = names[-2], names[-1]
    return (head + "\n" if head else "") + ",".join(["time_s", *names]) + "\n" + body


def wrapped(x: pl.Expr) -> pl.Expr:
    """Counts of an encoder that begins anew after each turn."""
    return x % 2048


INPUTS: dict[str, Mislabelled] = {
    "time in ms": Mislabelled("platform", column("time_s", lambda x: 1000.0 * x)),
    "time in us": Mislabelled("platform", column("time_s", lambda x: 1e6 * x)),
    "time runs backwards": Mislabelled("platform", column("time_s", lambda x: -x)),
    "every time the same": Mislabelled("platform", column("time_s", lambda x: 0.0 * x)),
    "voltage in mV": Mislabelled("platform", column("voltage_V", lambda x: 1000.0 * x)),
    "voltage as PWM of 255": Mislabelled("platform", column("voltage_V", lambda x: (x * 255.0 / 12.0).round())),
    "voltage in percent": Mislabelled("platform", column("voltage_V", lambda x: (x * 100.0 / 12.0).round())),
    "voltage with the other sign": Mislabelled("platform", column("voltage_V", lambda x: -x)),
    "voltage a sample late": Mislabelled("platform", column("voltage_V", lambda x: x.shift(1).fill_null(0.0))),
    "counts as rad": Mislabelled("platform", column("yaw_counts", lambda x: x, "yaw_rad")),
    "degrees as rad": Mislabelled("platform", column("yaw_counts", lambda x: x * 360.0 / 2048.0, "yaw_rad")),
    "counts that begin anew each turn": Mislabelled("platform", column("yaw_counts", wrapped)),
    "counts with the other sign": Mislabelled("platform", column("yaw_counts", lambda x: -x)),
    "counts_per_rev of one edge in four": Mislabelled("platform", in_rig("= 2048", "= 512")),
    "decimal commas": Mislabelled("platform", in_logs(lambda t: t.replace(",", ";").replace(".", ","))),
    "no head": Mislabelled("platform", in_logs(lambda t: t.split("\n", 1)[1])),
    "heads of two columns exchanged": Mislabelled("platform", in_logs(swapped)),
    "a word in a cell": Mislabelled("platform", in_logs(lambda t: t.replace("\n2.500,", "\noff,", 1))),
    "inertia in g cm2": Mislabelled("platform", in_rig(r"inertia = (\d+\.\d+)", r"inertia = \g<1>e7")),
    "gain with the other sign": Mislabelled("platform", in_rig(r"gain = ", "gain = -")),
    "rate in 1/min": Mislabelled("wheel", column("wheel_rad_s", lambda x: x * 30.0 / np.pi)),
    "rate in deg/s": Mislabelled("wheel", column("wheel_rad_s", lambda x: x * 180.0 / np.pi)),
    "current in mA": Mislabelled("wheel", column("current_A", lambda x: 1000.0 * x)),
    "current with the other sign": Mislabelled("wheel", column("current_A", lambda x: -x)),
}


def fitted(files: Files) -> tuple[int, str, str]:
    """Status, stdout and stderr of `rwjax fit --json` on files in a folder of their own."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text)
        logs = [name for name in sorted(files) if name != "rig.toml"]
        command = [sys.executable, "-m", "rwjax", "fit", "rig.toml", *logs, "-o", "fitted.toml", "--json", "--quiet"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def outcome(status: int, out: str, err: str, right: dict[str, float]) -> tuple[str, str]:
    """What became of an input, and what was said of it first."""
    if status:
        said = err.strip().splitlines()[:1]
        kind = "crashed" if status != 2 or not said else "asked" if "`--force` goes on" in err else "refused"
        return kind, "".join(said)
    found = json.loads(out)
    numbers = {name: given["value"] for name, given in found["numbers"].items()}
    if all(abs(numbers[name] - value) <= WITHIN * abs(value) for name, value in right.items()):
        return "right", ""
    notes = [note for note in found["notes"] if "noise" in note or "explain" in note]
    return ("doubted", notes[0]) if notes else ("absurd", "; ".join(f"{k} {v:.3g}" for k, v in numbers.items()))


def given(kind: str) -> Files:
    """The rig file and the logs of a simulated rig to which nothing is missing."""
    with tempfile.TemporaryDirectory() as folder:
        write_case(make_case(kind, "none", SEEDS[kind], 1.0), Path(folder))
        return {p.name: p.read_text() for p in sorted(Path(folder).iterdir()) if p.suffix in (".csv", ".toml")}


def right_numbers(files: Files) -> dict[str, float]:
    """What the right input gives [SI]."""
    return {name: one["value"] for name, one in json.loads(fitted(files)[1])["numbers"].items()}


def main() -> None:
    """Command line."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    rigs = {kind: given(kind) for kind in SEEDS}
    right = {kind: right_numbers(files) for kind, files in rigs.items()}
    rows = []
    for what, one in INPUTS.items():
        rows.append([one.kind, what, *outcome(*fitted(one.change(rigs[one.kind])), right[one.kind])])
    counts = ", ".join(f"{sum(r[2] == c for r in rows)} {c}" for c in OUTCOMES)
    show(counts, ["rig", "input", "outcome", "said"], rows)


if __name__ == "__main__":
    main()
