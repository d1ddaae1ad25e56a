"""Antipodal pairs, compared with geometry worked out by hand."""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from bt_manip.grippers.two_finger.antipodal_sampling import (
    AntipodalPairs,
    antipodal_pairs,
    best_antipodal_pairs,
    face_extents,
    friction_cone,
    intersect,
    pad_contact,
    sample_surface,
)
from tests.grippers.shapes import HAND, convex, mug, solid, wedge


def normals_at(mesh, point):
    """Return the normals of the triangles that a point lies on, found by distance alone."""
    nearest = trimesh.triangles.closest_point(mesh.triangles, np.tile(point, (len(mesh.faces), 1)))
    distance = np.linalg.norm(nearest - point, axis=1)
    assert distance.min() < 1e-6, "it is not on the surface"
    return mesh.face_normals[distance < 1e-6]


@pytest.mark.parametrize("make", [
    wedge,
    lambda: trimesh.creation.icosphere(subdivisions=2, radius=0.03),
    lambda: trimesh.creation.cylinder(0.03, 0.05, sections=7),
    lambda: trimesh.creation.capsule(0.04, 0.02, count=[9, 8]),
])  # fmt: skip
def test_antipodal_pairs_are_inside_both_friction_cones(make):
    mesh, cone = make(), 0.15
    pairs = antipodal_pairs(
        [convex(mesh).polyhedron],
        cone=cone,
        max_width=0.08,
        count=200,
        rng=np.random.default_rng(1),
    )
    assert len(pairs.first) > 5
    for first, second in zip(pairs.first, pairs.second, strict=True):
        line = (second - first) / np.linalg.norm(second - first)
        assert np.linalg.norm(second - first) <= 0.08
        for point, outward in ((first, -line), (second, line)):
            steepest = max(float(n @ outward) for n in normals_at(mesh, point))
            assert math.acos(min(steepest, 1.0)) <= cone + 1e-6


def test_a_hollow_object_is_gripped_from_outside_and_by_its_walls_and_nowhere_twice():
    pairs, _ = best_antipodal_pairs(mug(), HAND, np.zeros(3), np.random.default_rng(0))
    lines, widths = pairs.lines()
    assert any(w == pytest.approx(0.064, abs=1e-3) for w in widths)
    assert any(w == pytest.approx(0.004, abs=1e-3) for w in widths)
    centres = 0.5 * (pairs.first + pairs.second)
    for i, k in combinations(range(len(centres)), 2):
        alike = abs(lines[i] @ lines[k]) > math.cos(0.3) and abs(widths[i] - widths[k]) < 0.01
        assert not alike or np.linalg.norm(centres[i] - centres[k]) >= 5e-3


def test_grasps_stay_inside_80_percent_of_the_cone_of_the_objects_smallest_friction():
    box = solid("box", 0.01, 0.01, 0.01)  # friction 0.7
    assert friction_cone([box]) == pytest.approx(0.8 * math.atan(0.7))
    assert friction_cone([box, replace(box, friction=0.2)]) == pytest.approx(0.8 * math.atan(0.2))


def across(half):
    """Return the pair of points on both sides of the origin, along x."""
    return AntipodalPairs(np.array([[-half, 0.0, 0.0]]), np.array([[half, 0.0, 0.0]]), np.zeros(1))


@pytest.mark.parametrize(("shape", "contact"), [
    (solid("box", 0.02, 0.1, 0.1), 1.0),
    (solid("box", 0.02, 0.1, 0.65 * HAND.pad), 1.0),
    (solid("box", 0.02, 0.1, 0.55 * HAND.pad), 0.5),
    (solid("box", 0.02, 0.55 * HAND.pad, 0.55 * HAND.pad), 0.0),
    (solid("sphere", 0.012), 0.0),  # 1.2 mm deeper at 60 % of the pads
    (solid("sphere", 0.02), 1.0),  # 0.7 mm
])  # fmt: skip
def test_pads_are_in_contact_where_the_surface_is_within_1_mm_at_60_percent_of_them(shape, contact):
    assert pad_contact([shape], across(shape.size[0]), HAND) == pytest.approx([contact])


def pairs_at(*points):
    """Return pairs along x at points (y, z), 40 mm apart."""
    first = np.array([[-0.02, *point] for point in points])
    return AntipodalPairs(first, first + [0.04, 0.0, 0.0], np.zeros(len(points)))


def test_pads_beyond_one_edge_have_three_quarters_of_the_contact():
    edge = 0.1 - 0.3 * HAND.pad
    pairs = pairs_at((edge, 0.0), (-edge, 0.0), (0.0, 0.0), (0.0, edge), (0.0, -edge))
    contact = pad_contact([solid("box", 0.02, 0.1, 0.1)], pairs, HAND)
    assert contact == pytest.approx([0.75, 0.75, 1.0, 0.75, 0.75])


def test_the_extent_of_faces_is_measured_from_each_pair_against_its_approach():
    pairs, z, y = pairs_at((0.0, 0.0155), (0.0, 0.0155), (0.03, 0.0)), *np.eye(3)[2:0:-1]
    found = face_extents([solid("box", 0.02, 0.0565, 0.04)], pairs, [-z, z, y])
    assert found == pytest.approx([0.02, 0.05, 0.08])


def test_points_are_uniform_on_the_surface_of_a_union():
    half, shift = np.array([0.01, 0.02, 0.04]), np.array([0.015, 0.01, 0.0])
    boxes = [solid("box", *half).polyhedron, solid("box", *half, at=shift).polyhedron]
    points, _ = sample_surface(boxes, 60000, np.random.default_rng(0))
    # Each box has a corner of 5 mm by 30 mm by 80 mm in the other; common faces count twice.
    share = 1.0 - (5e-3 * 80e-3 + 30e-3 * 80e-3) / (8.0 * (half * np.roll(half, 1)).sum())
    assert len(points) / 60000 == pytest.approx(share, abs=6e-3)
    inside = [(np.abs(points - at) < half - 2e-5).all(axis=1) for at in (0.0 * shift, shift)]
    assert not np.any(inside)
    own = points[np.abs(points[:, 0] + half[0]) < 1e-9]  # the face of the first box away from both
    assert np.std(own, axis=0)[1:] == pytest.approx(half[1:] / math.sqrt(3.0), rel=0.03)
    assert abs(np.corrcoef(own[:, 1], own[:, 2])[0, 1]) < 0.05
    area = half[1] * half[2] / (4.0 * (half * np.roll(half, 1)).sum())
    assert len(own) / 60000 == pytest.approx(area, abs=6e-3)


def test_a_line_through_solids_that_overlap_or_touch_leaves_the_last_of_them():
    turned = pin.utils.rotate("z", 0.5)
    shapes = [
        solid("box", 0.01, 0.05, 0.05), solid("box", 0.002, 0.05, 0.05, at=(0.05, 0.0, 0.0)),
        solid("box", 0.01, 0.05, 0.05, at=(0.015, 0.0, 0.0), rotation=turned),
        solid("box", 0.01, 0.05, 0.05, at=(0.05, 0.0, 0.0)),  # around the second one
        solid("box", 0.001, 0.05, 0.05, at=(0.061005, 0.0, 0.0)),  # 5 micrometres behind
        solid("box", 0.001, 0.05, 0.05, at=(0.063045, 0.0, 0.0)),  # 40 micrometres
    ]  # fmt: skip
    for order in (1, -1):
        (walls,) = intersect(
            [s.polyhedron for s in shapes[::order]], np.zeros((1, 3)), np.eye(3)[:1]
        )
        enter, leave, normal_in, normal_out = zip(*walls, strict=True)
        assert enter == pytest.approx([-0.01, 0.04, 0.062045])
        assert leave == pytest.approx([0.015 + 0.01 / math.cos(0.5), 0.062005, 0.064045])
        assert np.allclose(normal_in, -np.eye(3)[0])
        assert np.allclose(normal_out, [turned[:, 0], np.eye(3)[0], np.eye(3)[0]])


def test_fingers_press_on_the_outer_walls_or_on_both_sides_of_each_wall():
    walls = [solid("box", half, 0.1, 0.1, at=(x, 0.0, 0.0)).polyhedron
             for half, x in ((0.005, -0.025), (0.002, 0.0), (0.01, 0.02))]  # fmt: skip
    given = {"cone": 0.4, "max_width": 0.08, "rng": np.random.default_rng(0)}
    lines, widths = antipodal_pairs(walls, count=400, **given).lines()
    along = np.abs(lines[:, 0]) > 1.0 - 1e-9
    assert {*np.round(widths[along], 6)} == {0.06, 0.01, 0.004, 0.02}
    plate = [solid("box", 0.01, 3.0, 3.0).polyhedron]
    pairs = antipodal_pairs(plate, count=2000, **given)
    lines, _ = pairs.lines()
    # All lines are in the cone, half of them along the normal and the others on all sides of it.
    assert len(lines) > 0.95 * 2000
    assert 0.39 < pairs.normal_angle.max() <= 0.4
    assert (pairs.normal_angle < 1e-6).mean() == pytest.approx(0.5, abs=0.02)
    assert np.arccos(np.abs(lines[:, 0])) == pytest.approx(pairs.normal_angle, abs=1e-6)
    assert np.std(lines[:, 1]) == pytest.approx(np.std(lines[:, 2]), rel=0.1)


def test_the_best_pairs_come_first_and_at_most_ten_of_them_are_parallel():
    com = np.array([0.01, 0.0, 0.05])
    step = [solid("box", 0.01, 0.1, 0.1, at=(0.0, 0.0, -0.1)),
            solid("box", 0.0175, 0.02, 0.1, at=(0.0, 0.0, 0.1))]  # fmt: skip
    pairs, contact = best_antipodal_pairs(step, HAND, com, np.random.default_rng(0))
    centres, (lines, widths) = 0.5 * (pairs.first + pairs.second), pairs.lines()
    # 5 cm from the centre of mass cost as much as no contact, or an angle of 1 rad.
    cost = np.linalg.norm(centres - com, axis=1) / 0.05 + (1.0 - contact) + pairs.normal_angle
    assert (np.diff(cost) >= 0.0).all() and len({*contact}) > 2
    assert contact == pytest.approx(pad_contact(step, pairs, HAND))
    alike = (np.abs(lines @ lines.T) > math.cos(0.3)) & (np.abs(widths[:, None] - widths) < 0.01)
    assert np.tril(alike, -1).sum(axis=1).max() == 9
    ball = [convex(trimesh.creation.icosphere(subdivisions=3, radius=0.03))]
    pairs, _ = best_antipodal_pairs(ball, HAND, np.zeros(3), np.random.default_rng(0))
    lines, _ = pairs.lines()
    assert len(lines) == 60


@pytest.mark.parametrize("half", [3e-3, 4e-3, 6.9e-3, 9e-3, 19e-3, 29e-3, 39e-3, 59e-3, 0.12])
def test_the_extent_of_a_face_is_estimated_as_half_to_all_of_it_up_to_12_cm(half):
    shape = solid("box", 0.02, 0.2, half)
    (extent,) = face_extents([shape], across(0.02), [np.array([0.0, 0.0, -1.0])])
    assert extent <= half and (extent > 0.5 * half or half <= 3e-3)
