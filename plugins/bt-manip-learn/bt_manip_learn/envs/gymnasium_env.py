"""Gymnasium environment of a tree."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from bt_manip.exceptions import BtManipError
from bt_manip_learn.agents import ActionSpace, Images, Observations, ObservationSpec

from .learning_task import OPTIONS, LearningTask, Outcome, refuse_unknown
from .position_goal import PositionGoal

RENDERED = Images(("rgb",), ("overview",), 640, 480)
"""Image returned by `render`."""


class GymnasiumEnvironment(gymnasium.Env[dict[str, np.ndarray], Any]):
    """Gymnasium environment of a tree's task.

    An episode is terminated when the goal of the tree holds, when it can no longer be reached, or
    when the physics diverges; Gymnasium's time-limit wrapper truncates it. ``info`` has
    ``is_success``, ``failure`` (why the goal can no longer be reached), ``progress`` (from 0 to 1
    where the goal holds), ``task`` (a sentence that describes it), and ``seed`` and
    ``episode_number``, which identify the episode. For a tree that declares results, ``results``
    has those that were written, numbers as floats.

    Unless it is recorded or observed, an environment can be pickled, and copied by
    ``copy.deepcopy``; the copy continues the episode in its own station.

    Args:
        tree: The tree, as in ``bt-manip run``.
        render_mode: ``"rgb_array"``; None: `render` returns no images.
        physical_units: Whether actions have the units of ``task.action.space``; by default,
            continuous actions are scaled to [-1, 1].
        goal_conditioned: Whether observations are ``observation`` (all values in one array),
            ``achieved_goal`` and ``desired_goal`` (positions [m] and flags), and the reward is
            that of `PositionGoal.compute_reward`: 0 if the goal of the tree holds, otherwise -1.
        **options: Options of `LearningTask`: ``robot``, ``action``, ``reward``, ``images``, ...

    Attributes:
        task: The task; its actions have physical units.

    Raises:
        BtManipError: If an option is invalid, the tree declares no goal, or the goal of a
            goal-conditioned environment is not a position.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(
        self,
        tree: str,
        render_mode: str | None = None,
        *,
        physical_units: bool = False,
        goal_conditioned: bool = False,
        **options: Any,
    ) -> None:
        own = {"render_mode", "physical_units", "goal_conditioned"}
        refuse_unknown("an environment has no option", options, {*OPTIONS, *own})
        if goal_conditioned and (
            "images" in options or options.get("reward", "sparse") != "sparse"
        ):
            raise BtManipError(
                "a goal-conditioned environment observes numbers only, and has a reward of its "
                "own: leave out 'images' and 'reward'"
            )
        self.task = LearningTask(tree, **options)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1 / self.task.episodes.step_time)}
        observations = self.task.observations
        last = len(observations.entities) - 1
        robots, bounds = self.task.episodes.station.robots, dict[str, Any](BOUNDS)
        for name, one in robots.items():
            label, limits = name if len(robots) > 1 else "robot", one.arm.model.limits
            widened = limits.lower - JOINT_MARGIN, limits.upper + JOINT_MARGIN
            bounds[f"{label}_joint_positions"] = widened
        boxes: dict[str, spaces.Space[Any]] = {
            name: _box(name, spec, last, bounds) for name, spec in observations.specs.items()
        }
        self._goal = PositionGoal(self.task.episodes) if goal_conditioned else None
        if self._goal is not None:  # checkers recognise goal environments by this method
            self.compute_reward = self._goal.compute_reward
            found = self._observe().items()
            boxes = {name: spaces.Box(-np.inf, np.inf, one.shape) for name, one in found}
        self.observation_space: Any = spaces.Dict(boxes)
        self._scaled = not physical_units
        self.action_space = action_space_of(self.task.action.space, self._scaled)
        self._rendered: Observations | None = None
        self._seed: int | None = options.get("seed")
        self._episode = -1  # no episode has begun
        self._results: dict[str, Any] = {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Seed of this and the following episodes; None: the next episode. The first one has
                the option ``seed``, or else a random seed.
            options: ``episode``, the number of the episode, or ``state`` of `get_state` to
                continue from.

        Raises:
            BtManipError: If the episode cannot be started.
        """
        super().reset(seed=seed)
        options = options or {}
        refuse_unknown("reset has no option", options, ("episode", "state"))
        if seed is not None:
            self._seed, self._episode = seed, 0
        else:
            self._episode += 1
            if self._seed is None:
                self._seed = int(self.np_random.integers(2**31))
        if "state" in options:
            self.set_state(options["state"])
        else:
            self._episode = int(options.get("episode", self._episode))
            self.task.reset(self._seed, self._episode)
        self._results = self._read_results()
        return self._observe(), self._info(False, "")

    def step(self, action: Any) -> tuple[dict[str, np.ndarray], float, bool, bool, dict[str, Any]]:
        """Make one step; see `gymnasium.Env`."""
        outcome = self.task.step(self.in_units(action))
        self._results = self._read_results()
        return self.result(outcome)

    def expert_step(self) -> tuple[dict[str, np.ndarray], float, bool, bool, dict[str, Any]]:
        """Make one step in which the tree acts; ``info["expert_action"]`` has its action.

        Raises:
            BtManipError: If the expert cannot take over in the present state.
        """
        self.task.action.watch()
        outcome = self.task.expert_step()
        self._results = self._read_results()
        result = self.result(outcome)
        result[4]["expert_action"] = self._scale(self.task.action.recorded())
        return result

    def expert_action(self) -> np.ndarray:
        """Return the action of the expert in the present state, see `LearningTask.expert_action`.

        Raises:
            BtManipError: If the expert cannot take over in the present state.
        """
        return self._scale(self.task.expert_action())

    def _scale(self, action: np.ndarray) -> np.ndarray:
        return self.task.action.space.normalized(action) if self._scaled else action

    def in_units(self, action: Any) -> Any:
        """Convert an action to the physical units of the task."""
        return self.task.action.space.physical(action) if self._scaled else action

    def result(
        self, outcome: Outcome
    ) -> tuple[dict[str, np.ndarray], float, bool, bool, dict[str, Any]]:
        """Return the result of `step` with the present observations."""
        reward, success, failure = outcome
        info, observation = self._info(success, failure), self._observe()
        if self._goal is not None:
            goals = observation["achieved_goal"], observation["desired_goal"]
            reward = float(self._goal.compute_reward(*goals, info))
        return observation, reward, success or bool(failure), False, info

    def render(self) -> np.ndarray | None:
        """Return an image of the overview camera; None without a render mode."""
        if self.render_mode is None:
            return None
        if self._rendered is None:
            station = self.task.episodes.station
            self._rendered = Observations(station.cell, station.robots, RENDERED)
        return next(iter(self._rendered.images().values()))

    def close(self) -> None:
        """End recordings, and free the renderers."""
        self.task.close()
        if self._rendered is not None:
            self._rendered.close()

    def get_state(self) -> dict[str, Any]:
        """Return the state of the episode as plain data."""
        return self.task.get_state()

    def set_state(self, state: dict[str, Any]) -> None:
        """Continue an episode from a state, bit for bit, also in another process."""
        self.task.set_state(state)
        self._seed, self._episode = self.task.episodes.seed, self.task.episodes.episode
        self._results = self._read_results()

    def __getstate__(self) -> dict[str, Any]:
        """Return the attributes without the renderer, which is made again."""
        return {**vars(self), "_rendered": None}

    def _observe(self) -> dict[str, np.ndarray]:
        found = self.task.observe()
        if self._goal is None:
            return found
        return {
            "observation": np.concatenate([one.ravel() for one in found.values()]),
            "achieved_goal": self._goal.achieved(),
            "desired_goal": self._goal.desired(),
        }

    def _info(self, success: bool, failure: str) -> dict[str, Any]:
        identity = {"seed": self._seed, "episode_number": self._episode}
        task = self.task.episodes.run.tree.task
        results = {"results": self._results} if self._results else {}
        found = {"is_success": success, "failure": failure, "progress": self.task.progress}
        return {**found, "task": task, **identity, **results}

    def _read_results(self) -> dict[str, Any]:
        """Return the results that the tree has written; numbers as floats, for arrays of them."""
        written = self.task.episodes.run.tree.result_values().items()
        return {
            key: float(value) if type(value) in (int, float) else value
            for key, value in written
            if value is not None
        }


BOUNDS = {"_rotation": (-1.001, 1.001), "_gripper_opening": (-0.1, 1.1)}
"""Bounds of observations by the end of their names, with a margin for the physics and `float32`."""

JOINT_MARGIN = 0.1
"""Distance beyond its limits that a joint may reach against their springs [rad] or [m]."""


def _box(name: str, spec: ObservationSpec, last: int, bounds: Mapping[str, Any]) -> spaces.Box:
    """Return the space of an observation.

    Args:
        name: Its name.
        spec: Its shape and type.
        last: The largest id in a segmentation.
        bounds: Bounds by the end of the name.
    """
    low: Any = 0.0
    high: Any = {"uint8": 255, "int32": last}.get(spec.dtype, np.inf)
    if len(spec.shape) == 1:
        found = (values for end, values in bounds.items() if name.endswith(end))
        low, high = next(found, (-np.inf, np.inf))
    dtype = np.dtype(spec.dtype).type
    lower, upper = (np.full(spec.shape, one, dtype) for one in (low, high))
    return spaces.Box(lower, upper, dtype=dtype)


def action_space_of(space: ActionSpace, scaled: bool) -> spaces.Space[Any]:
    """Return the space of actions for Gymnasium; scaled: from -1 to 1."""
    if space.choices:
        return spaces.Discrete(len(space.choices))
    if scaled:
        return spaces.Box(-1.0, 1.0, space.shape, np.float32)
    return spaces.Box(space.low, space.high, dtype=np.float32)
