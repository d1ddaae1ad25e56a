"""Grasps of primitives, compared with geometry worked out by hand."""

import contextlib
import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from bt_manip.exceptions import MotionError
from bt_manip.grippers.two_finger.antipodal_grasps import (
    AntipodalGrasp,
    box_grasps,
    cylinder_grasps,
    grasp_candidates,
    sampled_grasps,
    sphere_grasps,
)
from bt_manip.grippers.two_finger.antipodal_sampling import AntipodalPairs
from tests.grippers.shapes import DOWN, HAND, candidates, convex, solid, wedge

TURNED = pin.SE3(pin.rpy.rpyToMatrix(0.5, -0.3, 1.1), np.array([0.1, -0.2, 0.3]))


def approach(grasp):
    return grasp.T_ot.rotation[:, 2]


def closing(grasp):
    return grasp.T_ot.rotation[:, 1]


# The palm is 3 mm from a sphere of radius r when the tips are r - 16.5 mm above its centre. This
# may be a quarter of r, or the sine of 80 % of the friction angle: 16 % for a friction of 0.2.
@pytest.mark.parametrize(("radius", "friction", "gripped"), [
    (0.0218, 0.7, True), (0.0222, 0.7, False), (0.0194, 0.2, True), (0.0198, 0.2, False),
])  # fmt: skip
def test_a_sphere_too_large_for_the_palm_is_not_gripped_above_its_widest_point(
    radius, friction, gripped
):
    ball, hand = replace(solid("sphere", radius), friction=friction), HAND._replace(palm=0.01)
    with contextlib.nullcontext() if gripped else pytest.raises(MotionError, match="deep enough"):
        assert len(candidates(ball, hand=hand))


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule", "mesh"])
def test_an_object_that_is_too_wide_fails_with_its_width_and_the_stroke(kind):
    mesh = trimesh.creation.box((0.1, 0.11, 0.12))
    wide = convex(mesh) if kind == "mesh" else solid(kind, 0.05, 0.05, 0.05)
    with pytest.raises(MotionError, match="100 mm wide; the fingers open to 80 mm"):
        candidates(wide)


def test_an_object_without_clearance_between_the_fingers_fails_with_the_width_it_needs():
    with pytest.raises(MotionError, match="79 mm wide; the fingers open to 80 mm and need 82 mm"):
        candidates(solid("box", 0.0395, 0.05, 0.05))
    with pytest.raises(MotionError, match="79 mm wide; the fingers open to 80 mm and need 82 mm"):
        candidates(convex(trimesh.creation.box((0.079, 0.1, 0.1))))


def test_sampled_pairs_are_approached_in_five_directions_with_either_finger_first():
    R, p = TURNED.rotation, TURNED.translation
    places = np.array([[0.0, 0.01, 0.0155], [0.0, -0.03, 0.0]])
    aside = [0.02, 0.0, 0.0]
    pairs = AntipodalPairs(
        (places - aside) @ R.T + p, (places + aside) @ R.T + p, np.array([0.1, 0.2])
    )
    expected, contact = [], np.array([0.3, 0.9])
    for place, extent, *quality in zip(places, (0.04, 0.05), contact, (0.1, 0.2), strict=True):
        for k in range(-2, 3):  # eighths of a turn from straight down
            a = R @ pin.utils.rotate("x", k * math.pi / 4) @ [0.0, 0.0, -1.0]
            for line in (R[:, 0], -R[:, 0]):
                row = R @ place + p, line, a, 0.04, 0.0 if k else extent, quality
                expected.append(np.hstack(row))
    shape = solid("box", 0.02, 0.2, 0.0565, at=p, rotation=R)
    found = sampled_grasps([shape], pairs, contact, R @ [0.6, 0.0, -0.8])
    rows = sorted_rows(np.hstack(grasp[:7]) for grasp in found)
    assert rows == pytest.approx(sorted_rows(expected), abs=1e-9)


def test_an_object_is_half_a_millimetre_wider_than_the_closed_fingers():
    hand = HAND._replace(least=0.02)
    assert {*np.round(candidates(solid("box", 0.0103, 0.05, 0.05), hand=hand).width, 6)} == {0.0206}
    with pytest.raises(MotionError, match="20.4 mm wide; the .* open to 80 mm and close to 20 mm"):
        candidates(solid("box", 0.0102, 0.05, 0.05), hand=hand)


def test_the_same_seed_gives_the_same_grasps():
    made = [candidates(convex(wedge()), seed=seed) for seed in (3, 3, 4)]
    texts = [[grasp.to_text() for grasp in table] for table in made]
    assert texts[0] == texts[1] != texts[2]


def test_a_palm_too_near_to_the_fingertips_fails_with_the_length_of_the_fingers():
    with pytest.raises(MotionError, match="deep enough: the fingers extend 5 mm beyond the palm"):
        candidates(solid("box", 0.025, 0.025, 0.025), hand=HAND._replace(palm=-0.0045))


# A long box is also gripped on both sides of its centre; faces farther apart than 77 mm are not.
@pytest.mark.parametrize(
    "half", [(0.02, 0.0287, 0.036), (0.0265, 0.03, 0.026), (0.06, 0.02, 0.035)]
)
def test_a_box_is_gripped_by_its_faces_over_each_face_and_edge_that_is_not_below(half):
    R, p, expected = TURNED.rotation, TURNED.translation, []
    for i in (i for i in range(3) if 2.0 * half[i] <= 0.077):
        for k in range(8):  # eighths of a turn: faces and edges
            j, other = ((i + 1) % 3, (i + 2) % 3) if k % 4 == 0 else ((i + 2) % 3, (i + 1) % 3)
            a = pin.exp3(k * math.pi / 4 * R[:, i]) @ R[:, (i + 1) % 3]
            row, shift = (math.sqrt(0.5) * min(half[j], half[other]), 0.5), 0.0
            if k % 2 == 0:
                row = half[j], min(1.0, half[other] / HAND.pad)
                shift = 0.6 * (half[other] - HAND.pad) if half[other] > 3.0 * HAND.pad else 0.0
            for at in {0.0, shift, -shift} if a @ DOWN >= -0.1 else ():
                for closing in (R[:, i], -R[:, i]):
                    centre = p + at * R[:, other]
                    expected.append(np.hstack([centre, closing, a, 2.0 * half[i], *row]))
    found = box_grasps(solid("box", *half, at=p, rotation=R), HAND, DOWN)
    rows = sorted_rows(np.hstack(grasp[:6]) for grasp in found)
    assert rows == pytest.approx(sorted_rows(expected), abs=1e-9)


@pytest.mark.parametrize(
    ("kind", "half", "round_end"), [("cylinder", 0.03, 0), ("capsule", 0.017, 1)]
)
@pytest.mark.parametrize("radius", [0.008, 0.013])
def test_a_cylinder_is_gripped_across_it_along_it_and_at_its_ends(kind, half, round_end, radius):
    R, p = TURNED.rotation, TURNED.translation
    axis, eighth = R[:, 2], math.pi / 4
    steepest = DOWN - (DOWN @ axis) * axis
    steepest /= np.linalg.norm(steepest)

    def turned(vector, eighths):
        return pin.exp3(eighths * eighth * axis) @ vector

    expected, round_side = [], (2.0 * radius, 0.0, 0.8, 0.0, radius)
    for up in (-1.0, 1.0):
        side = 2.0 * radius, half, 0.8, 0.0, 0.0
        expected += [(p, turned(R[:, 0], k), up * axis, *side) for k in range(8)]
        for k in range(8):
            a = turned(steepest, k)
            shift = 0.6 * (half - HAND.pad) if half > 2.0 * HAND.pad else 0.0
            for at in {0.0, shift, -shift}:
                expected.append((p + at * axis, up * np.cross(axis, a), a, *round_side))
        width, contact = 2.0 * (half + round_end * radius), min(1.0, radius / HAND.pad)
        end = (width, 0.0, 0.6, 0.0, 0.0) if round_end else (width, 0.5 * radius, contact, 0.0, 0.0)
        expected += [(p, up * axis, turned(steepest, k), *end) for k in range(-2, 3)]
    rows = [np.hstack(row) for row in expected if row[2] @ DOWN >= -0.1]
    found = cylinder_grasps(solid(kind, radius, half, at=p, rotation=R), HAND, DOWN)
    assert sorted_rows(np.hstack(grasp[:8]) for grasp in found) == pytest.approx(sorted_rows(rows))


def sorted_rows(rows):
    rows = np.array([*rows])
    return rows[np.lexsort(np.round(rows, 6).T + 0.0)]


def test_only_a_single_round_solid_may_be_gripped_from_all_around():
    R, p = TURNED.rotation, TURNED.translation
    for kind, axis in (("sphere", DOWN), ("cylinder", R[:, 2])):
        found = candidates(solid(kind, 0.02, 0.05, at=p, rotation=R))
        assert found.clear and (found.free_axis == axis).all() and (found.pivot == p).all()
    two = candidates(solid("sphere", 0.02), solid("sphere", 0.02, at=(0.06, 0.0, 0.0)))
    assert two.free_axis is None and not two.clear
    assert candidates(solid("box", 0.02, 0.02, 0.02)).free_axis is None


def test_a_ball_is_approached_from_above_to_the_side_along_eight_diameters():
    found = list(sphere_grasps(solid("sphere", 0.02, at=TURNED.translation), HAND, 0.5 * DOWN))
    for i, grasp in enumerate(found):
        turn, tilt = 0.25 * math.pi * (i // 3), 0.25 * math.pi * (i % 3)
        far = (-1.0) ** (i // 3) * math.sin(tilt)  # either finger first
        # From the direction nearest to x, about straight down.
        expected = [math.cos(turn), -math.sin(turn), 0.0]
        assert grasp.closing == pytest.approx(expected, abs=1e-9)
        aside = np.cross(grasp.closing, DOWN)
        assert grasp.approach == pytest.approx(math.cos(tilt) * DOWN + far * aside, abs=1e-9)
        assert grasp[3:8] == (0.04, 0.0, 0.6, 0.0, 0.02)  # two points touch the pads
    assert len(found) == 24


def test_up_to_eight_solids_are_gripped_by_their_dimensions():
    cubes = [solid("box", 0.02, 0.02, 0.02, at=(0.1 * i, 0.0, 0.0)) for i in range(9)]
    alone = len(candidates(cubes[0]))
    assert len(candidates(*cubes[:8])) == 8 * alone and len(candidates(*cubes)) != 9 * alone


BALL_ON_BOX = [("sphere", 0.02), ("box", 0.02, 0.03, 0.03)]
OFF_CENTRE = math.asin(3.1 / 33.0)  # [rad] of a ball of 33 mm, where the palm ends the approach


# Of a box, a plate, a ball, the box below a ball as a part and as all, and a wide slope: the
# grasp, where the tool ends above the contacts [m], the largest angle of a normal there [rad], the
# costs of contact and slack, and how far the tool is short of the preferred depth [m].
@pytest.mark.parametrize(
    ("shapes", "given", "back", "angle", "contact", "slack", "short"),
    [
        ([("box", 0.02, 0.03, 0.05)], (0.04, 0.05, 0.7), 0.04, 0.0, 0.09, 0.0, 0.0),
        ([("box", 0.035, 0.03, 0.004)], (0.075, 0.004, 1, 0.2), 0.0095, 0.2, 0.0, 0.15, 0.0095),
        ([("sphere", 0.033)], (0.066, 0, 0.6, 0, 0.033), 0.0126, OFF_CENTRE, 0.12, 0.0, 0.0126),
        (BALL_ON_BOX, (0.04, 0.03, 1.0, 0.0, 0.0, 1), 0.02, 0.0, 0.0, 0.0, 0.0),
        (BALL_ON_BOX, (0.04, 0.03), 0.0296, 0.0, 0.0, 0.0, 0.0096),
        ([("box", 0.02, 0.03, 0.01)], (0.03, 0.0, 1.2, 0.9), 0.0045, 0.9, 0.0, 0.0, 0.0045),
    ],
)
def test_the_tool_is_as_deep_as_palm_tips_and_contacts_allow(
    shapes, given, back, angle, contact, slack, short
):
    R = TURNED.rotation
    placed = [
        solid(*shape, at=TURNED.act(np.array([0.0, 0.0, 0.03]) * (len(shapes) - 1 - i)), rotation=R)
        for i, shape in enumerate(shapes)
    ]
    made = AntipodalGrasp(TURNED.translation, R[:, 0], -R[:, 2], *given)
    hand = HAND._replace(centre=0.004, shift=0.5)
    found = grasp_candidates([made, made._replace(approach=R[:, 2])], hand, placed, False)
    one = found[0]
    # A fixed jaw is 1 mm beside the object.
    at = [-0.004 - 0.5 * (given[0] + 0.002), 0.0, back]
    assert TURNED.actInv(one.T_ot.translation) == pytest.approx(at, abs=1e-9)
    # The open pads are 3 mm beside the object, over their whole width.
    opened = given[0] + 0.006 + 2.0 * HAND.pad * math.tan(angle)
    assert one.width == given[0] and found.opening[0] == pytest.approx(min(opened / 0.08, 1.0))
    costs = [contact, min(angle / (math.pi / 4), 1.0), slack, 0.5 * short / (HAND.tip + HAND.palm)]
    names = ("contact", "angle", "slack", "depth")
    assert [found.costs[name][0] for name in names] == pytest.approx(costs)


# The tips are 1 mm above the support; 4 mm of them overlap faces, or 2 mm a point contact.
@pytest.mark.parametrize(
    ("half", "point", "gripped"),
    [(0.0026, False, True), (0.0024, False, False), (0.0031, True, True), (0.0029, True, False)],
)
def test_a_flat_object_is_gripped_where_the_fingers_fit_above_its_support(half, point, gripped):
    made = AntipodalGrasp(np.zeros(3), np.eye(3)[0], DOWN, 0.04, 0.0 if point else half)
    assert len(grasp_candidates([made], HAND, [solid("box", 0.02, 0.03, half)], True)) == gripped
