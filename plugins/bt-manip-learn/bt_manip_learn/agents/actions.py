"""Actions of an agent: commands for one step, also derived from the expert's motion."""

import abc
from typing import Any, ClassVar, NamedTuple

import numpy as np

from bt_manip.bt import NodeStatus

from .episodes import Episodes


class ActionSpace(NamedTuple):
    """Space of the actions of one kind.

    Attributes:
        low: Lower bounds.  # (n,)
        high: Upper bounds.  # (n,)
        names: Name of each component.
        units: Unit of each component.
        choices: Meanings of the values 0, 1, ... of a discrete action; empty if continuous.
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
        """NumPy name of the data type."""
        return "int64" if self.choices else "float32"

    def physical(self, action: Any) -> np.ndarray:
        """Convert an action scaled to [-1, 1] to physical units; keep discrete actions."""
        scaled = np.asarray(action, dtype=float)
        if self.choices or scaled.shape != self.shape:
            return np.asarray(action)
        low, high = self.low.astype(float), self.high.astype(float)
        return low + 0.5 * (scaled + 1.0) * (high - low)

    def normalized(self, actions: Any) -> np.ndarray:
        """Scale and clip actions in physical units to [-1, 1]; keep discrete ones."""  # (..., n)
        if self.choices:
            return np.asarray(actions)
        low, high = self.low.astype(float), self.high.astype(float)
        scaled = 2.0 * (np.asarray(actions, dtype=float) - low) / (high - low) - 1.0
        return np.clip(scaled, -1.0, 1.0).astype(np.float32)


class ActionKind(abc.ABC):
    """One kind of actions for the robots of a station; the actor of the loop during a step.

    `step` acts in place of the tree. To convert a step of the tree to an action, call `watch`,
    `Episodes.expert_step` and `recorded`.

    Args:
        episodes: The episodes in which to act.

    Attributes:
        space: The action space.
    """

    kind: ClassVar[str]
    space: ActionSpace

    def __init__(self, episodes: Episodes) -> None:
        self._episodes = episodes
        self._robots = list(episodes.station.robots.values())

    def step(self, action: Any) -> None:
        """Make one step with an action.

        Args:
            action: The action; it is clipped to the bounds.

        Raises:
            BtManipError: If its shape is wrong or it is not finite.
        """
        self.command(action)
        self._episodes.agent_step(self)

    @abc.abstractmethod
    def command(self, action: Any) -> None:
        """Command an action for the coming step; see `step`."""

    def tick(self) -> NodeStatus:
        """Act at a tick of the step; return RUNNING."""
        return NodeStatus.RUNNING

    def watch(self) -> None:  # noqa: B027 (optional)
        """Begin to observe a step of the expert."""

    @abc.abstractmethod
    def recorded(self) -> np.ndarray:
        """Return the action that reproduces the step since `watch`."""

    def get_state(self) -> Any:
        """Return the state kept between steps, as plain data.

        An environment restores the initial state at the start of each episode.
        """
        return None

    def set_state(self, state: Any) -> None:  # noqa: B027 (optional)
        """Restore a state of `get_state`, after the state of the episode."""


def action_kind(name: str, episodes: Episodes) -> ActionKind:
    """Return a registered kind of actions.

    Raises:
        UnknownPartError: If no kind has this name.
    """
    make = episodes.parts.of("actions").maker(name, "space", "step", expected="an ActionKind")
    return make(episodes)
