"""Contract of kinds of actions: an environment continues from its own state bit for bit."""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bt_manip.bt import Node
from bt_manip.registry import Parts
from bt_manip.runner import prepare, request_of
from bt_manip.spatial import pose
from bt_manip.testing import Check

from .agents import without_progress
from .envs import LearningTask

Moment = Callable[[LearningTask, np.random.Generator], bool]

AGENT_STEPS = 3  # of an agent after each restored state
EXPERT_STEPS = 400  # of the expert until a gripper holds an object


@dataclass(frozen=True)
class EnvironmentCase:
    """Environments of a tree with a kind of actions.

    Attributes:
        action: Name of the kind of actions.
        parts: The registered parts.
        tree: The tree, as in ``bt-manip run``.
        options: Fields of `bt_manip.runner.RunRequest`.
    """

    action: str
    parts: Parts
    tree: str = "pick_place"
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def goal(self) -> Sequence[Node]:
        """The conditions of the tree's goal."""
        return prepare(request_of(self.tree, self.parts, **self.options), self.parts).tree.goal

    def make(self) -> LearningTask:
        """Return a new environment, in a station of its own; with the dense reward if possible."""
        reward = "sparse" if without_progress(self.goal) else "dense"
        return LearningTask(
            self.tree, action=self.action, reward=reward, parts=self.parts, **self.options
        )


def describes_its_actions(case: EnvironmentCase) -> None:
    """Check that bounds are finite, and that each number has a name and a unit."""
    space = case.make().action.space
    assert space.low.shape == space.high.shape == (len(space.names),) == (len(space.units),), (
        f"'{case.action}' has {space.low.shape} bounds, {len(space.names)} names and "
        f"{len(space.units)} units"
    )
    assert np.isfinite([space.low, space.high]).all() and (space.low <= space.high).all(), (
        f"'{case.action}' has the bounds {space.low} and {space.high}"
    )


def goes_on_from_its_state(case: EnvironmentCase) -> None:
    """Check that an environment, and another one, continue from states, bit for bit.

    The states are those of `MOMENTS`; each is restored after another episode. Trees without a goal
    have no environments.
    """
    if not case.goal:
        return
    task, other = case.make(), case.make()
    for number, moment in enumerate(MOMENTS):
        rng = np.random.default_rng(number)
        task.reset(0, number)
        if not moment(task, rng):
            continue
        state = json.dumps(task.get_state())
        actions = [_action(task, rng) for _ in range(AGENT_STEPS)]
        expected = [_step(task, action) for action in actions]
        task.reset(1)
        task.step(actions[0])
        for which, one in (("the same", task), ("another", other)):
            one.set_state(json.loads(state))
            found = [_step(one, action) for action in actions]
            what = moment.__name__.strip("_").replace("_", " ")
            assert found == expected, (
                f"'{case.action}': {which} environment of '{case.tree}' continues differently from "
                f"its state {what}"
            )


def has_the_same_episodes_in_any_order(case: EnvironmentCase) -> None:
    """Check that episodes in two orders, in environments of their own, have the same bits."""
    numbers = range(2)

    def steps(task: LearningTask, number: int) -> list[str]:
        rng = np.random.default_rng(number)
        task.reset(0, number)
        return [_digest(task), *(_step(task, _action(task, rng)) for _ in range(AGENT_STEPS))]

    forth, back = case.make(), case.make()
    expected = {number: steps(forth, number) for number in numbers}
    found = {number: steps(back, number) for number in reversed(numbers)}
    for number in numbers:
        assert found[number] == expected[number], (
            f"'{case.action}': episode {number} of '{case.tree}' depends on those before it"
        )


ACTION_CONTRACT: tuple[Callable[[EnvironmentCase], None], ...] = (
    describes_its_actions,
    goes_on_from_its_state,
    has_the_same_episodes_in_any_order,
)
"""Checks of the contract; each raises `AssertionError` if it fails."""


def environment_checks(
    parts: Parts,
    provides: Mapping[str, tuple[str, ...]],
    settings: Mapping[str, Mapping[str, Any]],
) -> Iterator[Check]:
    """Yield the checks of a plugin's kinds of actions, and of environments of its trees.

    Args:
        parts: All registered parts.
        provides: Names of the plugin's parts, by kind.
        settings: Values of the keys of trees, by name.
    """

    def make(check: Callable[[EnvironmentCase], None], case: EnvironmentCase) -> Any:
        return lambda situations: check(case)

    for name in provides.get("actions", ()):
        for check in ACTION_CONTRACT:
            title = check.__name__.replace("_", " ")
            yield Check(f"{name}: {title}", make(check, EnvironmentCase(name, parts)))
    for name in provides.get("trees", ()):
        options = {"settings": {key: str(value) for key, value in settings.get(name, {}).items()}}
        for action in parts.of("actions"):
            case = EnvironmentCase(action, parts, name, options)
            title = f"tree {name}: environments go on from their states with {action}"
            yield Check(title, make(goes_on_from_its_state, case), long=True)


def _while_an_object_is_held(task: LearningTask, rng: np.random.Generator) -> bool:
    grippers = [one.gripper for one in task.episodes.station.robots.values() if one.gripper]
    for _ in range(EXPERT_STEPS):
        if any(gripper.held for gripper in grippers):
            return True
        task.episodes.expert_step()
    return False


def _after_actions_with_a_held_object(task: LearningTask, rng: np.random.Generator) -> bool:
    held = _while_an_object_is_held(task, rng)
    return held and _after_actions(task, rng)


def _after_objects_were_added_and_removed(task: LearningTask, rng: np.random.Generator) -> bool:
    station = task.episodes.station
    removed = set(_free_objects(task)[:1])
    station.cell.add(station.models.create("cube"), pose((0.0, 3.0, 0.1)), name="contract_cube")
    task.step(_action(task, rng))
    for name in station.cell.entities.keys() & removed:  # unless the tree has removed it
        station.cell.remove(name)
    return _after_actions(task, rng)


def _after_an_object_was_lost(task: LearningTask, rng: np.random.Generator) -> bool:
    for name in _free_objects(task)[:1]:
        task.episodes.station.cell.move(name, pose((0.0, 3.0, 0.1)), overlap=1.0)
        return _after_actions(task, rng)
    return False


def _at_the_start_of_an_episode(task: LearningTask, rng: np.random.Generator) -> bool:
    return True


def _after_actions(task: LearningTask, rng: np.random.Generator) -> bool:
    for _ in range(AGENT_STEPS):
        task.step(_action(task, rng))
    return True


MOMENTS: tuple[Moment, ...] = (
    _after_actions_with_a_held_object,
    _while_an_object_is_held,
    _after_objects_were_added_and_removed,
    _after_an_object_was_lost,
    _at_the_start_of_an_episode,
    _after_actions,
)
"""Bring an environment to a moment of its episode; return whether there is such a moment."""


def _free_objects(task: LearningTask) -> list[str]:
    cell = task.episodes.station.cell
    return [name for name in cell.objects if cell.is_free(name)]


def _action(task: LearningTask, rng: np.random.Generator) -> Any:
    space = task.action.space
    return rng.integers(len(space.choices)) if space.choices else rng.uniform(space.low, space.high)


def _step(task: LearningTask, action: Any) -> str:
    return f"{task.step(action)} {_digest(task)}"


def _digest(task: LearningTask) -> str:
    digest = hashlib.sha256(task.episodes.station.cell.state_bytes())
    for name, values in task.observe().items():
        digest.update(name.encode() + values.tobytes())
    digest.update(json.dumps(task.get_state(), sort_keys=True).encode())
    return digest.hexdigest()
