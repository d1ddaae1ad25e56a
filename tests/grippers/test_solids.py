"""Convex solids as polyhedra."""

import math
from collections import Counter
from types import SimpleNamespace

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
from bt_manip.grippers.two_finger.hand import measure_hand
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


HAND = """<mujoco><asset><mesh name="pyramid" vertex="-.04 -.05 -.02 .04 -.05 -.02 -.04 .05 -.02
.04 .05 -.02 0 0 .02"/></asset><worldbody><body name="hand" pos="1 2 3" quat=".8 .2 -.4 .3">
<geom type="mesh" mesh="pyramid"/>
<geom name="jaw" type="box" size=".009 .02 .045" pos="0 -.01 .07"/>
<geom type="box" size=".008 .002 .01" pos="0 -.028 .1"/>
<site name="tool" pos="-.002 .003 .1" quat=".9 0 0 .3"/>
<body pos="0 .03 .05"><joint/><geom name="finger" type="box" size=".007 .004 .06" pos="0 0 .02"/>
<geom type="box" size=".03 .004 .01" pos="0 0 .049"/></body></body></worldbody></mujoco>"""


# In the frame of the hand the jaw is 15 mm higher than the tool and ends 7 mm beside it.
@pytest.mark.parametrize(
    ("width", "shift", "palm"), [(0.05, 0.0, -0.015), (0.036, 0.5, -0.015), (0.044, 0.5, 0.08)]
)
def test_a_fixed_jaw_that_reaches_between_the_fingers_is_a_palm(width, shift, palm):
    model = mujoco.MjModel.from_xml_string(HAND)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    tool = model.site("tool").id
    T_wt = pin.SE3(data.site_xmat[tool].reshape(3, 3), data.site_xpos[tool])
    R_wg, p_wg = data.geom_xmat.reshape(-1, 3, 3), data.geom_xpos
    placed = {i: T_wt.actInv(pin.SE3(R_wg[i], p_wg[i])) for i in range(model.ngeom)}
    closing = T_wt.rotation.T @ data.xmat[model.body("hand").id].reshape(3, 3)[:, 1]
    travel = SimpleNamespace(
        closing=closing, open_width=width, min_width=0.01, centre=(-0.003, shift), one_moves=shift
    )
    mechanism = SimpleNamespace(geoms=((3, 4), (1, 2)), travel=travel)
    hand = measure_hand(model, mechanism, tool, placed)
    # Of the tips only the highest 20 mm count: up to the jaw, 9 mm wide, and 2 mm beside the tool.
    expected = [*closing, width, 0.01, 0.03, palm, 0.011, -0.003, shift]
    assert np.hstack(hand) == pytest.approx(expected)
    assert hand.opening(np.array([0.01, width])) == pytest.approx([0.0, 1.0])
    assert hand.offset(np.array([0.02])) == pytest.approx([-0.003 + shift * 0.022])
    if not shift:
        mechanism.geoms = (3,), (4,)
        without_palm = {i: placed[i] for i in (3, 4)}
        assert measure_hand(model, mechanism, tool, without_palm).palm == np.inf


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
    a, b, c = geom_surface(model, 2).transpose(1, 0, 2)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert area == pytest.approx(trimesh.creation.box((0.06, 0.04, 0.02)).area)
    assert geom_surface(model, 1).shape == (0, 3, 3)  # a plane


def test_a_capsule_is_as_wide_at_both_ends_of_its_cylinder():
    model = mujoco.MjModel.from_xml_string(MESHES)
    points = geom_surface(model, 3).reshape(-1, 3)
    wide = points[np.hypot(points[:, 0], points[:, 1]) > 0.01 - 1e-9]
    assert {*np.round(wide[:, 2], 9)} == {-0.03, 0.03}
