r"""The sampled loop between a goal and what a drive is given: at every tick it reads the position and sets its output.

At a tick, with the error $e = \mathrm{goal} - \psi$ within its limit,

$u = \mathrm{clip}(k_p e + k_i I + k_d s), \qquad s \leftarrow (T_f s + d - d_{before})/(T_f + T), \qquad I \leftarrow I + T e$

where $d$ is $e$ or $-\psi$. The integral rests while the output is limited and would wind up further. The output goes through the
drive's effects and acts until the next tick. All that the loop remembers, what waits in a delay line included, is part of the
plant's state, so that a window of a fit may begin anywhere.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from rwjax.effects.ports import CommandFilter, GoalDelay
from rwjax.kinds import SERVO
from rwjax.plant.one_axis import OneAxis
from rwjax.plant.structure import State
from rwjax.types import Scalar

OWN = f"{SERVO}:"
"""What the names of a servo's states begin with."""
Memory = dict[str, Scalar]
"""A servo's states, by their names without `OWN`."""


class Tick(NamedTuple):
    """What is known of a step of time before the run; of a whole log with a first axis of steps.

    Attributes:
        ticks: Whether the servo ticks in the step.
        part: Part of the step that has passed at the tick [1].
        goal: What is wanted at the tick [rad].
        supply: Voltage of the supply [V]; 1 where the output is no share of it or the plant knows its voltage.
        share: Share of the step in which the newest outputs act, the last one first `(outputs,)` [1].
        on: Whether torque is on when the step begins.
        powered: Share of the step in which current can flow [1].
    """

    ticks: Bool[Array, "*s"]
    part: Float[Array, "*s"]
    goal: Float[Array, "*s"]
    supply: Float[Array, "*s"]
    share: Float[Array, "*s outputs"]
    on: Bool[Array, "*s"]
    powered: Float[Array, "*s"]


def slope(before: Scalar, last: Scalar, now: Scalar, filter_time: Scalar | float, period: Scalar | float) -> Scalar:
    """Filtered rate of a signal at a sample.

    Args:
        before: The rate at the sample before [rad/s].
        last: The signal at the sample before [rad].
        now: The signal [rad].
        filter_time: Time constant of the filter [s].
        period: Time between samples [s].

    Returns:
        The rate [rad/s].
    """
    return (filter_time * before + now - last) / (filter_time + period)


def integral(before: Scalar, error: Scalar, asked: Scalar, given: Scalar, period: Scalar | float) -> Scalar:
    """Integral of the error after a sample; it rests where the output is limited and would be limited further.

    Args:
        before: The integral before [rad s].
        error: Error at the sample [rad].
        asked: Output that the gains ask for [V, 1, A or N m].
        given: Output that is given [V, 1, A or N m].
        period: Time between samples [s].

    Returns:
        The integral [rad s].
    """
    winds_up = (given != asked) & (jnp.sign(asked) == jnp.sign(error))
    return before + jnp.where(winds_up, 0.0, period * error)


def goal_delay(plant: OneAxis) -> Scalar:
    """Time by which a servo's goal acts late.

    Args:
        plant: A plant with a servo.

    Returns:
        The time [s].
    """
    return sum((effect.delay() for effect in plant.on(GoalDelay)), start=jnp.zeros(()))


def _sign(plant: OneAxis) -> Scalar:
    """Sign of the output with which positive gains restore [1]."""
    if plant.structure.kind == "platform":
        return jnp.sign(plant.numbers["drive.gain"])
    return -jnp.ones(()) if plant.structure.kind == "reaction" else jnp.ones(())


def outputs_at_once(plant: OneAxis) -> int:
    """How many outputs of a servo may act within one step, those that are late included.

    Args:
        plant: A plant with a servo.

    Returns:
        The number [1].
    """
    return 1 + sum(name.startswith(f"{OWN}given:") for name in plant.structure.states)


def acted(plant: OneAxis, t: Scalar, x: State, tick: Tick, h: Scalar) -> tuple[State, Scalar]:
    """What a servo makes act over one step.

    A run begins with an output, and with a past in which the servo gave the same and the axis turned as it does.

    Args:
        plant: A plant with a servo.
        t: Time at which the step begins [s].
        x: State at its beginning.
        tick: What is known of the step.
        h: Length of the step [s].

    Returns:
        The state with the servo's memory as at the step's end, all else as at its beginning, and what acts in the mean over
        the step [V, A or N m].
    """
    states = dict(zip(plant.structure.states, x, strict=True))
    memory = {name.removeprefix(OWN): value for name, value in states.items() if name.startswith(OWN)}
    begun = memory["begun"] > 0.0
    now = tick.ticks | ~begun
    position, rate = plant.servo_reads(t, _moved(plant, x, jnp.where(tick.ticks, tick.part, 0.0) * h))
    T = plant.numbers[f"{SERVO}.period"]
    read, age = _line(memory, "read"), plant.age()
    if age is not None:
        past = [jnp.where(begun, value, position - (k + 1) * T * rate) for k, value in enumerate(read)]
        seen = _shifted(past, position, now)
        memory |= _as_line("read", seen[: len(read)])
        position = _late(seen, age / T)
    memory, output = _output(plant, memory, tick, position, rate)
    held = [jnp.where(begun, value, output) for value in _line(memory, "given")]
    line = _shifted(held, output, now)
    memory |= _as_line("given", line[:-1])
    u = sum((tick.share[k] * value for k, value in enumerate(line)), start=jnp.zeros(()))
    memory, u = _filtered(plant, memory, u, begun, h)
    memory |= {"begun": jnp.ones(()), "acting": u}
    states |= {f"{OWN}{name}": value for name, value in memory.items()}
    return tuple(states.values()), u


def _line(memory: Memory, name: str) -> list[Scalar]:
    """Values of a delay line, the newest first."""
    return [value for key, value in memory.items() if key.startswith(f"{name}:")]


def _as_line(name: str, values: list[Scalar]) -> Memory:
    """A delay line as states."""
    return {f"{name}:{k}": value for k, value in enumerate(values)}


def _shifted(line: list[Scalar], new: Scalar, now: Bool[Array, ""]) -> list[Scalar]:
    """A delay line with a new value before it at a tick; between ticks as it is, its last value twice."""
    return [jnp.where(now, a, b) for a, b in zip([new, *line], [*line, line[-1]], strict=True)]


def _late(line: list[Scalar], age: Scalar) -> Scalar:
    """Value of a line some ticks ago, by parabolas through the ticks on both sides and the one before."""
    whole = jnp.clip(jnp.floor(age), 0.0, len(line) - 3.0)
    part = age - whole
    around = 0.5 * (1.0 - part) * (2.0 - part), part * (2.0 - part), -0.5 * part * (1.0 - part)
    shares = (jnp.where(whole + j == k, share, 0.0) for k in range(len(line)) for j, share in enumerate(around))
    weights = [sum(next(shares) for _ in around) for _ in line]
    return sum((w * value for w, value in zip(weights, line, strict=True)), start=jnp.zeros(()))


def _moved(plant: OneAxis, x: State, after: Scalar) -> State:
    """State in which every angle has gone on at its rate for a time [s]."""
    names, moved = plant.structure.states, list(x)
    rate_of = {"psi": "w", "theta": "Omega"} | {
        name: name.replace(":twist", ":slip") for name in names if ":twist" in name
    }
    for angle, rate in rate_of.items():
        if angle in names:
            moved[names.index(angle)] += after * x[names.index(rate)]
    return tuple(moved)


def _output(plant: OneAxis, memory: Memory, tick: Tick, position: Scalar, rate: Scalar) -> tuple[Memory, Scalar]:
    """What a servo makes the drive give after its tick, and its memory then, the delay line aside.

    Its memory stays as it is between ticks.
    """
    n = {key.removeprefix(f"{SERVO}."): value for key, value in plant.numbers.items()}
    damps_error = plant.structure.servo is not None and plant.structure.servo.damping_on == "error"
    begun = memory["begun"] > 0.0
    now, T = tick.ticks | ~begun, n["period"]
    error = tick.goal - position
    if "error_limit" in n:
        error = jnp.clip(error, -n["error_limit"], n["error_limit"])
    asked = n["kp"] * error
    if "slope" in memory:
        damped = error if damps_error else -position
        last, before = jnp.where(begun, memory["seen"], damped + T * rate), jnp.where(begun, memory["slope"], -rate)
        s = slope(before, last, damped, n.get("derivative_filter", jnp.zeros(())), T)
        asked = asked + n["kd"] * s
        memory = memory | {"seen": jnp.where(now, damped, last), "slope": jnp.where(now, s, before)}
    if "integral" in memory:
        asked = asked + n["ki"] * memory["integral"]
    given = asked
    for limit in [n["limit"]] if "limit" in n else []:
        given = jnp.clip(given, -limit, limit)
    if plant.structure.command == "duty":
        given = jnp.clip(given, -1.0, 1.0)
    if "integral" in memory:
        grown = integral(memory["integral"], error, asked, given, T)
        memory = memory | {"integral": jnp.where(tick.on, jnp.where(now, grown, memory["integral"]), 0.0)}
    given = jnp.where(tick.on, given, 0.0)
    return memory, plant.act(_sign(plant) * tick.supply * given)


def _filtered(plant: OneAxis, memory: Memory, u: Scalar, begun: Bool[Array, ""], h: Scalar) -> tuple[Memory, Scalar]:
    """What lags and rate limits of the drive make of a step's mean output, settled when the run begins."""
    k = 0
    for effect in plant.on(CommandFilter):
        names = [f"filter:{k + j}" for j in range(len(effect.filter_states))]
        k += len(names)
        now, u = effect.over(h)(tuple(jnp.where(begun, memory[name], u) for name in names), u)
        memory = memory | dict(zip(names, now, strict=True))
    return memory, u
