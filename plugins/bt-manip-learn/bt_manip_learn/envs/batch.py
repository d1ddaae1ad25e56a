"""Batch of episodes of one environment, simulated in parallel by MuJoCo."""

import copy
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from dm_control import composer
from mujoco.batch import Batch as Simulations

from bt_manip.control import ControllerManager
from bt_manip.exceptions import BtManipError
from bt_manip.robots import Payload, RobotModel
from bt_manip_learn.agents import ArmAction, JointTorques
from bt_manip_learn.native import FEEDFORWARD_STEPS, NativePD, NativeTwoFingerGripper

from .gymnasium_env import GymnasiumEnvironment
from .learning_task import LearningTask

_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION.value)
_OF_ENVIRONMENT = ("_seed", "_episode", "_results", "_np_random", "_np_random_seed")
_OF_TASK = ("_losses", "progress", "_diverged", "_last")
_GROUPS = 4  # one group is simulated while others are commanded and judged


@dataclass
class _Slot:
    """State of an episode beside that of its physics.

    Attributes:
        kept: Attributes of the environment and of the task.
        references: References of the arms.
        grippers: References of the grippers.
        models: Payload of each arm, and its model with this payload.
        fresh: Data of an episode before its first step; None later.
    """

    kept: tuple[Mapping[str, Any], Mapping[str, Any]]
    references: list[Any]
    grippers: list[tuple[Any, ...]]
    models: list[tuple[Payload | None, RobotModel]]
    fresh: mujoco.MjData | None


class Batch:
    """Batch of episodes that share the station and the model of one environment.

    A step commands, simulates and judges each episode. To command, observe or judge an episode, its
    state is loaded into the station, so that the code is that of the single environment. Meanwhile
    MuJoCo simulates other groups of episodes, each in one call.

    Args:
        env: The environment.
        count: Number of episodes.
        threads: Number of simulation threads; 0: one per CPU.

    Attributes:
        groups: Simulations of each group of episodes, in the order of their numbers.

    Raises:
        BtManipError: If the task cannot be batched, with the reason.
    """

    def __init__(self, env: GymnasiumEnvironment, count: int, threads: int) -> None:
        for reason in _reasons(env.task):
            raise BtManipError(
                f"these environments cannot be batched: {reason}; make one environment per process"
            )
        self._env, self._task = env, env.task
        episodes = env.task.episodes
        self._cell, self._robots = episodes.station.cell, list(episodes.station.robots.values())
        self._grippers: list[Any] = [r.gripper for r in self._robots if r.gripper is not None]
        self._action: Any = env.task.action
        self._ticks, self._per_tick = episodes.ticks, episodes.run.request.steps_per_tick
        self._at_first = self._kept()
        self._slots: dict[int, _Slot] = {}
        groups = np.array_split(np.arange(count), min(count, _GROUPS))
        self.groups = [
            Simulations(self._cell.model, len(group), threads, persistent=True) for group in groups
        ]
        self._place = [(k, j) for k, group in enumerate(groups) for j in range(len(group))]
        self._model = _bytes_of(self._cell.model)
        self._signals = np.zeros((count, self._ticks * self._per_tick, self._cell.model.nu))

    def reset(self, i: int, seed: int | None, options: Mapping[str, Any]) -> tuple[Any, Any]:
        """Start an episode; return its observations and ``info``.

        Raises:
            BtManipError: If it cannot be started, or its model differs from that of the batch.
        """
        self._keep(self._slots[i].kept if i in self._slots else self._at_first)
        observation, info = self._env.reset(seed=seed, options=dict(options))
        model, data = self._cell.model, self._cell.data
        if _bytes_of(model) != self._model:
            raise BtManipError(
                f"episodes in a batch share one model, and that of seed {info['seed']}, episode "
                f"{info['episode_number']}, differs: fixed objects are placed or physical "
                "properties are randomized in each episode; make one environment per process"
            )
        references = self._action.take_over()
        controllers = [one.controllers.controller for one in self._robots]
        self._slots[i] = _Slot(
            self._kept(),
            references,
            [gripper.driven() for gripper in self._grippers],
            [(None, one.bare_model.with_payload(None)) for one in controllers],
            copy.copy(data),
        )
        self._warnings = data.warning.number
        group, place = self._place[i]
        mujoco.mj_getState(model, data, self.groups[group].state[place], _STATE)
        self._signals[i] = data.ctrl
        return observation, info

    def step(self, ids: Sequence[int], actions: Sequence[Any]) -> list[Any]:
        """Make one step of the given episodes.

        Args:
            ids: Numbers of the episodes, ascending.
            actions: Action of each episode, in physical units.

        Returns:
            Result of `GymnasiumEnvironment.step` for each episode.
        """
        given = dict(zip(ids, actions, strict=True))
        groups = [[i for i in ids if self._place[i][0] == k] for k in range(len(self.groups))]
        results: list[Any] = []
        with ThreadPoolExecutor(1) as pool:
            running = []
            for group in filter(None, groups):
                for i in group:
                    self._load(i)
                    self._action.follow(self._slots[i].references)
                    self._command(self._signals[i], self._slots[i], given[i])
                running.append((group, pool.submit(self._simulate, group)))
            for group, raised in running:
                results += map(self._judge, group, raised.result())
        return results

    def within(self, i: int, function: Callable[[], Any]) -> Any:
        """Return the result of a function that reads the environment, in the state of an episode.

        Before the first reset, that is the state of the environment that all share.
        """
        if i not in self._slots:
            return function()
        self._load(i)
        self._keep(self._slots[i].kept)
        found = function()
        self._slots[i].kept = self._kept()
        return found

    def _simulate(self, ids: Sequence[int]) -> np.ndarray:
        """Simulate a step of episodes of one group; return the MuJoCo warnings of each."""
        group, places = self.groups[self._place[ids[0]][0]], [self._place[i][1] for i in ids]
        numbers = group.warning[..., 1]  # counts
        before = numbers[places]
        group.rollout(self._signals.shape[1], self._signals[ids], record=(), ids=places)
        return numbers[places] > before  # (n, kinds)

    def _judge(self, i: int, raised: np.ndarray) -> Any:
        """Judge an episode at the end of a step, given its warnings."""
        slot, diverged = self._slots[i], ""
        self._load(i)
        self._keep(slot.kept)
        if raised.any():
            names = np.array(list(mujoco.mjtWarning.__members__))[np.flatnonzero(raised)]
            text = ", ".join(name.removeprefix("mjWARN_") for name in names.tolist())
            diverged = f"MuJoCo warned at {self._cell.time:.3f} s: {text}"
        result = self._env.result(self._task.judge(diverged))
        slot.kept = self._kept()
        return result

    def _command(self, signals: np.ndarray, slot: _Slot, action: Any) -> None:
        """Write the control signals of a step, and advance all references to its end.

        The signals are those of all actuators in each control step.  # (steps, nu)
        """
        self._action.command(action)
        for k, (one, reference) in enumerate(zip(self._robots, slot.references, strict=True)):
            controller: Any = one.controllers.controller
            payload, model = slot.models[k]
            if reference.payload is not payload:
                model = controller.bare_model.with_payload(reference.payload)
                slot.models[k] = reference.payload, model
            signals[:, one.robot.ctrl_adr] = controller.signals(model, *reference.finish())
        ticks = self._ticks if self._action.waiting else 1  # otherwise all ticks are alike
        n = self._per_tick * self._ticks // ticks
        for tick in range(ticks):
            self._action.tick()
            for gripper in self._grippers:
                rows = signals[tick * n : (tick + 1) * n]
                rows[:, gripper.mechanism.ctrl_adr] = gripper.signals(n)
        slot.grippers = [gripper.driven() for gripper in self._grippers]
        slot.fresh = None

    def _load(self, i: int) -> None:
        """Load the state of an episode into the station."""
        slot, data = self._slots[i], self._cell.data
        warned = self._warnings.copy()
        if slot.fresh is not None:
            mujoco.mj_copyData(data, self._cell.model, slot.fresh)
        else:
            group, place = self._place[i]
            self.groups[group].get_data(place, data)
        self._warnings[:] = warned  # those of the cell
        for gripper, driven in zip(self._grippers, slot.grippers, strict=True):
            gripper.drive(driven)

    def _kept(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the attributes of environment and task that are part of an episode."""
        return (
            {name: getattr(self._env, name) for name in _OF_ENVIRONMENT},
            {name: getattr(self._task, name) for name in _OF_TASK},
        )

    def _keep(self, kept: tuple[Mapping[str, Any], Mapping[str, Any]]) -> None:
        """Set the attributes returned by `_kept`."""
        vars(self._env).update(kept[0])
        vars(self._task).update(kept[1])


def _reasons(task: LearningTask) -> Any:
    """Yield the reasons why a task cannot be batched."""
    episodes = task.episodes
    if not isinstance(task.action, ArmAction) or isinstance(task.action, JointTorques):
        yield (
            f"actions of kind '{task.action.kind}' act between control steps "
            "(joint_targets and cartesian_deltas do not)"
        )
    if any(len(spec.shape) > 1 for spec in task.observations.specs.values()):
        yield "images are rendered one by one"
    if task.observed:
        yield "'record', 'observers' and 'faults' act in control steps"
    for name, one in episodes.station.robots.items():
        active, gripper = one.controllers.controller, one.gripper
        if not isinstance(active, NativePD):
            yield f"robot '{name}': the controller '{active.kind}' is not 'native_pd'"
        if gripper is not None and not isinstance(gripper, NativeTwoFingerGripper):
            yield f"robot '{name}': its gripper '{gripper.kind}' is not controlled by the simulator"
    if episodes.run.request.steps_per_tick % FEEDFORWARD_STEPS:
        yield f"a tick has to be a multiple of {FEEDFORWARD_STEPS} control steps"
    for condition in episodes.run.tree.goal:
        if condition.memory:
            yield f"the condition '{condition.registration}' of the goal has a memory"
    native = (ControllerManager, NativeTwoFingerGripper)
    for entity in episodes.station.cell.arena.iter_entities():
        if not isinstance(entity, native) and any(
            getattr(type(entity), hook) is not getattr(composer.Entity, hook)
            for hook in ("before_substep", "after_substep")
        ):
            yield f"'{entity.mjcf_model.model}' acts in control steps"


def _bytes_of(model: mujoco.MjModel) -> bytes:
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()
