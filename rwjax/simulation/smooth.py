"""The smooth solver: dry friction by a smooth sign, adaptive steps of diffrax.

Everything is differentiable in all numbers, by forward and by reverse mode. The price is the width of the sign: a body that
friction would hold creeps. `docs/methods.md` says what that costs beside the exact solver.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from numbers import Real
from typing import Any, ClassVar, NamedTuple

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float, Int

from rwjax.errors import InputError
from rwjax.kinds import is_angle
from rwjax.logs.log import Log
from rwjax.logs.noise import pooled_noise
from rwjax.plant.assemble import plant_of
from rwjax.plant.from_rig import structure_of, theta_of
from rwjax.plant.plant import Plant
from rwjax.plant.structure import LONGEST_STEP, State, Structure
from rwjax.rig.columns import unit_of
from rwjax.rig.model import Rig
from rwjax.simulation.batch import Batch
from rwjax.simulation.commands import Stretch, commands, each_window
from rwjax.simulation.forward_mode import with_jacobian
from rwjax.simulation.solver import Solver, ThroughWindow
from rwjax.simulation.windows import log_by_log, side_by_side, time_grid
from rwjax.types import Scalar

SLOWEST_SEEN = 10.0
"""Time in which a creeping body may move by what its encoder resolves [s]: one count in it is the default width."""
OF_NOISE = 0.1
"""Share of a rate's noise that is the default width [1]."""
SLOW = 1e-4
"""Share of a body's fastest rate below which a width only costs time [1]."""
SPAN = 0.1
"""Time over which the rate of an angle is taken [s]."""
VISIBLE = 5.0
"""Width in units of the default one above which a note says that it shows [1]."""
UNSEEN = 0.01
"""Width where neither a reading nor the rig file says what can be seen [rad/s]."""
STIFF = 300.0
"""Fastest rate of the plant times the step of the grid above which an implicit method is taken: an explicit one would need some
hundred steps to each, and one step of an implicit one costs as much as ten to twenty [1]."""
MOST_STEPS, MOST_STEPS_EACH = 256, 128
"""Most steps through a window, and besides for each of its steps of the grid; a run that needs more has failed."""
FEW = 64
"""Numbers up to which forward mode is taken to differentiate a simulation [1]: beyond, one pass backwards costs less."""


class Smooth(Solver):
    """Adaptive steps of diffrax through a plant whose dry friction has a smooth sign.

    A step ends wherever the command jumps. A run that fails ends in readings that are infinite.

    Attributes:
        width: Rate at which 76 % of the dry friction acts [rad/s]; chosen by what the encoders resolve where it is None.
        method: A solver of diffrax; explicit, or implicit for a stiff plant, where it is None.
        rtol: Relative tolerance of a step [1].
        atol: Absolute tolerance of a step [SI].
        every_step: Whether steps end wherever the command may jump, not only where it does: a derivative by the command needs it.
        adjoint: How diffrax is differentiated; as it stands by forward mode, whose cost grows with the numbers.
    """

    name: ClassVar[str] = "diffrax"
    smooth: ClassVar[bool] = True
    width: float | None = None
    method: diffrax.AbstractSolver | None = eqx.field(static=True, default=None)
    rtol: float = 1e-6
    atol: float = 1e-8
    every_step: bool = eqx.field(static=True, default=False)
    adjoint: diffrax.AbstractAdjoint = eqx.field(static=True, default=diffrax.ForwardMode())

    @property
    def from_library(self) -> bool:
        """Whether it is made of the library's and diffrax's parts alone."""
        parts = [self.adjoint, *([] if self.method is None else [self.method, *vars(self.method).values()])]
        owners = {type(part).__module__.partition(".")[0] for part in parts if isinstance(part, eqx.Module)}
        return type(self) is Smooth and owners <= {"diffrax", "optimistix", "lineax"}

    def __check_init__(self) -> None:
        if self.width is None or isinstance(self.width, Tracer):
            return
        if not _is_positive(self.width):
            raise InputError(f"width {self.width}: the width of the smooth sign has to be a positive number [rad/s]")

    def suited(self, rig: Rig, logs: Sequence[Log]) -> "Smooth":
        """This solver with a width by what the encoders resolve, and a method by how stiff the rig is."""
        if isinstance(self.width, Tracer):
            raise InputError(f"width {self.width}: the width of the smooth sign must not be traced by JAX")
        structure = structure_of(rig)
        if structure.servo is not None or structure.switched:
            what = (
                "the loop of [drive.servo]"
                if structure.servo is not None
                else "torque that is off at times (`enabled`)"
            )
            raise InputError(f"the smooth solver does not simulate {what}; take the exact one")
        width = default_width(rig, logs) if self.width is None else self.width
        method = method_for(rig, logs, width) if self.method is None else self.method
        return replace(self, width=width, method=method)

    @property
    def sign_width(self) -> float | None:
        """Width of the smooth sign of dry friction [rad/s]."""
        return self.width

    def acts_on(self, rig: Rig) -> bool:
        """Whether the rig has dry friction, on which the smooth sign acts."""
        structure, zero = structure_of(rig), jnp.zeros(())
        plant, rest = plant_of(structure, jnp.asarray(theta_of(rig, structure))), (zero,) * len(structure.states)
        return bool(plant.with_friction(zero, rest, plant.no_command(), rest).torques)

    def notes(self, rig: Rig, logs: Sequence[Log]) -> list[str]:
        """The width and the method, and whether a held body creeps so fast that these logs show it."""
        suited = self.suited(rig, logs)
        width, unseen, method = suited.width or 0.0, default_width(rig, logs), type(suited.method).__name__
        if not self.acts_on(rig):
            return [f"the rig has no dry friction that could be smooth; solved by {method}"]
        found = [f"dry friction acts by a smooth sign {width:.3g} rad/s wide, solved by {method}"]
        if width > VISIBLE * unseen:
            found.append(
                f"the smooth sign is {width / unseen:.2g} times as wide as what these readings leave unseen, {unseen:.2g} rad/s: "
                "bodies that friction holds creep"
            )
        return found

    def by_commands(self) -> "Smooth":
        """This solver with a step's end wherever the command may jump."""
        return replace(self, every_step=True)

    def of_vector(self, run: Callable[[Solver, Array], Array], z: Float[Array, " p"]) -> Array:
        """By the whole Jacobian, from forward mode, of few numbers; by a checkpointed adjoint, in reverse mode alone, of many."""
        if len(z) <= FEW:
            return with_jacobian(partial(run, self))(z)
        return run(replace(self, adjoint=diffrax.RecursiveCheckpointAdjoint()), z)

    @property
    def of_logs(self) -> Callable[..., Any]:
        """On a processor one log after the other: side by side, what a run saves would be copied at each step of any of them."""
        return log_by_log if jax.default_backend() == "cpu" else side_by_side

    def through_windows(self, plant: Plant, run: Batch) -> tuple[ThroughWindow, Any]:
        """Adaptive steps through a window, and its readings by the method's own interpolation."""
        h, t0 = time_grid(plant, run)
        acting, m = commands(plant, run), run.step_index.shape[0]

        def window(x: Float[Array, " n"], part: Stretch) -> tuple[Float[Array, " n"], Float[Array, "q y"]]:
            begin = t0 + h * part.points[0].astype(float)
            steps, at_reading = acting(part)
            t = begin + h * (part.slot_step.astype(float) + part.slot_part)
            return self._window(plant, x, _Held(begin, h, steps), begin + m * h, t, at_reading)

        return window, each_window(run)

    def _window(
        self, plant: Plant, x0: Float[Array, " n"], held: "_Held", end: Scalar, t: Float[Array, " q"], u: Array
    ) -> tuple[Float[Array, " n"], Float[Array, "q y"]]:
        """State at a window's end, and its readings at times `t` under voltages `u` there."""
        age, names = plant.age(), plant.structure.states
        late = t if age is None else jnp.maximum(t - age, held.begin)
        times = [t, end[None]] if age is None else [t, end[None], late]
        found = self._states(plant, held, x0, jnp.concatenate(times))
        x, last, *earlier = jnp.split(found, np.cumsum([len(each) for each in times])[:-1])
        seen = tuple(x.T)
        if age is not None:
            before = jnp.minimum(t - age - held.begin, 0.0)  # as if each body had turned at its first rate
            seen = list(earlier[0].T)
            for angle, rate, *_ in plant.structure.turning:
                seen[names.index(angle)] += before * seen[names.index(rate)]
        y = jax.vmap(plant.outputs)(t, tuple(x.T), u, tuple(seen))
        return last[0], jnp.where(jnp.isfinite(x).all(axis=1)[:, None], jnp.stack(y, axis=-1), jnp.inf)

    def _states(
        self, plant: Plant, held: "_Held", x0: Float[Array, " n"], times: Float[Array, " k"]
    ) -> Float[Array, "k n"]:
        """States at times in any order, infinite where the solver does not get there."""
        lives = jnp.isfinite(x0).all()  # a run that has failed is not carried on
        times = jnp.where(lives, times, held.begin)
        # in steps of the grid: else a derivative by its pace would move the solver's steps
        times = (times - held.begin) / held.h
        order = jnp.argsort(times)
        width = jnp.asarray(self.width)

        def field(t: Any, x: State, u: Array) -> State:
            rates = plant.with_smooth_friction(held.begin + held.h * t, x, u[held.step(t)], width)
            return tuple(held.h * rate for rate in rates)

        jumps = held.grid[1:] if self.every_step else held.jumps()
        control = diffrax.PIDController(rtol=self.rtol, atol=self.atol)
        assert self.method is not None, "a method is chosen by `suited`"
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(field),
            self.method,
            0.0,
            times[order[-1]],
            None,
            tuple(x0),
            args=held.u,
            saveat=diffrax.SaveAt(ts=times[order]),
            stepsize_controller=diffrax.ClipStepSizeController(control, jump_ts=jumps),
            adjoint=self.adjoint,
            max_steps=MOST_STEPS + MOST_STEPS_EACH * len(held.u),
            throw=False,
        )
        return jnp.stack(solution.ys or (), axis=1)[jnp.argsort(order)]


def _is_positive(value: Any) -> bool:
    """Whether a value is one real number, positive and finite."""
    if isinstance(value, np.ndarray | jax.Array):
        real = value.ndim == 0 and any(jnp.issubdtype(value.dtype, of) for of in (jnp.integer, jnp.floating))
    else:
        real = isinstance(value, Real) and not isinstance(value, bool)
    try:
        return real and 0.0 < float(value) < np.inf
    except OverflowError:
        return False


class _Held(NamedTuple):
    """Voltages `u` `(s, …)` held over equal steps of length `h` from `begin` on."""

    begin: Scalar
    h: Scalar
    u: Array

    @property
    def grid(self) -> Float[Array, " s"]:
        """Times at which the steps begin [steps]."""
        return jnp.arange(len(self.u), dtype=float)

    def step(self, t: Scalar) -> Int[Array, ""]:
        """The step in which a time lies."""
        return jnp.maximum(jnp.searchsorted(self.grid, t, side="right") - 1, 0)

    def jumps(self) -> Float[Array, " s"]:
        """Times at which the voltage changes, infinite where it does not [steps]."""
        return jnp.where(jnp.any(self.u[1:] != self.u[:-1], axis=tuple(range(1, self.u.ndim))), self.grid[1:], jnp.inf)


def default_width(rig: Rig, logs: Sequence[Log]) -> float:
    """Width of the smooth sign that the readings can hardly show.

    Of each reading it is one resolved step of an angle in ten seconds, or a tenth of the noise of a rate, yet not below a
    ten-thousandth of its fastest motion; the smallest of these counts. Of logs without readings it is one count of the rig file's
    encoders in ten seconds.

    Args:
        rig: The rig.
        logs: Its logs.

    Returns:
        The width [rad/s].
    """
    noise = {name: sd for name, sd in pooled_noise(tuple(logs)).items() if unit_of(name) != "A"}
    found = [max(_seen(name, sd), SLOW * _fastest(name, logs)) for name, sd in noise.items()]
    found += [] if found else [2.0 * np.pi / counts / SLOWEST_SEEN for counts in rig.counts_per_rev.values()]
    return float(min((width for width in found if width > 0.0), default=UNSEEN))


def _seen(output: str, noise: float) -> float:
    """Slowest rate that a reading with some noise shows [rad/s]."""
    return np.sqrt(12.0) * noise / SLOWEST_SEEN if is_angle(output) else OF_NOISE * noise


def _fastest(output: str, logs: Sequence[Log]) -> float:
    """Fastest rate that the logs hold of a body, of an angle between samples `SPAN` apart [rad/s]."""
    rates = [np.zeros(1)]
    for log in (log for log in logs if output in log.outputs):
        value, step = log.outputs[output], max(round(SPAN / float(np.median(np.diff(log.time)))), 1)
        if is_angle(output):
            value = (value[step:] - value[:-step]) / (log.time[step:] - log.time[:-step])
        rates.append(np.abs(value[np.isfinite(value)]))
    return float(np.max(np.concatenate(rates)))


def method_for(rig: Rig, logs: Sequence[Log], width: float) -> diffrax.AbstractSolver:
    """Method that suits a rig: an implicit one where a time constant is far shorter than a step of the grid.

    Args:
        rig: The rig.
        logs: Its logs.
        width: Width of the smooth sign [rad/s].

    Returns:
        `Tsit5` or `Kvaerno3`.
    """
    structure = structure_of(rig)
    h = min(LONGEST_STEP, *(float(np.median(np.diff(log.time))) for log in logs))
    with jax.ensure_compile_time_eval():  # a method is chosen by the rig's own numbers, wherever it is simulated
        slopes = np.asarray(_at_rest(structure, theta_of(rig, structure), width))
    fastest = np.max(np.abs(np.linalg.eigvals(slopes)))
    return diffrax.Kvaerno3() if fastest * h > STIFF else diffrax.Tsit5()


@partial(jax.jit, static_argnums=0)
def _at_rest(structure: Structure, theta: Float[Array, " p"], width: Scalar) -> Float[Array, "n n"]:
    """Derivatives of the rates by the state at rest without a command, where friction is steepest."""
    plant, n = plant_of(structure, theta), len(structure.states)

    def rates(x: Float[Array, " n"]) -> Float[Array, " n"]:
        return jnp.stack(plant.with_smooth_friction(jnp.zeros(()), tuple(x), plant.no_command(), width))

    return jax.jacfwd(rates)(jnp.full(n, jnp.minimum(1e-9, 1e-3 * width)))
