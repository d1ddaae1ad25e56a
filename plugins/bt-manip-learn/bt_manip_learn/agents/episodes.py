"""Episodes of a tree in a station: reset, steps of the expert or an agent, success."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.bt import NodeStatus
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.runner import Run, RunLoop, RunObserver, RunRequest, prepare

from .references import MAX_LAG

if TYPE_CHECKING:
    from .actions import ActionKind

STEP = 0.05
"""Default time between two actions [s]."""

START_TIMEOUT = 10.0
"""Longest simulated time until the first command of the tree to a robot [s]."""

MakeObservers = Callable[[Run, int], Sequence[RunObserver]]


class Episodes:
    """Runs episodes of a tree, one after the other, in one station.

    An episode depends only on its seed and number, as in ``bt-manip run --seed S --episode N``.
    After `reset` the tree has just commanded a robot for the first time; earlier actions, such as
    adding objects, are complete. Then the tree continues as the expert (`expert_step`), or an agent
    acts in its place (`agent_step`). The expert can take over again at any step: its tree starts
    again behind the leaves that have added and removed objects, so that its conditions skip what is
    done. A tree that succeeds without commanding a robot is no expert.

    Observers see an episode as one cycle of a run, from `reset` to `finish`, the next `reset`,
    `set_state` or `close`.

    Args:
        request: Tree, scene, robot and the other fields of a run.

    Attributes:
        run: The run, whose request has the seed of the episode.
        parts: The registered parts.
        station: The station.
        step_time: Duration of a step of the expert or of an agent [s].
        seed: Seed of the episode.
        episode: Number of the episode.
        steps: Number of steps made in the episode.
        ticks: Number of ticks in a step.
        gripped: For each gripper commanded in the last step of the expert, the tick of the command,
            by the name of its robot.
        status: Status of the tree; RUNNING until it ends.
        ended: Whether `finish` has ended the episode for its observers.
        make_observers: Makes the observers of an episode from the run and the episode's number.

    Raises:
        BtManipError: If the request is invalid.
    """

    def __init__(self, request: RunRequest, parts: Parts, *, step_time: float = STEP) -> None:
        self.ticks = round(step_time / request.tick)
        if self.ticks < 1 or abs(step_time / request.tick - self.ticks) > 1e-6:
            raise BtManipError(
                f"a step takes a whole number of ticks of {1e3 * request.tick:g} ms, "
                f"got {1e3 * step_time:g} ms"
            )
        self.run, self.parts = prepare(request, parts), parts
        self.station, self.step_time = self.run.station, step_time
        self.seed, self.episode, self.steps = request.seed, 0, 0
        self.status = NodeStatus.IDLE
        self.make_observers: MakeObservers = lambda run, episode: ()
        self._loop = RunLoop(self.run)
        self._ticked = self.ended = False
        self._again: dict[str, Any] | None = None  # state in which the tree starts again
        self._took_over = False  # since the start of the episode
        self.gripped: dict[str, int] = {}
        self._gripping = self._read_gripping()

    def reset(self, seed: int, episode: int = 0) -> None:
        """Start an episode: tick the tree until it commands a robot.

        Args:
            seed: Seed of the episode.
            episode: Number of the episode.

        Raises:
            BtManipError: If the scene cannot be randomized with this seed, or the tree fails before
                it commands a robot, or commands none within `START_TIMEOUT`.
        """
        self._begin(seed, episode)
        self._open(self.make_observers(self.run, episode))
        self._loop.begin(episode)
        set_up = SetUp(self.run)
        self._tick_until_commanded()
        self._again = set_up.state_behind() if self._ticked else None

    def _tick_until_commanded(self) -> None:
        """Tick the tree until it has commanded a robot, or has nothing to do."""
        while True:
            self.status = self._loop.tick()
            if self.status is NodeStatus.FAILURE:
                reason = self.run.tree.failure_reason()
                raise BtManipError(f"the tree failed before it commanded a robot: {reason}")
            if self.status is NodeStatus.SUCCESS:
                self.status = NodeStatus.IDLE
                return
            if self._commanded():
                self._ticked = True
                return
            if self.station.cell.time > START_TIMEOUT:
                raise BtManipError(f"the tree commanded no robot within {START_TIMEOUT:g} s")
            self._loop.step()

    def expert_step(self) -> None:
        """Make one step in which the tree acts, until its goal holds or it has ended.

        Raises:
            BtManipError: If it cannot take over from an agent, or has failed after it did.
        """
        self.gripped = {}
        if self.status is NodeStatus.IDLE and not self.success:
            self._take_over()
        for i in range(self.ticks):
            if not self._ticked:
                self._loop.tick(self)
            self._ticked = False
            gripping = self._read_gripping()
            changed = [name for name in gripping if gripping[name] != self._gripping[name]]
            self.gripped |= dict.fromkeys(changed, i)
            self._gripping = gripping
            self._loop.step()
        self.steps += 1
        if self._took_over and self.status is NodeStatus.FAILURE:
            self._took_over = False
            reason = self.run.tree.failure_reason()
            raise BtManipError(f"the expert cannot go on from the actions of the agent: {reason}")

    def tick(self) -> NodeStatus:
        """Act as the expert at a tick: tick the tree unless its goal holds, or it has ended."""
        if self.status is NodeStatus.RUNNING and not self.success:
            self.status = self.run.tree.tick()
        return self.status

    def agent_step(self, agent: "ActionKind") -> None:
        """Make one step in which an agent acts in place of the tree, which is halted first.

        Args:
            agent: Acts at each tick.
        """
        self.release()
        for _ in range(self.ticks):
            self._loop.advance(agent)
        self.steps += 1

    def release(self) -> None:
        """Halt the tree, so that an agent can act in its place."""
        if self.status is NodeStatus.RUNNING:
            self.run.tree.halt()
            self.status = NodeStatus.IDLE

    def finish(self, reason: str = "") -> None:
        """End the episode for its observers; the simulation can continue without them.

        Args:
            reason: Reason of a failure; empty on success.
        """
        self._loop.end(NodeStatus.FAILURE if reason else NodeStatus.SUCCESS, reason)
        self.ended = True
        self._open()

    def close(self) -> None:
        """Close the observers; an unfinished episode remains without an end."""
        self._loop.close()

    @property
    def success(self) -> bool:
        """Whether the goal of the tree holds; without a goal, whether the tree has succeeded."""
        if not self.run.tree.goal:
            return self.status is NodeStatus.SUCCESS
        return not self.run.goal.why_not()

    def get_state(self) -> dict[str, Any]:
        """Return the state of the episode as plain data."""
        return {
            "run": self.run.get_state(),
            "episode": [self.seed, self.episode],
            "steps": self.steps,
            "status": self.status.name,
            "ticked": self._ticked,
            "ended": self.ended,
            "again": self._again,
            "took_over": self._took_over,
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore a state of `get_state`, also in another process; close the observers."""
        self._begin(*state["episode"])
        self.run.set_state(state["run"])
        self._open()
        self.steps, self._ticked, self.ended = state["steps"], state["ticked"], state["ended"]
        if not self.ended:
            self._loop.begin(self.episode, in_place=True)
        self.status, self._again = NodeStatus[state["status"]], state["again"]
        self._took_over = state["took_over"]
        self._gripping = self._read_gripping()

    # Internal

    def _take_over(self) -> None:
        """Let the tree start again, and let the robots follow their arms from where they are."""
        if self._again is None:
            raise BtManipError(
                "the expert cannot take over: its tree commands no robot, or adds or removes "
                "objects beside other actions"
            )
        for one in self.station.robots.values():
            reference, q = one.controllers.reference, one.robot.q
            if reference is one.arm:
                continue
            if np.abs(reference.q - q).max() < MAX_LAG and not one.arm.fault:
                q = reference.q.copy()
            one.arm.reset(q.clip(one.arm.model.limits.lower, one.arm.model.limits.upper))
            one.arm.payload = reference.payload
            one.controllers.activate(one.controllers.default)
            one.controllers.reference = one.arm
        self.run.tree.set_state(self._again)
        self.status, self._took_over = NodeStatus.RUNNING, True

    def _begin(self, seed: int, episode: int) -> None:
        """Return to the state before the first tick of an episode."""
        self._loop.close()
        self.run.begin_episode(episode, seed)
        self.seed, self.episode, self.steps = seed, episode, 0
        self.status, self._ticked, self.ended = NodeStatus.IDLE, False, False
        self._took_over = False
        self._gripping = self._read_gripping()

    def _open(self, observers: Sequence[RunObserver] = ()) -> None:
        """Close the previous loop and open a new one."""
        self._loop.close()
        self._loop = RunLoop(self.run, observers)
        self._loop.open()

    def _read_gripping(self) -> dict[str, bool]:
        robots = self.station.robots.items()
        return {name: one.gripper.gripping for name, one in robots if one.gripper is not None}

    def _commanded(self) -> bool:
        """Return whether the tree has commanded a robot."""
        return any(
            one.arm.busy
            or one.controllers.active != one.controllers.default
            or (one.gripper is not None and one.gripper.moving)
            for one in self.station.robots.values()
        )


class SetUp:
    """Finds the leaves that change which objects there are, while a tree starts.

    A leaf is one of them if objects were added or removed, or the run's random generator was used,
    until it completed.

    Args:
        run: The run, before the first tick.
    """

    def __init__(self, run: Run) -> None:
        self._run, self._found = run, set[int]()
        self._places = {id(node): i for i, node in enumerate(run.tree.nodes)}
        self._fresh, self._seen = run.tree.get_state(), self._read()
        run.tree.observers.append(self._note)  # until `state_behind`, or the end of the episode

    def state_behind(self) -> dict[str, Any] | None:
        """Return the present state of the tree, in which all nodes behind these leaves are idle.

        None if such leaves and others run side by side.
        """
        tree, node, first = self._run.tree, self._run.tree.nodes[0], 0
        tree.observers.remove(self._note)
        while not self._found.isdisjoint(range(first, first + _count(node))):
            running = [one for one in node.child_nodes if one.engine_status is NodeStatus.RUNNING]
            if len(running) != 1:
                return None
            node, first = running[0], self._places[id(running[0])]
        state, end = tree.get_state(), first + _count(node)
        state["nodes"][first:end] = self._fresh["nodes"][first:end]
        return state

    def _read(self) -> Any:
        station = self._run.station
        return tuple(station.cell.entities), station.rng.bit_generator.state

    def _note(self, node: Any, old: NodeStatus, new: NodeStatus) -> None:
        if new in (NodeStatus.SUCCESS, NodeStatus.FAILURE) and not node.child_nodes:
            if (now := self._read()) != self._seen:
                self._seen = now
                self._found.add(self._places[id(node)])


def _count(node: Any) -> int:
    """Return the number of nodes from a node downwards."""
    return 1 + sum(map(_count, node.child_nodes))
