"""Coordination of two arms in one cell: they wait or stop for each other and never collide."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.arm.coordination import MultiArmCoordinator
from bt_manip.collision import INTER_ROBOT_CLEARANCE, INTER_ROBOT_STEP
from bt_manip.exceptions import MotionError
from bt_manip.trajectories import JointTrajectory, MotionProfile

MIDDLE = spatial.pointing_down((0.0, 0.0, 1.2))


def geoms_of(station, robot) -> np.ndarray:
    model = station.cell.model
    root = model.body_rootid[model.site_bodyid[robot.robot.tool_site_id]]
    own = model.body_rootid[model.geom_bodyid] == root
    return np.flatnonzero(own & (model.geom_contype != 0))


def distance(station) -> float:
    """Measure the distance of the two robots with MuJoCo's distance query, geom by geom [m]."""
    model, data, most = station.cell.model, station.cell.data, 0.2
    a, b = (geoms_of(station, robot) for robot in station.robots.values())
    gaps = np.linalg.norm(data.geom_xpos[a][:, np.newaxis] - data.geom_xpos[b], axis=2)
    gaps -= np.add.outer(model.geom_rbound[a], model.geom_rbound[b])  # of spheres around them
    nearest = most
    for pair in np.argsort(gaps, axis=None):
        i, j = np.unravel_index(pair, gaps.shape)
        if gaps[i, j] >= nearest:
            break
        nearest = min(nearest, mujoco.mj_geomDistance(model, data, a[i], b[j], most, None))
    return nearest


def smallest_distance(station, timeout: float = 6.0) -> float:
    """Step until all motions have ended; return the smallest distance of the robots [m]."""
    arms = [robot.arm for robot in station.robots.values()]
    nearest, end = distance(station), station.cell.time + timeout
    while any(arm.moving for arm in arms):
        assert station.cell.time < end
        station.cell.step(10)
        nearest = min(nearest, distance(station))
    return nearest


@pytest.fixture(scope="module")
def left_there(built):
    """The state in which the left arm rests in the middle."""
    station, start = built
    station.set_state(start)
    arm = station.robots["left"].arm
    arm.move_to_pose(MIDDLE)
    station.step_until(lambda: not arm.moving)
    return station.get_state()


@pytest.fixture
def left_leaves(station, left, left_there):
    """The left arm leaves the middle slowly."""
    station.set_state(left_there)
    left.arm.move_to_configuration(left.robot.description.home, speed=0.3)


def test_target_that_another_robot_occupies_or_will_is_refused_with_its_name(
    station, left, right, left_there
):
    left.arm.move_to_pose(MIDDLE)
    for state in (station.get_state(), left_there):  # during the motion there, and there
        station.set_state(state)
        with pytest.raises(MotionError, match="'left' blocks") as refused:
            right.arm.move_to_pose(MIDDLE)
        assert refused.value.reason == "robot" and not right.arm.moving


class Delayed(MultiArmCoordinator):
    """Coordinates an arm with another one, to which its motions come too near if they end early."""

    def __init__(self, arm, other, clear_from):
        self._names, self.clear_from, self.since = {arm: "arm", other: "other"}, clear_from, []

    def _collides(self, arm, trajectory, other, since):
        self.since.append(since)
        return trajectory.duration < self.clear_from


class StubArm:
    speed_scale, q, stopped = 1.0, np.array([0.3]), ""

    def __init__(self, moving, remaining, stopping=False):
        self.moving, self.remaining = moving, remaining
        self.follower = SimpleNamespace(stopping=stopping, ahead=lambda times: times)

    def stop(self, cause):
        self.stopped = cause


class Compared(MultiArmCoordinator):
    """Coordinates two arms that come too near to each other from a distance on."""

    def __init__(self, arm, other, now):
        self._names, self.now, self.compared = {arm: "arm", other: "other"}, now, []

    def _pair(self, paths):
        return self, *paths.values()

    def distance(self, first, second):
        return self.now

    def too_close(self, first, second, clearance):
        self.compared.append((first, second, clearance))
        return True


@pytest.mark.parametrize("now", [1.0, 0.5 * INTER_ROBOT_CLEARANCE])
@pytest.mark.parametrize(
    ("moving", "stopping", "other_moving", "other_stopping", "stopped"),
    [
        (1, 0, 1, 0, "other"),
        (0, 0, 1, 0, "other"),
        (1, 0, 1, 1, "arm"),
        (1, 0, 0, 0, "arm"),
        (1, 1, 0, 0, ""),
        (0, 0, 1, 1, ""),
    ],
)
def test_of_two_arms_that_come_nearer_than_their_clearance_or_than_they_are_one_stops(
    now, moving, stopping, other_moving, other_stopping, stopped
):
    arm, other = StubArm(moving, 0.305, stopping), StubArm(other_moving, 0.2, other_stopping)
    coordinator = Compared(arm, other, now)
    coordinator.motion_changed(arm)
    assert arm.stopped == ("'other' blocks the path" if stopped == "arm" else "")
    changed = "'arm' blocks the path: its motion has changed"
    assert other.stopped == (changed if stopped == "other" else "")
    for first, second, clearance in coordinator.compared:  # until both rest
        assert np.array_equal(first, second) and first[0] == 0.0
        assert 0.305 <= first[-1] <= 0.305 + INTER_ROBOT_STEP
        assert np.diff(first) == pytest.approx(INTER_ROBOT_STEP)
        nearest = INTER_ROBOT_CLEARANCE if now == 1.0 else now
        assert 0.0 <= nearest - clearance < 2e-4
    assert len(coordinator.compared) == bool(stopped)


def rest(duration):
    return JointTrajectory([MotionProfile([], duration, 0.3)])


@pytest.mark.parametrize(
    ("stop", "clear_from", "duration", "since"),
    [
        (None, 0.0, 1.0, [0.0]),
        (None, 1.15, 1.2, [0.0, 0.1, 0.2]),
        (None, 1.22, 1.25, [0.0, 0.1, 0.2, 0.25]),  # when the other one rests
        (None, 1.3, None, [0.0, 0.1, 0.2, 0.25]),
        (rest(0.4), 1.55, 1.6, [0.0] * 3),
    ],
)
def test_a_motion_starts_at_the_first_tenth_of_a_second_that_is_clear_of_the_other_arm(
    stop, clear_from, duration, since
):
    arm = StubArm(stop is not None, 9.0)
    coordinator = Delayed(arm, StubArm(True, 0.25), clear_from)
    if duration is None:
        with pytest.raises(MotionError, match="'other' blocks the motion"):
            coordinator.delay(arm, stop, rest(1.0))
    else:
        assert coordinator.delay(arm, stop, rest(1.0)).duration == pytest.approx(duration)
    assert coordinator.since == pytest.approx(since)
    arm.moving, coordinator.clear_from = True, 1.15
    with pytest.raises(MotionError, match="'other' blocks the motion"):
        coordinator.delay(arm, None, rest(1.0))  # it moves, and cannot wait


def test_the_base_of_another_robot_is_an_obstacle_and_not_that_robot(left):
    bodies = {left.arm.world.other_robot(f"right/{body}") for body in ("link1", "hand")}
    assert bodies == {"right"}
    assert left.arm.world.other_robot("right/link0") == ""  # it will not move away
    assert left.arm.world.other_robot("left/hand") == left.arm.world.other_robot("table") == ""


def test_motion_to_a_pose_that_another_robot_is_leaving_starts_later(station, left_leaves, right):
    right.arm.move_to_pose(MIDDLE)
    assert right.arm.remaining > 0.8  # alone it takes 0.6 s
    assert smallest_distance(station) > 0.8 * INTER_ROBOT_CLEARANCE
    assert np.linalg.norm(right.robot.tool_pose.translation - MIDDLE.translation) < 2e-3


def test_a_slow_arm_does_not_wait_for_one_that_leaves_before_it_arrives(
    station, left, right, left_there
):
    right.arm.speed_scale = 0.5
    right.arm.move_to_pose(MIDDLE)
    alone = right.arm.remaining
    station.set_state(left_there)
    right.arm.speed_scale = 0.5
    left.arm.move_to_configuration(left.robot.description.home, speed=0.3)
    assert left.arm.remaining < alone
    right.arm.move_to_pose(MIDDLE)
    assert right.arm.remaining == pytest.approx(alone)
    assert smallest_distance(station) > 0.8 * INTER_ROBOT_CLEARANCE


def at_random(station, rng, moves: int, speed_scale: float = 1.0) -> tuple[float, int]:
    """Move both arms at random; return their smallest distance [m] and the number of motions."""
    for robot in station.robots.values():
        robot.arm.speed_scale = speed_scale
    nearest, made = distance(station), 0
    for _ in range(moves):
        robot = station.robots[("left", "right")[int(rng.integers(2))]]
        position = rng.uniform((-0.2, -0.25, 1.1), (0.2, 0.25, 1.35))
        try:
            robot.arm.move_to_pose(spatial.pointing_down(position, rng.uniform(-1.5, 1.5)))
            made += 1
        except MotionError as error:
            assert error.reason in ("robot", "unreachable", "collision")
        for _ in range(int(rng.integers(2, 40))):  # so that many start during other motions
            station.cell.step(10)
            nearest = min(nearest, distance(station))
    return nearest, made


def test_random_motions_of_two_arms_come_near_but_never_collide(station):
    rng = np.random.default_rng(0)
    nearest, made = at_random(station, rng, 18)
    assert made >= 9 and 0.6 * INTER_ROBOT_CLEARANCE < nearest < 5.0 * INTER_ROBOT_CLEARANCE
    nearest, made = at_random(station, rng, 8, speed_scale=0.4)
    assert made >= 3 and nearest > 0.5 * INTER_ROBOT_CLEARANCE
    assert not any(robot.arm.fault for robot in station.robots.values())


@pytest.mark.soak
def test_many_random_motions_of_two_arms_never_collide(station):
    nearest, made = at_random(station, np.random.default_rng(1), 600)
    assert made >= 250 and nearest > 0.5 * INTER_ROBOT_CLEARANCE
    assert not any(robot.arm.fault for robot in station.robots.values())


def test_arm_stops_when_another_one_stops_on_its_path(station, left_leaves, left, right):
    right.arm.move_to_pose(MIDDLE)
    station.cell.step(100)
    left.arm.stop()
    assert "'left' blocks" in right.arm.fault
    assert smallest_distance(station) > 0.5 * INTER_ROBOT_CLEARANCE
    assert np.linalg.norm(right.robot.tool_pose.translation - MIDDLE.translation) > 0.05


def test_resumed_arm_stops_when_another_one_blocks_its_path_by_now(station, left, right):
    left.arm.move_to_pose(spatial.pointing_down((-0.25, 0.0, 1.2)))
    station.step_until(lambda: not left.arm.moving)
    left.arm.move_linear(spatial.pointing_down((0.1, 0.0, 1.2)), speed=0.3)
    station.cell.step(100)
    left.arm.pause()
    station.step_until(lambda: left.arm.paused)
    right.arm.move_to_pose(spatial.pointing_down((0.15, 0.0, 1.2)))  # around where it rests
    station.step_until(lambda: not right.arm.moving)
    left.arm.resume()
    assert "'right' blocks" in left.arm.fault
    assert smallest_distance(station) > 0.5 * INTER_ROBOT_CLEARANCE
