"""The return of the expert under the dense reward, beside ways to stall before the goal.

`python -m benchmarks rewards` prints both, with and without discount.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from bt_manip.plugins import load_plugins
from bt_manip_learn.envs import LearningTask

STEPS = 300
"""Steps of an episode that stalls, after those of the expert: it is cut there."""

Act = Callable[[LearningTask, int, np.ndarray], Any]


def hold(task: LearningTask, step: int, held: np.ndarray) -> Any:
    """Stay where the expert was left."""
    return held


def shake(task: LearningTask, step: int, held: np.ndarray) -> Any:
    """Go back and forth about where the expert was left, with what the gripper holds."""
    return _beside(task, held, 0.2 if step // 10 % 2 else -0.2)


def retreat(task: LearningTask, step: int, held: np.ndarray) -> Any:
    """Go away from where the expert was left and come back, again and again."""
    return _beside(task, held, 0.6 if step // 20 % 2 else 0.0)


def flail(task: LearningTask, step: int, held: np.ndarray) -> Any:
    """Act at random."""
    space = task.action.space
    return np.random.default_rng(step).uniform(space.low, space.high)


STALLING: dict[str, tuple[float | None, Act]] = {
    "does nothing": (0.0, hold),
    "stops halfway": (0.5, hold),
    "keeps hold": (None, hold),
    "stops before the end": (0.9, hold),
    "shakes": (None, shake),
    "leaves and returns": (0.7, retreat),
    "acts at random": (0.0, flail),
}
"""Ways to stall: the share of the expert's steps before it, and what is done then.

None: ten less than after which an object is last held, or four fifths where none is.
"""


def returns(tree: str, seed: int = 0) -> dict[str, tuple[float, float]]:
    """Return the sums of rewards of the expert and of each way to stall, without and with discount.

    Raises:
        BtManipError: If the tree is no environment.
    """
    task = LearningTask(tree, reward="dense", parts=load_plugins().parts)
    held_at: list[int] = []
    rewards, success = _expert(task, seed, 10**9, held_at)
    assert success, f"the expert of {tree} failed"
    found = {"expert": _sums(rewards)}
    last = len(rewards) - 1  # the step before which the goal does not hold
    holding = max(held_at[-1] - 10, 0) if held_at else int(0.8 * last)
    for name, (share, act) in STALLING.items():
        rewards, _ = _expert(task, seed, holding if share is None else int(share * last), [])
        held = task.action.recorded()
        for step in range(STEPS):
            outcome = task.step(act(task, step, held))
            rewards.append(outcome.reward)
            if outcome.success or outcome.failure:
                break
        if not outcome.success:  # where things fall into place alone, it did not stall
            found[name] = _sums(rewards)
    return found


def rows() -> list[tuple[str, str, str]]:
    """Give the figures: what, how much, beside what."""
    found = []
    for tree in tasks():
        for name, (plain, discounted) in returns(tree).items():
            found.append((f"{tree}: {name}", f"{plain:.2f}", f"{discounted:.2f} discounted"))
    return found


def tasks() -> list[str]:
    """Return the trees that are environments without settings."""
    import gymnasium

    from bt_manip_learn.envs import environment_id

    return [t for t in load_plugins().parts.trees if environment_id(t) in gymnasium.registry]


def _expert(
    task: LearningTask, seed: int, steps: int, held_at: list[int]
) -> tuple[list[float], bool]:
    """Let the expert make at most this many steps; return the rewards, and whether it succeeded.

    ``held_at`` gets the numbers of steps after which a gripper holds an object.
    """
    task.reset(seed)
    rewards: list[float] = []
    success = False
    while len(rewards) < steps and not success and task.episodes.status.name == "RUNNING":
        outcome = task.expert_step()
        rewards.append(outcome.reward)
        success = outcome.success
        robots = task.episodes.station.robots.values()
        if any(one.gripper is not None and one.gripper.held for one in robots):
            held_at.append(len(rewards))
    return rewards, success


def _beside(task: LearningTask, held: np.ndarray, angle: float) -> np.ndarray:
    """Return the action with the first joint of each arm turned [rad]."""
    names = task.action.space.names
    first = [i for i in range(len(names)) if i == 0 or names[i - 1].endswith("_gripper")]
    moved = held.copy()
    moved[first] += angle
    return moved


def _sums(rewards: list[float]) -> tuple[float, float]:
    discounted = sum(0.99**i * reward for i, reward in enumerate(rewards))
    return float(sum(rewards)), float(discounted)
