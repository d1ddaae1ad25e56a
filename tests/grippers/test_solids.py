"""Convex solids as polyhedra."""

import math
from collections import Counter

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import trimesh

from bt_manip.grippers.solids import (
    BodySurface,
    Polyhedron,
    geom_surface,
    least_width,
    surface_triangles,
)
from bt_manip.grippers.two_finger.hand import jaw_height
from bt_manip.spatial import pose
from tests.grippers.shapes import convex, mug, solid, wedge


@pytest.mark.parametrize(("kind", "size", "volume"), [
    ("box", (0.01, 0.02, 0.03), 8 * 6e-6),
    ("cylinder", (0.02, 0.03), 2 * math.pi * 4e-4 * 0.03),
    ("sphere", (0.02,), 4 / 3 * math.pi * 8e-6),
    ("capsule", (0.02, 0.03), 2 * math.pi * 4e-4 * 0.03 + 4 / 3 * math.pi * 8e-6),
    ("ellipsoid", (0.01, 0.02, 0.03), 4 / 3 * math.pi * 6e-6),
])  # fmt: skip
def test_the_polyhedron_of_a_primitive_is_closed_and_has_nearly_its_volume(kind, size, volume):
    polyhedron = Polyhedron.from_triangles(surface_triangles(kind, np.array([*size, 0.0, 0.0][:3])))
    triangles = polyhedron.triangles
    a, b, c = triangles.transpose(1, 0, 2)
    signed = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    assert np.abs(signed).sum() == pytest.approx(volume, rel=0.02)
    heights = polyhedron.normals @ triangles.reshape(-1, 3).T
    assert (heights <= polyhedron.offsets[:, None] + 1e-9).all()
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    ends = (np.round(edges, 9) + 0.0).tolist()
    undirected = Counter(tuple(sorted(map(tuple, edge))) for edge in ends)
    assert set(undirected.values()) == {2}  # an edge borders on two triangles


def test_the_support_function_of_a_primitive_is_that_of_its_polyhedron():
    directions = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.6, 0.0, 0.8]])
    for kind in ("box", "sphere", "cylinder", "capsule", "ellipsoid"):
        turned = pin.utils.rotate("x", 0.4) @ pin.utils.rotate("z", 0.9)
        made = solid(kind, 0.02, 0.03, 0.04, at=(0.1, 0.0, -0.05), rotation=turned)
        corners = made.polyhedron.triangles.reshape(-1, 3)
        expected = (directions @ corners.T).max(axis=1)
        assert made.support(directions) == pytest.approx(expected, abs=5e-4)


def test_the_least_width_is_that_of_the_narrowest_side():
    assert least_width([solid("box", 0.02, 0.03, 0.01)]) == pytest.approx(0.02)
    assert least_width([solid("capsule", 0.02, 0.03)]) == pytest.approx(0.04)
    assert least_width(mug()) == pytest.approx(0.064)
    assert least_width([convex(wedge())]) == pytest.approx(0.04)


def test_a_part_of_a_fixed_jaw_between_the_jaws_is_as_high_as_its_top():
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body><geom name="jaw" type="box" size=".01 .01 .06"/>'
        '<geom type="box" pos="0 .05 .01" size=".015 .01 .02"/></body></worldbody></mujoco>'
    )
    closing = np.array([0.0, 1.0, 0.0])
    for depth, top in ((0.03, 0.03), (0.0, 0.06), (0.07, -np.inf)):
        height = jaw_height(model, 0, pin.SE3.Identity(), closing, depth)
        assert height == pytest.approx(top)


MESHES = """<mujoco><asset><mesh name="small" vertex="0 0 0 .1 0 0 0 .2 0 0 0 .3"/>
<mesh name="box" vertex="-.03 -.02 -.01 .03 -.02 -.01 -.03 .02 -.01 .03 .02 -.01
-.03 -.02 .01 .03 -.02 .01 -.03 .02 .01 .03 .02 .01"/></asset><worldbody>
<geom type="mesh" mesh="small" pos="0 0 -3"/><geom type="plane" size="1 1 1"/>
<body name="it" pos="0 0 1" quat=".9 .1 -.3 .2">
<geom type="mesh" mesh="box" pos=".1 .05 .02" quat=".6 .5 -.4 .3"/>
<geom type="capsule" size=".01 .03" pos="-.05 .02 .03" quat=".2 .7 .1 -.4" contype="0"/>
<geom size=".5" contype="0" conaffinity="0"/></body></worldbody></mujoco>"""


def test_the_surface_of_a_body_above_a_plane_is_that_of_its_colliding_geoms():
    model = mujoco.MjModel.from_xml_string(MESHES)
    T_tb, body = pose((0.2, 0.3, 1.0), (0.4, -0.5, 0.6, 0.2)), model.body("it").id
    T_box = T_tb * pose((0.1, 0.05, 0.02), (0.6, 0.5, -0.4, 0.3))
    T_capsule = T_tb * pose((-0.05, 0.02, 0.03), (0.2, 0.7, 0.1, -0.4))
    capsule = trimesh.creation.capsule(0.06, 0.01, count=[64, 64])
    capsule.apply_translation([0.0, 0.0, -capsule.bounds.mean(axis=0)[2]])
    parts = [trimesh.creation.box((0.06, 0.04, 0.02)).apply_transform(T_box.homogeneous),
             capsule.apply_transform(T_capsule.homogeneous)]  # fmt: skip
    whole = trimesh.util.concatenate(parts)
    found = BodySurface(model, body).beyond(T_tb, -np.inf)
    assert np.abs([found.min(axis=0), found.max(axis=0)] - whole.bounds).max() < 5e-4
    for part in parts:  # through its middle
        height = part.bounds[:, 2].mean()
        cut = trimesh.intersections.mesh_plane(whole, [0.0, 0.0, 1.0], [0.0, 0.0, height])
        kept = np.concatenate([whole.vertices[whole.vertices[:, 2] > height], *cut])
        above = BodySurface(model, body).beyond(T_tb, height)
        assert (
            np.abs(
                [above.min(axis=0) - kept.min(axis=0), above.max(axis=0) - kept.max(axis=0)]
            ).max()
            < 5e-4
        )
    assert len(geom_surface(model, 1)) == 0  # a plane


def test_a_capsule_is_as_wide_at_both_ends_of_its_cylinder():
    model = mujoco.MjModel.from_xml_string(MESHES)
    points = geom_surface(model, 3).reshape(-1, 3)
    wide = points[np.hypot(points[:, 0], points[:, 1]) > 0.01 - 1e-9]
    assert {*np.round(wide[:, 2], 9)} == {-0.03, 0.03}
