"""Error messages when no grasp is feasible."""

from bt_manip.exceptions import MotionError
from bt_manip.grasping.rejections import Rejections


def test_without_candidates_the_object_is_unreachable():
    error = Rejections("cube").error()
    assert str(error) == "no feasible grasp of 'cube': there are no candidates"
    assert error.reason == "unreachable"


def test_the_message_lists_the_reasons_and_the_entities():
    rejections = Rejections("cube")
    rejections.no_clearance["wall"] += 1
    rejections.no_clearance["wall"] += 1
    rejections.no_clearance["roof"] += 1
    rejections.collisions["panda/hand", "table"] += 1
    rejections.collisions["panda/link7", "panda/link2"] += 1
    rejections.reject_approach(MotionError("joint limit", reason="unreachable"))
    rejections.unreachable += 4
    assert rejections.total == 10
    assert rejections.error().reason == "grasp"
    assert str(rejections.error()) == (
        "no feasible grasp of 'cube': 'wall' leaves the gripper no clearance at 'cube'; "
        "'roof' leaves none at other grasps; 'panda/hand' would touch 'table'; "
        "'panda/link7' would touch 'panda/link2'; "
        "1 straight approaches are not feasible (joint limit); 4 grasps are unreachable"
    )


def test_a_robot_that_blocks_the_object_is_a_reason_to_wait():
    rejections = Rejections("cube", ["left"])
    rejections.collisions["right/hand", "left/hand"] += 1
    assert rejections.error().reason == "robot"
    assert str(rejections.error()) == "'left' blocks 'cube'"
