"""Actions of an agent: the commands of one step, and the expert's motion in the same terms."""

import abc
from typing import Any, ClassVar, NamedTuple

import numpy as np

from bt_manip.bt import NodeStatus

from .episodes import Episodes


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

    def physical(self, action: Any) -> np.ndarray:
        """Return the action in units whose numbers were scaled to [-1, 1]; others as they are."""
        scaled = np.asarray(action, dtype=float)
        if self.choices or scaled.shape != self.shape:
            return np.asarray(action)
        low, high = self.low.astype(float), self.high.astype(float)
        return low + 0.5 * (scaled + 1.0) * (high - low)

    def normalized(self, actions: Any) -> np.ndarray:
        """Return actions in units scaled to [-1, 1], clipped; choices as they are."""  # (..., n)
        if self.choices:
            return np.asarray(actions)
        low, high = self.low.astype(float), self.high.astype(float)
        scaled = 2.0 * (np.asarray(actions, dtype=float) - low) / (high - low) - 1.0
        return np.clip(scaled, -1.0, 1.0).astype(np.float32)


class ActionKind(abc.ABC):
    """One kind of actions, for the robots of a station: the actor of the loop in a step.

    Either `step` acts in place of the tree, or ``watch``, `Episodes.expert_step` and ``recorded``
    return the action that reproduces what the tree did in that step.

    Attributes:
        space: Its actions.
    """

    kind: ClassVar[str]
    space: ActionSpace

    def __init__(self, episodes: Episodes) -> None:
        self._episodes = episodes
        self._robots = list(episodes.station.robots.values())

    def step(self, action: Any) -> None:
        """Make one step with an action.

        Args:
            action: The action; numbers beyond the bounds are clipped.

        Raises:
            BtManipError: If it has another shape or is not finite.
        """
        self.command(action)
        self._episodes.agent_step(self)

    @abc.abstractmethod
    def command(self, action: Any) -> None:
        """Command an action for the step that begins; see `step`."""

    def tick(self) -> NodeStatus:
        """Act at a tick of the step; an agent is always running."""
        return NodeStatus.RUNNING

    def watch(self) -> None:  # noqa: B027 (optional)
        """Begin to observe a step of the expert."""

    @abc.abstractmethod
    def recorded(self) -> np.ndarray:
        """Return the action that reproduces the step since `watch`."""

    def get_state(self) -> Any:
        """Return the state that it keeps between steps, as plain data.

        An environment restores the first one at the start of each episode.
        """
        return None

    def set_state(self, state: Any) -> None:  # noqa: B027 (optional)
        """Restore a state of `get_state`, after that of the episode."""


def action_kind(name: str, episodes: Episodes) -> ActionKind:
    """Return a registered kind of actions.

    Raises:
        UnknownPartError: If none has this name.
    """
    make = episodes.parts.actions.maker(name, "space", "step", expected="an ActionKind")
    return make(episodes)
