"""The command `init`: a first rig file for logs."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from rwjax.cli.options import RATE, LogFiles, Quiet, check_file, finite, positive
from rwjax.cli.progress import progress
from rwjax.cli.terminal import document, next_command, note, say
from rwjax.errors import InputError


class Kind(StrEnum):
    """Kinds of rig with one command."""

    WHEEL = "wheel"
    PLATFORM = "platform"
    REACTION = "reaction"
    JOINT = "joint"


OfKind = Annotated[Kind | None, typer.Option("--kind", help="kind of the rig; by the columns without it")]
Output = Annotated[Path | None, typer.Option("-o", metavar="RIG.toml", help="stdout without it")]
Supply = Annotated[
    float | None, typer.Option(help="voltage at which the datasheet's numbers hold; of a PWM at full power [V]")
]
StallTorque = Annotated[float | None, typer.Option(help="at standstill, behind the gear [N m]")]
NoLoadSpeed = Annotated[float | None, typer.Option(help="speed without a load, behind the gear [1/min]")]
Resistance = Annotated[float | None, typer.Option(help="of the winding [ohm]")]
Mass = Annotated[float | None, typer.Option(help="of what the axis carries, a rod or with --bob a bob [kg]")]
Length = Annotated[float | None, typer.Option(help="of that rod, or of the arm of that bob, from the axis [m]")]
Bob = Annotated[
    bool,
    typer.Option(
        "--bob",
        help="the mass sits at the end of --length: inertia m l2, gravity m g l; of a rod, taken without it, a third and half of that",
    ),
]
FromMjcf = Annotated[
    Path | None, typer.Option("--from-mjcf", metavar="MODEL.xml", help="numbers of one hinge of a MuJoCo model")
]
Joint = Annotated[
    str | None, typer.Option("--joint", metavar="NAME", help="that hinge; the one with an actuator without it")
]
TorqueConstant = Annotated[float | None, typer.Option(help="of the motor, behind the gear [N m/A]")]
WheelInertia = Annotated[float | None, typer.Option(help="of wheel and rotor [kg m2]; free where it is not given")]
AxisInertia = Annotated[float | None, typer.Option(help="of what the axis carries [kg m2]; free where it is not given")]
Gain = Annotated[
    float | None,
    typer.Option(help="of a platform's drive: torque per volt [N m/V]; its stall torque over --supply, too"),
]
Kp = Annotated[
    float | None, typer.Option("--kp", help="of the servo's loop [V/rad], or per rad in what `acts_on` says of it")
]
Kd = Annotated[
    float | None, typer.Option("--kd", help="rate gain of that loop [V s/rad], or in what `acts_on` says; 0: none")
]
Counts = Annotated[float | None, typer.Option(help="counted edges per turn of the encoder")]


def init(
    log_files: LogFiles,
    kind: OfKind = None,
    supply: Supply = None,
    stall_torque: StallTorque = None,
    no_load_speed: NoLoadSpeed = None,
    resistance: Resistance = None,
    torque_constant: TorqueConstant = None,
    wheel_inertia: WheelInertia = None,
    axis_inertia: AxisInertia = None,
    gain: Gain = None,
    kp: Kp = None,
    kd: Kd = None,
    mass: Mass = None,
    length: Length = None,
    bob: Bob = False,
    counts: Counts = None,
    from_mjcf: FromMjcf = None,
    joint: Joint = None,
    output: Output = None,
    quiet: Quiet = False,
) -> None:
    """Write a first rig file for logs, from their columns and a datasheet's numbers or a MuJoCo model. What is guessed is said, and free where logs can tell it.

    Example: `rwjax init logs/*.csv -o rig.toml`
    """
    from rwjax.methods.first_rig import Datasheet, first_rig
    from rwjax.methods.mujoco_joint import mujoco_joint
    from rwjax.text_files import write_text

    if output is not None:
        check_file(output, *log_files, *([from_mjcf] if from_mjcf else []))
        if output.exists():
            raise InputError(f"{output}: is there already; give another with -o, or remove it")
    given = {"supply": supply, "stall-torque": stall_torque, "no-load-speed": no_load_speed, "resistance": resistance}
    given |= {"torque-constant": torque_constant, "wheel-inertia": wheel_inertia, "axis-inertia": axis_inertia}
    given |= {"mass": mass, "length": length, "counts": counts, "gain": gain, "kp": kp, "kd": kd}
    _check(given, kind, from_mjcf, joint)
    if bob and mass is None:
        raise InputError("--bob says how the mass of --mass and --length is spread: give both")
    speed = None if no_load_speed is None else no_load_speed * RATE
    with progress(quiet) as show:
        show("looking at the logs")
        numbers = {name.replace("-", "_"): value for name, value in given.items()}
        datasheet = Datasheet(**(numbers | {"no_load_speed": speed}), bob=bob)
        model = mujoco_joint(from_mjcf, joint) if from_mjcf else None
        found = first_rig(log_files, datasheet, kind.value if kind else None, model)
    if output is None:
        document(found.text)
    else:
        write_text(output, found.text, InputError)
        say(f"written to {output}\n{next_command('check', output, *log_files)}")
    if not quiet:
        note(*found.notes)


def _check(given: dict[str, float | None], kind: Kind | None, from_mjcf: Path | None, joint: str | None) -> None:
    """Raises `InputError` for options that do not go together, or a number that none of them can have."""
    if (given["mass"] is None) != (given["length"] is None):
        raise InputError("--mass and --length go together: both are of one rod, or of one bob")
    if joint is not None and from_mjcf is None:
        raise InputError("--joint names a hinge of the model that --from-mjcf gives")
    beside = ("counts", "supply")  # what no model says
    other = [name for name, value in given.items() if value is not None and name not in beside]
    other += ["kind"] * (kind is not None)
    if from_mjcf is not None and other:
        raise InputError(f"--{other[0]} does not go with --from-mjcf: the model says it")
    at_voltage = [name for name in ("stall-torque", "no-load-speed") if given[name] is not None]
    if given["supply"] is None and at_voltage:
        raise InputError("--stall-torque and --no-load-speed need --supply, the voltage at which they hold")
    finite(**{name: value for name, value in given.items() if value is not None})
    positive(**{name: value for name, value in given.items() if value is not None and (name, value) != ("kd", 0.0)})
