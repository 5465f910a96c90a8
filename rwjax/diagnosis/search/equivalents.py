"""Sets of names that are the same thing as a chosen one for a kind of rig, whatever the logs."""

from collections.abc import Sequence

import numpy as np

from rwjax.diagnosis.hypothesis import Hypothesis, beside, brings_level, models_dry, on_one_axis
from rwjax.diagnosis.model_fits import ModelFits
from rwjax.kinds import HALVES, on_half
from rwjax.rig.model import Rig


def equivalents(fits: ModelFits, candidates: Sequence[str], best: Hypothesis) -> list[Hypothesis]:
    """Sets that are the same thing as `best` for this kind of rig, whatever the logs."""
    platform, names = fits.rig.kind == "platform", {*best.names, *fits.rig.effects}
    groups = [["axis.asymmetric_friction", "axis.bias_torque"]]
    if fits.rig.kind == "two_axis":
        groups = [[on_half(name, k) for name in group] for group in groups for k in range(len(HALVES))]
    if platform and "drive.deadzone" not in names:
        groups[0].append("drive.bias")
    if platform:
        groups.append(["drive.delay", "sensor.delay"])
        if _falls(fits, best):
            groups.append(["drive.curvature", "drive.supply_sag"])
    for number in (n for n in best.numbers if on_one_axis(n) == "motor.resistance"):
        if fits.known(best).numbers()[number] > fits.rig.numbers[number]:  # a source's lies in series
            groups.append([f"parameter.{number}", beside(number, "drive.supply_sag")])
    found = []
    for group in groups:
        same = [name for name in group if name in candidates]
        members = [name for name in best.names if name in same]
        if len(members) == 1:
            found += [e for name in same if (e := _instead(fits.rig, best, members[0], name)) not in (best, None)]
    return found


def _falls(fits: ModelFits, best: Hypothesis) -> bool:
    """Whether a curved drive's gain falls with the command's size, most of all where that is large, as that of a sagging
    supply does: where no current is known, the command alone says how much it is loaded."""
    if "drive.curvature" not in best.names:
        return True
    c, p, u_1 = (fits.known(best).numbers()[f"drive.curvature.{name}"] for name in ("c", "p", "u_1"))
    bend = np.log1p(abs(c) * u_1) - np.log1p(0.5 * abs(c) * u_1)  # from half the largest command to all of it
    return bool(c < 0.0 and bend > abs(p) * np.log(2.0))


def _instead(rig: Rig, best: Hypothesis, member: str, name: str) -> Hypothesis | None:
    """`best` with a name in the place of a member; None where without dry friction the one is not the other."""
    other, level = best.without(member).plus(name), beside(member, "axis.coulomb")
    if models_dry(rig, member):
        return other
    if brings_level(member):
        return other if brings_level(name) else other.plus(level)
    if brings_level(name):
        return other.without(level) if level in best.names else None
    return other
