"""Effects that a rig may have beside its base equations; the order of tables, reports and docs."""

from rwjax.effects.axis import AsymmetricFriction, BiasTorque, Coulomb, Stribeck, Viscous
from rwjax.effects.drive import DeadZone, DriveBias, DriveDelay
from rwjax.effects.ports import Effect as Effect
from rwjax.effects.wheel import WheelCoulomb

EFFECTS: tuple[type[Effect], ...] = (
    Viscous,
    Coulomb,
    Stribeck,
    AsymmetricFriction,
    BiasTorque,
    WheelCoulomb,
    DeadZone,
    DriveBias,
    DriveDelay,
)
BY_NAME = {effect.name: effect for effect in EFFECTS}
