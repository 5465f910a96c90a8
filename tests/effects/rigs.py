"""Rigs, commands and runs on which the effects are tried."""

import jax.numpy as jnp
import numpy as np

from rwjax.effects.effect import Motion
from rwjax.effects.library import BY_NAME, EFFECTS
from rwjax.effects.ports import AxisElastic, Coupling
from rwjax.plant.from_rig import structure_of
from rwjax.rig.model import Rig
from tests.systems import platform, reaction, record, run
from tests.systems import wheel as wheel_rig

TIME = np.arange(1001) * 0.01
REST = np.zeros_like(TIME)
FREE = platform("viscous = 0.0\ncoulomb = 0.0")  # 0.1 kg m2, 0.4 N m/V
DRY = platform("viscous = 0.0\ncoulomb = 0.05")
RIGS = {"wheel": wheel_rig(), "platform": platform(), "reaction": reaction("viscous = 0.003\ncoulomb = 0.002")}
LACKS = {"wheel": ("axis.",), "platform": ("wheel.", "motor."), "reaction": ()}
ALONE = [
    effect for effect in EFFECTS if issubclass(effect, AxisElastic | Coupling)
]  # no two of a port, none at its null
HERE = [effect for effect in EFFECTS if not effect.needs_servo]  # none of these rigs has a servo
TOGETHER = {
    kind: [e.name for e in HERE if e not in ALONE and not e.name.startswith(lacks)] for kind, lacks in LACKS.items()
}
KIND = {"axis": "platform", "wheel": "wheel", "motor": "wheel", "drive": "wheel", "sensor": "platform"}


def among(effect: str | None, kind: str) -> tuple[str, ...]:
    """Effects of the program in which an effect is tested: all that can stand side by side, or it alone."""
    return (effect,) if effect and BY_NAME[effect] in ALONE else tuple(TOGETHER[kind])


def go(rig: Rig, u: np.ndarray, start: dict[str, float], effects: dict[str, dict[str, float]]) -> dict[str, np.ndarray]:
    """Free run over `TIME` with effects, one program for all that can stand side by side."""
    alone = next((name for name in effects if BY_NAME[name] in ALONE), None)
    outputs = dict.fromkeys(structure_of(rig).outputs, np.zeros_like(u))
    return run(rig, record(TIME, u, outputs), start, effects={name: {} for name in among(alone, rig.kind)} | effects)


def motion(w: float = 0.0, Omega: float = 0.0) -> Motion:
    zero = jnp.zeros(())
    return Motion(
        t=zero,
        V=zero,
        psi=zero,
        w=jnp.asarray(w),
        theta=zero,
        Omega=jnp.asarray(Omega),
        i=zero,
        drawn=zero,
        load=zero,
        sensed=zero,
        own={},
    )
