"""The interface of a time step: what moves a plant over one step of the grid."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from rwjax.plant.one_axis import OneAxis
from rwjax.plant.plant import Command, Plant
from rwjax.plant.structure import State
from rwjax.types import Scalar


class Stepper(ABC):
    """A rule that moves any plant over one time step.

    A stepper decides which program is compiled. So it has to be immutable and hashable, as a frozen dataclass is, and steppers
    with the same settings have to be equal.

    Attributes:
        from_library: Whether it is the library's own, so that the library's source of one version determines the program.
            Programs of others are not kept on disk.
    """

    from_library: ClassVar[bool] = False

    @abstractmethod
    def prepare(self, plant: Plant, h: Scalar) -> Any:
        """What all steps of a run share.

        Args:
            plant: The plant of the run.
            h: Length of every step [s].

        Returns:
            Arrays, which `step` is given; None where there is nothing to share.
        """

    @abstractmethod
    def step(self, plant: Plant, prepared: Any, t: Scalar, x: State, u: Command, h: Scalar) -> State:
        """State after one step.

        Args:
            plant: The plant of the run.
            prepared: What `prepare` returned.
            t: Time at which the step begins [s].
            x: State at its beginning.
            u: Mean voltage over the step [V], `()` or `(2,)`.
            h: Length of the step [s].

        Returns:
            State at the step's end.
        """


class SlidingStepper(Stepper):
    """A stepper that can also move an axis that slides one way whatever its speed, as optimisation of commands needs."""

    @abstractmethod
    def slide(
        self, plant: OneAxis, prepared: Any, t: Scalar, x: State, u: Scalar, h: Scalar, direction: Scalar
    ) -> State:
        """`step` of an axis that slides in a given direction: dry friction neither holds it nor turns with it.

        So the state is smooth in the commands that bring the axis to rest.

        Args:
            plant: The plant of the run.
            prepared: What `prepare` returned.
            t: Time at which the step begins [s].
            x: State at its beginning.
            u: Mean voltage over the step [V].
            h: Length of the step [s].
            direction: Direction in which the axis slides, 1 or -1 [1].

        Returns:
            State at the step's end.
        """
