"""Nav2's decorators (nav2_behavior_tree/plugins/decorator of ros-navigation/navigation2).

Nav2 gets poses, speeds and new goals from ROS. Here they are entries of the blackboard; time is the
tree's clock, which is simulated time in a run.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from bt_manip.bt import Decorator, Input, Node, NodeStatus, Output
from bt_manip.exceptions import PortError
from bt_manip_nav2.messages import field, length_of, poses_of, position_of, stamp_of

FAILURE, IDLE, RUNNING = NodeStatus.FAILURE, NodeStatus.IDLE, NodeStatus.RUNNING
SKIPPED, SUCCESS = NodeStatus.SKIPPED, NodeStatus.SUCCESS

TOLERANCE = 1e-9
"""A clock that adds up time steps may stay this far [s] below the end of a period."""


def _read_or(node: Node, port: str, default: Any) -> Any:
    """Return the value of a port, or the default where its entry is missing."""
    try:
        return node.read_port(port)
    except PortError:
        return default


class _Paced(Decorator):
    """A decorator that ticks a child that is not running at first, and then now and then."""

    def _begin(self) -> None:
        """Start a round: the node was idle."""

    def _is_due(self) -> bool:
        """Return whether a child that does not run is ticked."""
        raise NotImplementedError

    def _after(self, state: NodeStatus) -> None:
        """React to the child's result."""

    def _tick(self) -> NodeStatus:
        first = self._node_status is IDLE
        if first:
            self._begin()
        due = self._is_due()
        self._enter()
        if not (first or due or self.child_node.engine_status is RUNNING):
            return RUNNING
        state = self.child_node.execute()
        self._after(state)
        return state


class _Periodic(_Paced):
    """A paced decorator that counts the time since a moment of the tree's clock."""

    _since = 0.0

    def _elapsed(self) -> float:
        return self.runtime.clock() - self._since + TOLERANCE

    def _restart(self) -> None:
        self._since = self.runtime.clock()

    def get_state(self) -> dict[str, Any]:
        """Return the state, with the time that has passed [s]."""
        return {**super().get_state(), "elapsed": self.runtime.clock() - self._since}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore the state that `get_state` returned."""
        super().set_state(state)
        self._since = self.runtime.clock() - state["elapsed"]


class RateController(_Periodic):
    """Tick the child at a rate: once its period has passed since it last succeeded.

    | child   | result                                                                   |
    |---------|--------------------------------------------------------------------------|
    | waiting | RUNNING until the period has passed; the first tick does not wait        |
    | SUCCESS | SUCCESS; the period starts anew                                          |
    | FAILURE | FAILURE; the period goes on                                              |
    | RUNNING | RUNNING; the next tick goes on with the child                            |
    | SKIPPED | SKIPPED; the period goes on                                              |
    | halt    | the child is halted; the next tick does not wait                         |
    """

    memory: ClassVar[tuple[str, ...]] = ("_period",)
    hz = Input(float, default=10.0, doc="rate", unit="1/s", above=0.0)
    _period = 1.0

    def _begin(self) -> None:
        self._period = 1 / self.hz
        self._restart()

    def _is_due(self) -> bool:
        return self._elapsed() >= self._period

    def _after(self, state: NodeStatus) -> None:
        if state is SUCCESS:
            self._restart()


class DistanceController(_Paced):
    """Tick the child each time the robot has moved by a distance since it last succeeded.

    | child   | result                                                                   |
    |---------|--------------------------------------------------------------------------|
    | no pose | FAILURE while the entry of the robot's pose is missing                   |
    | waiting | RUNNING until the robot has moved; the first tick does not wait          |
    | SUCCESS | SUCCESS; the distance is counted anew                                    |
    | FAILURE | FAILURE                                                                  |
    | RUNNING | RUNNING; the next tick goes on with the child                            |
    | SKIPPED | SKIPPED                                                                  |
    | halt    | the child is halted; the next tick does not wait                         |
    """

    memory: ClassVar[tuple[str, ...]] = ("_origin",)
    distance = Input(float, default=1.0, doc="distance", unit="m")
    global_frame = Input(str, default="map", doc="not used: the entry is in this frame")
    robot_base_frame = Input(str, default="base_link", doc="not used: the entry is of this frame")
    robot_pose = Input(default="{@robot_pose}", doc="the robot's pose: PoseStamped, or a list [m]")
    _origin: tuple[float, ...] | None = None

    def _tick(self) -> NodeStatus:
        try:
            self._position = position_of(self.robot_pose)
        except PortError as error:
            self._because(f"the robot's pose is not known: {error}")
            return FAILURE
        return super()._tick()

    def _begin(self) -> None:
        self._origin = self._position

    def _is_due(self) -> bool:
        assert self._origin is not None
        return math.dist(self._origin, self._position) >= self.distance

    def _after(self, state: NodeStatus) -> None:
        if state is SUCCESS:
            self._origin = self._position


class _Goals(_Paced):
    """A paced decorator that ticks its child at once when the goals have changed."""

    memory: ClassVar[tuple[str, ...]] = ("_goals",)
    goals = Input(default="{goals}", doc="goals; by default the entry goals, if there is one")
    goal = Input(default="{goal}", doc="the goal; by default the entry goal, if there is one")
    _goals: Any = None

    def _present_goals(self) -> list[Any]:
        """Return goal and goals; None for one that is missing."""
        return [_read_or(self, name, None) for name in ("goal", "goals")]

    def _begin(self) -> None:
        self._goals = self._present_goals()

    def _goals_changed(self) -> bool:
        present = self._present_goals()
        changed = bool(present != self._goals)
        self._goals = present
        return changed


class GoalUpdatedController(_Goals):
    """Tick the child at first, and each time the goals have changed.

    | child   | result                                                                   |
    |---------|--------------------------------------------------------------------------|
    | waiting | RUNNING while the goals are as before; the first tick does not wait      |
    | SUCCESS | SUCCESS                                                                  |
    | FAILURE | FAILURE                                                                  |
    | RUNNING | RUNNING; the next tick goes on with the child                            |
    | SKIPPED | SKIPPED                                                                  |
    | halt    | the child is halted; the next tick does not wait                         |
    """

    def _is_due(self) -> bool:
        return self._goals_changed()


class SpeedController(_Goals, _Periodic):
    """Tick the child at a rate that grows with the robot's speed.

    | child   | result                                                                   |
    |---------|--------------------------------------------------------------------------|
    | waiting | RUNNING until the period has passed; the first tick, and the one after a |
    |         | change of the goals, do not wait                                         |
    | SUCCESS | SUCCESS                                                                  |
    | FAILURE | FAILURE                                                                  |
    | RUNNING | RUNNING; the next tick goes on with the child                            |
    | SKIPPED | SKIPPED                                                                  |
    | halt    | the child is halted; the next tick does not wait                         |

    The rate is linear in the speed, between min_rate at min_speed and max_rate at max_speed. It is
    set anew when a period ends; the first one is that of max_rate.
    """

    memory: ClassVar[tuple[str, ...]] = ("_goals", "_period")
    min_rate = Input(float, default=0.1, doc="lowest rate", unit="1/s", above=0.0)
    max_rate = Input(float, default=1.0, doc="highest rate", unit="1/s", above=0.0)
    min_speed = Input(float, default=0.0, doc="speed of the lowest rate", unit="m/s")
    max_speed = Input(float, default=0.5, doc="speed of the highest rate", unit="m/s")
    robot_speed = Input(
        default="{@robot_speed}", doc="the robot's speed [m/s]: a number, or a Twist; 0 if missing"
    )
    _period = 1.0

    def _begin(self) -> None:
        super()._begin()
        self._start_period()

    def _start_period(self) -> None:
        self._period = 1 / self.max_rate
        self._restart()

    def _is_due(self) -> bool:
        if self._goals_changed():
            self._start_period()
            return True
        if self._elapsed() < self._period:
            return False
        low, high, slowest, fastest = self.min_rate, self.max_rate, self.min_speed, self.max_speed
        rate = (self._speed() - slowest) / (fastest - slowest) * (high - low) + low
        self._period = 1 / max(min(rate, high), low)
        self._restart()
        return True

    def _speed(self) -> float:
        speed = _read_or(self, "robot_speed", 0.0)
        if isinstance(speed, int | float | str):
            return abs(float(speed))
        linear = field(speed, "twist.twist.linear") or field(speed, "linear")
        return math.hypot(field(linear, "x", 0.0), field(linear, "y", 0.0))


class GoalUpdater(Decorator):
    """Tick the child with the goal, or with a newer one that came meanwhile.

    The outputs get the entries ``goal_update`` and ``goals_update`` where these have a time that is
    not before that of the inputs, else the inputs.

    | child   | result                                                                   |
    |---------|--------------------------------------------------------------------------|
    | SUCCESS | SUCCESS                                                                  |
    | FAILURE | FAILURE                                                                  |
    | RUNNING | RUNNING                                                                  |
    | SKIPPED | SKIPPED                                                                  |
    | halt    | the child is halted                                                      |
    """

    input_goal = Input(default="", doc="the goal: PoseStamped")
    input_goals = Input(default="", doc="goals: Goals")
    output_goal = Output(doc="the newer goal")
    output_goals = Output(doc="the newer goals")
    goal_update = Input(default="{@goal_update}", doc="the last goal that came: PoseStamped")
    goals_update = Input(default="{@goals_update}", doc="the last goals that came: Goals")

    def _tick(self) -> NodeStatus:
        for name in ("goal", "goals"):
            given = _read_or(self, f"input_{name}", None)
            update = _read_or(self, f"{name}_update", None)
            if update and stamp_of(update) > 0 and stamp_of(update) >= stamp_of(given):
                given = update
            if given and self.is_connected(f"output_{name}"):
                self.write_port(f"output_{name}", given)
        return self.child_node.execute()


class PathLongerOnApproach(Decorator):
    """Tick the child where a new path to the same goal is much longer, near to the goal.

    | child   | result                                                                   |
    |---------|--------------------------------------------------------------------------|
    | none    | SUCCESS: the path is the first one, as long as before, or to another goal |
    | SUCCESS | SUCCESS; the new path becomes the old one                                |
    | FAILURE | FAILURE; the new path becomes the old one                                |
    | RUNNING | RUNNING; the next tick compares the same two paths                       |
    | SKIPPED | SKIPPED; the next tick compares the same two paths                       |
    | halt    | the child is halted                                                      |

    Paths are new if they have another number of poses. The old path counts as near to the goal
    where it is shorter than prox_len, and the new one as much longer where it exceeds
    length_factor times its length.
    """

    memory: ClassVar[tuple[str, ...]] = ("_old",)
    path_ = Input(name="path", doc="the planned path: Path, or a list of poses")
    prox_len = Input(float, default=3.0, doc="length of an old path near to the goal", unit="m")
    length_factor = Input(float, default=2.0, doc="factor that makes a path much longer")
    _old: tuple[Any, ...] = ()

    def _tick(self) -> NodeStatus:
        old, new = self._old, poses_of(_read_or(self, "path", []))
        self._enter()
        if _goal_of(old) == _goal_of(new) and len(new) != len(old):
            length = length_of(old)
            if length < self.prox_len and length_of(new) > self.length_factor * length:
                state = self.child_node.execute()
                if state is SUCCESS or state is FAILURE:
                    self._old = tuple(new)
                    self._reset_child()
                return state
        self._old = tuple(new)
        return SUCCESS


def _goal_of(path: Sequence[Any]) -> Any:
    """Return the pose at the end of a path, without its header; None for an empty path."""
    return field(path[-1], "pose", path[-1]) if path else None


class SingleTrigger(Decorator):
    """Tick the child until it has completed; fail from then on.

    | child     | result                                                                 |
    |-----------|------------------------------------------------------------------------|
    | SUCCESS   | SUCCESS                                                                |
    | FAILURE   | FAILURE                                                                |
    | RUNNING   | RUNNING                                                                |
    | SKIPPED   | SKIPPED; this does not count as its run                                |
    | completed | FAILURE, until the node is halted or reset                             |
    | halt      | the child is halted; the next tick ticks it again                      |
    """

    memory: ClassVar[tuple[str, ...]] = ("_done",)
    _done = False

    def _tick(self) -> NodeStatus:
        if self._node_status is IDLE:
            self._done = False
        self._enter()
        if self._done:
            self._because(f"{self.child_node.name} has completed before")
            return FAILURE
        state = self.child_node.execute()
        self._done = state is SUCCESS or state is FAILURE
        return state
