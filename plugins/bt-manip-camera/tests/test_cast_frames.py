"""Poses from frames whose depths MuJoCo's ray casting finds; nothing is drawn."""

from types import SimpleNamespace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import looking_at
from bt_manip.spatial import pose
from bt_manip_camera.behaviours import SegmentTable
from bt_manip_camera.estimation import KnownObject, NotSeenError, estimate_pose, why_not
from bt_manip_camera.frame import Frame, focal_length
from bt_manip_camera.noise import DepthErrors
from bt_manip_camera.perception import sees_through
from bt_manip_camera.segmentation import find_clusters, fit_circle, fit_rectangle

SCENE = """<mujoco><worldbody><geom type="box" size=".6 .8 .02" pos=".3 0 .98"/>
<geom type="{kind}" size="{size}" pos="{place}" euler="0 0 {yaw}"/></worldbody></mujoco>"""
EYE, TARGET = (0.3, -0.35, 1.5), (0.3, 0.0, 1.0)
WIDTH, HEIGHT, FOVY = 320, 240, 50.0


def cast(kind="box", size=(0.06, 0.04, 0.05), at=(0.32, 0.03), yaw=0.0, eye=EYE, bias=0.0):
    """Return the frame of one thing on a table at height 1 m."""
    half = np.array(size) / 2.0
    text = SCENE.format(
        kind=kind, size="{} {} {}".format(*(half if kind == "box" else half[[0, 2, 2]])),
        place=f"{at[0]} {at[1]} {1.0 + half[2]}", yaw=np.degrees(yaw),
    )  # fmt: skip
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    T_wc = looking_at(eye, TARGET)
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


def test_a_cylinder_is_where_it_is_and_is_no_box():
    frame = cast("cylinder", (0.06, 0.06, 0.05))
    T = estimate_pose(frame, KnownObject("can", "cylinder", (0.06, 0.06, 0.05))).T_wo
    assert np.abs(T.translation - (0.32, 0.03, 1.025)).max() < 1.5e-3
    with pytest.raises(NotSeenError, match="it is round"):
        estimate_pose(frame, KnownObject("cube", "box", (0.06, 0.06, 0.05)))


def test_the_top_is_the_rectangle_at_the_height_of_the_box_above_the_table():
    (cluster,) = find_clusters(cast(size=(0.08, 0.04, 0.06), yaw=0.5))
    assert cluster.surface == pytest.approx(1.0, abs=2e-3)
    assert cluster.height == pytest.approx(0.06, abs=2e-3)
    assert cluster.rectangle.size == pytest.approx((0.08, 0.04), abs=4e-3)
    assert cluster.rectangle.yaw % np.pi == pytest.approx(0.5, abs=0.03)


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


@pytest.mark.parametrize("by", [-0.03, 0.03])
def test_a_box_that_is_longer_or_shorter_is_another_one(by):
    (cluster,) = find_clusters(cast(size=(0.10, 0.04, 0.05)))
    assert why_not(cluster, KnownObject("box", "box", (0.10, 0.04, 0.05))) == ""
    assert "its top is" in why_not(cluster, KnownObject("box", "box", (0.10 + by, 0.04, 0.05)))


@pytest.mark.parametrize("yaw", [0.2, 1.4])
def test_rectangles_and_circles_are_those_of_their_points_but_for_a_few(yaw):
    # 80 of 20,000 stray: the fits leave out 0.5 %.
    rng, centre = np.random.default_rng(0), (0.2, 0.1)
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    inside = rng.uniform((-0.04, -0.02), (0.04, 0.02), (20_000, 2))
    angle, radius = rng.uniform(0, 2 * np.pi, 20_000), 0.03 * np.sqrt(rng.uniform(size=20_000))
    disc = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    ends = np.array([[0.1, 0.0], [-0.1, 0.0], [0.0, 0.1], [0.0, -0.1]])
    for stray, length, angular in ((ends[:0], 5e-4, 0.01), (ends.repeat(20, axis=0), 2e-3, 0.02)):
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


def test_the_focal_length_is_that_of_half_the_angle():
    assert focal_length(480, 90.0) == pytest.approx(240.0)
    assert focal_length(480, 2.0 * np.degrees(np.arctan(0.5))) == pytest.approx(480.0)


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
    assert free(8, 6, 1.94) and not free(8, 6, 1.96) and not free(8, 6, -1.0)
    depth[4, 4] = 0.0
    assert not free(6, 6) and free(7, 7)
