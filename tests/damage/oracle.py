"""What no rig, log or plan can have, and what no result may hold: written down by hand, apart from the limits of the code.

The limits are wide: beyond them a number is nonsense for certain. The code may refuse earlier.
"""

import math
import re
from collections.abc import Iterable, Iterator

import numpy as np

from rwjax import Log, Rig
from rwjax.planning.files import Plan

LARGEST, SMALLEST = 1e15, 1e-15
"""Largest size of a number of a rig, and smallest of one that has to be positive [SI]."""
COUNTS = (1.0, 1e9)
PULSE_US, VOLTS_PER_US = (1.0, 1e6), (1e-9, 1e6)
MOST_VOLTS, MOST_SECONDS, LEAST_SECONDS = 1e6, 1e9, 1e-9
DRIVEN = 11.0
"""Rate [1/s] at which negative viscous friction would speed an axis up that no rig has: by a factor of e in 0.1 s."""
POSITIVE = ("inertia", "torque_constant", "resistance", "stribeck_velocity")
NOT_NEGATIVE = ("inductance", "motor.friction", "motor_1.friction", "motor_2.friction", "coulomb", "static")
PLAIN_NOTES = {"layout", "run", "experiment", "role", "why"}
"""Notes of a run's file: that its columns are rwjax's, and what the plan decides."""


def of_rig(rig: Rig) -> Iterator[str]:
    """What a rig holds that none can have."""
    for name, value in rig.values.items():
        if not math.isfinite(value) or abs(value) > LARGEST:
            yield f"{name} beyond any rig"
        if name.endswith(POSITIVE) and value < SMALLEST:
            yield f"{name} below any rig"
        if name.endswith(NOT_NEGATIVE) and value < 0.0:
            yield f"{name} negative"
    if abs(rig.numbers.get("drive.gain", 1.0)) < SMALLEST:
        yield "drive.gain below any rig"
    for axis in ("axis", "yaw", "pitch"):
        inertia, viscous = (rig.numbers.get(f"{axis}.{n}", d) for n, d in (("inertia", 1.0), ("friction.viscous", 0.0)))
        if viscous < -DRIVEN * inertia:
            yield f"{axis}.friction.viscous drives the axis"
    for who, counts in rig.counts_per_rev.items():
        if not COUNTS[0] <= counts <= COUNTS[1]:
            yield f"counts_per_rev of {who}"
    if rig.pwm is not None and not PULSE_US[0] <= rig.pwm.neutral_us <= PULSE_US[1]:
        yield "neutral_us"
    if rig.pwm is not None and not VOLTS_PER_US[0] <= abs(rig.pwm.volts_per_us) <= VOLTS_PER_US[1]:
        yield "volts_per_us"
    for name, (mean, deviation) in rig.prior.items():
        if not (abs(mean) <= LARGEST and SMALLEST**2 <= deviation <= LARGEST):
            yield f"fit.prior of {name}"
    for name, (low, high) in rig.bounds.items():
        if not low <= rig.values[name] <= high:
            yield f"fit.bounds of {name}"
    for name, error in rig.standard_error.items():
        if not error >= 0.0:
            yield f"fit.standard_error of {name}"


def of_log(log: Log) -> Iterator[str]:
    """What a log holds that none can have."""
    step = np.diff(log.time)
    if not (np.isfinite(log.time).all() and np.max(np.abs(log.time)) <= MOST_SECONDS):
        yield "time_s beyond any run"
    if not (step > 0.0).all() or np.median(step) < LEAST_SECONDS:
        yield "time_s in steps that no logger makes"
    if not (np.isfinite(log.command).all() and np.max(np.abs(log.command)) <= MOST_VOLTS):
        yield "voltage_V beyond any rig"
    if log.supply is not None and not ((log.supply > 0.0) & (log.supply <= MOST_VOLTS)).all():
        yield "supply_V that no rig runs on"
    for name, y in log.outputs.items():
        if np.isinf(y).any() or np.nanmax(np.abs(y), initial=0.0) > LARGEST:
            yield f"{name} beyond any rig"
        if not np.isfinite(y).any():
            yield f"{name} without any reading"
    if any(not math.isfinite(value) for value in log.added.values()):
        yield "added number not finite"


def of_plan(plan: Plan) -> Iterator[str]:
    """What a plan holds that none can have."""
    for run in plan.runs:
        e = run.experiment
        if not abs(e.amplitude) + abs(e.offset) <= MOST_VOLTS:
            yield "volts beyond any rig"
        if not (0.0 < e.period <= MOST_SECONDS and 0.0 < e.length <= MOST_SECONDS):
            yield "seconds beyond any run"
        if not re.fullmatch(r"[\w-]+", run.name):
            yield "a run's name that is no file's"
    for name, value in plan.limits.items():
        if not math.isfinite(value):
            yield f"limit {name!a} not finite"


def of_message(message: str) -> Iterator[str]:
    """What is wrong with the message of a refusal."""
    if len(message.splitlines()) != 1:
        yield "message of several lines"
    elif not message.isprintable():
        yield "message with characters that are not printed"
    if len(message) >= 2000:
        yield "message of 2 kB"
    if re.search(r"\b(Errno|Traceback|object at 0x|Exceeds the limit)\b", message):
        yield "message in the words of Python"


def of_numbers(what: str, values: Iterable[np.ndarray]) -> Iterator[str]:
    """What is wrong with numbers of a result."""
    if not all(np.isfinite(value).all() for value in values):
        yield f"{what} not finite"


def of_words(what: str, text: str) -> Iterator[str]:
    """What is wrong with a result in words; an interval may be open to one side, `to inf`."""
    plain = re.sub(r"\bto inf\b|-inf to ", "", text)
    if re.search(r"(?<![\w.])[-+]?(nan|inf|NaN|Infinity)(?![\w.])", plain):
        yield f"{what} says nan or inf"


def of_run_file(text: str, role: str) -> Iterator[str]:
    """What is wrong with the file of a plan's run: notes beside its own, another role."""
    notes = [line[1:].partition(":") for line in text.splitlines() if line.startswith("#")]
    if {key.strip() for key, _, _ in notes} - PLAIN_NOTES or len(notes) > len(PLAIN_NOTES):
        yield "a note injected"
    if [value.strip() for key, _, value in notes if key.strip() == "role"] != [role]:
        yield "a role injected"
