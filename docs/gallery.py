"""The gallery of effects, `python docs/gallery.py`: equation, signature, what it was taken for, and the run that shows it.

The signature is what a user sees: a run of a rig with the effect, of the first size at which a search looks for it, and the best fit of the
same rig without it.
"""

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

import rwjax
from rwjax.effects.effect import Effect
from rwjax.effects.library import BY_NAME, EFFECTS, included_in, of_kind
from rwjax.effects.parameter import parameters
from rwjax.effects.shown import RUNS
from rwjax.fitting.scales import scales

ROOT = Path(__file__).parents[1]
RIGS = {
    "platform": """
kind = "platform"
drive.gain = 0.4
axis.inertia = 0.2
axis.friction.viscous = 0.08
axis.friction.coulomb = 0.05
fit.free = ["axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"]
""",
    "wheel": """
kind = "wheel"
motor.torque_constant = 0.0182
motor.resistance = 0.83
motor.friction = 4e-6
wheel.inertia = 1.24e-4
fit.free = ["motor.torque_constant", "motor.friction", "wheel.inertia"]
""",
    "joint": """
kind = "joint"
motor.torque_constant = 0.5
motor.resistance = 2.0
axis.inertia = 0.02
axis.friction.viscous = 0.03
axis.friction.coulomb = 0.05
axis.gravity.torque = 0.3
drive.servo = { acts_on = "voltage", kp = 24.0, kd = 1.0 }
fit.free = ["axis.inertia", "axis.friction.viscous", "axis.friction.coulomb"]
""",
}
"""A rig of each kind, on the first of which an effect is shown that the kind may have."""
OUTPUT = {"platform": ("yaw_rad", "rad"), "wheel": ("wheel_rad_s", "rad/s"), "joint": ("yaw_rad", "rad")}
STEP, SECONDS, NOISE = 0.01, 24.0, 1e-4  # s, s, share of the largest reading
RESULTS = ("second.jsonl", "final.jsonl")
MOST = 3  # names that an effect was taken for


def command() -> tuple[np.ndarray, np.ndarray]:
    """Time, and squares of two heights after a rest, then a triangle through standstill."""
    t = STEP * np.arange(round(SECONDS / STEP))
    square = np.where(t < 8.0, 3.0, 6.0) * np.sign(np.sin(2.0 * np.pi * t / 4.0))
    triangle = 4.0 * np.abs(2.0 * ((t - 16.0) / 8.0 % 1.0) - 1.0) - 2.0
    return t, np.where(t < 0.6, 0.0, np.where(t < 16.0, square, triangle))


def numbers_of(effect: type[Effect], sizes: Mapping[str, float]) -> dict[str, float]:
    """Its numbers where a search first looks for it; those of its form at their null."""
    return {
        name: (p.begin(sizes)[0] if p.starts and not p.optional else p.null) for name, p in parameters(effect).items()
    }


def kind_of(effect: type[Effect]) -> str | None:
    """The kind of rig on which it is shown."""
    return next(
        (kind for kind in RIGS if effect.name in of_kind(kind) and effect.needs_servo == (kind == "joint")), None
    )


def without(effect: type[Effect], text: str) -> str:
    """A rig file without the numbers that say what the effect says, or what it includes."""
    included = included_in(effect.name)
    said = {*effect.modelled_by, *(BY_NAME[included].modelled_by if included else ())}
    kept = [line for line in text.splitlines() if line.partition(" = ")[0] not in said]
    for name in said:
        kept = [line.replace(f', "{name}"', "") for line in kept]
    return "\n".join([*kept, ""])


def draw(effect: type[Effect], kind: str, path: Path) -> dict[str, float]:
    """Draws the signature of an effect; the numbers that it has there."""
    text, (t, u) = without(effect, RIGS[kind]), command()
    rig = rwjax.parse_rig(text)
    column = "goal_rad" if kind == "joint" else "voltage_V"
    u = 0.2 * u if kind == "joint" else u
    output, unit = OUTPUT[kind]
    plain = np.asarray(rwjax.simulate(rig, t, {column: u})[output])
    sizes = scales(rig, [rwjax.Log.from_arrays(rig, time=t, **{column: u, output: plain})])
    given = numbers_of(effect, sizes)
    with_it = rwjax.parse_rig(
        text + f'[effects."{effect.name}"]\n' + "".join(f"{k} = {v!r}\n" for k, v in given.items())
    )
    measured = np.asarray(rwjax.simulate(with_it, t, {column: u})[output])
    measured = measured + NOISE * np.max(np.abs(measured)) * np.random.default_rng(1).standard_normal(len(t))
    log = rwjax.Log.from_arrays(rig, time=t, **{column: u, output: measured})
    fitted = np.asarray(rwjax.predict(rwjax.fit(rig, [log]).rig, log)[output])
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 2.6), layout="constrained")
    left.plot(t, measured, "k", label="measured")
    left.plot(t, fitted, "C1", label="best fit without it")
    left.set(xlabel="time [s]", ylabel=f"{output.rpartition('_rad')[0]} [{unit}]")
    left.legend(frameon=False)
    right.plot(t, measured - fitted, "C3")
    right.set(xlabel="time [s]", ylabel=f"error [{unit}]")
    figure.savefig(path)
    plt.close(figure)
    return given


def taken_for() -> dict[str, Counter[str]]:
    """How often each cause of the blind cases was named by another name, or beside one."""
    found: dict[str, Counter[str]] = {}
    for name in RESULTS:
        for text in (ROOT / "experiments" / "blind" / "results" / name).read_text().splitlines():
            line = json.loads(text)
            if line["group"] == "single" and line["verdict"] in ("effect", "ambiguous", "partial"):
                said = {other for names in (line["effects"], *line["alternatives"]) for other in names}
                found.setdefault(line["effect"], Counter()).update(said - {line["effect"]})
    return found


def section(effect: type[Effect], folder: Path, others: Counter[str]) -> str:
    """An effect's section of the page."""
    kind = kind_of(effect)
    lines = [
        f"## {effect.label}",
        "",
        f"`{effect.name}`: {effect.meaning or effect.label}.",
        "",
        f"    {effect.equation}",
        "",
    ]
    if kind is not None:
        picture = folder / f"{effect.name}.svg"
        given = draw(effect, kind, picture)
        numbers = ", ".join(
            f"{name} = {value:.3g}" for name, value in given.items() if value != parameters(effect)[name].null
        )
        lines += [f"![{effect.label}: a run with it, and the best fit without]({folder.name}/{picture.name})", ""]
        lines += [f"On a {kind} with {numbers}." if numbers else f"On a {kind}.", ""]
    if others:
        named = ", ".join(f"`{name}` ({count})" for name, count in others.most_common(MOST))
        lines += [f"Of the blind cases with this cause, these were named in its place or beside it: {named}.", ""]
    if effect.shown_by:
        lines += [f"Shown by {'; '.join(RUNS[run] for run in effect.shown_by)}.", ""]
    return "\n".join(lines)


def write(docs: Path) -> None:
    """Writes the page and its pictures into `_generated` of the folder of pages."""
    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "rwjax"
    folder = docs / "_generated"
    (folder / "gallery").mkdir(parents=True, exist_ok=True)
    others = taken_for()
    head = (
        "# Gallery of effects\n\nWhat each effect looks like: a run of a rig that has it, and the best fit of the same rig without it. "
        "The command is squares of two heights, then a triangle through standstill. Every number and unit: [files.md](../files.md#effects).\n\n"
    )
    sections = [section(effect, folder / "gallery", others.get(effect.name, Counter())) for effect in EFFECTS]
    (folder / "gallery.md").write_text(head + "\n".join(sections))


if __name__ == "__main__":
    write(Path(__file__).parent)
