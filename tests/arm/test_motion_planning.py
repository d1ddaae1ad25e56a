"""Planning is a function of its arguments: it repeats bit for bit and changes no arm."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.arm.motion_planning import (
    ConfigurationRequest,
    FollowRequest,
    PlanningScene,
    PoseRequest,
    ServoRequest,
    ToolPathRequest,
    plan,
)
from bt_manip.planning import LineTo
from tests.measuring.scenes import free_start, wall


@pytest.fixture(scope="module")
def walled():
    planned, left, right = wall()
    return planned.arm, free_start(planned, left), right


def request_of(kind, arm, start, right):
    here = arm.model.pose(arm.q)
    above = spatial.pose((0.0, 0.0, 0.05)) * here
    return {
        "configuration": ConfigurationRequest(start + [0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.8),
        "pose": PoseRequest(right, 1.0, 0.05, 0.0),
        "tool path": ToolPathRequest([LineTo(above)], 1.0, 0.0, False),
        "follow": FollowRequest(above, 1.0),
    }[kind]


def as_data(motion):
    return None if motion is None else (motion.trajectory.get_state(), *motion[1:])


@pytest.mark.parametrize(("moving", "speed_scale"), [(False, 0.0), (True, 0.5)])
@pytest.mark.parametrize("kind", ["configuration", "pose", "tool path", "follow"])
def test_equal_arguments_give_the_same_trajectory(walled, kind, moving, speed_scale):
    arm, start, right = walled
    arm.reset(start)
    if moving:
        arm.move_to_pose(right)
        for _ in range(150):
            arm.follower.advance(1e-3)  # nothing is simulated: it would not follow
    arm.speed_scale = speed_scale
    for _ in range(20 if moving else 0):
        arm.follower.advance(1e-3)
    assert arm.moving == moving
    request = request_of(kind, arm, start, right)
    scene = PlanningScene(arm.model, arm.ik, arm.world, arm.planner)
    state = arm.follower.state
    before = arm.get_state()
    first = plan(request, state, scene, np.random.default_rng(3))
    assert arm.get_state() == before
    other = state._replace(q=state.q.copy(), v=state.v.copy(), a=state.a.copy())
    second = plan(request, other, scene, np.random.default_rng(3))
    assert arm.get_state() == before
    assert as_data(first) == as_data(second)


def test_requests_of_the_arm_are_planned_by_that_function(walled):
    arm, start, right = walled
    arm.reset(start)
    scene = PlanningScene(arm.model, arm.ik, arm.world, arm.planner)
    motion = plan(
        PoseRequest(right, 1.0, 0.05, 0.0), arm.follower.state, scene, np.random.default_rng(0)
    )
    arm.move_to_pose(right)
    assert arm.trajectory.get_state() == motion.trajectory.get_state()


def test_a_moving_arm_stops_at_a_request_of_velocities_beyond_its_limits(walled):
    arm, start, _ = walled
    arm.reset(start)
    scene = PlanningScene(arm.model, arm.ik, arm.world, arm.planner)
    request = ServoRequest(1.1 * arm.model.limits.velocity, 0.2, False)
    assert plan(request, arm.follower.state, scene, np.random.default_rng(0)) is None
    arm.move_to_configuration(start + 0.2)
    for _ in range(50):
        arm.follower.advance(1e-3)
    motion = plan(request, arm.follower.state, scene, np.random.default_rng(0))
    assert motion.stops and motion.trajectory.duration < 0.3


def test_a_motion_whose_speed_cannot_be_changed_yet_goes_on_and_is_changed_later(walled):
    arm, start, _ = walled
    arm.reset(start)
    goal = start + np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    arm.move_to_configuration(goal)
    while arm.a[0] > -0.99 * arm.model.limits.acceleration[0]:
        arm.follower.advance(1e-3)
    # It brakes at the limit: braking along the trajectory too would exceed that.
    scene = PlanningScene(arm.model, arm.ik, arm.world, arm.planner)
    state = arm.follower.state._replace(speed_scale=0.1)
    motion = plan(ConfigurationRequest(goal, 1.0), state, scene, np.random.default_rng(0))
    assert motion.lagging
    assert motion.trajectory.duration == pytest.approx(arm.remaining, abs=2e-3)
