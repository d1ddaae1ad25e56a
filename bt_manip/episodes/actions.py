"""Actions of an agent: what they command for one step, and what the expert did in these terms."""

import abc
from typing import Any, ClassVar, NamedTuple

import numpy as np

from .episodes import Episodes, Then


class ActionSpace(NamedTuple):
    """The actions of one kind.

    Attributes:
        low: Least numbers.  # (n,)
        high: Largest numbers.  # (n,)
        names: Name of each number.
        units: Unit of each number.
        choices: What the numbers 0, 1, ... of a single discrete action mean; empty if continuous.
    """

    low: np.ndarray
    high: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    choices: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of an action."""
        return () if self.choices else self.low.shape

    @property
    def dtype(self) -> str:
        """NumPy's name of the number type."""
        return "int64" if self.choices else "float32"


class ActionKind(abc.ABC):
    """One kind of actions, for the robots of a station.

    Either `step` acts in place of the tree, or ``watch``, `Episodes.expert_step` and ``recorded``
    return the action that reproduces what the tree did in that step.

    Attributes:
        space: Its actions.
    """

    kind: ClassVar[str]
    space: ActionSpace

    def __init__(self, episodes: Episodes) -> None:
        """Act in these episodes."""
        self._episodes = episodes
        self._robots = list(episodes.station.robots.values())

    @abc.abstractmethod
    def step(self, action: Any, then: Then = ()) -> None:
        """Make one step with an action.

        Args:
            action: The action; numbers beyond the bounds are clipped.
            then: Called after each control step.

        Raises:
            BtManipError: If it has another shape or is not finite.
        """

    def watch(self) -> None:  # noqa: B027 (optional)
        """Begin to observe a step of the expert."""

    @abc.abstractmethod
    def recorded(self) -> np.ndarray:
        """Return the action that reproduces the step since `watch`."""

    def get_state(self) -> Any:
        """Return the state that it keeps between steps, as plain data."""
        return None

    def set_state(self, state: Any) -> None:  # noqa: B027 (optional)
        """Restore a state of `get_state`, after that of the episode."""
