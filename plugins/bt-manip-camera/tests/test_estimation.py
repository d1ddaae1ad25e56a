"""Clusters on a table become named objects, or are refused with what was seen."""

import numpy as np
import pytest

from bt_manip.cell import Cell, looking_at
from bt_manip.cell.objects import Box
from bt_manip.spatial import pose
from bt_manip_camera.camera import DepthCamera
from bt_manip_camera.estimation import KnownObject, NotSeenError, estimate_pose, fit_pose
from bt_manip_camera.frame import Frame
from bt_manip_camera.segmentation import FEWEST, Cluster, find_clusters

BOX = KnownObject("box", "box", (0.06, 0.04, 0.05))


@pytest.fixture
def look(opengl, parts):
    """See boxes, given by place, yaw and parameters, from above a table."""

    def see(*boxes, target=(0.3, 0.0, 1.0), width=320, height=240):
        cell, camera = Cell(), DepthCamera(width=width, height=height)
        with cell.editing():
            cell.add(parts.objects.create("table"), pose((0.3, 0.0, 0.0)), name="table", free=False)
            top = cell.surface_height("table")
            for i, ((x, y), yaw, made) in enumerate(boxes):
                at = pose((x, y, top + made.rest_height), (np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)))
                cell.add(made, at, name=f"thing_{i}")
            cell.add(camera, looking_at((0.3, -0.35, 1.5), target), name="camera", free=False)
        return camera.expose(np.random.default_rng(0))

    return see


def box(**parameters):
    return Box(**{"size": (0.06, 0.04, 0.05), **parameters})


def test_single_pixels_of_noise_are_no_object():
    depth, rng = np.full((240, 320), 1.0), np.random.default_rng(3)
    rows, columns = np.arange(4, 236, 16), np.arange(4, 316, 16)
    depth[np.ix_(rows, columns)] -= rng.uniform(0.02, 0.1, (len(rows), len(columns)))
    frame = Frame(depth, np.zeros((240, 320, 3), np.uint8), 200.0, pose((0.0, 0.0, 1.0)))
    assert len(rows) * len(columns) > 4 * FEWEST
    assert find_clusters(frame) == []


def test_two_that_look_alike_are_refused(look):
    frame = look(((0.36, 0.0), 0.0, box()), ((0.22, 0.03), 0.0, box()))
    assert [round(float(one.middle[0]), 2) for one in find_clusters(frame)] == [0.22, 0.36]
    both = "2 things look like 'box': .* mm at .0.22.*; .* mm at .0.36"
    with pytest.raises(NotSeenError, match=both):
        estimate_pose(frame, BOX)


def test_colour_tells_two_of_one_size_apart(look):
    frame = look(
        ((0.36, 0.0), 0.0, box(colour=(0.9, 0.1, 0.1))),
        ((0.22, 0.03), 0.0, box(colour=(0.1, 0.2, 0.9))),
    )
    blue = KnownObject("blue", "box", BOX.size, (0.1, 0.2, 0.9))
    red = KnownObject("red", "box", BOX.size, (0.9, 0.1, 0.1))
    assert abs(estimate_pose(frame, blue, others=[red]).T_wo.translation[0] - 0.22) < 3e-3
    assert abs(estimate_pose(frame, red, others=[blue]).T_wo.translation[0] - 0.36) < 3e-3


def test_a_thing_that_fits_two_names_is_refused(look):
    twin = KnownObject("twin", "box", BOX.size)
    with pytest.raises(NotSeenError, match="'box' and 'twin' look like the same thing"):
        estimate_pose(look(((0.3, 0.0), 0.0, box())), BOX, others=[twin])


def test_what_was_seen_instead_is_said(look):
    with pytest.raises(NotSeenError, match="'box' is not seen; seen is .*it is 90 mm high"):
        estimate_pose(look(((0.3, 0.0), 0.0, box(size=(0.08, 0.08, 0.09)))), BOX)
    with pytest.raises(NotSeenError, match="'box' is not seen; seen is nothing"):
        estimate_pose(look(), BOX)


def test_what_the_border_cuts_is_not_named(look):
    frame = look(((0.3, 0.0), 0.0, box()), target=(-0.16, 0.0, 1.0))
    with pytest.raises(NotSeenError, match="it is cut by the image's border"):
        estimate_pose(frame, BOX)


def test_a_fit_tells_how_sure_it_is(look):
    (cluster,) = find_clusters(look(((0.3, 0.0), 0.3, box()), width=640, height=480))
    good = fit_pose(cluster, BOX)
    bad = fit_pose(cluster, KnownObject("box", "box", (0.066, 0.046, 0.05)))
    assert 0.2e-3 < good.position_error < 1.5e-3 < bad.position_error
    assert good.yaw_error < bad.yaw_error


def filled(length, width, yaw, at=(0.4, -0.1)):
    """Return points that fill a rectangle evenly, in no order."""
    x, y = np.meshgrid(*(side * (np.arange(120) - 59.5) / 120 for side in (length, width)))
    local = np.random.default_rng(0).permutation(np.column_stack([x.ravel(), y.ravel()]))
    return at + local @ np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])


@pytest.mark.parametrize(("size", "shape", "yaw", "misfit"), [
    ((0.06, 0.04, 0.05), "box", 0.3, 0.0), ((0.04, 0.06, 0.05), "box", 0.3 - np.pi / 2, 0.0),
    ((0.066, 0.04, 0.05), "box", 0.3, 6e-3), ((0.05, 0.05, 0.05), "cylinder", 0.0, None),
])  # fmt: skip
def test_a_pose_is_fitted_to_the_top_with_its_errors(size, shape, yaw, misfit):
    cluster = Cluster(filled(0.06, 0.04, 0.3), 0.05, 1.0, np.zeros(3), 2e-3)
    found = fit_pose(cluster, KnownObject("box", shape, size), 0.7)
    assert found.T_wo.isApprox(
        pose(found.T_wo.translation, (np.cos(yaw / 2), 0, 0, np.sin(yaw / 2))), 0.02
    )
    centre = (0.4, -0.1, 1.025)
    assert found.T_wo.translation == pytest.approx(centre, abs=4e-3 if misfit else 1e-3)
    assert found.time == 0.7 and found.name == "box"
    if misfit is None:  # two or three quarters of a pixel, and a quarter of what it is too large
        misfit = cluster.circle.diameter - 0.05
        assert found.yaw_error == 0.0
    else:
        assert found.yaw_error == pytest.approx(
            np.arctan2(1e-3 + 0.25 * misfit, max(size[:2]) / 2), rel=0.15
        )
    assert found.position_error == pytest.approx(np.hypot(1.5e-3, 0.25 * misfit), rel=0.05)
