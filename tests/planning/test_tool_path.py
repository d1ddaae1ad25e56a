"""The geometry of tool paths."""

from contextlib import nullcontext

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.exceptions import MotionError
from bt_manip.planning import ArcTo, LineTo, TurnAbout, tool_paths
from bt_manip.robots import ToolLimits

START = spatial.pointing_down([0.4, -0.2, 0.3])
CORNER = spatial.pointing_down([0.4, 0.1, 0.3], 0.5)
END = spatial.pointing_down([0.6, 0.1, 0.4], 0.2)
BLEND = 0.05


def positions(path, n=2001):
    """Return positions at even fractions of a path."""
    return np.array([path.pose(s).translation for s in np.linspace(0.0, 1.0, n)])


def test_a_line_is_straight_and_turns_at_a_constant_rate():
    (path,) = tool_paths(START, [LineTo(CORNER)])
    assert path.narrowest == 1.0  # no part of it is narrower than the whole
    for beyond, end in ((-0.2, START), (1.2, CORNER)):
        assert path.pose(beyond).isApprox(end)
    for s in np.linspace(0.0, 1.0, 11):
        T = path.pose(s)
        straight = (1.0 - s) * START.translation + s * CORNER.translation
        assert T.translation == pytest.approx(straight, abs=1e-12)
        turned = np.linalg.norm(pin.log3(START.rotation.T @ T.rotation))
        assert turned == pytest.approx(0.5 * s, abs=1e-9)


@pytest.mark.parametrize("via", [(0.5, -0.12, 0.35), (0.5, 0.12, 0.35), (0.4, -0.3, 0.3)])
def test_an_arc_passes_its_via_point_on_a_circle(via):
    (path,) = tool_paths(START, [ArcTo(via, END)])
    points = positions(path)
    assert points[0] == pytest.approx(START.translation) and points[-1] == pytest.approx(
        END.translation
    )
    assert np.linalg.norm(points - np.array(via), axis=1).min() < 1e-3
    # The centre is as far from three points as from all others, which are in one plane with it.
    a, b, c = points[0], np.array(via), points[-1]
    rows = np.array([b - a, c - a, np.cross(b - a, c - a)])
    right = [(b @ b - a @ a) / 2.0, (c @ c - a @ a) / 2.0, np.cross(b - a, c - a) @ a]
    centre = np.linalg.solve(rows, right)
    radii = np.linalg.norm(points - centre, axis=1)
    assert radii == pytest.approx(radii[0], abs=1e-9)
    assert (points - a) @ rows[2] == pytest.approx(0.0, abs=1e-9)
    assert path.length == pytest.approx(
        np.linalg.norm(np.diff(points, axis=0), axis=1).sum(), rel=1e-5
    )


def test_a_turn_about_an_axis_carries_the_tool_with_it():
    point, axis, angle = np.array([0.5, 0.0, 0.3]), np.array([0.0, 1.0, 2.0]), 1.2
    (path,) = tool_paths(START, [TurnAbout(point, axis, angle)])
    R = pin.exp3(angle * axis / np.linalg.norm(axis))
    T_turn = pin.SE3(R, point - R @ point)
    assert np.abs(pin.log6(path.pose(1.0).actInv(T_turn * START)).np).max() < 1e-9
    points = [
        T.actInv(pin.SE3(np.eye(3), point)).translation for T in map(path.pose, (0.0, 0.4, 1.0))
    ]
    assert points[1] == pytest.approx(points[0]) and points[2] == pytest.approx(points[0])


def test_a_blended_corner_leaves_the_lines_only_within_the_blend():
    (path,) = tool_paths(START, [LineTo(CORNER), LineTo(END)], BLEND)
    points = positions(path)
    corner = CORNER.translation
    directions = [
        (T.translation - corner) / np.linalg.norm(T.translation - corner) for T in (START, END)
    ]
    off = np.min(
        [
            np.linalg.norm((points - corner) - np.outer((points - corner) @ d, d), axis=1)
            for d in directions
        ],
        axis=0,
    )
    far = np.linalg.norm(points - corner, axis=1) > BLEND + 1e-9
    assert far.any() and off[far].max() < 1e-9
    assert off.max() > 1e-3
    assert 0.1 * BLEND < np.linalg.norm(points - corner, axis=1).min() < 0.35 * BLEND


def test_a_blend_takes_at_most_half_of_a_line():
    far = pin.SE3(END.rotation, END.translation - [0.2, 0.3, 0.1])
    (path,) = tool_paths(START, [LineTo(CORNER), LineTo(END), LineTo(far)], 10.0)
    points = positions(path)
    assert points[0] == pytest.approx(START.translation)
    assert points[-1] == pytest.approx(far.translation)
    (two,) = tool_paths(START, [LineTo(CORNER), LineTo(END)], 10.0)  # of 0.3 m and sqrt(0.05) m
    assert two.narrowest * two.travel == pytest.approx(np.sqrt(0.05))
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 1.01 * path.travel / 2000


@pytest.mark.parametrize(
    "steps",
    [
        [LineTo(CORNER), TurnAbout(CORNER.translation, (0.0, 0.0, 1.0), 0.8), LineTo(END)],
        [LineTo(CORNER), ArcTo([0.5, 0.2, 0.35], END)],
        [LineTo(CORNER), LineTo(START)],
    ],
    ids=["turning in the corner", "into an arc", "back"],
)
def test_the_curvature_is_continuous_in_a_corner(steps):
    (path,) = tool_paths(START, steps, BLEND)
    jerks = []
    for n in (1000, 2000):
        s = np.linspace(0.0, 1.0, n + 1)
        columns = path.extra_columns(s)[:, :6]
        assert np.array_equal(path.extra_columns(s)[:, 6], s)
        jerks.append(np.abs(np.diff(columns, 3, axis=0)).max() * n**3)
    # Where the second derivative jumps, third differences over h^3 grow with 1/h; or they converge.
    assert jerks[1] == pytest.approx(jerks[0], rel=0.02)


def test_the_derivative_of_the_angle_columns_is_the_angular_velocity():
    (path,) = tool_paths(START, [LineTo(CORNER), LineTo(END)], BLEND)
    s = np.linspace(0.0, 1.0, 4001)
    rate = np.gradient(path.extra_columns(s)[:, 3:6], s, axis=0)
    h = 1e-6
    for i in (500, 2000, 2300, 3500):
        R = [path.pose(s[i] + d).rotation for d in (-h, h)]
        turning = pin.log3(R[1] @ R[0].T) / (2.0 * h)
        assert rate[i] == pytest.approx(turning, abs=2e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LineTo(np.eye(4)), "pose must be a pin.SE3, got ndarray"),
        (lambda: ArcTo([0.0, np.nan, 0.0], END), "via point of an arc must be 3 finite numbers"),
        (lambda: ArcTo([0.0, 0.0, 0.0], None), "pose must be a pin.SE3"),
        (lambda: TurnAbout([0.0, 0.0], [0, 0, 1], 1.0), "point of the axis of a turn must be 3"),
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
def test_invalid_paths_are_refused_by_name(make, message):
    with pytest.raises(MotionError, match=message) as raised:
        make()
    assert raised.value.reason == "target"


@pytest.mark.parametrize(("near", "far"), [(9e-4, 1.0), (1.0, 9e-4), (0.2, 0.3)])
def test_three_points_are_on_a_line_below_an_angle_whatever_their_distances_are(near, far):
    for sine, straight in ((1e-7, True), (1e-5, False)):
        via = START.translation + [near, 0.0, 0.0]
        end = pin.SE3(START.rotation, START.translation + [far, far * sine, 0.0])
        with pytest.raises(MotionError, match="not on a line") if straight else nullcontext():
            ArcTo(via, end).segment(START)


@pytest.mark.parametrize("pair", [(0, 1), (0, 2), (1, 2)])
def test_three_points_of_which_two_are_within_a_micrometre_are_no_arc(pair):
    # The other one is so near that the triangle is not flat.
    for apart, refused in ((0.5e-6, True), (2e-6, False)):
        points = np.tile(START.translation, (3, 1)) + 1e-5 * np.eye(3)[[0, 0, 0]]
        points[list(pair)] = START.translation, START.translation + [0.0, apart, 0.0]
        start, via, end = (pin.SE3(START.rotation, point) for point in points)
        with pytest.raises(MotionError, match="are apart") if refused else nullcontext():
            ArcTo(via.translation, end).segment(start)


def test_limits_progress_and_grids_of_a_path_of_a_line_an_arc_and_a_turn():
    # A line of 0.3 m with 0.5 rad; half a turn at 0.1 m; a turn of 2 rad at 0.02 m, which counts
    # as 0.3 m/rad: they are 0.3 m, 0.1 pi m, and 0.6 m of travel.
    steps = [
        LineTo(CORNER), TurnAbout(CORNER.translation + [0.1, 0.0, 0.0], (0.0, 0.0, 2.0), -np.pi),
        TurnAbout(CORNER.translation + [0.2, 0.0, 0.02], (0.0, 3.0, 0.0), 2.0),
    ]  # fmt: skip
    travels = np.array([0.3, 0.3 * np.pi, 0.6])  # turning by pi counts more than 0.1 pi m
    lengths, angles = np.array([0.3, 0.1 * np.pi, 0.04]), np.array([0.5, np.pi, 2.0])
    (path,) = tool_paths(START, steps, 0.02)
    assert path.travel == pytest.approx(travels.sum())
    assert path.length == pytest.approx(lengths.sum()) and path.angle == pytest.approx(angles.sum())
    half = 0.02 / 1.0  # the line goes 1 m a metre of travel, the first arc a third, the last 1/15
    assert path.narrowest == pytest.approx(2.0 * half / travels.sum())
    assert path.grids[0] == int(25 / path.narrowest) and path.grids[1] == 2000
    tool = ToolLimits(0.5, 2.0, 40.0, 1.2, 5.0, 100.0)
    limits, whole = path.limits(tool), travels.sum()
    axis = np.array([1.0, 3.0**-0.5, 3.0**-0.5])[:, np.newaxis]
    linear, angular = np.array([[0.5, 2.0, 40.0], [1.2, 5.0, 100.0]])[:, :, np.newaxis]
    np.testing.assert_allclose(limits[:, :3], np.tile(axis * linear, 3))
    np.testing.assert_allclose(limits[:, 3:6], np.tile(axis * angular, 3))
    fastest = np.minimum(linear[:, 0] / whole, angular[:, 0] / (whole / 0.3))
    np.testing.assert_allclose(limits[:, 6], fastest)
    (line,) = tool_paths(START, steps[:1])
    np.testing.assert_allclose(
        line.limits(tool)[:, 0], np.minimum(linear[:, 0] / 0.3, angular[:, 0] / 0.5)
    )
    separate = tool_paths(START, steps)
    assert [one.name for one in (line, *separate)] == ["line", *["path"] * 3]
    share, text = separate[1].progress(0.5)
    assert share == pytest.approx((0.3 + 0.15 * np.pi) / whole)
    assert text == "42 % (0.457 m of 0.654 m, 2.071 rad of 5.642 rad)"
    assert line.progress(0.5)[1] == "50 % (0.150 m of 0.300 m, 0.250 rad of 0.500 rad)"
    (turn,) = tool_paths(START, [TurnAbout(START.translation, (0.0, 0.0, 1.0), -1.0)])
    assert turn.progress(0.25) == (0.25, "25 % (0.250 rad of 1.000 rad)")
    # Corners of less than 1.5 % of the travel, 0.0278 m, are stops; finer grids resolve corners.
    assert [len(tool_paths(START, steps, blend)) for blend in (0.0135, 0.0145)] == [2, 1]
    assert line.grids == (120, 360) and tool_paths(START, steps, 0.1)[0].grids == (360, 2000)
    (two,) = tool_paths(START, [TurnAbout(START.translation, (0, 0, 1), -1.0), LineTo(END)], 0.02)
    assert two.narrowest == pytest.approx(0.04 / two.travel)
