"""How far other tools' models of a corrected rig are from its logs: `python -m experiments.exports.run`.

Three rigs of the separate simulator lack an effect. Each is diagnosed, and its corrected rig is written as a MuJoCo model. The model is
played under the commands of the held-out log, from the first state that the corrected rig has there. Its python-control plant is driven by
the same commands, with the slope of its friction at the amplitude that the rate has in the log. A line holds the error of the rig as it was, of
the corrected rig, and of both models, each against the log.
"""

import tempfile
from pathlib import Path

import control
import numpy as np

from experiments.exports.played import played
from experiments.speed.diagnosis import CASES, write
from experiments.speed.table import show
from rwjax import read_logs, read_rig
from rwjax.diagnosis.diagnosis import diagnose
from rwjax.export.targets import export, moved_by
from rwjax.fitting.predict import predict
from rwjax.logs.log import Log
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Rig

RIGS = ("platform, Stribeck friction", "reaction, Coulomb friction", "wheel, Coulomb friction")


def rms(error: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(error**2)))


def of_model(rig: Rig, log: Log, output: str) -> np.ndarray:
    """An output of the rig's MuJoCo model under a log's commands."""
    start = {name: float(values[0]) for name, values in predict(rig, log).columns.items()}
    return played(export(rig, "mjcf").text, log.time, log.command, start)[output]


def of_plant(rig: Rig, log: Log, output: str) -> np.ndarray | None:
    """The angle of the rig's python-control plant under a log's commands; None for a wheel alone, of which there is no such plant."""
    if rig.kind == "wheel":
        return None
    names: dict = {}
    exec(compile(export(rig, "python-control").text, "plant.py", "exec"), names)
    angle = predict(rig, log).columns[output]
    amplitude = float(np.sqrt(2.0) * rms(np.gradient(angle, log.time)))
    driven = control.forced_response(names["plant"](amplitude), log.time - log.time[0], log.command)
    return angle[0] + np.asarray(driven.outputs).ravel()


def main() -> None:
    """Prints the table."""
    rows = []
    for name in RIGS:
        with tempfile.TemporaryDirectory() as folder:
            files = write(CASES[name], Path(folder))
            rig = read_rig(Path(folder) / "rig.toml")
            logs = read_logs([Path(folder) / file for file in files], rig)
            found = diagnose(rig, logs)
        log, corrected = next(log for log in logs if log.validate), found.corrected
        y, unit = log.outputs[found.signal], unit_of(found.signal)
        errors = [y - predict(found.rig, log).columns[found.signal], y - predict(corrected, log).columns[found.signal]]
        errors.append(y - of_model(corrected, log, found.signal))
        plant = of_plant(corrected, log, found.signal)
        linear = "-" if plant is None else f"{rms(y - plant):.3g} {unit}"
        model = export(corrected, "mjcf")
        left = ", ".join(model.left_out) or "nothing"
        moved = f"{moved_by(corrected, model.held, [log])[found.signal]:.3g} {unit}" if model.left_out else ""
        rows.append(
            [name, " + ".join(found.effects) or "-", *(f"{rms(e):.3g} {unit}" for e in errors), left, moved, linear]
        )
    title = "Error on the held-out log"
    show(
        title,
        [
            "rig and what it lacks",
            "named",
            "as it was",
            "corrected",
            "model in MuJoCo",
            "left out",
            "which moves it by",
            "plant in python-control",
        ],
        rows,
    )


if __name__ == "__main__":
    main()
