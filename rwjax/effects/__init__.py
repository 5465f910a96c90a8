"""Effects that a rig may have beside its base equations; the order of tables, reports and docs."""

from rwjax.effects import axis, drive, motor, sensor, wheel
from rwjax.effects.ports import Effect as Effect
from rwjax.param import parameters
from rwjax.rig_names import SUBSYSTEMS

EFFECTS: tuple[type[Effect], ...] = (
    axis.Viscous,
    axis.Coulomb,
    axis.Stribeck,
    axis.QuadraticDrag,
    axis.AsymmetricFriction,
    axis.Presliding,
    axis.AngleFriction,
    axis.LoadFriction,
    axis.DryDrift,
    axis.Imbalance,
    axis.Spring,
    axis.BiasTorque,
    axis.Backlash,
    axis.FlexibleCoupling,
    axis.EndStop,
    axis.PeriodicTorque,
    wheel.WheelCoulomb,
    wheel.WheelDrag,
    wheel.Cogging,
    motor.Heating,
    motor.Saturation,
    motor.DriverLimit,
    drive.DeadZone,
    drive.DriveDelay,
    drive.DriveLag,
    drive.RateLimit,
    drive.DriveSaturation,
    drive.DriveBias,
    drive.AsymmetricGain,
    drive.SupplySag,
    drive.Curvature,
    sensor.Scale,
    sensor.Eccentricity,
    sensor.SensorDelay,
    sensor.MissedCounts,
    sensor.LoggerClock,
)
BY_NAME: dict[str, type[Effect]] = {effect.name: effect for effect in EFFECTS}
"""Every effect that rig files, fits and the diagnosis know, those registered from outside the library last."""


def plain(number: str) -> float | None:
    """Null of a number of an effect's form, one that a rig file may leave out; None for every other number."""
    effect, _, name = number.rpartition(".")
    found = parameters(BY_NAME[effect])[name] if effect in BY_NAME else None
    return found.null if found is not None and found.optional else None


def register(effect: type[Effect]) -> None:
    """Makes an effect from outside the library known. Its programs are compiled anew in every process.

    Raises `ValueError` where its name is taken or begins with no subsystem, or where it lacks a method of its port.
    """
    if BY_NAME.get(effect.name, effect) is not effect:
        raise ValueError(f"an effect `{effect.name}` is there already; give {effect.__name__} another name")
    if effect.name.partition(".")[0] not in SUBSYSTEMS:
        raise ValueError(f"`{effect.name}` has to begin with one of {', '.join(f'`{s}.`' for s in SUBSYSTEMS)}")
    if missing := sorted(getattr(effect, "__abstractmethods__", ())):
        raise ValueError(f"{effect.__name__} lacks {', '.join(missing)}; an effect defines all methods of its port")
    BY_NAME[effect.name] = effect
