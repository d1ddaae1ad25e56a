"""Episodes of a tree in a station: reset, steps of the expert or of an agent, success."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from bt_manip.bt import NodeStatus
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts, Surroundings
from bt_manip.runner import CONTROLLER, SCENE, RunRequest, find_tree, prepare

STEP = 0.05
"""Time between two actions [s]."""

START_TIMEOUT = 10.0
"""Longest simulated time in which the tree commands a robot for the first time [s]."""

Then = Sequence[Callable[[], None]]


def episode_request(tree: str, parts: Parts, **options: Any) -> RunRequest:
    """Return the request of a registered tree's episodes, with the scene that it requires.

    Args:
        tree: Registered name of the tree, or where it is, as for `bt_manip.runner.find_tree`.
        parts: The registered parts.
        **options: Fields of `RunRequest`: ``robot``, ``scene``, ``settings``, ...

    Raises:
        BtManipError: If there is no such tree, or an option is out of range.
    """
    wants = parts.surroundings.get(tree, Surroundings())
    options.setdefault("scene", wants.scene or SCENE)
    options.setdefault("controller", wants.controller or CONTROLLER)
    trees = {name: parts.trees.get(name) for name in parts.trees}
    return RunRequest(find_tree(tree, trees), **options)


class Episodes:
    """Runs episodes of a tree, one after the other, in one station.

    An episode is identified by its seed: it is the first cycle of ``bt-manip run --seed``, bit for
    bit, and does not depend on the episodes before it. After `reset` the tree has just commanded a
    robot for the first time: what it does before that, such as adding objects, is done. Then either
    the tree goes on as the expert (`expert_step`), or an agent acts (`agent_step`).

    Attributes:
        run: The tree in its station; its request has the seed of the episode.
        station: The station.
        step_time: Time of one step, of the expert or of an agent [s].
        seed: Seed of the episode.
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
        self.run = prepare(replace(request, cycles=1), parts)
        self.station, self.step_time = self.run.station, step_time
        self._home = self.run.get_state()
        self.seed, self.steps = request.seed, 0
        self.status = NodeStatus.IDLE
        self._ticked = False
        self.gripped: dict[str, int] = {}
        self._gripping = self._read_gripping()

    def begin(self, seed: int) -> None:
        """Return to the start of the run of a seed, as if it had just been prepared.

        `run` can then be executed with observers, in place of `reset` and steps.

        Raises:
            BtManipError: If the scene cannot be randomized with this seed.
        """
        run, station = self.run, self.station
        run.goal.stop()
        for robot in station.robots.values():
            robot.controllers.reference = robot.arm
        run.set_state(self._home)
        run.request = replace(run.request, seed=seed)
        station.reseed(seed)
        self.seed, self.steps, self.status, self._ticked = seed, 0, NodeStatus.IDLE, False
        self._gripping = self._read_gripping()

    def reset(self, seed: int) -> None:
        """Start the episode of a seed: the tree is ticked until it commands a robot.

        Raises:
            BtManipError: If the tree ends without commanding a robot, or commands none within
                `START_TIMEOUT`.
        """
        self.begin(seed)
        self.station.randomizer.begin(0)
        self.run.goal.begin()
        cell = self.station.cell
        while True:
            self._tick()
            if self.status is not NodeStatus.RUNNING:
                reason = self.run.tree.failure_reason()
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
            "seed": self.seed,
            "steps": self.steps,
            "status": self.status.name,
            "ticked": self._ticked,
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore a state of `get_state`, also in another process."""
        self.begin(state["seed"])
        self.run.set_state(state["run"])
        self.steps, self._ticked = state["steps"], state["ticked"]
        self.status = NodeStatus[state["status"]]

    # Internal

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
