"""Clusters on a table become named objects, or are refused with what was seen."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from bt_manip.spatial import pose
from bt_manip_camera.estimation import KnownObject, NotSeenError, estimate_pose, fit_pose, why_not
from bt_manip_camera.segmentation import Cluster, find_clusters

from .test_segmentation import painted

BOX = KnownObject("box", "box", (0.06, 0.04, 0.05))


def test_two_that_look_alike_are_refused():
    frame = painted(((140, 161), (140, 172), 0.05), ((80, 101), (140, 172), 0.05))
    assert [round(float(one.middle[0]), 3) for one in find_clusters(frame)] == [0.245, 0.357]
    both = "2 things look like 'box': .* mm at .0.245.*; .* mm at .0.357"
    with pytest.raises(NotSeenError, match=both):
        estimate_pose(frame, BOX)


def test_what_was_seen_instead_is_said():
    with pytest.raises(NotSeenError, match="'box' is not seen; seen is .*it is 90 mm high"):
        estimate_pose(painted(((80, 122), (140, 182), 0.09)), BOX)
    with pytest.raises(NotSeenError, match="'box' is not seen; seen is nothing"):
        estimate_pose(painted(), BOX)


def filled(length, width, yaw, at=(0.4, -0.1)):
    """Return points that fill a rectangle evenly, in no order."""
    x, y = np.meshgrid(*(side * (np.arange(120) - 59.5) / 120 for side in (length, width)))
    local = np.random.default_rng(0).permutation(np.column_stack([x.ravel(), y.ravel()]))
    return at + local @ np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])


# A box that is nearly square looks the same after a quarter turn.
@pytest.mark.parametrize(
    ("top", "size", "shape", "yaw"),
    [
        ((0.06, 0.04), (0.06, 0.04, 0.05), "box", 0.3),
        ((0.06, 0.04), (0.04, 0.06, 0.05), "box", 0.3 - np.pi / 2),
        ((0.06, 0.04), (0.066, 0.04, 0.05), "box", 0.3),
        ((0.06, 0.04), (0.06, 0.044, 0.05), "box", 0.3),
        ((0.0505, 0.047), (0.047, 0.0505, 0.05), "box", 0.3),
        ((0.0515, 0.047), (0.047, 0.0515, 0.05), "box", 0.3 - np.pi / 2),
        ((0.06, 0.04), (0.05, 0.05, 0.05), "cylinder", 0.0),
    ],
)
def test_a_pose_is_fitted_to_the_top_with_its_errors(top, size, shape, yaw):
    cluster = Cluster(filled(*top, 0.3), 0.05, 1.0, np.zeros(3), 2e-3)
    found = fit_pose(cluster, KnownObject("box", shape, size), 0.7)
    turn = pose(found.T_wo.translation, (np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)))
    assert found.T_wo.isApprox(turn, 0.02)
    misfit = np.abs(np.sort(size[:2]) - np.sort(cluster.rectangle.size)).max()
    yaw_error = np.arctan2(1e-3 + 0.25 * misfit, max(size[:2]) / 2)
    if shape == "cylinder":
        misfit, yaw_error = cluster.circle.diameter - 0.05, 0.0
    atol = 1e-3 if misfit < 1e-3 else 4e-3
    assert found.T_wo.translation == pytest.approx((0.4, -0.1, 1.025), abs=atol)
    assert found.time == 0.7 and found.name == "box"
    assert found.position_error == pytest.approx(np.hypot(1.5e-3, 0.25 * misfit))
    assert found.yaw_error == pytest.approx(yaw_error)


def test_a_thing_can_be_what_is_as_large_to_6_mm_and_two_pixels_as_round_and_of_its_colour():
    def seen(top, colour=(0.4, 0.0, 0.0)):
        return Cluster(top, 0.05, 1.0, np.array(colour), 1e-3)

    square = filled(0.05, 0.05, 0.0, (0.0, 0.0))
    disc = square[np.hypot(*square.T) < 0.025]
    oblong, sizes = filled(0.06, 0.04, 0.3), np.array([0.06, 0.04, 0.05])
    for off, other in itertools.product((7.4e-3, -7.4e-3, 8.6e-3, -8.6e-3), np.eye(3)):
        size, why = sizes + off * other, "mm high" if other[2] else "its top is"
        known = KnownObject("box", "box", tuple(size[[1, 0, 2]]))
        assert (why in why_not(seen(oblong), known)) == (abs(off) > 8e-3)
        known = KnownObject("can", "cylinder", (0.05 + off, 0.05 + off, 0.05))
        assert ("its top is" in why_not(seen(disc), known)) == (abs(off) > 8e-3)
    for longer, oval in ((1.15, False), (1.25, True)):
        top, known = seen(disc * (longer, 1.0)), KnownObject("thing", "box", (0.06, 0.05, 0.05))
        assert ("it is round" in why_not(top, known)) != oval
        known = KnownObject("thing", "cylinder", (0.055, 0.055, 0.05))
        assert ("not round" in why_not(top, known)) == oval
    for angle, other in ((24.0, False), (26.0, True)):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        known = KnownObject("box", "box", tuple(sizes), (0.9 * c, 0.0, 0.9 * s))
        assert (f"colour is {angle:.0f} degrees" in why_not(seen(oblong), known)) == other
    assert "180 degrees" in why_not(seen(oblong, (0.0, 0.0, 0.0)), known)
    assert "cut by the image's border" in why_not(replace(seen(oblong), at_border=True), known)
