"""Check before a run whether a robot can do a task."""

import contextlib
from typing import TYPE_CHECKING

from bt_manip.behaviours import ArmBehaviour, CellBehaviour
from bt_manip.bt import NodeStatus
from bt_manip.exceptions import BtManipError, PortError, one_line
from bt_manip.registry import Parts
from bt_manip.robots import RobotDescription
from bt_manip.runner import EPISODE_TIMEOUT, Run, RunObserver, prepare, request_of

if TYPE_CHECKING:
    from bt_manip.bt.nodes import TreeNode

STARTS = 3
"""Number of sampled starts of a task."""

_PATIENCE = 5.0  # [s] longest simulated time until the first motion: objects settle first


def why_not(
    task: str, robot: str | RobotDescription, parts: Parts, starts: int = STARTS, episodes: int = 0
) -> str:
    """Return why a robot cannot do a task; empty if no obstacle is found.

    Starts of the scene are sampled within reach of the robot. From each, the tree is ticked until
    an arm begins to move, which includes planning the first grasp; then each behaviour is asked by
    `CellBehaviour.why_infeasible`. No motion is executed: physical failures, such as a grip that
    does not come to rest, are found by `episodes`.

    Args:
        task: Name of a registered tree, or its path.
        robot: Name of a registered robot, or a description or its path.
        parts: The registered parts.
        starts: Number of starts.
        episodes: Number of whole episodes to run afterwards.
    """
    try:
        run = prepare(request_of(task, parts, robot=robot), parts)
        for start in range(starts):
            run.begin_episode(start)
            reason = _why_not_from_here(run)
            if reason:
                return reason
        for episode in range(episodes):
            run.begin_episode(starts + episode)
            reason = _why_it_fails(run)
            if reason:
                return f"episode {episode + 1} of {episodes}: {reason}"
    except BtManipError as error:
        return one_line(error)
    return ""


def _why_not_from_here(run: Run) -> str:
    """Return why a run fails, as far as known when its first motion begins."""
    cell, watch = run.station.cell, _Watch()
    end = cell.time + _PATIENCE

    def begins() -> bool:
        moving = any(one.arm.moving for one in run.station.robots.values())
        if moving:
            watch.moves = [n for n in run.tree if n.engine_status is NodeStatus.RUNNING]
        return moving or cell.time > end

    run.execute([watch], stop=begins)
    # A motion of another kind is the recovery from the failure.
    recovers = watch.failed and not any(type(n) is type(watch.failed[0]) for n in watch.moves)
    if watch.failed and recovers:
        return watch.failed[1]
    if not watch.moves:
        return watch.reason or "no motion begins"
    for node in run.tree:
        if isinstance(node, CellBehaviour):
            with contextlib.suppress(PortError):  # its entry is written later
                reason = node.why_infeasible()
                if reason:
                    return f"{node.name}: {reason}"
    return ""


def _why_it_fails(run: Run) -> str:
    """Run an episode; return why it fails, empty on success."""
    watch, cell = _Watch(), run.station.cell
    end = cell.time + EPISODE_TIMEOUT
    run.execute([watch], stop=lambda: cell.time > end)
    if watch.succeeded:
        return ""
    return (
        watch.failed[1] if watch.failed else watch.reason or f"no end within {EPISODE_TIMEOUT:g} s"
    )


class _Watch(RunObserver):
    """Stores the first failure of an arm behaviour, and which nodes ran at the first motion."""

    def __init__(self) -> None:
        self.failed: tuple[TreeNode, str] | None = None
        self.moves: list[TreeNode] = []
        self.reason, self.succeeded = "", False

    def run_started(self, run: Run) -> None:
        """Observe the nodes of the tree."""
        run.tree.observers.append(self._node_changed)

    def cycle_ended(self, status: str, reason: str) -> None:
        self.reason, self.succeeded = reason, status == NodeStatus.SUCCESS.name

    def _node_changed(self, node: "TreeNode", old: NodeStatus, new: NodeStatus) -> None:
        failed = new is NodeStatus.FAILURE and isinstance(node, ArmBehaviour)
        if failed and self.failed is None:
            self.failed = node, f"{node.name}: {node.feedback_message}"
