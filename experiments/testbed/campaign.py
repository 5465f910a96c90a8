"""A campaign on the simulated testbed: the firmware compiled, its experiments played and recorded over the serial line."""

from pathlib import Path

from experiments.blind.simulator import Truth
from experiments.testbed.plant import Testbed
from firmware.simavr.avr import Avr, build
from firmware.simavr.bench import Bench
from firmware.simavr.protocol_simavr import url
from rwjax.link.play_experiment import play
from rwjax.link.recorder import Recorded, record
from rwjax.link.rest import at_rest
from rwjax.planning.experiment import Experiment
from rwjax.rig.model import Rig
from rwjax.rig.read import read_rig

FOLDER = Path(__file__).resolve().parents[2] / "data" / "testbed"
RIG = FOLDER / "rig.toml"
TRUTH = Truth(kind=2, I=0.0495, viscous=0.0026, coulomb=0.004)
"""The testbed with nothing missing: what `RIG` says."""
PLAN = {
    "square": Experiment("square", 3.0, 0.0, 5.0, 15.0),
    "triangle": Experiment("triangle", 2.5, 0.0, 8.0, 16.0),
    "multisine": Experiment("multisine", 2.5, 0.0, 10.0, 20.0),
    "square_again": Experiment("square", 3.0, 0.0, 5.0, 15.0),
    "coast_down": Experiment("coast-down", 3.0, 0.0, 3.0, 12.0),
    "staircase": Experiment("staircase", 3.0, 0.0, 16.0, 16.0),
    "square_fast": Experiment("square", 2.2, 0.3, 3.0, 12.0),
}
VALIDATE = ("staircase", "square_fast")


def bench(truth: Truth) -> Bench:
    """The board with the testbed hanging on it, just switched on."""
    return Bench(Avr(build()), Testbed(truth))


def campaign(truth: Truth, folder: Path, rig: Rig | None = None) -> list[Path]:
    """The logs of PLAN, played one after the other on one board; the last ones are for validation."""
    rig, port, logs = rig or read_rig(RIG), url(bench(truth)), []
    for name, experiment in PLAN.items():
        notes = {"simulated": "firmware/ in simavr", "experiment": experiment.words()}
        notes |= {"role": "validate"} if name in VALIDATE else {}
        done: Recorded = record(port, rig, folder / f"{name}.csv", notes, play(experiment, rig), ready=at_rest)
        if done.failure:
            raise done.failure
        logs += done.logs
    return logs
