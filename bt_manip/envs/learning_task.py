"""The task of a tree for an agent: observations, actions, reward and end."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from bt_manip.cell import PhysicsDiverged
from bt_manip.episodes import (
    STEP,
    Episodes,
    Images,
    LossCheck,
    Observations,
    action_kind,
    goal_progress,
)
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.runner import request_of

REWARDS = ("sparse", "dense")
"""Rewards of a step: 1 where the goal holds and 0 elsewhere, or the progress towards the goal."""


class Outcome(NamedTuple):
    """What a step led to.

    Attributes:
        reward: The reward, from 0 to 1.
        success: Whether the goal of the tree holds.
        failure: Why the goal cannot be met any more; empty if it can.
    """

    reward: float
    success: bool
    failure: str


class LearningTask:
    """The task of a tree: an agent acts in place of the tree until the goal holds.

    Attributes:
        episodes: The episodes of the tree in its station.
        observations: The observations.
        action: The kind of actions.
    """

    def __init__(
        self,
        tree: str,
        *,
        action: str = "joint_targets",
        reward: str = "sparse",
        images: Images | Mapping[str, Any] | None = None,
        step_time: float = STEP,
        parts: Parts | None = None,
        **request: Any,
    ) -> None:
        """Prepare the station and the spaces.

        Args:
            tree: The tree, as in ``bt-manip run``.
            action: ``"joint_torques"``, ``"joint_targets"``, ``"cartesian_deltas"`` or
                ``"subtree_choice"``.
            reward: ``"sparse"`` or ``"dense"``.
            images: Images among the observations; default: none.
            step_time: Time of a step [s].
            parts: The registered parts; default: those of all installed plugins.
            **request: Fields of `RunRequest`: ``robot``, ``scene``, ``controller``, ``settings``.

        Raises:
            BtManipError: If an argument is invalid, or the tree declares no goal.
        """
        if reward not in REWARDS:
            raise BtManipError(f"a reward is {' or '.join(REWARDS)}, got '{reward}'")
        if parts is None:
            from bt_manip.plugins import load_plugins

            parts = load_plugins().parts
        self.episodes = Episodes(request_of(tree, parts, **request), parts, step_time=step_time)
        if not self.episodes.run.tree.goal:
            raise BtManipError(
                f"the tree '{tree}' declares no goal, so that success is not defined"
            )
        self._dense = reward == "dense"
        self.episodes.reset(self.episodes.seed)  # objects that the tree adds are there then
        wanted = Images(**images) if isinstance(images, Mapping) else images
        station = self.episodes.station
        self.observations = Observations(station.cell, station.robots, wanted)
        self.action = action_kind(action, self.episodes)
        self._losses = LossCheck(self.episodes)
        self._diverged = ""
        self._last = self.observations.read()

    def reset(self, seed: int, episode: int = 0) -> None:
        """Start an episode; see `Episodes.reset`."""
        self.episodes.reset(seed, episode)
        self._losses, self._diverged = LossCheck(self.episodes), ""

    def step(self, action: Any) -> Outcome:
        """Make one step with an action.

        Raises:
            BtManipError: If the action is not one of the space.
        """
        try:
            self.action.step(action)
        except PhysicsDiverged as error:
            self._diverged = str(error)
        return self.outcome()

    def outcome(self) -> Outcome:
        """Judge the present state."""
        if self._diverged:
            return Outcome(0.0, False, self._diverged)
        if self._dense:
            reward = goal_progress(self.episodes)
            success = reward == 1.0
        else:
            success = self.episodes.success
            reward = float(success)
        return Outcome(reward, success, "" if success else self._losses.reason())

    def observe(self) -> dict[str, np.ndarray]:
        """Return the present observations; if the physics has diverged, the last ones before."""
        if not self._diverged:
            self._last = self.observations.read()
        return dict(self._last)

    def get_state(self) -> dict[str, Any]:
        """Return the state of the episode as plain data, for `set_state` in any process."""
        return {
            "episode": self.episodes.get_state(),
            "action": self.action.get_state(),
            "losses": self._losses.get_state(),
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Continue an episode, bit for bit.

        Raises:
            BtManipError: If the state is of another tree.
        """
        self.episodes.set_state(state["episode"])
        self.action.set_state(state["action"])
        self._losses.set_state(state["losses"])
        self._diverged = ""
