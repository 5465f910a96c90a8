"""`Truth`: every number of a real rig, and the layout of the state that the simulator moves."""

from dataclasses import dataclass, fields

import numpy as np

# What a step of the equations of motion moves …
PSI, W, THETA, OMEGA, AMPERE, HEAT, PSI_DRIVE, W_DRIVE, LOST = range(9)
MOVED = 9
# … and what follows by rules of its own: elastic friction, command, supply, the side on which a gap is closed or an
# end stop touched, oddities outside the list of effects.
ELEMENTS = 4
SHARE = 9  # the first of ELEMENTS
SLEW, LAG_1, LAG_2, LOAD, CONTACT, TOUCH, REST, MEMORY, PLAY, GATE = range(SHARE + ELEMENTS, SHARE + ELEMENTS + 10)
STATES = GATE + 1


@dataclass(frozen=True)
class Truth:
    """Numbers of the real rig in SI. Every effect is off at its default."""

    kind: int = 0  # 0 wheel, 1 platform, 2 reaction
    K: float = 0.0182
    R: float = 0.83
    L: float = 0.0641
    b: float = 4.07e-6
    J: float = 1.24e-4
    gain: float = 0.428
    I: float = 0.228
    viscous: float = 0.0
    coulomb: float = 0.0
    excess: float = 0.0  # breakaway above sliding friction
    v_s: float = 0.1
    form: float = 0.0  # of the fall with speed: 0 exp(-(w/v_s)**exponent), 1 Lorentzian
    exponent: float = 2.0
    gravity: float = 0.0
    gravity_angle: float = 0.0
    # axis
    quadratic: float = 0.0
    quadratic_power: float = 2.0
    asymmetry: float = 0.0
    preslide_form: float = 0.0  # 0 stick and slip, 1 LuGre, 2 Dahl, 3 Maxwell-slip elements
    preslide: float = 0.01  # rad, displacement of the order of which the friction builds up
    preslide_damping: float = 0.0
    angle_friction: float = 0.0
    angle_form: float = 0.0  # 0 sine, 1 raised-cosine spot
    angle_order: float = 1.0
    angle_phase: float = 0.0
    load_friction: float = 0.0
    drift: float = 0.0  # share of the dry friction that is gone when the rig is warm
    drift_viscous: float = 0.0  # the same of the viscous friction
    drift_form: float = 0.0  # 0 exponential, 1 linear
    drift_time: float = 5.0
    imbalance: float = 0.0
    imbalance_phase: float = 0.0
    imbalance_2: float = 0.0
    imbalance_2_phase: float = 0.0
    spring: float = 0.0
    spring_3: float = 0.0
    spring_zero: float = 0.0
    bias_torque: float = 0.0
    coupling: float = 0.0  # 0 rigid, 1 elastic, 2 gap between elastic contacts, 3 gap between hard inelastic ones
    drive_share: float = 0.3  # of the inertia, on the drive's side of the coupling
    stiffness: float = 1.0
    damping: float = 0.0
    gap: float = 0.0  # rad, whole play
    stop_form: float = 0.0  # 0 none, 1 spring and damper, 2 hard
    stop_low: float = -1e9  # rad
    stop_high: float = 1e9
    stop_stiffness: float = 0.0
    stop_damping: float = 0.0
    restitution: float = 0.0
    periodic: float = 0.0
    periodic_rate: float = 1.0  # rad/s
    periodic_phase: float = 0.0
    periodic_2: float = 0.0
    # wheel
    wheel_coulomb: float = 0.0
    wheel_breakaway: float = 0.0  # share by which the wheel's breakaway exceeds its sliding friction
    wheel_drag: float = 0.0
    cogging: float = 0.0
    cogging_order: float = 6.0
    cogging_phase: float = 0.0
    cogging_2: float = 0.0  # second harmonic, share of the first
    # motor
    heat: float = 0.0  # 1/J, relative rise of the resistance for the energy lost in it
    heat_time: float = 30.0
    saturation_current: float = 0.0
    saturation_form: float = 0.0  # of the torque per ampere: 0 1/(1+x²), 1 tanh(x)/x, 2 1/sqrt(1+x²)
    current_limit: float = 0.0
    foldback: float = 0.0  # ohm, 0: hard limit
    # drive
    deadzone: float = 0.0
    deadzone_form: float = 0.0  # 0 hard corner, 1 threshold, 2 soft corner
    bias_command: float = 0.0
    delay: float = 0.0
    lag: float = 0.0
    lag_2: float = 0.0  # share of `lag`: time constant of a second lag in series
    rate_limit: float = 0.0
    saturation: float = 0.0
    drive_saturation_form: float = 0.0  # 0 hard, 1 tanh
    gain_asymmetry: float = 0.0
    sag: float = 0.0  # ohm, or 1/V for a platform
    sag_form: float = 0.0  # 0 in series with the motor (platform: at once), 1 on a bus (platform: with a time constant)
    sag_time: float = 0.5
    curvature: float = 0.0
    curvature_form: float = 0.0  # 0 with |u|, 1 with u², 2 power law
    curvature_volts: float = 1.0  # command at which `curvature` is the relative change of the gain
    # sensor: the axis encoder, or the wheel's where there is no axis
    scale: float = 0.0
    eccentricity: float = 0.0
    eccentricity_phase: float = 0.0
    eccentricity_2: float = 0.0
    sensor_delay: float = 0.0
    missed: float = 0.0
    missed_form: float = 0.0  # 0 a share of the counts above the speed, 1 a share of the speed's excess
    missed_above: float = 0.0
    clock: float = 0.0
    # outside the list of effects
    dwell: float = 0.0  # N m, breakaway that grows with the time at rest
    dwell_time: float = 1.0
    moving_inertia: float = 0.0  # relative rise of the inertia at high speed
    moving_speed: float = 1.0
    hysteresis: float = 0.0
    hysteresis_volts: float = 1.0
    gate_on: float = 0.0
    gate_off: float = 0.0
    bursts: float = 0.0
    loose: float = 0.0  # natural logarithm by which the gain falls while a contact is loose
    memory: float = 0.0
    memory_time: float = 0.5
    memory_speed: float = 1.0
    angle_gain: float = 0.0
    angle_gain_phase: float = 0.0
    roughness: float = 0.0
    jump: float = 0.0
    jump_time: float = 5.0
    salt: float = 0.0  # makes random events differ from log to log
    rumble: float = 0.0  # N m, RMS of the coloured noise of the torque in a run

    def array(self) -> np.void:
        """The numbers as a record, whose fields compiled code reads by name."""
        return np.array([tuple(float(getattr(self, f.name)) for f in fields(self))], RECORD)[0]


RECORD = np.dtype([(f.name, np.float64) for f in fields(Truth)])
