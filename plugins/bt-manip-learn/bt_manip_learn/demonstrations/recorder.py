"""Recording of a tree as the expert, at the rate of an environment."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.bt import NodeStatus
from bt_manip.exceptions import ANY_BUT_INTERRUPT, reason_of
from bt_manip.plugins import load_plugins
from bt_manip.record import cpu_name, identify, versions
from bt_manip.runner import next_digest, request_of
from bt_manip_learn.agents import STEP, Episodes, Images, Observations, action_kind

from .store import Demonstration, DemonstrationStore

MAX_EPISODE_STEPS = 1200
"""Steps after which an episode fails: 60 s; a pick and place takes 80 steps."""

SETTLING_STEPS = 5
"""Steps for which the goal holds before an episode ends, so that a replay has time to reach it."""

ACTION_KINDS = ("joint_targets", "cartesian_deltas")
"""Recorded kinds of actions."""

PARTS = ("robot", "controller", "planner")
"""Parts of the request; a scene may name others for its robots."""


class DemonstrationRecorder:
    """Records episodes of a tree in this process.

    The tree is ticked once per environment step, at its start: commands then begin when actions do,
    so that the recorded actions reproduce them.

    Args:
        tree: The tree, as in ``bt-manip run``.
        choice: The `bt_manip.plugins.PluginSelection`; None: that of the environment.
        cameras: Cameras whose images are recorded.
        size: Width and height of the images [pixels].
        vary: Parameters of ``bt-manip run --vary``, by name.
        **options: Fields of `bt_manip.runner.RunRequest`; None: the default.

    Attributes:
        folder: The folder of the `DemonstrationStore`.
        failures: Whether to keep the steps of failed episodes.
        episodes: The episodes.

    Raises:
        BtManipError: If the request is invalid.
    """

    def __init__(
        self,
        folder: Path,
        tree: str,
        *,
        choice: Any = None,
        cameras: Sequence[str] = (),
        size: tuple[int, int] = (128, 128),
        failures: bool = False,
        vary: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> None:
        parts = load_plugins(choice=choice, warn=lambda message: None).parts
        request = request_of(tree, parts, tick=STEP, varied=vary, **options)
        self.folder, self.failures = folder, failures
        self._images = Images(("rgb",) if cameras else (), tuple(cameras), *size)
        self.episodes = Episodes(request, parts)
        self._run = self.episodes.run
        self._actions = [action_kind(name, self.episodes) for name in ACTION_KINDS]
        self._store: DemonstrationStore | None = None
        nodes = self._run.tree.nodes
        self._leaves = {i: node.path for i, node in enumerate(nodes) if not node.child_nodes}

    def identity(self) -> dict[str, Any]:
        """Return the specification of the demonstrations, as plain data.

        Raises:
            BtManipError: If the first episode does not start.
        """
        request = self._run.request
        self.episodes.reset(request.seed)
        observations = self._observations()
        return {
            "tree": request.tree.name,
            "task": self._run.tree.task,
            "seed": request.seed,
            **identify(self._run),
            "request": {key: str(getattr(request, key)) for key in PARTS},
            "versions": versions(),
            "cpu": cpu_name(),
            "failures": self.failures,
            "step_s": STEP,
            "images": self._images._asdict(),
            "observations": {name: one._asdict() for name, one in observations.specs.items()},
            "actions": {
                one.kind: {
                    "names": one.space.names,
                    "units": one.space.units,
                    "low": one.space.low.tolist(),
                    "high": one.space.high.tolist(),
                }
                for one in self._actions
            },
            "nodes": [node.path for node in self._run.tree.nodes],
        }

    def run(self, episode: int) -> None:
        """Run an episode and write its file; an exception becomes the reason of a failure.

        Raises:
            BtManipError: If the folder is of another identity, such as that of a tree edited since.
        """
        if self._store is None:
            self._store = DemonstrationStore.create(self.folder, self.identity())
        try:
            demonstration = self.record(episode)
        except ANY_BUT_INTERRUPT as error:
            demonstration = Demonstration(episode, False, reason_of(error))
        if not (demonstration.success or self.failures):
            demonstration = Demonstration(episode, False, demonstration.reason)
        self._store.write(demonstration)

    def record(self, episode: int) -> Demonstration:
        """Run an episode and return it.

        Raises:
            BtManipError: If it does not start, or a node raises.
            PhysicsDiverged: If the physics diverges.
        """
        episodes, tree, cell = self.episodes, self._run.tree, self.episodes.station.cell
        episodes.reset(episodes.seed, episode)
        observations = self._observations()
        observed, states = [observations.read()], [cell.state_bytes()]
        actions = defaultdict(list)
        statuses: list[bytes] = []
        digest, ended, held = b"", False, 0
        try:
            while not ended:
                for one in self._actions:
                    one.watch()
                episodes.expert_step()
                for one in self._actions:
                    actions[one.kind].append(one.recorded())
                statuses.append(tree.statuses())
                observed.append(observations.read())
                states.append(cell.state_bytes())
                digest = next_digest(digest, states[-1], statuses[-1])
                success = episodes.success
                held = held + 1 if success else 0
                going = success or episodes.status is NodeStatus.RUNNING
                ended = held > SETTLING_STEPS or not going or episodes.steps >= MAX_EPISODE_STEPS
        finally:
            observations.close()
        rows = np.array([np.frombuffer(one, dtype=np.uint8) for one in statuses])
        last = np.arange(len(rows)) == len(rows) - 1
        return Demonstration(
            episode,
            success,
            "" if success else self._why_not(),
            digest.hex(),
            {name: np.array([one[name] for one in observed]) for name in observed[0]},
            {kind: np.array(numbers) for kind, numbers in actions.items()},
            (last & success).astype(np.float32),
            last,
            same_length(states),
            tuple(self._running(row) for row in rows),
            rows,
            tree.task,
        )

    def _observations(self) -> Observations:
        station = self.episodes.station
        return Observations(station.cell, station.robots, self._images)

    def _why_not(self) -> str:
        if self.episodes.status is NodeStatus.RUNNING:
            return f"no end within {MAX_EPISODE_STEPS * STEP:g} s simulated"
        return self._run.tree.failure_reason() or self._run.goal.why_not()

    def _running(self, statuses: np.ndarray) -> str:
        """Return the paths of the running leaves."""
        running = NodeStatus.RUNNING
        return "; ".join(path for i, path in self._leaves.items() if statuses[i] == running)


def same_length(states: list[bytes]) -> np.ndarray:
    """Return states as rows; shorter ones, with fewer objects, are padded with NaN."""
    rows = [np.frombuffer(state) for state in states]
    size = max(map(len, rows))
    filled = np.full((len(rows), size), np.nan)
    for row, state in zip(filled, rows, strict=True):
        row[: len(state)] = state
    return filled
