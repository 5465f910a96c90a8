"""Colours and axis labels, the same in every figure."""

from rwjax.kinds import half_column

MEASURED, BEFORE, AFTER, FLOOR = "#222222", "#c1440e", "#1b6ca8", "#8a8a8a"
"""Colours of a measurement, of the model before and after effects are added, and of the noise floor."""
AXIS_LABEL = {
    "yaw_rad": "yaw ψ [rad]",
    "yaw_rad_s": "yaw rate ψ' [rad/s]",
    "wheel_rad": "wheel angle θ [rad]",
    "wheel_rad_s": "wheel rate Ω [rad/s]",
    "current_A": "current i [A]",
    "yaw_rate": "yaw rate ψ' [rad/s]",
    "yaw": "yaw ψ, one turn [rad]",
    "wheel_rate": "wheel rate Ω [rad/s]",
    "wheel_angle": "wheel angle θ, one turn [rad]",
    "current": "current i [A]",
    "voltage": "command u [V]",
    "time": "time t [s]",
}
AXIS_LABEL |= {
    "pitch_rad": "pitch θ [rad]",
    "pitch_rad_s": "pitch rate θ' [rad/s]",
    "pitch": "pitch θ [rad]",
    "pitch_rate": "pitch rate θ' [rad/s]",
    **{
        half_column(y, k): f"{k + 1}: {AXIS_LABEL[y]}"
        for y in ("wheel_rad", "wheel_rad_s", "current_A")
        for k in range(2)
    },
}
"""Label of every output by its column of the log, and of every coordinate of a missing torque by its name."""
