"""Effects that a rig may have beside its base equations; the order of tables, reports and docs."""

from rwjax import setup_jax as setup_jax  # float64 comes before any computation
from rwjax.effects import axis, drive, motor, sensor, two_axis, wheel
from rwjax.effects.parameter import parameters
from rwjax.effects.ports import Effect as Effect
from rwjax.kinds import NUMBERS, SUBSYSTEMS, TWO_AXIS

EFFECTS: tuple[type[Effect], ...] = (
    axis.Viscous,
    axis.Coulomb,
    axis.Stribeck,
    axis.QuadraticDrag,
    axis.AsymmetricFriction,
    axis.Presliding,
    axis.AngleFriction,
    axis.LoadFriction,
    axis.FrictionDrift,
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
ON_TWO_AXES: tuple[type[Effect], ...] = (
    *two_axis.on_each_half(EFFECTS),
    two_axis.Gyroscopic,
    two_axis.Misalignment,
)
"""What a two-axis rig has: the effects above on each of its halves, and what only it can have."""
BY_NAME: dict[str, type[Effect]] = {effect.name: effect for effect in (*EFFECTS, *ON_TWO_AXES)}
"""Every effect that rig files, fits and the diagnosis know, those registered from outside the library last."""


def of_kind(kind: str) -> dict[str, type[Effect]]:
    """The effects that a kind of rig may have, in their order."""
    if kind in TWO_AXIS:
        return {name: e for name, e in BY_NAME.items() if e in ON_TWO_AXES or issubclass(e, two_axis.OF_THE_LOG)}
    return {
        name: e for name, e in BY_NAME.items() if e not in ON_TWO_AXES and kind in SUBSYSTEMS[name.partition(".")[0]]
    }


def plain(number: str) -> float | None:
    """Null of a number of an effect's form, one that a rig file may leave out; None for every other number."""
    effect, _, name = number.rpartition(".")
    found = parameters(BY_NAME[effect])[name] if effect in BY_NAME else None
    return found.null if found is not None and found.optional else None


def unit_of_number(number: str) -> str:
    """SI unit of a number of the rig file or of an effect, "" where it has none."""
    effect, _, name = number.rpartition(".")
    unit = parameters(BY_NAME[effect])[name].unit if effect in BY_NAME else NUMBERS[number].unit
    return "" if unit == "1" else unit


def register(effect: type[Effect]) -> None:
    """Makes an effect from outside the library known. Its programs are compiled anew in every process.

    Raises `ValueError` where its name is taken or begins with no subsystem, or where it lacks a method of its port.
    """
    if BY_NAME.get(effect.name, effect) is not effect:
        raise ValueError(f"an effect `{effect.name}` is there already; give {effect.__name__} another name")
    parts = [part for part, kinds in SUBSYSTEMS.items() if kinds != TWO_AXIS]
    if effect.name.partition(".")[0] not in parts:
        raise ValueError(f"`{effect.name}` has to begin with one of {', '.join(f'`{s}.`' for s in parts)}")
    if missing := sorted(getattr(effect, "__abstractmethods__", ())):
        raise ValueError(f"{effect.__name__} lacks {', '.join(missing)}; an effect defines all methods of its port")
    BY_NAME[effect.name] = effect
