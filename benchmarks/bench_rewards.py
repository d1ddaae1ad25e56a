"""Progress and return of the expert under the dense reward, beside ways that do not finish.

``python -m benchmarks rewards`` prints the returns; ``python -m benchmarks.bench_rewards
docs/images/rewards.svg`` draws the progress of all tasks over time.
"""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bt_manip.bt import texts_of
from bt_manip.plugins import load_plugins
from bt_manip.spatial import pose
from bt_manip_learn.envs import LearningTask

STEPS = 60
"""Steps of 50 ms of an agent in place of the expert."""

NEARLY = 0.85
"""Largest progress of an agent that keeps holding an object: beyond, it would fall into place."""

COLOURS = {
    "expert": "#1b7837", "holds": "#4393c3", "hovers": "#9970ab", "waits": "#636363",
    "presses": "#e08214", "random": "#bf812d", "knocks off": "#d6604d",
}  # fmt: skip
"""Ways to act, with their colours: the expert; an agent that stays where the expert last holds an
object, just before it grasps one, or at the start; that presses down there; that acts at random;
and that throws an object of the goal from the table."""


class Curve(NamedTuple):
    """One episode, or the part of it that was made.

    Attributes:
        start: Number of its first step.
        progress: Progress at its start and after each step.
        reward: Sum of all rewards, those of the expert before its first step included.
    """

    start: int
    progress: list[float]
    reward: float


def curves(tree: str, seed: int = 0) -> dict[str, Curve]:
    """Return the curves of a task by the names of `COLOURS`; without those that it does not have.

    Raises:
        BtManipError: If the tree is no environment.
    """
    task = LearningTask(tree, reward="dense", action="cartesian_deltas")
    task.reset(seed)
    moments = [_Moment(task, 0, 0.0)]
    last: _Moment | None = None
    progress, total, held, ended = [task.progress], 0.0, False, False
    while not ended:
        outcome = task.expert_step()
        progress.append(task.progress)
        total += outcome.reward
        ended = outcome.success or bool(outcome.failure) or len(progress) > 1200
        robots = task.episodes.station.robots.values()
        holds = any(one.gripper is not None and one.gripper.held for one in robots)
        held = held or holds
        if len(progress) % 8 == 0 and not held:
            moments.append(_Moment(task, len(progress) - 1, total))
        if len(progress) % 4 == 0 and holds and task.progress < NEARLY:
            last = _Moment(task, len(progress) - 1, total)
    assert outcome.success, f"the expert of {tree} failed: {outcome.failure}"
    found = {"expert": Curve(0, progress, total)}
    if last is not None:
        found["holds"] = last.go_on(_stay)
    start, before = moments[0], moments[-2:][0]  # the last one may be within the grasp
    rng = np.random.default_rng(seed)
    found |= {
        "hovers": before.go_on(_stay),
        "waits": start.go_on(_stay),
        "presses": before.go_on(_press),
        "random": start.go_on(lambda one: rng.uniform(one.action.space.low, one.action.space.high)),
    }
    if any(task.episodes.station.cell.is_free(name) for name in _objects(task)):
        found["knocks off"] = before.go_on(_knock_off)
    return found


class _Moment:
    """A moment of an episode, from which an agent can go on."""

    def __init__(self, task: LearningTask, step: int, reward: float) -> None:
        self._task, self._step, self._reward = task, step, reward
        self._state = task.get_state()

    def go_on(self, act: Callable[[LearningTask], Any]) -> Curve:
        """Return the curve of an agent from here."""
        task, total = self._task, self._reward
        task.set_state(self._state)
        progress = [task.progress]
        for _ in range(STEPS):
            outcome = task.step(act(task))
            progress.append(task.progress)
            total += outcome.reward
            if outcome.success or outcome.failure:
                break
        return Curve(self._step, progress, total)


def _stay(task: LearningTask) -> np.ndarray:
    """Keep the tools where they are, and the grippers as they are."""
    action = np.zeros(task.action.space.shape)
    robots = task.episodes.station.robots.values()
    grips = [one.gripper.gripping for one in robots if one.gripper is not None]
    action[_places(task, "gripper")] = np.where(grips, 1.0, -1.0)
    return action


def _press(task: LearningTask) -> np.ndarray:
    """Move the tools down at 0.2 m/s."""
    action = _stay(task)
    action[_places(task, "z")] = -0.2 * task.episodes.step_time
    return action


def _knock_off(task: LearningTask) -> np.ndarray:
    """Throw an object of the goal from the table, then stay."""
    cell = task.episodes.station.cell
    name = next(name for name in _objects(task) if cell.is_free(name))
    if task.episodes.station.cell.pose(name).translation[1] < 2.0:
        cell.move(name, pose((0.0, 3.0, 0.05)), overlap=1.0)
    return _stay(task)


def _objects(task: LearningTask) -> Iterator[str]:
    """Yield the free objects that the goal names, or all."""
    cell = task.episodes.station.cell
    named = [text for one in task.episodes.run.tree.goal for text in texts_of(one)]
    free = [name for name in cell.objects if cell.is_free(name)]
    yield from [name for name in free if name in named] or free


def _places(task: LearningTask, value: str) -> list[int]:
    return [i for i, name in enumerate(task.action.space.names) if name.endswith(f"_{value}")]


def tasks() -> list[str]:
    """Return the trees that are environments without settings."""
    import gymnasium

    from bt_manip_learn.envs import environment_id

    return [t for t in load_plugins().parts.trees if environment_id(t) in gymnasium.registry]


def rows() -> list[tuple[str, str, str]]:
    """Give the figures: what, how much, beside what."""
    return [
        (f"{tree}: {name}", f"return {one.reward:.2f}", f"progress {one.progress[-1]:.2f}")
        for tree in tasks()
        for name, one in curves(tree).items()
    ]


def draw(found: dict[str, dict[str, Curve]], columns: int = 5) -> str:
    """Return the progress of tasks over time as an SVG image."""
    width, height, gap, top = 150, 90, 32, 40
    rows = -(-len(found) // columns)
    size = columns * (width + gap) + gap, rows * (height + gap + 10) + top
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]} {size[1]}" '
        'font-family="sans-serif" font-size="10">',
        f'<rect width="{size[0]}" height="{size[1]}" fill="white"/>',
    ]
    for i, (name, colour) in enumerate(COLOURS.items()):
        x = gap + 95 * i
        parts.append(f'<path d="M{x} 12h18" stroke="{colour}" stroke-width="2"/>')
        parts.append(f'<text x="{x + 22}" y="16">{name}</text>')
    for i, (tree, ways) in enumerate(found.items()):
        x, y = gap + i % columns * (width + gap), top + i // columns * (height + gap + 10)
        longest = max(one.start + len(one.progress) for one in ways.values())
        parts += [
            f'<rect x="{x}" y="{y}" width="{width}" height="{height}" fill="none" stroke="#bbb"/>',
            f'<text x="{x}" y="{y - 4}">{tree}</text>',
            f'<text x="{x - 3}" y="{y + 8}" text-anchor="end">1</text>',
            f'<text x="{x - 3}" y="{y + height}" text-anchor="end">0</text>',
            f'<text x="{x + width}" y="{y + height + 12}" text-anchor="end">'
            f"{0.05 * longest:.1f} s</text>",
        ]
        for name, one in reversed(ways.items()):
            points = " ".join(
                f"{x + width * (one.start + k) / longest:.1f},{y + height * (1 - value):.1f}"
                for k, value in enumerate(one.progress)
            )
            parts.append(
                f'<polyline points="{points}" fill="none" stroke="{COLOURS[name]}" '
                'stroke-width="1.5"/>'
            )
    return "\n".join([*parts, "</svg>\n"])


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(draw({tree: curves(tree) for tree in tasks()}))
