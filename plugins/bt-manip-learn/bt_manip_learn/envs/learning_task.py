"""The task of a tree for an agent: observations, actions, reward and termination."""

import inspect
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bt_manip.cell import PhysicsDiverged
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.plugins import load_plugins
from bt_manip.registry import Parts
from bt_manip.runner import Run, RunObserver, RunRequest, recorder_for, request_of
from bt_manip_learn.agents import (
    STEP,
    Episodes,
    Images,
    LossCheck,
    Observations,
    action_kind,
    goal_progress,
    without_progress,
)

REWARDS = ("sparse", "dense", "shaped")
"""Kinds of rewards: 1 if the goal holds, otherwise 0; this plus the progress made in the step; or
this plus potential-based shaping for the agent's discount."""

DISCOUNT = 0.99
"""Default discount of the shaped reward."""


class Outcome(NamedTuple):
    """Result of a step.

    Attributes:
        reward: The reward: from 0 to 1; from -1 to 2 unless it is sparse.
        success: Whether the goal of the tree holds.
        failure: Why the goal can no longer be reached; empty if it can.
    """

    reward: float
    success: bool
    failure: str


class LearningTask:
    """The task of a tree: an agent acts in place of the tree until its goal holds.

    Args:
        tree: The tree, as in ``bt-manip run``.
        action: Name of the kind of actions.
        reward: ``"sparse"``: 1 if the goal holds, otherwise 0. ``"dense"``: this plus the change
            of `progress` in the step, so that the return of an episode is the progress made, plus
            1 for success. ``"shaped"``: this plus ``discount * after - before`` of the progress,
            potential-based shaping (Ng, Harada and Russell 1999), which preserves the optimal
            policy. A lost object or diverged physics end an episode with progress 0.
        discount: The agent's discount, for the shaped reward; default `DISCOUNT`.
        images: Images to observe; default: none.
        step_time: Duration of a step [s].
        record: File for recordings, e.g. ``run-{episode}.mcap``, whose suffix selects the recorder.
            Without ``{episode}`` only the first episode is recorded.
        faults: Faults to inject into each episode, as in ``bt-manip run --fault``.
        observers: Further observers of all episodes, such as a `bt_manip.viewer.Page`.
        vary: Parameters of ``bt-manip run --vary``, by name: ``{"scene.mass": 2}``.
        parts: The registered parts; default: those of all installed plugins.
        **request: Fields of `RunRequest`: ``robot``, ``scene``, ``controller``, ``settings``.

    Attributes:
        episodes: The episodes of the tree in its station.
        observations: The observations.
        action: The kind of actions.
        reward_bounds: Smallest and largest reward of a step.
        progress: Progress towards the goal after the last step, from 0 to 1 where the goal holds;
            see `goal_progress`.

    Raises:
        BtManipError: If an argument is invalid, the tree declares no goal, or a condition of the
            goal has no method ``progress`` or ``places`` for a reward that is not sparse.
    """

    def __init__(
        self,
        tree: str,
        *,
        action: str = "joint_targets",
        reward: str = "sparse",
        discount: float | None = None,
        images: Images | Mapping[str, Any] | None = None,
        step_time: float = STEP,
        record: str = "",
        faults: Sequence[str] = (),
        observers: Sequence[RunObserver] = (),
        vary: Mapping[str, Any] | None = None,
        parts: Parts | None = None,
        **request: Any,
    ) -> None:
        if reward not in REWARDS:
            raise BtManipError(f"a reward is {' or '.join(REWARDS)}, got '{reward}'")
        if discount is not None and reward != "shaped":
            raise BtManipError(
                f"the discount is that of the reward 'shaped', and has no effect on '{reward}'"
            )
        self._discount = {"dense": 1.0, "shaped": DISCOUNT if discount is None else discount}.get(
            reward
        )
        refuse_unknown("an environment has no option", request, OPTIONS)
        self._arguments: dict[str, Any] = {
            "tree": tree, "action": action, "reward": reward, "discount": discount,
            "images": images, "step_time": step_time, "faults": faults, "vary": vary,
            "parts": parts, **request,
        }  # fmt: skip
        if parts is None:
            parts = load_plugins().parts
        self._record, self._observers, self._parts = record, tuple(observers), parts
        self._recorded = bool(record)
        modifiers = {"fault": tuple(faults)} if faults else {}
        asked = request_of(tree, parts, modifiers=modifiers, varied=vary, **request)
        self.episodes = Episodes(asked, parts, step_time=step_time)
        if not self.episodes.run.tree.goal:
            raise BtManipError(
                f"the tree '{tree}' declares no goal, so that success is not defined"
            )
        self.reward_bounds = (0.0, 1.0)
        if self._discount is not None:
            if not 0.0 <= self._discount <= 1.0:
                raise BtManipError(f"the discount is from 0 to 1, got {self._discount:g}")
            self.reward_bounds = (-1.0, 1.0 + self._discount)
            if names := without_progress(self.episodes.run.tree.goal):
                raise BtManipError(
                    f"the reward '{reward}' needs the progress of the goal, but its condition "
                    f"{', '.join(names)} has no method 'places' or 'progress': add one, or use "
                    "'sparse'"
                )
        self.episodes.reset(self.episodes.seed)  # the tree adds its objects
        if isinstance(images, Mapping):
            refuse_unknown("images have no option", images, Images._fields)
            images = Images(**images)
        station = self.episodes.station
        self.observations = Observations(station.cell, station.robots, images)
        self.action = action_kind(action, self.episodes)
        self._at_first = self.action.get_state()
        self.episodes.run.identity["agent"] = action
        self.episodes.make_observers = self._make_observers
        self._losses, self._diverged = LossCheck(self.episodes), ""
        self._last = self.observations.read()
        self.progress = goal_progress(self.episodes)

    def reset(self, seed: int, episode: int = 0) -> None:
        """Start an episode; see `Episodes.reset`."""
        self.episodes.reset(seed, episode)
        self.action.set_state(self._at_first)
        self._losses, self._diverged = LossCheck(self.episodes), ""
        self.progress = goal_progress(self.episodes)

    def step(self, action: Any) -> Outcome:
        """Make one step with an action.

        Raises:
            BtManipError: If the action is not in the action space.
        """
        return self._outcome(partial(self.action.step, action))

    def expert_step(self) -> Outcome:
        """Make one step in which the tree acts, also after steps of an agent.

        Raises:
            BtManipError: If the expert cannot take over in the present state.
        """
        return self._outcome(self.episodes.expert_step)

    def expert_action(self) -> np.ndarray:
        """Return the action of the expert in the present state, in which the task remains.

        After a step of an agent it is the beginning of the tree from a rest at this place.

        Raises:
            BtManipError: If the expert cannot take over in the present state, or the task is
                recorded or observed.
        """
        if self.observed:
            raise BtManipError("a recorded or observed environment cannot try the expert's action")
        state = self.get_state()
        try:
            self.action.watch()
            self.episodes.expert_step()
            return self.action.recorded()
        finally:
            self.set_state(state)

    def close(self) -> None:
        """End the observers, and free the renderers."""
        self.episodes.close()
        self.observations.close()

    def observe(self) -> dict[str, np.ndarray]:
        """Return the present observations; after divergence, the last ones before it."""
        if not self._diverged:
            self._last = self.observations.read()
        return dict(self._last)

    def get_state(self) -> dict[str, Any]:
        """Return the state of the episode as plain data, for `set_state` in any process."""
        return {
            "episode": self.episodes.get_state(),
            "action": self.action.get_state(),
            "losses": self._losses.get_state(),
            "progress": self.progress,
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Continue an episode, bit for bit.

        Raises:
            BtManipError: If the state is of another tree.
        """
        self.episodes.set_state(state["episode"])
        self.action.set_state(state["action"])
        self._losses.set_state(state["losses"])
        self.progress, self._diverged = state["progress"], ""

    def judge(self, diverged: str = "") -> Outcome:
        """Judge the present state as that after a step.

        Args:
            diverged: How the physics diverged in the step; empty if it did not.
        """
        self._diverged, before = diverged, self.progress
        self.progress = 0.0 if diverged else goal_progress(self.episodes)
        success = self.progress == 1.0
        failure = diverged or ("" if success else self._losses.reason())
        if failure:
            self.progress = 0.0
        shaping = 0.0 if self._discount is None else self._discount * self.progress - before
        return Outcome(float(success) + shaping, success, failure)

    @property
    def observed(self) -> bool:
        """Whether episodes are recorded, observed or modified by faults."""
        return self._recorded or bool(self._observers or self.episodes.run.modifiers)

    def _outcome(self, step: Callable[[], None]) -> Outcome:
        """Make a step and judge its outcome; finish the episode if it has ended."""
        try:
            step()
        except PhysicsDiverged as error:
            self._diverged = str(error)
        outcome = self.judge(self._diverged)
        if (outcome.success or outcome.failure) and not self.episodes.ended:
            self.episodes.finish(outcome.failure)
        return outcome

    def __reduce__(self) -> Any:
        """Pickle or copy the arguments and the state of the environment.

        Raises:
            BtManipError: If it is recorded or observed.
        """
        if self._recorded or self._observers:
            raise BtManipError(
                "an environment with 'record' or 'observers' cannot be copied or pickled: both "
                "would write the same files; make another one and give it the state of get_state()"
            )
        return partial(LearningTask, **self._arguments), (), self.get_state()

    __setstate__ = set_state

    def _make_observers(self, run: Run, episode: int) -> list[RunObserver]:
        found = list(self._observers)
        if self._record:
            path = Path(self._record.replace("{episode}", str(episode)))
            if "{episode}" not in self._record:
                self._record = ""  # only the first episode is recorded
            found.append(recorder_for(path, self._parts.recorders))
        return found


OPTIONS = sorted(
    {*inspect.signature(LearningTask).parameters, *(one.name for one in fields(RunRequest))}
    - {"request", "cycles", "real_time", "modifiers"}
)
"""Names of the options of an environment."""


class UnknownOptionError(BtManipError, TypeError):
    """An option has an unknown name; libraries try options, and expect a `TypeError`."""


def refuse_unknown(what: str, given: Mapping[str, Any], known: Collection[str]) -> None:
    """Check the names of options.

    Raises:
        UnknownOptionError: If one is unknown; the message suggests similar names.
    """
    for name in given:
        if name not in known:
            raise UnknownOptionError(
                f"{what} '{name}'{did_you_mean(name, known)} (unexpected keyword argument '{name}')"
            )
