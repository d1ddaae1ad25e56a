"""A hand-over is judged from contacts; the free end of a held object is found."""

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import build_station, spatial
from bt_manip.behaviours import Grasp, Hover, Lift, Reach
from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import Cell
from bt_manip.cell.objects import Box
from bt_manip.exceptions import MotionError
from bt_manip.testing import Trial, play
from bt_manip_impedance import FindFreeEnd, HoldOut, IsHandedOver

HIGH = 0.5  # [m] of the posts, which stand for two robots


@pytest.fixture
def handed_over(cell) -> Tree:
    """Return the condition that the rod is handed over from the left to the right post."""
    tree = Tree(IsHandedOver("handed over", object="rod", giver="left", receiver="right"))
    tree.setup(cell=cell)
    return tree


@pytest.fixture
def cell() -> Cell:
    """Return a table, two posts on it, and a rod on the table."""
    cell = Cell()
    cell.add(Box(size=(1.0, 1.0, 0.1)), spatial.pose((0.0, 0.0, 0.05)), name="table", free=False)
    for name, x in (("left", -0.1), ("right", 0.1)):
        post = Box(size=(0.04, 0.04, HIGH))
        cell.add(post, spatial.pose((x, 0.0, 0.1 + HIGH / 2)), name=name, free=False)
    cell.add(Box(size=(0.3, 0.03, 0.03)), spatial.pose((0.0, 0.3, 0.115)), name="rod", free=True)
    return cell


def move(cell: Cell, x: float, y: float, z: float) -> None:
    cell.move("rod", spatial.pose((x, y, z)))
    cell.step(200)


def test_an_object_is_handed_over_once_the_giver_has_let_go_of_it_in_the_air(cell, handed_over):
    on_posts, on_left, on_right = (0.0, 0.0), (-0.1, 0.0), (0.1, 0.0)
    for (x, y), z, expected in (
        ((0.0, 0.3), 0.115, NodeStatus.FAILURE),  # on the table
        (on_left, 0.115 + HIGH, NodeStatus.FAILURE),  # with the giver
        (on_right, 0.115 + HIGH, NodeStatus.FAILURE),  # with the receiver, but not by the giver
        (on_posts, 0.115 + HIGH, NodeStatus.FAILURE),  # with both, after the receiver
        (on_left, 0.115 + HIGH, NodeStatus.FAILURE),  # with the giver
        (on_posts, 0.115 + HIGH, NodeStatus.FAILURE),  # with both, after the giver
        (on_right, 0.115 + HIGH, NodeStatus.SUCCESS),  # with the receiver
        ((0.0, 0.3), 0.115, NodeStatus.FAILURE),  # put down
    ):
        move(cell, x, y, z)
        assert handed_over.tick() is expected
    assert "without putting it down on 'table'" in handed_over.root.feedback_message


@pytest.mark.parametrize(
    ("kept", "gap", "again", "expected"),
    [
        (30, 5, 200, NodeStatus.SUCCESS),  # [ms] contacts flutter
        (30, 60, 200, NodeStatus.FAILURE),  # the receiver let it fall
        (150, 60, 50, NodeStatus.SUCCESS),  # and this it may do, once it has held it
    ],
)
def test_a_short_gap_in_the_contact_is_no_loss(cell, handed_over, kept, gap, again, expected):
    for x, steps in ((-0.1, 200), (0.0, 200), (0.1, kept)):
        cell.move("rod", spatial.pose((x, 0.0, 0.115 + HIGH)))
        cell.step(steps)
    cell.move("rod", spatial.pose((0.1, 0.0, 0.3 + HIGH)))
    cell.step(gap)
    assert not cell.contacts.partners("rod")
    cell.move("rod", spatial.pose((0.1, 0.0, 0.115 + HIGH)))
    cell.step(again)
    assert handed_over.tick() is expected


def test_a_hand_over_counts_in_its_own_cycle_and_for_the_object_that_was_handed_over(
    cell, handed_over
):
    def pass_on():
        for x in (-0.1, 0.0, 0.1):
            move(cell, x, 0.0, 0.115 + HIGH)
            status = handed_over.tick()
        return status

    assert pass_on() is NodeStatus.SUCCESS
    handed_over.root.begin_cycle()
    for x in (0.1, 0.0, 0.1):
        move(cell, x, 0.0, 0.115 + HIGH)
        assert handed_over.tick() is NodeStatus.FAILURE
    assert pass_on() is NodeStatus.SUCCESS
    cell.remove("rod")
    high = spatial.pose((0.1, 0.0, 0.115 + HIGH))
    cell.add(Box(size=(0.3, 0.03, 0.03)), high, name="rod", free=True)
    cell.step(200)
    assert handed_over.tick() is NodeStatus.FAILURE


def test_an_object_on_a_block_between_the_robots_is_not_in_the_air(cell, handed_over):
    cell.add(
        Box(size=(0.04, 0.04, 0.49)), spatial.pose((0.0, 0.0, 0.355)), name="block", free=False
    )
    for height, passed in ((0.355, False), (0.345, True)):  # above and below the posts
        cell.move("block", spatial.pose((0.0, 0.0, height)), overlap=1.0)
        for x in (-0.25, 0.0, 0.25) if height > 0.35 else (-0.1, 0.0, 0.1):
            cell.move("rod", spatial.pose((x, 0.0, 0.115 + HIGH)), overlap=1.0)
            cell.step(200)
            status = handed_over.tick()
        assert (status is NodeStatus.SUCCESS) is passed


@pytest.fixture(scope="module")
def held_out(parts):
    """Return a station whose left robot holds the rod out to the right one."""
    station = build_station(parts, scene=parts.scenes.create("hand_over"))
    play(
        station,
        Hover(object="rod", height=0.2, robot="left"), Reach(object="rod", robot="left"),
        Grasp(object="rod", force=40.0, robot="left"), Lift(height=0.2, robot="left"),
        HoldOut(object="rod", receiver="right", robot="left"),
    )  # fmt: skip
    return station


@pytest.mark.parametrize("end", [1.0, -1.0])
@pytest.mark.parametrize("half_turn", [False, True])
def test_the_tool_points_along_the_object_at_the_end_that_is_not_held(end, half_turn):
    cell, T_wo = Cell(), pin.SE3(pin.exp3(np.array([0.3, -0.5, 0.7])), np.array([0.1, 0.2, 0.9]))
    cell.add(Box(size=(0.04, 0.2, 0.03)), T_wo, name="bar", free=False)
    outwards, across = end * T_wo.rotation[:, 1], T_wo.rotation[:, 2]  # of the longest, least side
    holder = T_wo.act(np.array([0.3, -0.03 * end, 0.1]))
    leaf = SimpleNamespace(
        cell=cell, object="bar", inset=0.02, distance=0.07, _holder=lambda name: holder
    )
    R = np.column_stack([np.cross(across, -outwards), across, -outwards])
    turned = R @ np.diag([-1.0, -1.0, 1.0]) if half_turn else R
    leaf.T_wt = pin.SE3(turned @ pin.exp3(np.array([0.2, 0.1, 0.3])), np.zeros(3))
    FindFreeEnd.start(leaf)
    default = FindFreeEnd(object="bar", pose="{pose}")
    assert (default.inset, default.distance) == (0.01, 0.1)
    assert leaf.pose.rotation == pytest.approx(turned)
    assert leaf.pose.translation == pytest.approx(T_wo.translation + (0.1 + 0.05) * outwards)


def test_poses_to_hold_an_object_out_at_are_tried_in_turn_where_the_receiver_reaches_its_end(
    held_out, monkeypatch
):
    giver, receiver = (held_out.robots[name].arm for name in ("left", "right"))
    tried, asked, reached = [], [], [True]

    def refuse(target, **given):
        tried.append(target)
        raise MotionError("out of reach", reason="unreachable")

    def reach(poses, q):
        asked.append((poses, q))
        return iter([SimpleNamespace(q=len(asked))] * reached[0])

    monkeypatch.setattr(giver, "move_to_pose", refuse)
    monkeypatch.setattr(receiver.ik, "nearest_first", reach)
    leaf = HoldOut(object="rod", receiver="right", robot="left")
    assert Trial(held_out, leaf).fails_with("out of reach")
    # The rod is 14 cm long; both grasps are 1 cm from its ends.
    expected = [
        (offset - 0.06, 0.0, 1.015 + height)
        for offset in (0.0, -0.05, -0.1, 0.05)
        for height in (0.535, 0.45, 0.4, 0.35, 0.3, 0.6)
    ]
    assert all(target.free_axis.tolist() == [0.0, 0.0, 1.0] for target in tried)
    at = np.array([target.pose.translation for target in tried])
    assert at == pytest.approx(np.array(expected), abs=1e-6)
    for k, (poses, q) in enumerate(asked):
        before, there = divmod(k, 2)[0], (0.22, 0.12)[k % 2]  # the approach, and the grasp
        axes = np.array([T.rotation.T for T in poses])
        assert axes[:, 2] == pytest.approx(np.tile([-1.0, 0.0, 0.0], (4, 1)), abs=1e-9)
        turned = axes[:, 0] @ axes[0, :2].T  # x axes by quarters of a turn
        assert turned == pytest.approx(np.array([(1, 0), (0, 1), (-1, 0), (0, -1)]), abs=1e-9)
        for T in poses:
            assert T.translation == pytest.approx(at[before] + (there, 0.0, 0.0), abs=1e-6)
        assert k % 2 == 0 or q == k
    monkeypatch.setattr(giver.ik, "nearest_first", lambda *_: iter([1]))
    assert leaf.why_infeasible() == ""
    monkeypatch.setattr(giver.ik, "nearest_first", lambda *_: iter([]))
    assert leaf.why_infeasible() == "'left' and 'right' reach no pose to hand 'rod' over"
    reached[0] = False
    why = "no pose to hold 'rod' out at is within reach of 'right'"
    assert Trial(held_out, leaf).fails_with(why)
    leaf = HoldOut(object="rod", receiver="rigth", robot="left")
    assert Trial(held_out, leaf).fails_with("there is no robot 'rigth'; did you mean 'right'")


def test_the_progress_of_a_hand_over_rises_with_every_stage(cell, handed_over):
    condition = handed_over.root
    near, far, rod, nothing = (0.05, 0.0, 0.7), (2.0, 0.0, 0.7), ("rod",), ()
    high = (0.0, 0.0, 0.7)

    def robot(position, held):
        arm = SimpleNamespace(tool_pose=spatial.pose(position))
        return SimpleNamespace(robot=arm, gripper=SimpleNamespace(held=held))

    progress = []
    for z, giver, receiver in (
        (0.115, robot(far, nothing), robot(far, nothing)),
        (0.115, robot(near, nothing), robot(far, nothing)),
        (0.115, robot(near, rod), robot(far, nothing)),  # on the table
        (0.7, robot(near, rod), robot(far, nothing)),
        (0.7, robot(near, rod), robot(near, nothing)),
        (0.7, robot(near, rod), robot(near, rod)),
    ):
        cell.move("rod", spatial.pose((0.0, 0.0 if z > 0.5 else 0.3, z)))
        cell.step(20 if z < 0.5 else 1)
        condition.robots = {"left": giver, "right": receiver}
        progress.append(condition.progress())
    near_it = [
        0.2 / (0.2 + np.linalg.norm(np.subtract(at, rod)))
        for rod in ((0.0, 0.3, 0.115), high)
        for at in (far, near)
    ]
    expected = [0.2 * near_it[0], 0.2 * near_it[1], 0.4]
    expected += [0.5 + 0.3 * near_it[2], 0.5 + 0.3 * near_it[3], 0.9]
    assert progress == pytest.approx(expected, abs=1e-3)
