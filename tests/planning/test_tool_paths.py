"""Lines and arcs of the tool: their geometry, and the motions that follow them."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from bt_manip.planning import (
    QUICK_REFINEMENTS,
    ArcTo,
    LineTo,
    TurnAbout,
    follow_tool_path,
    tool_paths,
)
from bt_manip.planning.collision_check import check_tool_path
from bt_manip.robots import ToolLimits
from bt_manip.trajectories import effort_use, limit_use

START = spatial.pointing_down([0.4, -0.2, 0.3])
CORNER = spatial.pointing_down([0.4, 0.1, 0.3], 0.5)
END = spatial.pointing_down([0.6, 0.1, 0.4], 0.2)
BLEND = 0.05


def places(path, n=2001):
    return np.array([path.pose(s).translation for s in np.linspace(0.0, 1.0, n)])


def tool_motion(arm, trajectory, step=1e-3):
    """Velocity [m/s] and angular velocity [rad/s] of the tool, by Pinocchio."""
    q, v, _ = trajectory.sample(np.arange(0.0, trajectory.duration, step))
    rates = np.array([arm.model.jacobian(x) @ u for x, u in zip(q, v, strict=True)])
    return rates[:, :3], rates[:, 3:]


def planned(arm):
    return arm.trajectory


@pytest.fixture
def at_start(arm) -> Arm:
    arm.reset(arm.ik.nearest(START, arm.model.home).q)
    return arm


# Geometry


def test_a_line_is_straight_and_turns_evenly():
    (path,) = tool_paths(START, [LineTo(CORNER)])
    for s in np.linspace(0.0, 1.0, 11):
        T = path.pose(s)
        straight = (1.0 - s) * START.translation + s * CORNER.translation
        assert T.translation == pytest.approx(straight, abs=1e-12)
        turned = np.linalg.norm(pin.log3(START.rotation.T @ T.rotation))
        assert turned == pytest.approx(0.5 * s, abs=1e-9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_an_arc_goes_through_its_point_on_a_circle(side):
    via = np.array([0.5, side * 0.12, 0.35])
    (path,) = tool_paths(START, [ArcTo(via, END)])
    way = places(path)
    assert way[0] == pytest.approx(START.translation) and way[-1] == pytest.approx(END.translation)
    assert np.linalg.norm(way - via, axis=1).min() < 1e-3
    # The centre is as far from three points as from all others, which are in one plane with it.
    a, b, c = way[0], via, way[-1]
    rows = np.array([b - a, c - a, np.cross(b - a, c - a)])
    right = [(b @ b - a @ a) / 2.0, (c @ c - a @ a) / 2.0, np.cross(b - a, c - a) @ a]
    centre = np.linalg.solve(rows, right)
    radii = np.linalg.norm(way - centre, axis=1)
    assert radii == pytest.approx(radii[0], abs=1e-9)
    assert (way - a) @ rows[2] == pytest.approx(0.0, abs=1e-9)
    assert path.length == pytest.approx(
        np.linalg.norm(np.diff(way, axis=0), axis=1).sum(), rel=1e-5
    )


def test_an_arc_with_its_point_far_around_is_longer_than_half_a_circle():
    end = pin.SE3(START.rotation, START.translation + [0.1, 0.0, 0.0])
    (path,) = tool_paths(START, [ArcTo(START.translation + [0.05, 0.2, 0.0], end)])
    assert path.length > np.pi * 0.1


def test_a_turn_about_an_axis_carries_the_tool_with_it():
    point, axis, angle = np.array([0.5, 0.0, 0.3]), np.array([0.0, 1.0, 2.0]), 1.2
    (path,) = tool_paths(START, [TurnAbout(point, axis, angle)])
    R = pin.exp3(angle * axis / np.linalg.norm(axis))
    T_turn = pin.SE3(R, point - R @ point)
    assert np.abs(pin.log6(path.pose(1.0).actInv(T_turn * START)).np).max() < 1e-9
    seen = [
        T.actInv(pin.SE3(np.eye(3), point)).translation for T in map(path.pose, (0.0, 0.4, 1.0))
    ]
    assert seen[1] == pytest.approx(seen[0]) and seen[2] == pytest.approx(seen[0])


def test_a_turn_about_an_axis_through_the_tool_leaves_it_in_its_place():
    (path,) = tool_paths(START, [TurnAbout(START.translation, (0.0, 0.0, 1.0), -1.0)])
    assert places(path) == pytest.approx(np.tile(START.translation, (2001, 1)))
    assert path.angle == pytest.approx(1.0) and path.length < 1e-12


def test_without_a_blend_the_tool_halts_in_each_corner():
    paths = tool_paths(START, [LineTo(CORNER), LineTo(END)])
    assert [np.round(path.pose(1.0).translation, 9).tolist() for path in paths] == [
        CORNER.translation.tolist(),
        END.translation.tolist(),
    ]


def test_a_rounded_corner_stays_near_it_and_leaves_the_lines_within_the_blend():
    (path,) = tool_paths(START, [LineTo(CORNER), LineTo(END)], BLEND)
    way = places(path)
    corner = CORNER.translation
    directions = [
        (T.translation - corner) / np.linalg.norm(T.translation - corner) for T in (START, END)
    ]
    off = np.min(
        [
            np.linalg.norm((way - corner) - np.outer((way - corner) @ d, d), axis=1)
            for d in directions
        ],
        axis=0,
    )
    far = np.linalg.norm(way - corner, axis=1) > BLEND + 1e-9
    assert far.any() and off[far].max() < 1e-9
    assert off.max() > 1e-3
    assert 0.1 * BLEND < np.linalg.norm(way - corner, axis=1).min() < 0.35 * BLEND


def test_a_blend_takes_at_most_half_of_a_line():
    (path,) = tool_paths(START, [LineTo(CORNER), LineTo(END)], 10.0)
    way = places(path)
    assert way[0] == pytest.approx(START.translation) and way[-1] == pytest.approx(END.translation)
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).max() < 1.01 * path.travel / 2000


@pytest.mark.parametrize(
    "steps",
    [
        [LineTo(CORNER), LineTo(END)],
        [LineTo(CORNER), TurnAbout(CORNER.translation, (0.0, 0.0, 1.0), 0.8), LineTo(END)],
        [LineTo(CORNER), ArcTo([0.5, 0.2, 0.35], END)],
        [LineTo(CORNER), LineTo(START)],
    ],
    ids=["lines", "turning in the corner", "into an arc", "back"],
)
def test_the_curvature_of_place_and_rotation_does_not_jump_in_a_corner(steps):
    (path,) = tool_paths(START, steps, BLEND)
    bends = []
    for n in (2000, 4000):
        s = np.linspace(0.0, 1.0, n + 1)
        carried = path.extra_columns(s)[:, :6]
        assert np.array_equal(path.extra_columns(s)[:, 6], s)
        bends.append(np.abs(np.diff(carried, 3, axis=0)).max() * n**3)
    # Where the second derivative jumps, third differences over h^3 grow with 1/h; or they converge.
    assert bends[1] == pytest.approx(bends[0], rel=0.02)


def test_the_angle_that_a_path_carries_has_the_turning_for_its_derivative():
    (path,) = tool_paths(START, [LineTo(CORNER), LineTo(END)], BLEND)
    s = np.linspace(0.0, 1.0, 4001)
    rate = np.gradient(path.extra_columns(s)[:, 3:6], s, axis=0)
    h = 1e-6
    for i in (500, 2000, 2300, 3500):
        R = [path.pose(s[i] + d).rotation for d in (-h, h)]
        turning = pin.log3(R[1] @ R[0].T) / (2.0 * h)
        assert rate[i] == pytest.approx(turning, abs=2e-3)


# Motions


@pytest.mark.parametrize(
    ("steps", "blend"),
    [
        ([LineTo(CORNER), LineTo(END)], 0.0),
        ([LineTo(CORNER), LineTo(END), LineTo(START)], 0.03),
        ([ArcTo([0.5, 0.0, 0.35], CORNER)], 0.0),
        ([TurnAbout([0.4, 0.0, 0.3], [0.0, 0.0, 1.0], -1.0)], 0.0),
        ([LineTo(CORNER), ArcTo([0.5, 0.2, 0.35], END)], 0.04),
    ],
    ids=["halting", "polyline", "arc", "turn", "line and arc"],
)
def test_a_path_is_driven_to_its_end_inside_all_limits(at_start, steps, blend):
    arm = at_start
    paths = tool_paths(arm.model.pose(arm.q), steps, blend)
    arm.move_path(steps, blend=blend)
    trajectory = planned(arm)
    assert limit_use(trajectory, arm.model.limits).inside
    assert effort_use(trajectory, arm.model) <= 0.96
    q, *_ = trajectory.sample(np.linspace(0.0, trajectory.duration, 150))
    poses = [path.pose(s) for path in paths for s in np.linspace(0.0, 1.0, 4001)]
    near = np.array([T.translation for T in poses])
    for x in q:
        T = arm.model.pose(x)
        far = np.linalg.norm(near - T.translation, axis=1)
        assert far.min() < 3e-4
        beside = [poses[i] for i in np.flatnonzero(far < far.min() + 5e-4)]
        off = min(np.linalg.norm(pin.log3(T.rotation.T @ other.rotation)) for other in beside)
        assert off < 4e-3
    while arm.moving:
        arm.advance(1e-3)
    assert np.abs(pin.log6(paths[-1].pose(1.0).actInv(arm.model.pose(arm.q))).np).max() < 1e-5


@pytest.mark.parametrize("blend", [0.0, 0.04])
def test_the_tool_is_never_faster_than_its_limits(at_start, blend):
    arm = at_start
    limits = ToolLimits(velocity=0.25, acceleration=1.5, angular_velocity=0.6)
    arm.model.tool_limits = limits
    arm.move_path([LineTo(CORNER), ArcTo([0.5, 0.2, 0.35], END), LineTo(START)], blend=blend)
    linear, angular = tool_motion(arm, planned(arm))
    speed = np.linalg.norm(linear, axis=1)
    assert 0.95 * 0.25 < speed.max() <= 1.001 * 0.25
    assert np.linalg.norm(angular, axis=1).max() <= 1.001 * 0.6
    acceleration = np.linalg.norm(np.gradient(linear, 1e-3, axis=0), axis=1)
    assert acceleration.max() <= 1.02 * 1.5


def test_half_the_speed_takes_twice_the_time(at_start):
    steps = [LineTo(CORNER), LineTo(END)]
    at_start.move_path(steps, blend=BLEND)
    fast = planned(at_start).duration
    at_start.reset(at_start.ik.nearest(START, at_start.model.home).q)
    at_start.move_path(steps, 0.5, blend=BLEND)
    assert planned(at_start).duration == pytest.approx(2.0 * fast, rel=0.02)


def test_a_rounded_corner_is_passed_without_a_halt_and_sooner(at_start):
    durations = []
    for blend in (0.0, 0.08):
        at_start.reset(at_start.ik.nearest(START, at_start.model.home).q)
        at_start.move_path([LineTo(CORNER), LineTo(END)], blend=blend)
        speed = np.linalg.norm(tool_motion(at_start, planned(at_start))[0], axis=1)
        durations.append(planned(at_start).duration)
        slowest = speed[60:-60].min()
        assert slowest < 1e-3 if blend == 0.0 else slowest > 0.1
    assert durations[1] < durations[0]


def test_a_path_stops_and_resumes_on_itself(at_start):
    arm = at_start
    (path,) = tool_paths(arm.model.pose(arm.q), [LineTo(CORNER), LineTo(END)], BLEND)
    near = places(path, 8001)
    arm.move_path([LineTo(CORNER), LineTo(END)], blend=BLEND)
    for _ in range(int(1e3 * 0.5 * arm.remaining)):
        arm.advance(1e-3)
    arm.pause()
    while arm.moving:
        arm.advance(1e-3)
    assert arm.paused
    assert np.linalg.norm(near - arm.model.pose(arm.q).translation, axis=1).min() < 2e-4
    arm.resume()
    while arm.moving:
        arm.advance(1e-3)
    assert np.linalg.norm(arm.model.pose(arm.q).translation - END.translation) < 1e-5


def test_the_state_of_a_path_goes_on_bit_for_bit(at_start, robot):
    arm = at_start
    arm.move_path([LineTo(CORNER), ArcTo([0.5, 0.2, 0.35], END)], blend=BLEND)
    for _ in range(200):
        arm.advance(1e-3)
    other = Arm(robot, ik=arm.ik)
    other.set_state(arm.get_state())
    for _ in range(300):
        arm.advance(1e-3)
        other.advance(1e-3)
        assert np.array_equal(arm.q, other.q)


# What cannot be done


@pytest.mark.parametrize("blend", [0.0, 0.03])
def test_a_path_that_leaves_the_reach_says_how_far_of_all_it_goes(at_start, blend):
    far = spatial.pointing_down([1.4, 0.1, 0.3], 0.5)
    with pytest.raises(MotionError, match=r"the path can be followed only for \d+ %") as e:
        at_start.move_path([LineTo(CORNER), LineTo(far)], blend=blend)
    assert e.value.reason == "line" and not at_start.moving
    # Of 0.3 m to the corner and 1 m from there, it may get along x to where the arm is stretched.
    assert "of 1.300 m" in str(e.value)
    assert 0.3 / 1.3 < e.value.fraction < (0.3 + 0.5) / 1.3


def test_a_path_through_something_says_how_much_of_it_is_free(walled):
    arm = Arm(walled.robot, ik=walled.ik, world=walled.world)
    arm.reset(arm.ik.nearest(walled.left, arm.model.home).q)
    aside = pin.SE3(walled.left.rotation, np.array([0.4, 0.25, 0.2]))
    through = pin.SE3(walled.left.rotation, np.array([0.4, -0.25, 0.2]))
    with pytest.raises(MotionError, match=r"the path is blocked after \d+ % .* 'wall'") as raised:
        arm.move_path([LineTo(aside), LineTo(through)], blend=0.03)
    assert raised.value.reason == "collision"
    first = np.linalg.norm(aside.translation - walled.left.translation)
    assert first / (first + 0.5) < raised.value.fraction < (first + 0.25) / (first + 0.5)
    assert not arm.moving


def test_a_line_is_followed_with_a_joint_led_along_its_limit(model, ik):
    q0 = np.array([-1.072, -0.626, 0.458, -2.31, 0.266, 1.729, 2.847])  # joint 7 by its limit
    start = model.pose(q0)
    down = pin.SE3(start.rotation, start.translation - [0.0, 0.0, 0.385])
    (path,) = tool_paths(start, [LineTo(down)])
    curve = follow_tool_path(ik, q0, path)
    q = curve.evaluate(np.linspace(0.0, 1.0, 3000), 0)[0][:, : model.nq]
    assert (model.limits.upper - q).min() < 0.01
    assert model.limits.contain(q, 1e-9)
    assert np.abs(model.pose(q[-1]).translation - down.translation).max() <= 1e-7


@pytest.mark.parametrize("size", [1e-8, 1e-7, 1e-6, 1e-5, 1e-4])
@pytest.mark.parametrize("turned", [False, True])
def test_the_least_way_is_driven_inside_all_limits_too(at_start, size, turned):
    arm = at_start
    T = arm.model.pose(arm.q)
    little = np.array([0.0, 0.0, size])
    aside = pin.SE3(pin.exp3(little), np.zeros(3)) if turned else pin.SE3(np.eye(3), little)
    arm.move_linear(T * aside)
    assert 0.0 < arm.remaining < 0.05
    assert limit_use(planned(arm), arm.model.limits).inside
    while arm.moving:
        arm.advance(1e-3)
    assert np.abs(pin.log6(arm.model.pose(arm.q).actInv(T * aside)).np).max() <= 2e-8


def test_a_look_at_the_knots_tells_ways_apart_as_a_close_look_does(walled, rng):
    ik, world = walled.ik, walled.world
    home = ik.model.home
    places = rng.uniform([0.35, -0.35, 0.2, -3.0], [0.65, 0.35, 0.35, 3.0], (40, 4))
    verdicts = []
    for x, y, z, yaw in places:
        T = spatial.pointing_down([x, y, z], yaw)
        tilted = pin.SE3(T.rotation @ pin.exp3(rng.uniform(-0.4, 0.4, 3)), T.translation)
        q = ik.solve(tilted, home).q
        start = ik.model.pose(q)
        ahead = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.15]))
        (path,) = tool_paths(start, [LineTo(start * ahead)])
        try:
            curve = follow_tool_path(ik, q, path, QUICK_REFINEMENTS)
        except MotionError:
            continue
        told = []
        for closely in (True, False):
            try:
                check_tool_path(world, curve, path, fine=closely)
            except MotionError as error:
                told.append(error.reason)
            else:
                told.append("")
        assert told[0] == told[1]
        verdicts.append(told[0])
    assert 5 < verdicts.count("") < len(verdicts) - 5


def test_a_line_on_which_the_joints_turn_sharply_is_driven_inside_all_limits(arm):
    arm.reset([2.558, -0.092, 1.678, -1.425, 1.705, 0.252, -0.388])  # nearly singular
    start = arm.model.pose(arm.q)
    along = np.array([0.108, 0.199, 0.005])
    arm.move_linear(pin.SE3(start.rotation, start.translation + along))
    assert limit_use(planned(arm), arm.model.limits).inside
    direction = along / np.linalg.norm(along)
    for q in planned(arm).sample(np.arange(0.0, arm.remaining, 0.02))[0]:
        gone = arm.model.pose(q).translation - start.translation
        assert np.linalg.norm(gone - direction * (direction @ gone)) <= 6e-5


@pytest.mark.parametrize("angle", [-3.0, -np.pi])
def test_a_turn_is_slow_only_where_a_joint_comes_to_its_limit(arm, angle):
    arm.reset([-0.181, -0.117, -0.233, -2.318, -0.033, 2.204, 0.392])
    place = arm.model.pose(arm.q).translation
    arm.move_path([TurnAbout(place, (0.0, 0.0, 1.0), angle)])
    trajectory, limits = planned(arm), arm.model.limits
    assert limit_use(trajectory, limits).inside and effort_use(trajectory, arm.model) <= 0.96
    q, v, _ = trajectory.sample(np.arange(0.0, trajectory.duration, 1e-3))
    assert limits.upper[6] - q[:, 6].max() < 0.01
    before = (q[:, 6] > 0.8) & (q[:, 6] < 2.2)
    assert (np.abs(v[before]) / limits.velocity).max(axis=1).min() > 0.8
    # No joint is faster than its limit: on its way from knot to knot the path takes this at least.
    ways = np.abs(np.diff(trajectory.path.knots[:, :7], axis=0))
    assert trajectory.duration < 2.0 * (ways / limits.velocity).max(axis=1).sum()
    assert max(np.abs(arm.model.pose(x).translation - place).max() for x in q) <= 5e-5


def test_nothing_to_do_is_no_motion(at_start):
    T = at_start.model.pose(at_start.q)
    at_start.move_path([])
    at_start.move_path([LineTo(T), LineTo(T)], blend=0.01)
    assert not at_start.moving


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LineTo(np.eye(4)), "pose must be a pin.SE3, got ndarray"),
        (
            lambda: ArcTo([0.0, np.nan, 0.0], END),
            "via point of an arc must be 3 finite numbers",
        ),
        (lambda: ArcTo([0.0, 0.0, 0.0], None), "pose must be a pin.SE3"),
        (
            lambda: TurnAbout([0.0, 0.0], [0, 0, 1], 1.0),
            "point of the axis of a turn must be 3",
        ),
        (lambda: TurnAbout([0.0, 0.0, 0.0], [0, 0, 0], 1.0), "axis of a turn must not be zero"),
        (lambda: TurnAbout([0.0, 0.0, 0.0], [0, 0, 1], np.inf), "finite number .rad., got inf"),
        (lambda: tool_paths(START, [END]), "a LineTo, ArcTo or TurnAbout, got SE3"),
        (lambda: tool_paths(START, [LineTo(END)], -0.1), "blend must be at least 0 .m., got -0.1"),
        (lambda: tool_paths(START, [LineTo(END)], np.nan), "blend must be at least 0 .m., got nan"),
        (
            lambda: tool_paths(START, [ArcTo(0.5 * (START.translation + END.translation), END)]),
            "three points that are apart and not on a line",
        ),
        (lambda: tool_paths(START, [ArcTo([0.5, 0.0, 0.3], START)]), "three points that are apart"),
    ],
)
def test_what_is_no_path_is_refused_by_name(make, message):
    with pytest.raises(MotionError, match=message) as raised:
        make()
    assert raised.value.reason == "target"
