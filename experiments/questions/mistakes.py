"""Mistakes that logs come with, made on purpose: each turns the logs of a run into what a user would give by mistake."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from rwjax.kinds import is_angle
from rwjax.logs.log import Log

Logs = tuple[Log, ...]


def _in_time(factor: float) -> Callable[[Sequence[Log]], Logs]:
    return lambda logs: tuple(replace(log, time=factor * log.time, origin=factor * log.origin) for log in logs)


def _pulses(logs: Sequence[Log], per_volt: float, neutral: float) -> Logs:
    return tuple(replace(log, command=np.round(neutral + per_volt * log.command)) for log in logs)


def _full(logs: Sequence[Log]) -> float:
    """Supply of a rig [V]: 12 V, or what the logs' command needs."""
    return max(12.0, *(float(np.abs(log.command).max()) for log in logs))


def counts_of_255(logs: Sequence[Log]) -> Logs:
    return _pulses(logs, 255.0 / _full(logs), 0.0)


def percent(logs: Sequence[Log]) -> Logs:
    return _pulses(logs, 100.0 / _full(logs), 0.0)


def microseconds(logs: Sequence[Log]) -> Logs:
    return _pulses(logs, 500.0 / _full(logs), 1500.0)


def other_command(logs: Sequence[Log]) -> Logs:
    """The first log with the command of the second, held at its end; of a single log, its command played backwards."""
    first, *rest = logs
    if not rest:
        return (replace(first, command=first.command[::-1].copy()),)
    times = rest[0].time - rest[0].time[0]
    at = np.searchsorted(times, first.time - first.time[0], side="right") - 1
    return (replace(first, command=rest[0].command[at]), *rest)


def still_reading(logs: Sequence[Log]) -> Logs:
    """Every log with its first output at its first reading throughout."""
    found = []
    for log in logs:
        name, values = next(iter(log.outputs.items()))
        constant = np.full(len(values), values[np.isfinite(values)][0])
        found.append(replace(log, outputs=log.outputs | {name: constant}))
    return tuple(found)


def _times(end: Callable[[str], bool], factor: float) -> Callable[[Sequence[Log]], Logs]:
    def turned(log: Log) -> Log:
        return replace(log, outputs={name: y * (factor if end(name) else 1.0) for name, y in log.outputs.items()})

    return lambda logs: tuple(map(turned, logs))


MISTAKES: dict[str, Callable[[Sequence[Log]], Logs]] = {
    "clock x10": _in_time(10.0),
    "clock /10": _in_time(0.1),
    "PWM of 255": counts_of_255,
    "percent": percent,
    "pulses in us": microseconds,
    "command of another run": other_command,
    "constant reading": still_reading,
    "degrees": _times(is_angle, 180.0 / np.pi),
    "1/min": _times(lambda name: name.endswith("_rad_s"), 30.0 / np.pi),
    "sign": _times(lambda name: name.startswith("yaw") or name.startswith("wheel"), -1.0),
    "mV": lambda logs: tuple(replace(log, command=1000.0 * log.command) for log in logs),
}
"""Mistakes by name."""


def differs(logs: Logs, wrong: Logs) -> bool:
    """Whether a mistake changes any log: some logs hold no reading that it could be made in."""
    return any(
        not np.array_equal(a.time, b.time)
        or not np.array_equal(a.command, b.command)
        or any(not np.array_equal(a.outputs[name], b.outputs[name], equal_nan=True) for name in a.outputs)
        for a, b in zip(logs, wrong, strict=True)
    )
