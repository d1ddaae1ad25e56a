"""Episodes of a tree in a station: reset, steps of the expert or of an agent, success."""

from collections.abc import Callable, Sequence
from typing import Any

from bt_manip.bt import NodeStatus
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.runner import RunRequest, prepare

STEP = 0.05
"""Time between two actions [s]."""

START_TIMEOUT = 10.0
"""Longest simulated time in which the tree commands a robot for the first time [s]."""

Then = Sequence[Callable[[], None]]


class Episodes:
    """Runs episodes of a tree, one after the other, in one station.

    An episode is identified by a seed and a number, as in ``bt-manip run --seed S --episode N``,
    and depends on nothing else. After `reset` the tree has just commanded a robot for the first
    time: what it does before that, such as adding objects, is done. Then either the tree goes on as
    the expert (`expert_step`), or an agent acts in its place (`agent_step`).

    Attributes:
        run: The tree in its station; its request has the seed of the episode.
        station: The station.
        step_time: Time of one step, of the expert or of an agent [s].
        seed: Seed of the episode.
        episode: Number of the episode.
        steps: Steps made in the episode.
        ticks: Ticks of the tree in a step.
        gripped: The tick of the last step of the expert in which each gripper that was commanded to
            open or to close was, by the robot's name.
        status: Status of the tree; RUNNING until it ends.
    """

    def __init__(self, request: RunRequest, parts: Parts, *, step_time: float = STEP) -> None:
        """Prepare the station; `reset` starts an episode.

        Args:
            request: The tree, the scene and the parts to use.
            parts: The registered parts to choose from.
            step_time: Time of one step [s], a whole number of ticks of the tree.

        Raises:
            BtManipError: If the request is invalid.
        """
        self.ticks = round(step_time / request.tick)
        if self.ticks < 1 or abs(step_time / request.tick - self.ticks) > 1e-6:
            raise BtManipError(
                f"a step takes a whole number of ticks of {1e3 * request.tick:g} ms, "
                f"got {1e3 * step_time:g} ms"
            )
        self.run = prepare(request, parts)
        self.station, self.step_time = self.run.station, step_time
        self.seed, self.episode, self.steps = request.seed, 0, 0
        self.status = NodeStatus.IDLE
        self._ticked = False
        self.gripped: dict[str, int] = {}
        self._gripping = self._read_gripping()

    def reset(self, seed: int, episode: int = 0) -> None:
        """Start an episode: the tree is ticked until it commands a robot.

        Args:
            seed: Seed of the episode.
            episode: Its number.

        Raises:
            BtManipError: If the scene cannot be randomized with this seed, or the tree ends without
                commanding a robot, or commands none within `START_TIMEOUT`.
        """
        run, cell = self.run, self.station.cell
        self._begin(seed, episode)
        self.station.randomizer.begin(episode)
        run.goal.begin(episode)
        while True:
            self._tick()
            if self.status is not NodeStatus.RUNNING:
                reason = run.tree.failure_reason()
                raise BtManipError(f"the tree ended before it commanded a robot: {reason}")
            if self._commanded():
                return
            if cell.time > START_TIMEOUT:
                raise BtManipError(f"the tree commanded no robot within {START_TIMEOUT:g} s")
            self._advance(())

    def expert_step(self, then: Then = ()) -> None:
        """Let the tree go on for one step; once its goal holds or it has ended, it rests.

        Args:
            then: Called after each control step.
        """
        self.gripped = {}
        for i in range(self.ticks):
            if not self._ticked and self.status is NodeStatus.RUNNING and not self.success:
                self._tick()
            gripping = self._read_gripping()
            changed = [name for name in gripping if gripping[name] != self._gripping[name]]
            self.gripped |= dict.fromkeys(changed, i)
            self._gripping = gripping
            self._advance(then)
        self.steps += 1

    def agent_step(self, then: Then = (), tick: Callable[[], None] | None = None) -> None:
        """Simulate one step without the tree, which is halted before the first one.

        Args:
            then: Called after each control step.
            tick: Called at each tick in place of the tree; None if nothing is ticked.
        """
        self.release()
        if tick is None:
            self.station.cell.step(self.ticks * self.run.request.steps_per_tick, then=then)
        else:
            for _ in range(self.ticks):
                tick()
                self._advance(then)
        self.steps += 1

    def release(self) -> None:
        """Halt the tree, so that an agent acts in its place."""
        if self.status is NodeStatus.RUNNING:
            self.run.tree.halt()
            self.status = NodeStatus.IDLE

    @property
    def success(self) -> bool:
        """Whether the goal of the tree holds now.

        Of a tree that declares none, whether the tree itself has succeeded.
        """
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
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore a state of `get_state`, also in another process."""
        self._begin(*state["episode"])
        self.run.set_state(state["run"])
        self.steps, self._ticked = state["steps"], state["ticked"]
        self.status = NodeStatus[state["status"]]

    # Internal

    def _begin(self, seed: int, episode: int) -> None:
        """Return to the start of an episode, before the first tick."""
        self.run.begin_episode(episode, seed)
        self.seed, self.episode, self.steps = seed, episode, 0
        self.status, self._ticked = NodeStatus.IDLE, False
        self._gripping = self._read_gripping()

    def _read_gripping(self) -> dict[str, bool]:
        robots = self.station.robots.items()
        return {name: one.gripper.gripping for name, one in robots if one.gripper is not None}

    def _tick(self) -> None:
        self.status = self.run.tree.tick()
        self._ticked = True

    def _advance(self, then: Then) -> None:
        """Make the control steps of one tick."""
        self._ticked = False
        self.station.cell.step(self.run.request.steps_per_tick, then=then)

    def _commanded(self) -> bool:
        """Return whether the tree has commanded a robot."""
        return any(
            one.arm.busy
            or one.controllers.active != one.controllers.default
            or (one.gripper is not None and one.gripper.moving)
            for one in self.station.robots.values()
        )
