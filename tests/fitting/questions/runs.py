"""Logs of a platform beside what its rig file's numbers give."""

from dataclasses import replace

import numpy as np

from rwjax.fitting.questions.likeness import Run
from rwjax.logs.log import Log
from tests.systems import platform, record, run

RIG = platform()
TIME = np.arange(1500) * 0.01
SQUARE = np.where(TIME < 0.6, 0.0, 3.0 * np.sign(np.sin(2.0 * TIME)))
CHIRP = np.where(TIME < 0.6, 0.0, 4.0 * np.sin(0.5 * TIME**2 / 2.0))
STEPS = np.where(TIME < 0.6, 0.0, np.random.default_rng(4).choice([-4.0, -2.0, 2.0, 4.0], 30)[(TIME / 0.5).astype(int)])
COMMANDS = {"square.csv": SQUARE, "chirp.csv": CHIRP, "steps.csv": STEPS}


def measured(name: str) -> Log:
    """A log of the platform, by a simulation with other numbers and noise."""
    command = COMMANDS[name]
    truth = platform("viscous = 0.025\ncoulomb = 0.07")
    asked = record(TIME, command, {"yaw_rad": np.zeros(len(TIME)), "yaw_rad_s": np.zeros(len(TIME))})
    found = run(truth, asked, {})
    noise = 1e-3 * np.random.default_rng(len(name)).normal(size=(2, len(TIME)))
    outputs = {output: found[output] + noise[k] for k, output in enumerate(asked.outputs)}
    return replace(record(TIME, command, outputs), name=name)


LOGS = tuple(map(measured, COMMANDS))


def beside(log: Log) -> Run:
    """A log and its free run from rest with the rig file's numbers."""
    return Run(log, run(RIG, log, {}))
