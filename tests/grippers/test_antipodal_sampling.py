"""Antipodal pairs, compared with geometry worked out by hand."""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
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


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_best_pairs_are_near_the_centre_of_mass(side):
    rod, com = convex(trimesh.creation.box((0.04, 0.04, 0.3))), np.array([0.0, 0.0, 0.12 * side])
    pairs, _ = best_antipodal_pairs([rod], HAND, com, np.random.default_rng(0))
    assert side * (pairs.first[0] + pairs.second[0])[2] / 2.0 > 0.09


def test_a_triangular_prism_has_no_pairs_without_friction():
    prism = trimesh.creation.cylinder(0.02, 0.2, sections=3)

    def sides(cone):
        pairs = antipodal_pairs(
            [convex(prism).polyhedron], cone=cone, max_width=0.08, count=300,
            rng=np.random.default_rng(0),
        )  # fmt: skip
        return len(pairs.first)

    assert sides(math.radians(29.0)) == 0, "the sides are 60 degrees from being parallel"
    assert sides(math.radians(40.0)) > 0


def test_a_line_through_a_hollow_object_enters_and_leaves_each_wall():
    (found,) = intersect(
        [s.polyhedron for s in mug()], np.array([[0.0, 0.003, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    )
    assert found.enter == pytest.approx([-0.032, 0.028])
    assert found.leave == pytest.approx([-0.028, 0.032])


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


@pytest.mark.parametrize("half", [3e-3, 4e-3, 6.9e-3, 9e-3, 19e-3, 29e-3, 39e-3, 59e-3, 0.12])
def test_the_extent_of_a_face_is_estimated_as_half_to_all_of_it_up_to_12_cm(half):
    shape = solid("box", 0.02, 0.2, half)
    (extent,) = face_extents([shape], across(0.02), [np.array([0.0, 0.0, -1.0])])
    assert extent <= half and (extent > 0.5 * half or half <= 3e-3)
