"""A drawer is pulled open by its handle, with a limited force."""

from dataclasses import replace
from types import SimpleNamespace

from bt_manip import build_station
from bt_manip.behaviours import CloseGripper
from bt_manip.bt import NodeStatus
from bt_manip.evaluation import why_not
from bt_manip.grippers import TwoFingerGripper
from bt_manip_impedance import IsOpen, PullOpen, ReachHandle


def at_the_handle(parts, **drawer):
    """Return a station whose robot holds the handle."""
    scene = parts.scenes.create("open_drawer")
    *others, fixture = scene.objects
    scene = replace(scene, objects=(*others, replace(fixture, parameters=drawer)))
    station = build_station(parts, scene=scene)
    for behaviour in (ReachHandle("reach", object="drawer"), CloseGripper("close", force=50.0)):
        assert station.run(behaviour).status is NodeStatus.SUCCESS
    return station


def test_the_motion_that_was_blocked_is_the_one_that_is_made_again():
    motions = {"start": "over", "_move_down": "down", "begin_motion": lambda motion: motion}
    for phase in ("over", "down"):
        assert ReachHandle.begin_again(SimpleNamespace(_phase=phase, **motions)) == phase


def test_a_drawer_is_open_after_it_has_been_pulled(parts):
    station = at_the_handle(parts, resistance=10.0)
    is_open = IsOpen("open", object="drawer")
    assert station.run(is_open).status is NodeStatus.FAILURE
    assert 0.35 < is_open.progress() < 0.45  # the handle is held
    assert station.run(PullOpen("pull", object="drawer")).status is NodeStatus.SUCCESS
    station.cell.step(300)
    assert station.run(IsOpen("open", object="drawer")).status is NodeStatus.SUCCESS
    assert 0.15 <= station.cell.find("drawer").opening < 0.17
    station.cell.data.joint("drawer/slide").qvel = -0.1
    assert is_open.why_not() == "'drawer' moves at -100 mm/s"
    assert station.controllers.active == "computed_torque"


def test_a_drawer_that_is_stuck_is_not_pulled_with_more_than_the_allowed_force(parts):
    station = at_the_handle(parts, resistance=200.0)
    behaviour = PullOpen("pull", object="drawer", max_force=20.0)
    assert station.run(behaviour).status is NodeStatus.FAILURE
    assert "at most 20 N are allowed" in behaviour.feedback_message
    assert station.cell.find("drawer").opening < 0.01


def test_a_handle_that_is_not_held_is_not_pulled(parts):
    station = build_station(parts, scene=parts.scenes.create("open_drawer"))
    behaviour = PullOpen("pull", object="drawer")
    assert station.run(behaviour).status is NodeStatus.FAILURE
    is_open = IsOpen("open", object="drawer")
    assert station.run(is_open).status is NodeStatus.FAILURE
    assert 0.0 < is_open.progress() < 0.2
    assert behaviour.feedback_message == "the gripper does not hold 'drawer'"


def test_a_handle_that_is_too_thin_for_the_gripper_is_found_before_a_run(parts, monkeypatch):
    assert why_not("open_drawer", "panda", parts, starts=1) == ""
    monkeypatch.setattr(TwoFingerGripper, "min_object_width", 0.02)
    reason = why_not("open_drawer", "panda", parts, starts=1)
    assert reason.startswith("PullOpen: the gripper closes to 20.0 mm only")
