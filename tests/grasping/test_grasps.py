"""Grasps by geometry: where fingers can press, checked against shapes worked out by hand."""

import math

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from bt_manip.exceptions import MotionError
from bt_manip.grasping import Candidates, Grasp, Hand, Solid, antipodal_pairs
from bt_manip.grasping.antipodal import cross
from bt_manip.grasping.mesh import cone_of_friction, sampled_pairs
from bt_manip.grasping.polyhedron import bounded_by, triangles_of
from bt_manip.grasping.ranking import Ranking

DOWN = np.array([0.0, 0.0, -1.0])
# Much like the Panda's.
HAND = Hand(np.array([0.0, 1.0, 0.0]), 0.08, 0.0, 0.0095, 0.0234, 0.00875, 1.0)


def solid(kind, *size, at=(0.0, 0.0, 0.0), rotation=None):
    T = pin.SE3(np.eye(3) if rotation is None else rotation, np.array(at))
    return Solid(kind, np.array([*size, 0.0, 0.0][:3]), T, 0.7)


def convex(mesh):
    return Solid("mesh", np.zeros(3), pin.SE3.Identity(), 0.7, np.array(mesh.convex_hull.triangles))


def candidates(*solids, seed=0):
    return Candidates("it", solids, HAND, np.zeros(3), np.random.default_rng(seed))


def wedge():
    """Give a prism whose sides are not parallel, narrower above than below."""
    corners = np.array([[-0.03, -0.02], [0.03, -0.02], [0.02, 0.02], [-0.01, 0.03]])
    below = np.column_stack([corners, np.full(4, -0.02)])
    above = np.column_stack([0.8 * corners, np.full(4, 0.02)])
    return trimesh.convex.convex_hull(np.vstack([below, above]))


def mug():
    """Give walls of 4 mm around a hollow of 56 mm."""
    walls = []
    for i in range(4):
        angle = 0.5 * math.pi * i
        place = (0.030 * math.cos(angle), 0.030 * math.sin(angle), 0.0)
        rotation = pin.utils.rotate("z", angle)
        walls.append(solid("box", 0.002, 0.032, 0.04, at=place, rotation=rotation))
    return walls


# Analytic


def test_a_cube_is_gripped_by_faces_as_far_apart_as_its_edges_are_long():
    for grasp in candidates(solid("box", 0.025, 0.025, 0.025)).grasps(DOWN):
        assert grasp.width == pytest.approx(0.05)
        assert np.abs(grasp.closing).max() == pytest.approx(1.0)
        assert grasp.approach @ grasp.closing == pytest.approx(0.0, abs=1e-12)
        assert grasp.T_ot.rotation[:, 1] == pytest.approx(grasp.closing, abs=1e-12)
        assert np.linalg.det(grasp.T_ot.rotation) == pytest.approx(1.0)
        assert grasp.approach @ DOWN > -0.5, "nothing comes from below"


def test_only_the_faces_that_fit_between_the_fingers_are_gripped():
    widths = {round(g.width, 6) for g in candidates(solid("box", 0.06, 0.02, 0.035)).grasps(DOWN)}
    assert widths == {0.04, 0.07}


def test_a_thin_plate_is_gripped_with_the_tips_over_what_it_lies_on():
    grasps = candidates(solid("box", 0.03, 0.03, 0.004)).grasps(DOWN)
    above = [g for g in grasps if g.approach @ DOWN > 0.99]
    assert above
    for grasp in above:
        tips = grasp.T_ot.translation[2] - HAND.tip
        assert -0.004 + 1e-3 <= tips + 1e-9 < 0.004


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule"])
def test_what_is_too_wide_is_refused_with_its_width_and_the_stroke(kind):
    with pytest.raises(
        MotionError, match="100 mm wide where it is narrowest; the fingers open to 80 mm"
    ):
        candidates(solid(kind, 0.05, 0.05, 0.05)).grasps(DOWN)


def test_a_mesh_that_is_too_wide_is_refused_too():
    with pytest.raises(MotionError, match="120 mm wide .* open to 80 mm"):
        candidates(convex(trimesh.creation.box((0.12, 0.13, 0.14)))).grasps(DOWN)


@pytest.mark.parametrize("turn", [0.0, 0.6, 2.5])
def test_a_lying_cylinder_is_gripped_across_its_axis_from_straight_above(turn):
    rotation = pin.utils.rotate("z", turn) @ pin.utils.rotate("y", 0.5 * math.pi)
    grasps = candidates(solid("cylinder", 0.02, 0.05, rotation=rotation)).grasps(DOWN)
    above = [g for g in grasps if g.approach @ DOWN > 1.0 - 1e-9]
    assert above
    for grasp in above:
        assert abs(grasp.closing @ rotation[:, 2]) < 1e-9 and grasp.width == pytest.approx(0.04)


def test_a_ball_is_gripped_at_its_middle_or_as_far_before_it_as_the_palm_demands():
    for radius in (0.015, 0.033):
        for grasp in candidates(solid("sphere", radius)).grasps(DOWN):
            back = -grasp.T_ot.translation @ grasp.approach
            palm = back + HAND.palm
            assert palm >= radius + 3e-3 - 1e-9
            # Where the tips end before the middle, they press on faces that are turned by this.
            before = max(back - HAND.tip, 0.0)
            assert grasp.slant == pytest.approx(math.asin(before / radius), abs=1e-9)
            assert grasp.slant < 0.26


# Sampled


@pytest.mark.parametrize(("kind", "size", "volume"), [
    ("box", (0.01, 0.02, 0.03), 8 * 6e-6),
    ("cylinder", (0.02, 0.03), 2 * math.pi * 4e-4 * 0.03),
    ("sphere", (0.02,), 4 / 3 * math.pi * 8e-6),
    ("capsule", (0.02, 0.03), 2 * math.pi * 4e-4 * 0.03 + 4 / 3 * math.pi * 8e-6),
    ("ellipsoid", (0.01, 0.02, 0.03), 4 / 3 * math.pi * 6e-6),
])  # fmt: skip
def test_solids_are_bounded_by_planes_that_enclose_nearly_their_volume(kind, size, volume):
    made = bounded_by(triangles_of(kind, np.array([*size, 0.0, 0.0][:3])))
    a, b, c = made.triangles.transpose(1, 0, 2)
    signed = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    assert np.abs(signed).sum() == pytest.approx(volume, rel=0.02)
    assert (made.normals @ made.triangles.reshape(-1, 3).T <= made.offsets[:, None] + 1e-9).all()


def normals_at(mesh, place):
    """Give the normals of the triangles that a place lies on, found by distance alone."""
    nearest = trimesh.triangles.closest_point(mesh.triangles, np.tile(place, (len(mesh.faces), 1)))
    distance = np.linalg.norm(nearest - place, axis=1)
    assert distance.min() < 1e-6, "it is not on the surface"
    return mesh.face_normals[distance < 1e-6]


@pytest.mark.parametrize("make", [
    wedge,
    lambda: trimesh.creation.icosphere(subdivisions=2, radius=0.03),
    lambda: trimesh.creation.cylinder(0.03, 0.05, sections=7),
    lambda: trimesh.creation.capsule(0.04, 0.02, count=[9, 8]),
])  # fmt: skip
@pytest.mark.parametrize("cone", [0.15, 0.6])
def test_antipodal_pairs_are_inside_both_cones_of_friction(make, cone):
    mesh = make()
    pairs = antipodal_pairs(
        [convex(mesh).polyhedron], cone=cone, widest=0.08, count=200, rng=np.random.default_rng(1)
    )
    assert len(pairs.first) > 5
    for first, second in zip(pairs.first, pairs.second, strict=True):
        line = (second - first) / np.linalg.norm(second - first)
        assert np.linalg.norm(second - first) <= 0.08
        for place, outward in ((first, -line), (second, line)):
            steepest = max(float(n @ outward) for n in normals_at(mesh, place))
            assert math.acos(min(steepest, 1.0)) <= cone + 1e-6


def test_a_triangular_prism_has_no_pairs_without_friction():
    prism = trimesh.creation.cylinder(0.02, 0.2, sections=3)

    def sides(cone):
        pairs = antipodal_pairs(
            [convex(prism).polyhedron], cone=cone, widest=0.08, count=300,
            rng=np.random.default_rng(0),
        )  # fmt: skip
        return len(pairs.first)

    assert sides(math.radians(29.0)) == 0, "the sides are 60 degrees from being parallel"
    assert sides(math.radians(40.0)) > 0


def test_a_line_through_a_hollow_thing_goes_in_and_out_of_each_wall():
    (crossing,) = cross(
        [s.polyhedron for s in mug()], np.array([[0.0, 0.003, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    )
    assert crossing.enter == pytest.approx([-0.032, 0.028])
    assert crossing.leave == pytest.approx([-0.028, 0.032])


def test_a_hollow_thing_is_gripped_from_outside_and_by_its_walls():
    pairs = sampled_pairs(mug(), HAND, np.zeros(3), np.random.default_rng(0))
    widths = [np.linalg.norm(second - first) for first, second, _, _ in pairs]
    assert any(w == pytest.approx(0.064, abs=1e-3) for w in widths)
    assert any(w == pytest.approx(0.004, abs=1e-3) for w in widths)


def test_the_same_generator_gives_the_same_grasps():
    made = [candidates(convex(wedge()), seed=seed).grasps(DOWN) for seed in (3, 3, 4)]
    texts = [[grasp.to_text() for grasp in table] for table in made]
    assert texts[0] == texts[1] != texts[2]


def test_grasps_stay_inside_most_of_the_cone_that_the_greater_friction_allows():
    assert cone_of_friction([solid("box", 0.01, 0.01, 0.01)], HAND) == pytest.approx(
        0.8 * math.atan(1.0)
    )


# Ranking


def ranking(table, T_wo=None, centre=(0.0, 0.0, 0.0), T_now=None):
    T_now = (
        pin.SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 0.4])) if T_now is None else T_now
    )
    return Ranking(table, T_wo or pin.SE3.Identity(), np.array(centre), HAND, T_now)


def test_a_cube_is_gripped_from_above_first_and_nothing_speaks_against_it():
    found = list(ranking(candidates(solid("box", 0.025, 0.025, 0.025)).grasps(DOWN)).best_first())
    for one in found[:4]:
        assert one.T_wt.rotation[:, 2] == pytest.approx(DOWN)
        assert one.T_wt.translation == pytest.approx([0.0, 0.0, 0.015])
        assert one.cost.total == 0.0 and str(one.cost) == "nothing"
    assert found[4].cost.tilt > 0.4 and "tilt 0.50" in str(found[4].cost)


def test_of_grasps_that_are_alike_the_one_to_turn_least_for_comes_first():
    table = candidates(solid("box", 0.025, 0.025, 0.025)).grasps(DOWN)
    for angle in (0.3, 1.4, -1.4, 2.8):
        T_now = pin.SE3(pin.utils.rotate("z", angle) @ np.diag([1.0, -1.0, -1.0]), np.zeros(3))
        first = next(ranking(table, T_now=T_now).best_first())
        turned = pin.log3(T_now.rotation.T @ first.T_wt.rotation)
        assert np.linalg.norm(turned) <= math.pi / 4 + 1e-9


def test_a_rod_is_gripped_at_its_centre_of_mass_rather_than_beside_it():
    table = candidates(solid("box", 0.1, 0.015, 0.015)).grasps(DOWN)
    assert next(ranking(table).best_first()).T_wt.translation[0] == pytest.approx(0.0)
    heavy = next(ranking(table, centre=(0.06, 0.0, 0.0)).best_first())
    assert heavy.T_wt.translation[0] == pytest.approx(0.6 * (0.1 - HAND.pad))


def test_grasps_are_written_and_read():
    grasp = next(iter(candidates(solid("box", 0.025, 0.02, 0.03)).grasps(DOWN)))
    again = Grasp.from_text(grasp.to_text())
    assert again.T_ot.isApprox(grasp.T_ot, 1e-12) and again.width == grasp.width


@pytest.mark.parametrize("text", ["", "1;2;3", "0;0;0;1;0;0;0;nan", "0;0;0;1;0;0;0;-1", "a"])
def test_what_is_no_grasp_is_refused(text):
    with pytest.raises(ValueError, match="a grasp is"):
        Grasp.from_text(text)
