"""The interface of a solver: how a plant is moved through a whole log, and what its dry friction is at standstill."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import equinox as eqx
import jax
from jaxtyping import Array, Float, Int

from rwjax.logs.log import Log
from rwjax.plant.plant import Plant
from rwjax.rig.model import Rig
from rwjax.simulation.batch import Batch
from rwjax.simulation.windows import side_by_side

ThroughWindow = Callable[[Array, Any], tuple[Array, Array]]
"""What moves a plant through a window: from its first state and its inputs to the state at its end and its readings."""


class Solver(eqx.Module):
    """A way to simulate a plant under the command of a log.

    What is an array or a number in it may change without a new program; everything else decides which program is compiled.

    Attributes:
        name: Name for `--solver`.
        smooth: Whether dry friction is smooth in it, so that readings are differentiable in all numbers.
    """

    name: ClassVar[str]
    smooth: ClassVar[bool] = False

    @abstractmethod
    def suited(self, rig: Rig, logs: Sequence[Log]) -> "Solver":
        """This solver with all that its user left open chosen for a rig and its logs.

        Args:
            rig: The rig.
            logs: The logs that it is to simulate.

        Returns:
            The solver.
        """

    @property
    @abstractmethod
    def from_library(self) -> bool:
        """Whether it is the library's own, whose source determines the program; programs of others are not kept on disk."""

    @property
    def sign_width(self) -> float | None:
        """Width of the smooth sign of dry friction [rad/s]; None where friction is exact."""
        return None

    def acts_on(self, rig: Rig) -> bool:
        """Whether its smooth sign acts on anything.

        Args:
            rig: The rig.

        Returns:
            True where it has one and the rig has dry friction.
        """
        return False

    def notes(self, rig: Rig, logs: Sequence[Log]) -> list[str]:
        """What a user should know of a simulation by it.

        Args:
            rig: The rig.
            logs: The logs that it simulates.

        Returns:
            One sentence each.
        """
        return []

    def by_commands(self) -> "Solver":
        """This solver as it is needed to differentiate by the command.

        Returns:
            The solver.
        """
        return self

    def of_vector(self, run: "Callable[[Solver, Array], Array]", z: Float[Array, " p"]) -> Array:
        """What a simulation makes of a vector, so that JAX can differentiate it.

        Args:
            run: The simulation, called with a solver and the vector.
            z: The vector `(p,)` [SI].

        Returns:
            What it returns [SI].
        """
        return run(self, z)

    @property
    def of_logs(self) -> Callable[..., Any]:
        """What works a function out for every log of a batch, as `side_by_side` and `log_by_log` do."""
        return side_by_side

    @abstractmethod
    def through_windows(self, plant: Plant, run: Batch) -> tuple[ThroughWindow, Any]:
        """What moves a plant through any window of a log.

        Args:
            plant: The plant of the log.
            run: One log of a batch.

        Returns:
            A function from a window's first state `(n,)` [SI] and its inputs to the state at its end `(n,)` [SI] and its readings
            `(q, y)` [rad, rad/s or A], not finite where the run does not get there; and the inputs of all windows, arrays with a
            first axis of windows.
        """

    def whole(
        self, plant: Plant, run: Batch, x0: Float[Array, " n"]
    ) -> tuple[Float[Array, "w q y"], Float[Array, "w n"]]:
        """Free run of one log.

        Args:
            plant: The plant of the log.
            run: One log of a batch.
            x0: First state `(n,)` [SI].

        Returns:
            Readings `(w, q, y)` [rad, rad/s or A] and the states at the windows' starts `(w, n)` [SI].
        """
        window, inputs = self.through_windows(plant, run)

        def one(x: Array, given: Any) -> tuple[Array, tuple[Array, Array]]:
            end, y = window(x, given)
            return end, (y, x)

        return jax.lax.scan(one, x0, inputs)[1]

    def beginning(
        self, plant: Plant, run: Batch, x0: Float[Array, " n"], windows: Int[Array, ""]
    ) -> tuple[Float[Array, "w q y"], Float[Array, "w n"]]:
        """The first windows of `whole`.

        Args:
            plant: The plant of the log.
            run: One log of a batch.
            x0: First state `(n,)` [SI].
            windows: How many windows to simulate [1].

        Returns:
            Readings `(w, q, y)` [rad, rad/s or A] and the states at the windows' starts `(w, n)` [SI]; those of later windows do not
            count.
        """
        window, inputs = self.through_windows(plant, run)

        def one(w: Int[Array, ""], carry: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
            x, y, nodes = carry
            end, seen = window(x, jax.tree.map(lambda a: a[w], inputs))
            put = jax.lax.dynamic_update_index_in_dim
            return end, put(y, seen, w, 0), put(nodes, x, w, 0)

        W, q = run.slot_step.shape
        nothing = jax.lax.empty((W, q, len(plant.structure.outputs)), float), jax.lax.empty((W, len(x0)), float)
        return jax.lax.fori_loop(0, windows, one, (x0, *nothing))[1:]

    def windows(
        self, plant: Plant, run: Batch, nodes: Float[Array, "w n"]
    ) -> tuple[Float[Array, "w q y"], Float[Array, "w n"]]:
        """Every window of one log from a first state of its own, all side by side.

        Args:
            plant: The plant of the log.
            run: One log of a batch.
            nodes: First state of every window `(w, n)` [SI].

        Returns:
            Readings `(w, q, y)` [rad, rad/s or A], and the states at the windows' ends `(w, n)` [SI].
        """
        window, inputs = self.through_windows(plant, run)
        end, y = jax.vmap(window)(nodes, inputs)
        return y, end
