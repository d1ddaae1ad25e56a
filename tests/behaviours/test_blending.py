"""Behaviours that complete before the arm has come to rest, and those that come after them."""

import pytest

from bt_manip.behaviours import CloseGripper, Hover, Lift, MoveHome, Reach, SetSpeed, Stop
from bt_manip.bt import NodeStatus, Sequence

RUNNING, SUCCESS, FAILURE = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE
BLENDED = {"object": "cube", "height": 0.3, "blend_radius": 0.2}


@pytest.fixture
def blended(station, trial):
    """Hover until the next motion may begin."""
    assert trial(Hover(**BLENDED)).until_done() is SUCCESS
    assert station.arm.moving and station.arm.blend_radius == 0.2


def test_hover_and_reach_take_less_time_without_a_rest_between_them(station, trial):
    start, times = station.get_state(), []
    for radius in (0.0, 0.2):
        station.set_state(start)
        begun = station.cell.time
        hover = Hover(object="cube", height=0.3, blend_radius=radius)
        assert trial(Sequence("both", hover, Reach(object="cube"))).until_done() is SUCCESS
        times.append(station.cell.time - begun)
        tool = station.robot.tool_pose.translation
        assert tool[:2] == pytest.approx(station.cell.pose("cube").translation[:2], abs=2e-3)
        assert not station.arm.moving
    assert times[1] < times[0] - 0.05


def test_a_blended_reach_takes_the_path_that_hover_found(station, trial, blended, monkeypatch):
    requested = []
    move_linear = station.arm.move_linear

    def noted(*args, joint_path=None, **options):
        requested.append(joint_path)
        return move_linear(*args, joint_path=joint_path, **options)

    monkeypatch.setattr(station.arm, "move_linear", noted)
    assert trial(Reach(object="cube")).tick() is RUNNING
    (path,) = requested
    assert path.knots[-1, :7] == pytest.approx(station.arm.target, abs=1e-9)


def test_a_behaviour_that_needs_rest_waits_for_it(station, trial, blended):
    closing, gripper = trial(CloseGripper()), station.robot.gripper
    while station.arm.moving:
        assert closing.tick() is RUNNING and gripper.is_open
    closing.until_done()
    assert station.arm.blend_radius == 0.0 and not gripper.is_open


def test_a_waiting_behaviour_goes_on_from_its_state(trial, blended):
    closing, other = trial(CloseGripper()), trial(CloseGripper())
    assert closing.tick() is RUNNING
    other.tree.set_state(closing.tree.get_state())
    assert other.tick() is RUNNING and "s left" in other.behaviour.feedback_message


@pytest.mark.parametrize("follower", [Lift, CloseGripper])
def test_a_disturbance_in_between_is_the_reason_of_the_next_behaviour(
    station, trial, blended, follower
):
    station.arm.stop("somebody pushed")
    assert trial(follower()).fails_with("somebody pushed")
    assert trial(MoveHome()).tick() is RUNNING


@pytest.mark.parametrize("follower", [lambda: SetSpeed(speed=0.5), Stop])
def test_behaviours_that_need_no_rest_start_at_once(station, trial, blended, follower):
    trial(follower()).tick()
    assert station.arm.moving and (station.arm.speed_scale == 0.5 or station.arm.follower.stopping)


def test_an_arm_with_nothing_to_follow_comes_to_rest_at_its_target(station, blended):
    target = station.arm.target
    while station.arm.moving:
        station.cell.step()
    assert station.robot.q == pytest.approx(target, abs=2e-3)
