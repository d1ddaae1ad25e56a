"""Poses from frames whose depths MuJoCo's ray casting finds; nothing is drawn."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy import interpolate

from bt_manip.cell import looking_at
from bt_manip.spatial import pose
from bt_manip_camera import segmentation
from bt_manip_camera.behaviours import SegmentTable
from bt_manip_camera.detections import Detections
from bt_manip_camera.estimation import Estimate, KnownObject, estimate_pose
from bt_manip_camera.frame import Frame, focal_length
from bt_manip_camera.noise import DepthErrors
from bt_manip_camera.perception import sees_through
from bt_manip_camera.segmentation import find_clusters, fit_circle, fit_rectangle
from bt_manip_camera.tags import SeenTag

SCENE = """<mujoco><worldbody><geom type="box" size=".6 .8 .02" pos=".3 0 .98"/>
<geom type="box" size="{size}" pos="{place}" euler="0 0 {yaw}"/></worldbody></mujoco>"""
EYE, TARGET = (0.3, -0.35, 1.5), (0.3, 0.0, 1.0)
WIDTH, HEIGHT, FOVY = 320, 240, 50.0


def cast(size=(0.06, 0.04, 0.05), at=(0.32, 0.03), yaw=0.0, bias=0.0):
    """Return the frame of one thing on a table at height 1 m."""
    half = np.array(size) / 2.0
    text = SCENE.format(
        size="{} {} {}".format(*half),
        place=f"{at[0]} {at[1]} {1.0 + half[2]}", yaw=np.degrees(yaw),
    )  # fmt: skip
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    T_wc = looking_at(EYE, TARGET)
    far = 0.5 * HEIGHT / np.tan(np.radians(FOVY / 2.0))  # pixels to the edge at half the angle
    u, v = np.meshgrid(np.arange(WIDTH) + 0.5 - WIDTH / 2, HEIGHT / 2 - 0.5 - np.arange(HEIGHT))
    rays = np.dstack([u, v, np.full(u.shape, -far)]).reshape(-1, 3) / far @ T_wc.rotation.T
    away, met = np.empty(len(rays)), np.empty(len(rays), np.int32)
    mujoco.mj_multiRay(
        model, data, T_wc.translation, rays.ravel(), None, 1, -1, met, away, None, len(rays), 10.0
    )
    depth = np.where(met >= 0, away + bias, 0.0).reshape(HEIGHT, WIDTH)
    return Frame(
        depth, np.full((HEIGHT, WIDTH, 3), 128, np.uint8), focal_length(HEIGHT, FOVY), T_wc
    )


def yaw_of(T):
    return np.arctan2(T.rotation[1, 0], T.rotation[0, 0])


@pytest.mark.parametrize("bias", [0.0, 0.01])
@pytest.mark.parametrize("size", [(0.08, 0.04, 0.05), (0.04, 0.08, 0.05), (0.05, 0.05, 0.05)])
@pytest.mark.parametrize("yaw", [0.0, 0.4, 1.3, -0.7])
def test_a_box_is_where_it_is_up_to_its_symmetry(size, yaw, bias):
    frame, known = cast(size=size, yaw=yaw, bias=bias), KnownObject("box", "box", size)
    T = estimate_pose(frame, known, surface=1.0).T_wo  # the height of the table tells the bias
    assert np.abs(T.translation - (0.32, 0.03, 1.025)).max() < 2e-3
    turn = np.pi / 2.0 if size[0] == size[1] else np.pi
    assert abs((yaw_of(T) - yaw + turn / 2.0) % turn - turn / 2.0) < 0.03
    assert abs(yaw_of(T)) <= turn / 2.0 + 1e-9


@pytest.mark.parametrize("yaw", [0.5, -0.5])
def test_a_thing_on_the_table_is_given_by_the_middle_of_its_top_and_its_long_side(yaw):
    frame = cast(size=(0.08, 0.04, 0.06), yaw=yaw)
    shown = []
    seeing = SimpleNamespace(frame=lambda: frame, surface=1.0, show=shown.append)
    ((x, y, z, *turn),) = SegmentTable.look(seeing)
    assert [one.frame for one in shown] == [frame]
    T = pose((x, y, z), turn)
    assert np.linalg.norm(turn) == pytest.approx(1.0)
    assert np.abs(T.translation - (0.32, 0.03, 1.06)).max() < 2e-3
    assert yaw_of(T) % np.pi == pytest.approx(yaw % np.pi, abs=0.03)


@pytest.mark.parametrize("yaw", [0.235, 2.02])  # 1.4 degrees off multiples of 3
def test_rectangles_and_circles_are_those_of_their_points_but_for_a_few(yaw):
    # 80 of 20,000 stray: the fits leave out 0.5 %.
    rng, centre = np.random.default_rng(0), (0.2, 0.1)
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    inside = rng.uniform((-0.04, -0.02), (0.04, 0.02), (20_000, 2))
    angle, radius = rng.uniform(0, 2 * np.pi, 20_000), 0.03 * np.sqrt(rng.uniform(size=20_000))
    disc = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    ends = np.array([[0.1, 0.0], [-0.1, 0.0], [0.0, 0.1], [0.0, -0.1]])
    for stray, length, angular in ((ends[:0], 4e-4, 0.01), (ends.repeat(20, axis=0), 2e-3, 0.02)):
        points = rng.permutation(np.vstack([inside, stray]))
        found = fit_rectangle(points @ turn.T + centre)
        np.testing.assert_allclose(found.centre, centre, atol=length)
        assert found.size == pytest.approx((0.08, 0.04), abs=length)
        assert found.yaw % np.pi == pytest.approx(yaw, abs=angular)
        circle = fit_circle(np.vstack([disc, stray]) + centre)
        np.testing.assert_allclose(circle.centre, centre, atol=length)
        assert circle.diameter == pytest.approx(0.06, abs=length)
        expected = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * (0.04, 0.02) @ turn.T + centre
        gaps = np.linalg.norm(found.corners()[:, None] - expected, axis=2)
        assert gaps.min(axis=0).max() < 2.0 * length and gaps.min(axis=1).max() < 2.0 * length
        away = np.linalg.norm(circle.corners() - centre, axis=1)
        np.testing.assert_allclose(away, 0.03, atol=2.0 * length)
        sides = np.linalg.norm(np.diff(circle.corners(), axis=0), axis=1)
        np.testing.assert_allclose(sides, 0.06 * np.sin(np.pi / 24), atol=length)
        stray = ends[:1].repeat(40 * len(stray) // 4, axis=0)  # of known sizes, any number
        points, off = rng.permutation(np.vstack([inside, stray])) @ turn.T + centre, (2e-3, -3e-3)
        moved = segmentation.Rectangle(np.add(centre, off), yaw + 0.06, (0.08, 0.04))
        found = segmentation.refine_rectangle(points, moved)
        assert (*found.centre, *found.size) == pytest.approx((*centre, 0.08, 0.04), abs=4e-4)
        assert found.yaw == pytest.approx(yaw, abs=8e-3)
        moved = segmentation.Circle(np.add(centre, off), 0.06)
        points = rng.permutation(np.vstack([disc, stray])) + centre
        assert segmentation.refine_circle(points, moved).centre == pytest.approx(centre, abs=4e-4)


def test_the_calibration_is_wrong_by_the_declared_distance_and_angle():
    errors = DepthErrors(calibration_distance=5e-3, calibration_angle=1.0)
    found = [errors.calibration_error(np.random.default_rng(seed)) for seed in range(200)]
    away = np.array([T.translation for T in found])
    turns = np.array([pin.log3(T.rotation) for T in found])
    for vectors, length in ((away, 5e-3), (turns, np.radians(1.0))):
        assert np.linalg.norm(vectors, axis=1) == pytest.approx(length)
        assert np.abs(vectors.mean(axis=0)).max() < 0.2 * length  # of all directions


def test_a_place_is_free_where_all_pixels_around_it_show_what_is_behind():
    depth = np.full((12, 16), 2.0)
    frame = Frame(depth, np.zeros((12, 16, 3), np.uint8), 10.0, pin.SE3.Identity())

    def free(u, v, away=1.0):
        at = np.array([(u + 0.5 - 8) / 10, (5.5 - v) / 10, -1.0])
        return sees_through(frame, away * at, 0.05)

    seen = [[free(u, v) for u in range(16)] for v in range(12)]
    expected = np.pad(np.ones((8, 12), bool), 2)  # 5 x 5 pixels
    np.testing.assert_array_equal(seen, expected)
    assert free(8, 6, 1.94) and not free(8, 6, 1.96) and not free(8, 6, -0.5)
    depth[4, 4] = 0.0
    assert not free(6, 6) and free(7, 7)


def painted(*things, turn=np.pi / 2, error=0.0):
    """Return a frame from 0.8 m above a table at height 1 m: rows, columns, height of things."""
    depth = np.full((HEIGHT, WIDTH), 0.8)
    for rows, columns, height in things:
        depth[slice(*rows), slice(*columns)] = 0.8 - height
    T_wc = pin.SE3(pin.utils.rotate("z", turn), np.array([0.3, -0.2, 1.8]))
    return Frame(depth + error, np.zeros((HEIGHT, WIDTH, 3), np.uint8), 400.0, T_wc)


def test_a_top_is_exact_where_the_surface_around_it_tells_the_error_of_the_depths():
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    error = 0.012 + 1e-5 * u - 5e-6 * v
    error[70:75, 60:68] += 4e-3  # and a few that lie
    strips = [((100 + a, 100 + b), (120, 160), z) for a, b, z in (
        (0, 12, 0.05), (12, 26, 0.0436), (26, 35, 0.0424),  # 1.2 mm more than counts as its top
    )]  # fmt: skip
    frame = painted(*strips, ((150, 180), (220, 240), 0.11), turn=0.7, error=error)
    frame.colour[100:126, 120:160] = (200, 30, 60)
    first, second = find_clusters(frame, 1.0)
    assert first.height == pytest.approx(0.05, abs=1e-9) and not first.at_border
    found = second.height, second.surface, second.pixel
    assert found == pytest.approx((0.11, 1.0, 0.69 / 400.0), abs=1e-9)
    rows, columns = np.mgrid[100:126, 120:160].reshape(2, -1)
    depth = np.where(rows < 112, 0.75, 0.7564)
    local = np.column_stack([columns - 159.5, 119.5 - rows]) * depth[:, None] / 400.0
    expected = local @ [[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]] + (0.3, -0.2)
    off = np.linalg.norm(first.top[:, None] - expected, axis=2).min(axis=0)
    assert np.sum(off < 1e-9) == len(first.top) >= 0.99 * len(expected)
    assert first.middle == pytest.approx(np.median(first.top, axis=0))
    found = *first.colour, first.pixel  # the latter of all that is seen of it
    assert found == pytest.approx((200 / 255, 30 / 255, 60 / 255, 0.7564 / 400.0))


def test_the_surface_on_any_side_tells_the_error_of_the_depths():
    for rows, columns in (
        ((0, 30), (0, WIDTH)), ((HEIGHT - 30, HEIGHT), (0, WIDTH)),
        ((0, HEIGHT), (0, 30)), ((0, HEIGHT), (WIDTH - 30, WIDTH)),
    ):  # fmt: skip
        (seen,) = find_clusters(painted((rows, columns, 0.05), error=4e-3), 1.0)
        assert seen.height == pytest.approx(0.05, abs=1e-9)
    (seen,) = find_clusters(painted(((0, HEIGHT), (0, WIDTH), 0.05), error=4e-3), 1.0)
    assert seen.height == pytest.approx(0.046)  # without any
    assert not find_clusters(painted()._replace(depth=np.zeros((HEIGHT, WIDTH))))


@pytest.mark.parametrize("turn", [0.0, np.pi])
def test_the_surface_within_15_cm_tells_the_error_of_the_depths_and_not_that_farther_away(turn):
    error = np.full((HEIGHT, WIDTH), 4e-3)
    error[140:] = error[:, 160:] = 9e-3  # 0.15 m are 75 pixels
    (seen,) = find_clusters(painted(((40, 60), (40, 80), 0.05), turn=turn, error=error), 1.0)
    assert seen.height == pytest.approx(0.05, abs=1e-9)


def test_a_rectangle_is_that_of_all_but_half_a_percent_of_the_points_at_each_end():
    x, y = np.meshgrid(np.linspace(-0.04, 0.04, 45), np.linspace(-0.02, 0.02, 22))
    ends = np.repeat([[0.1, 0.0], [-0.1, 0.0], [0.0, 0.09], [0.0, -0.09]], 5, axis=0)
    points = np.vstack([ends, np.column_stack([x.ravel(), y.ravel()])]) + (0.3, 0.1)
    found = fit_rectangle(points)  # 5 of 1010 points do not count at each end
    assert found.centre == pytest.approx((0.3, 0.1), abs=1e-9)
    assert found.size == pytest.approx(np.array((0.08, 0.04)) / (1 - 10 / 1010), abs=1e-9)
    assert found.yaw == pytest.approx(0.0, abs=1e-9)


def test_things_are_8_to_250_mm_high_and_apart_and_cut_at_the_border_only():
    for height, found in ((0.007, 0), (0.009, 1), (0.24, 1), (0.26, 0)):
        seen = find_clusters(painted(((100, 130), (140, 180), height)), 1.0)
        assert [one.height for one in seen] == pytest.approx([height] * found)
    for gap, number in ((2, 1), (6, 2)):  # 6 mm from point to point, and 14 mm
        frame = painted(((90, 130), (140, 160), 0.03), ((90, 130), (160 + gap, 180), 0.03))
        frame.depth[4:236:16, 4:316:16] -= 0.02  # single pixels are nothing, and join nothing
        frame.depth[114, 160 + gap // 2] = 0.77
        assert len(find_clusters(frame, 1.0)) == number
    assert not find_clusters(painted(((100, 130), (140, 180), 0.005), error=-6e-3), 1.0)
    things = ((20, 220), (5, 60), 0.05), ((100, 110), (300, 310), 0.03)  # 0.5 m apart
    for turn in (0.0, np.pi):
        assert len(find_clusters(painted(*things, turn=turn), 1.0)) == 2
    coarse = painted(((100, 120), (140, 160), 0.05))._replace(focal_length=200.0)
    assert len(find_clusters(coarse, 1.0)) == 1  # of pixels of 4 mm
    for near, cut in ((0, True), (1, False)):
        for rows in ((near, 30), (100, 130), (200, HEIGHT - near)):
            for columns in ((near, 30), (140, 170), (290, WIDTH - near)):
                (seen,) = find_clusters(painted((rows, columns, 0.05), error=4e-3), 1.0)
                assert seen.height == pytest.approx(0.05)
                assert seen.at_border == (cut and (rows[0], columns[0]) != (100, 140))
    for side, top, number in ((7, 4, 0), (8, 3, 0), (8, 4, 1)):  # 60 points, half of them on top
        parts = ((90, 90 + side), (140, 148), 0.03), ((90, 90 + top), (140, 148), 0.05)
        assert len(find_clusters(painted(*parts), 1.0)) == number


def test_the_surface_is_at_the_median_of_the_largest_of_equal_heights():
    rng = np.random.default_rng(0)
    here = np.concatenate([rng.uniform(0.7011, 0.7049, 70), np.repeat([0.6961, 0.709], (20, 60))])
    others = np.repeat([0.6931, 0.7131, 0.9, 0.5], (30, 65, 40, 1))
    z = rng.permutation(np.concatenate([here, others]))
    assert segmentation.surface_height(z) == pytest.approx(np.median(here))
    assert segmentation.surface_height(np.full(60, 0.7)) == pytest.approx(0.7)
    for few in (np.full(59, 0.7), np.linspace(0.0, 1.0, 100)):
        assert segmentation.surface_height(few) is None


def test_points_are_where_pixels_show_them_and_pixels_where_points_are():
    rng, T_wc = np.random.default_rng(0), looking_at((0.3, -0.4, 1.2), (0.1, 0.2, 0.3))
    depth, colour = rng.uniform(0.4, 1.5, (7, 9)), rng.integers(0, 256, (7, 9, 3), np.uint8)
    depth[2, 4] = 0.0
    frame = Frame(depth, colour, 11.0, T_wc)
    points, colours = frame.points(2)
    at = [(u, v) for v in range(0, 7, 2) for u in range(0, 9, 2) if (u, v) != (4, 2)]
    for (u, v), point, seen in zip(at, points, colours, strict=True):
        local = depth[v, u] * np.array([(u - 4.0) / 11.0, (3.0 - v) / 11.0, -1.0])
        np.testing.assert_allclose(point, T_wc.act(local))
        assert seen.tolist() == colour[v, u].tolist()
    np.testing.assert_allclose(frame.pixels(points), np.add(at, 0.5))


def test_outlines_are_around_tops_where_the_image_shows_them():
    T_wo = pin.SE3(pin.utils.rotate("z", 0.4), np.array([0.35, -0.15, 1.05]))
    fits = [
        (Estimate(kind, T_wo, 1e-3, 0.0, 0.0), KnownObject(kind, kind, (0.06, width, 0.1)))
        for kind, width in (("box", 0.04), ("cylinder", 0.06))
    ]
    local = np.mgrid[-0.03:0.03:61j, -0.02:0.02:41j].reshape(2, -1).T @ T_wo.rotation[:2, :2].T
    oblong = segmentation.Cluster(local + (0.35, -0.15), 0.1, 1.0, np.zeros(3), 1e-3)
    tag = SeenTag(3, T_wo, np.zeros(2), np.arange(8.0).reshape(4, 2))
    box, can, marked, thing = Detections(painted(), [oblong], fits, [tag]).outlines()
    assert [one.label for one in (box, can, marked)] == ["box", "cylinder", "tag 3"]
    assert [one.named for one in (box, can, marked, thing)] == [True, True, True, False]
    assert marked.pixels is tag.corners
    corners = np.array([(0.03, 0.02, 0), (-0.03, 0.02, 0), (-0.03, -0.02, 0), (0.03, -0.02, 0)])
    x, y, _ = T_wo.rotation @ corners.T + 0.05  # the camera is turned by a quarter, 0.7 m above
    expected = np.column_stack([160 + y * 400 / 0.7, 120 + x * 400 / 0.7])
    np.testing.assert_allclose(box.pixels, expected)
    assert np.linalg.norm(thing.pixels[:, None] - expected, axis=2).min(axis=0).max() < 1.0
    radii = np.linalg.norm(can.pixels - expected.mean(axis=0), axis=1)
    np.testing.assert_allclose(radii, 0.03 * 400 / 0.7)
    np.testing.assert_allclose(can.pixels.mean(axis=0), expected.mean(axis=0))


def test_errors_of_depths_vary_smoothly_and_by_pixels_and_unknown_ones_stay_unknown():
    depth = np.random.default_rng(1).uniform(0.6, 0.602, (13, 17))
    depth[3, 5] = 0.0
    errors = DepthErrors(noise=1e-3, smooth_noise=3e-3, bias=2e-3, dropout=0.0)
    found = errors.corrupt(depth, np.random.default_rng(0))
    rng, (v, u) = np.random.default_rng(0), np.mgrid[:13, :17]
    grid = interpolate.RegularGridInterpolator(
        (np.arange(4), np.arange(5)), rng.normal(size=(4, 5))
    )
    wrong = 1e-3 * rng.normal(size=depth.shape) + 3e-3 * grid((v / 4, u / 4))
    expected = np.where(depth > 0.0, depth + 2e-3 + (depth / 0.65) ** 2 * wrong, 0.0)
    np.testing.assert_allclose(found, expected)
    for step, lost in ((0.018, 0.0), (0.022, 0.25)):
        depth = np.full((400, 10), 0.7)
        depth[:, 5:] += step
        seen = DepthErrors(dropout=0.25).corrupt(depth, np.random.default_rng(0))
        near = np.repeat([0.0, lost, 0.0], (3, 4, 3))  # columns at the edge
        assert np.mean(seen == 0.0, axis=0) == pytest.approx(near, abs=0.08)
