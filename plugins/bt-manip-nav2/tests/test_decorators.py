"""The decorators give the statuses of Nav2's unit tests (nav2_behavior_tree/test/plugins).

Where those use ROS topics and transforms, the entries of the blackboard stand for them.
"""

import pytest

from bt_manip.bt import (
    AlwaysFailure,
    AlwaysSuccess,
    BehaviourRegistry,
    Tree,
    parse_tree,
)
from bt_manip.exceptions import NodeError
from bt_manip_nav2.decorators import (
    DistanceController,
    GoalUpdatedController,
    GoalUpdater,
    PathLongerOnApproach,
    RateController,
    SingleTrigger,
    SpeedController,
)

from .dummy import FAILURE, IDLE, RUNNING, SUCCESS, Dummy


class Rig:
    def __init__(self, cls, **ports):
        self.now = 0.0
        self.child = Dummy()
        self.child.result = SUCCESS
        self.node = cls(self.child, **ports)
        self.tree = Tree(self.node, clock=lambda: self.now)
        self.entries = self.tree.blackboard

    def tick(self, after=0.0):
        self.now += after
        state = self.node.execute()
        assert self.child.engine_status in (IDLE, RUNNING)
        return state


def stamped(time, x=0.0):
    return {"header": {"stamp": time}, "pose": {"position": {"x": x, "y": 0.0, "z": 0.0}}}


def test_the_rate_controller_ticks_its_child_once_per_period_or_on_while_it_runs():
    rig = Rig(RateController, hz=1.0)
    rig.child.result = RUNNING
    assert rig.tick() is RUNNING
    rig.child.result = SUCCESS
    assert rig.tick(0.1) is SUCCESS
    assert [rig.tick(0.5) for _ in range(3)] == [RUNNING, SUCCESS, RUNNING]
    copy = Rig(RateController, hz=1.0)
    copy.now = 100.0
    copy.node.execute()
    copy.node.set_state(rig.node.get_state())
    assert [copy.tick(0.3), copy.tick(0.2)] == [RUNNING, SUCCESS]


def test_a_rate_of_zero_is_refused():
    with pytest.raises(NodeError, match="positive"):
        Rig(RateController, hz="0").tick()


def test_the_distance_controller_ticks_its_child_once_per_metre():
    rig = Rig(DistanceController, distance=1.0)
    assert rig.tick() is FAILURE
    assert "robot_pose" in rig.node.feedback_message
    rig.node.halt()
    rig.entries["robot_pose"] = stamped(0.0)
    assert rig.tick() is SUCCESS
    for number in range(1, 5):
        rig.entries["robot_pose"] = stamped(0.0, 0.51 * number)
        assert rig.tick() is (RUNNING if number % 2 else SUCCESS)


def test_the_rate_of_the_speed_controller_grows_with_the_speed():
    rig = Rig(SpeedController, min_rate=0.1, max_rate=1.0, min_speed=0.0, max_speed=0.5)
    rig.entries["goal"], rig.entries["goals"] = stamped(1.0), []
    rig.entries["robot_speed"] = {"linear": {"x": 0.223, "y": 0.0}}
    assert rig.tick() is SUCCESS
    assert rig.tick() is RUNNING
    assert rig.tick(1.0) is SUCCESS  # from now on 2 s
    rig.entries["robot_speed"] = {"linear": {"x": 0.0, "y": 0.0}}
    assert rig.tick(1.0) is RUNNING
    assert rig.tick(1.0) is SUCCESS  # from now on 10 s
    for _ in range(9):
        assert rig.tick(1.0) is RUNNING
    assert rig.tick(1.0) is SUCCESS
    assert rig.tick(1.0) is RUNNING
    rig.entries["goal"] = stamped(2.0)
    assert rig.tick() is SUCCESS


def test_the_goal_updated_controller_ticks_its_child_for_new_goals():
    rig = Rig(GoalUpdatedController)
    rig.entries["goal"], rig.entries["goals"] = stamped(1.0), [stamped(1.0)]
    assert rig.tick() is SUCCESS
    rig.entries["goal"] = stamped(2.0)
    assert rig.tick() is SUCCESS
    assert rig.tick() is RUNNING
    rig.entries["goals"] = [stamped(2.0)]
    assert rig.tick() is SUCCESS


UPDATER = """<root BTCPP_format="4"><BehaviorTree ID="Main">
  <GoalUpdater input_goal="{goal}" input_goals="{goals}"
    output_goal="{updated_goal}" output_goals="{updated_goals}"><AlwaysSuccess/></GoalUpdater>
</BehaviorTree></root>"""


@pytest.mark.parametrize(
    ("updates", "expected"),
    [([], 1.0), ([9.0], 1.0), ([10.0, 11.0], 11.0), ([0.0], 1.0)],
    ids=["no update", "an older one", "the latest of two", "one without a time"],
)
def test_the_goal_updater_passes_the_newest_goal_on(updates, expected):
    tree = parse_tree(UPDATER, BehaviourRegistry([GoalUpdater]), main="Main", strict=False)
    tree.blackboard["goal"] = stamped(10.0, 1.0)
    tree.blackboard["goals"] = {"header": {"stamp": 10.0}, "goals": [stamped(10.0, 1.0)]}
    for time in updates:
        tree.blackboard["goal_update"] = stamped(time, time)
        tree.blackboard["goals_update"] = {
            "header": {"stamp": time}, "goals": [stamped(time, time)],
        }  # fmt: skip
    assert tree.root.execute() is SUCCESS
    goal, goals = tree.blackboard["updated_goal"], tree.blackboard["updated_goals"]
    for pose in (goal, goals["goals"][0]):
        assert pose["pose"]["position"]["x"] == expected


def path(*xs):
    return {"poses": [stamped(0.0, x) for x in xs]}


def test_path_longer_on_approach_ticks_its_child_for_a_much_longer_path():
    tree = Tree(PathLongerOnApproach(AlwaysSuccess(), path="{path}", prox_len=5.0))
    tree.blackboard["path"] = path(*(1.5 * i for i in range(10)))
    assert tree.root.execute() is SUCCESS

    node = PathLongerOnApproach(AlwaysFailure(), path="{path}", prox_len=20.0, length_factor=1.0)
    tree = Tree(node)
    tree.blackboard["path"] = path(*(3.0 * i for i in range(1, 6)))
    assert node.execute() is SUCCESS
    tree.blackboard["path"] = path(*(1.5 * i for i in range(11)))
    assert node.execute() is FAILURE
    assert node.execute() is SUCCESS  # the same path again


@pytest.mark.parametrize(
    ("changes", "new"),
    [
        ({"prox_len": 5.0}, path(0, 6, 12, 15)),
        ({"length_factor": 3.0}, path(0, 6, 12, 15)),
        ({}, path(0, 6, 12, 18)),
        ({}, path(-9, 6, 15)),
    ],
    ids=["far from the goal", "not much longer", "to another goal", "as many poses"],
)
def test_path_longer_on_approach_passes_over_its_child(changes, new):
    node = PathLongerOnApproach(
        AlwaysFailure(), path="{path}", **{"prox_len": 20.0, "length_factor": 1.0, **changes}
    )
    tree = Tree(node)
    tree.blackboard["path"] = path(3, 9, 15)
    assert node.execute() is SUCCESS
    tree.blackboard["path"] = new
    assert node.execute() is SUCCESS


def test_a_single_trigger_runs_its_child_once():
    rig = Rig(SingleTrigger)
    assert rig.tick() is SUCCESS
    assert rig.tick() is FAILURE
    rig.child.result = IDLE
    assert rig.tick() is FAILURE
    rig.node.halt()
    rig.child.result = RUNNING
    assert rig.tick() is RUNNING
    rig.child.result = SUCCESS
    assert rig.tick() is SUCCESS
    assert rig.tick() is FAILURE
