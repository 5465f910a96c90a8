"""Effects that a rig may have beside its base equations; the order of tables, reports and docs."""

from rwjax.effects import axis, drive, motor, sensor, wheel
from rwjax.effects.ports import Effect as Effect

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
BY_NAME = {effect.name: effect for effect in EFFECTS}
